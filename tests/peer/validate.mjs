// What glTF files the validator of npm's `gltf-validator` finds fault with: node validate.mjs NPM_FOLDER FILE …
// Prints a line for each file and each kind of finding; exits with 1 if one is an error or a warning.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";

const [folder, ...files] = process.argv.slice(2);
const validator = createRequire(path.resolve(folder, "package.json"))("gltf-validator");
const severities = ["error", "warning", "info", "hint"];
let faults = 0;

for (const file of files) {
  const beside = (uri) => readFile(path.join(path.dirname(file), decodeURIComponent(uri)));
  // What the corpus names beside its files, its fuzz target makes up.
  const severityOverrides = file.includes("tests/data/fuzz/") ? { IO_ERROR: 2 } : {};
  const options = { uri: path.basename(file), externalResourceFunction: beside, severityOverrides };
  const { issues } = await validator.validateBytes(await readFile(file), options);
  console.log(`${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} remarks, ${issues.numHints} hints`);
  const kinds = new Set();
  for (const { severity, code, message, pointer } of issues.messages) {
    if (!kinds.has(code)) console.log(`  ${severities[severity]} ${code}, first at ${pointer ?? "/"}: ${message}`);
    kinds.add(code);
  }
  faults += issues.numErrors + issues.numWarnings;
}
process.exit(faults > 0 ? 1 : 0);
