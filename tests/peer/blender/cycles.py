"""blender -b --factory-startup -P cycles.py -- JOB.json: imports a glTF file and renders it in Cycles. JOB: as setting.py has it, with
samples, seed, output (EXR)."""
import json
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import lobes
import setting

with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
    job = json.load(file)
setting.render(setting.set_up(job, lobes.settle), job["samples"], job["seed"], job["output"])
