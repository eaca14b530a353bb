"""blender -b --factory-startup -P load.py -- SCENE OUTPUT.exr THREADS: imports a glTF file and has Cycles make it ready to render. Prints,
after "measured", seconds of the import, of Cycles' synchronization, of all threads' CPU time, and the most memory ever held, MiB."""
import pathlib
import sys
import time

import bpy
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import measure

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
    print("measured", imported, measure.header_seconds(output, "synchronization"), time.process_time() - before,
          measure.peak_memory())


words = sys.argv[sys.argv.index("--") + 1:]
main(words[0], words[1], int(words[2]))
