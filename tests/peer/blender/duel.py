"""blender -b --factory-startup -P duel.py -- JOB.json: imports a glTF file for Cycles, one lobe to a material, and renders it once for each
line of standard input: samples, seed, and an EXR file to write. After "measured" come numbers: for the import its seconds; for each render
its seconds by Cycles' own clock, those of the synchronization before, and the CPU seconds and the most memory (MiB) of this process so far.
What is synchronized stays for the next render. JOB: as setting.py has it."""
import json
import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import lobes
import measure
import setting


def main(job):
    began = time.perf_counter()
    scene = setting.set_up(job, lobes.reduce)
    scene.render.use_persistent_data = True
    print("measured", time.perf_counter() - began, flush=True)
    for line in sys.stdin:
        samples, seed, output = line.split(maxsplit=2)
        setting.render(scene, int(samples), int(seed), output.strip())
        times = [measure.header_seconds(output.strip(), what) for what in ("render", "synchronization")]
        print("measured", *times, time.process_time(), measure.peak_memory(), flush=True)


with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
    main(json.load(file))
