"""Renders each scene of duel.json here and in Cycles, by turns, with many seeds, and prints a table of truth, speed, noise, load time and
memory. See README.md."""
import argparse
import json
import math
import os
import pathlib
import sys

from contenders import Cycles, Tessera
from renderers import BLENDERS_PATH, HERE, blender, run


def parsed():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="takes scenes, pictures, and what was measured")
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="the folder of tessera, peer_errors and bench_load_once")
    parser.add_argument("--size", default="256x192")
    parser.add_argument("--samples", type=int, default=32, help="a pixel, of Cycles; here as many as take as long")
    parser.add_argument("--seeds", type=int, default=16)
    parser.add_argument("--bounces", type=int, default=12)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--only", nargs="+", help="scenes, by name; else all")
    options = parser.parse_args()
    if options.samples < 2:
        parser.error("--samples must be 2 or more: what one takes is taken off")
    return options


def write_scenes(folder):
    """Unless they are newer than all that they are written by."""
    names = [scene["name"] for scene in json.loads((HERE / "duel.json").read_text())]
    written = [folder / f"{name}.glb" for name in names] + [folder / "sky.exr"]
    sources = max(path.stat().st_mtime for path in (HERE / "blender").glob("*.py"))
    if not all(path.exists() and path.stat().st_mtime > sources for path in written):
        run(blender("write_scenes.py", folder, "duel"), folder / "written.log", **BLENDERS_PATH)


def fight(scene, options):
    """Renders by turns; what both took, and how far their pictures are off."""
    both = [Tessera(scene, options), Cycles(scene, options)]
    ours, theirs = (renderer.pilot() for renderer in both)
    if min(ours, theirs) <= 0:
        sys.exit("duel.py: the pilot run is too short to be timed: more --samples, or a larger --size")
    both[0].samples = max(2, round(options.samples * theirs / ours))
    for seed in range(1, options.seeds + 1):
        for renderer in both:
            renderer.render(seed)
    for renderer in both:
        renderer.end()
    command = [options.bin / "peer_errors", "--first", *both[0].pictures, "--second", *both[1].pictures]
    errors = json.loads(run([str(word) for word in command], options.folder / f"{scene['name']}.errors.log"))
    out = {"scene": scene, "seeds": options.seeds, **errors}
    for key, renderer in zip(("first", "second"), both):
        out[key].update(renderer.measured())
    ours, theirs = out["first"], out["second"]
    out["faster"] = {clock: theirs[clock] / ours[clock] for clock in ("seconds", "cpu_seconds")}
    # Error falls as one over the samples, or faster where they are not independent: at nearly equal times that matters little.
    out["to_equal_error"] = {
        f"{error} {clock}": ours[error] * ours[clock] * ours["samples"] / (theirs[error] * theirs[clock] * theirs["samples"])
        for error in ("relative", "trimmed") for clock in ("seconds", "cpu_seconds")}
    (options.folder / f"{scene['name']}.json").write_text(json.dumps(out, indent=1))
    return out


HEAD = """| Scene | Mean over Cycles', R / G / B | Pixels, blocks beyond {level:.1%} | Samples: ours, Cycles | … a second, million | Ratio | … of CPU time \
| relMSE, in a second: ours, Cycles | Trimmed | Time to equal error | … trimmed | … by CPU time, … trimmed | To load, s: ours, Cycles | Memory, MiB |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"""


def row(found):
    ours, theirs, ratios = found["first"], found["second"], found["to_equal_error"]
    means = " / ".join(f"{a / b:.4f} ± {2 * a / b * math.hypot(x / a, y / b):.4f}" for a, b, x, y in zip(
        ours["means"], theirs["means"], ours["standard_errors"], theirs["standard_errors"]))
    rates = [1e-6 * side["pixels"] / side["seconds"] for side in (ours, theirs)]
    errors = {key: [side[key] * side["seconds"] * side["samples"] for side in (ours, theirs)] for key in ("relative", "trimmed")}
    cells = [found["scene"]["about"], means, f"{found['beyond_pixels']:.2%}, {found['beyond_blocks']:.2%}",
             f"{ours['samples']}, {theirs['samples']}", f"{rates[0]:.2f}, {rates[1]:.2f}", f"{found['faster']['seconds']:.2f}", f"{found['faster']['cpu_seconds']:.2f}",
             *(f"{a:.3g}, {b:.3g}" for a, b in errors.values()),
             f"{ratios['relative seconds']:.2f}", f"{ratios['trimmed seconds']:.2f}",
             f"{ratios['relative cpu_seconds']:.2f}, {ratios['trimmed cpu_seconds']:.2f}",
             f"{ours['load']:.2f}, {theirs['load']:.2f}", f"{ours['memory']:.0f}, {theirs['memory']:.0f}"]
    return "| " + " | ".join(cells) + " |"


def geometric_mean(values):
    return math.exp(sum(map(math.log, values)) / len(values))


def main():
    options = parsed()
    options.folder = options.folder.resolve()
    options.folder.mkdir(parents=True, exist_ok=True)
    scenes = [scene for scene in json.loads((HERE / "duel.json").read_text()) if not options.only or scene["name"] in options.only]
    if not scenes:
        sys.exit("duel.py: no scene has such a name")
    write_scenes(options.folder)
    found = []
    for scene in scenes:
        found.append(fight(scene, options))
        if len(found) == 1:
            print(HEAD.format(level=found[0]["level"]))
        print(row(found[-1]), flush=True)
    ratios = ", ".join(f"{geometric_mean([one['to_equal_error'][key] for one in found]):.2f} ({key.replace('cpu_seconds', 'by CPU time')})"
                       for key in found[0]["to_equal_error"])
    print(f"\nTime to equal error over Cycles', geometric mean: {ratios}")


if __name__ == "__main__":
    main()
