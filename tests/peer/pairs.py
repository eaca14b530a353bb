"""Renders each scene of pairs.json here and in Cycles, compares the pictures, and prints a table. See README.md."""
import argparse
import hashlib
import json
import os
import pathlib
import sys

from renderers import BLENDERS_PATH, HERE, blender, run, tessera


def parsed():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="holds written/ and npm/; takes pictures, sheets, and what was measured")
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="the folder of tessera and peer_compare")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--bounces", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--only", nargs="+", help="pairs to render, by name; else all")
    return parser.parse_args()


class Pair:
    def __init__(self, asked, options):
        self.asked, self.options, self.name = asked, options, asked["name"]
        self.folder = options.folder.resolve()
        self.width, self.height = map(int, options.size.split("x"))

    def path(self, kind):
        return self.folder / f"{self.name}.{kind}"

    def render_here(self):
        scene = self.folder / self.asked["scene"]
        if "camera" in self.asked:  # Our own scene around the file, which says from where it is seen.
            scene = self.path("scene.json")
            scene.write_text(json.dumps({"tessera": 1, "include": [self.asked["scene"]], "camera": self.asked["camera"]}))
        around = self.asked.get("environment")
        command = tessera(self.options, scene, self.path("ours.exr"), self.options.samples, self.options.seed,
                          self.folder / around if around else None, self.asked.get("rotate", 0), self.asked.get("frame", 1))
        return json.loads(run(command, self.path("ours.log")).strip().splitlines()[-1])

    def render_in_cycles(self):
        """Once: the same job's picture is kept."""
        options = self.options
        scene = self.folder / self.asked["scene"]
        plain = scene.with_suffix(".plain.glb")
        scene = plain if plain.exists() else scene
        job = {**self.asked, "scene": str(scene), "output": str(self.path("cycles.exr")), "width": self.width, "height": self.height,
               "samples": options.samples, "bounces": options.bounces, "seed": options.seed, "threads": options.threads,
               "digest": hashlib.sha256(scene.read_bytes()).hexdigest()}
        if "environment" in job:
            job["environment"] = str(self.folder / job["environment"])
        text, file = json.dumps(job, indent=1), self.path("cycles.json")
        if file.exists() and file.read_text() == text and self.path("cycles.exr").exists():
            return
        self.path("cycles.exr").unlink(missing_ok=True)
        file.write_text(text)
        run(blender("cycles.py", file), self.path("cycles.log"), **BLENDERS_PATH)

    def compare(self):
        told = run([str(self.options.bin / "peer_compare"), str(self.path("ours.exr")), str(self.path("cycles.exr")),
                    "-o", str(self.path("sheet.png"))], self.path("compare.log"))
        return json.loads(told)


def row(name, like):
    ratio = " / ".join(f"{a / b:.3f}" if b else "–" for a, b in zip(like["first"], like["second"]))
    framing, blocks = like["framing"], like["blocks"]
    moved = f"{framing['right']:+.2f}, {framing['down']:+.2f}, {100 * framing['larger']:+.2f} %"
    worst = f"{100 * blocks['most']:.0f} % at {blocks['x']},{blocks['y']}"
    return f"| {name} | {ratio} | {moved} | {100 * blocks['median']:.1f} % | {worst} |"


def main():
    options = parsed()
    pairs = [pair for pair in json.loads((HERE / "pairs.json").read_text()) if not options.only or pair["name"] in options.only]
    if not pairs:
        sys.exit("pairs.py: no pair has such a name")
    print("| Pair | Mean over Cycles', R / G / B | Framing: right, down, larger | Blocks: median | Most |")
    print("|---|---|---|---|---|")
    for asked in pairs:
        pair = Pair(asked, options)
        pair.render_in_cycles()
        pair.render_here()
        print(row(pair.name, pair.compare()), flush=True)


if __name__ == "__main__":
    main()
