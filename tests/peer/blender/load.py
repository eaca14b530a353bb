"""blender -b --factory-startup -P load.py -- SCENE OUTPUT.exr THREADS: imports a glTF file and has Cycles make it ready to render. Prints,
after "measured", seconds of the import, of Cycles' synchronization, of all threads' CPU time, and the most memory ever held, MiB."""
import re
import sys
import time

import bpy
import numpy

numpy.bool = bool  # Blender 3.4's glTF add-on names what numpy 1.24 has dropped.


def main(scene_file, output, threads):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, before = bpy.context.scene, time.process_time()
    began = time.perf_counter()
    bpy.ops.import_scene.gltf(filepath=scene_file)
    imported = time.perf_counter() - began
    scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")
    render = scene.render
    render.engine, render.resolution_x, render.resolution_y = "CYCLES", 8, 8
    render.threads_mode, render.threads = "FIXED", threads
    render.filepath, render.use_file_extension, render.image_settings.file_format = output, False, "OPEN_EXR"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", 1, False
    bpy.ops.render.render(write_still=True)
    print("measured", imported, synchronization(output), time.process_time() - before, peak_memory())


def synchronization(picture):
    """From the picture's header, minutes:seconds."""
    with open(picture, "rb") as file:
        found = re.search(rb"synchronization_time\0string\0.{4}([0-9:.]+)", file.read(1 << 16), re.DOTALL)
    seconds = 0.0
    for part in found[1].decode().split(":"):
        seconds = 60 * seconds + float(part)
    return seconds


def peak_memory():
    with open("/proc/self/status", encoding="ascii") as file:
        return next(int(line.split()[1]) / 1024 for line in file if line.startswith("VmHWM"))


words = sys.argv[sys.argv.index("--") + 1:]
main(words[0], words[1], int(words[2]))
