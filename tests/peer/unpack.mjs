// node unpack.mjs FOLDER NAME …: files of npm's @pmndrs/assets (models/bunny.glb, hdri/studio.exr), which holds them as base64 in modules,
// written into FOLDER, where npm has installed it. Of a model also NAME.plain.glb, without the compression that Debian's Blender cannot read.
import { writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { basename, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, ...names] = process.argv.slice(2);
const require = createRequire(join(resolve(folder), "package.json"));
const load = (name) => import(pathToFileURL(require.resolve(name)));

const { NodeIO } = await load("@gltf-transform/core");
const { ALL_EXTENSIONS } = await load("@gltf-transform/extensions");
const draco = require("draco3dgltf");
const io = new NodeIO().registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({ "draco3d.decoder": await draco.createDecoderModule() });

for (const name of names) {
  const { default: text } = await load(`@pmndrs/assets/${name}.js`);
  const target = join(folder, basename(name));
  const bytes = Buffer.from(text.slice(text.indexOf(",") + 1), "base64");
  await writeFile(target, bytes);
  if (!name.endsWith(".glb")) continue;
  const document = await io.readBinary(bytes);
  for (const extension of document.getRoot().listExtensionsUsed())
    if (extension.extensionName === "KHR_draco_mesh_compression") extension.dispose();
  await writeFile(target.replace(/\.glb$/, ".plain.glb"), await io.writeBinary(document));
}
