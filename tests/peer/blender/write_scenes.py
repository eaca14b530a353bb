"""blender -b --factory-startup -P write_scenes.py -- FOLDER [NAME …]: writes the scenes, or those named, as glTF."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import light
import motion
import shapes
import studio
import surfaces

SCENES = {scene.__name__: scene for scene in (
    shapes.primitives, shapes.modifiers, shapes.hierarchy, shapes.instances, surfaces.metals, surfaces.glasses, surfaces.textures,
    light.punctual, light.sharp_spot, light.soft_spot, light.lamps, motion.posed)}

folder, *wanted = sys.argv[sys.argv.index("--") + 1:]
for name, make in SCENES.items():
    if wanted and name not in wanted:
        continue
    make()
    moving = {"export_apply": False, "export_animations": True, "export_nla_strips": False} if make is motion.posed else {}
    studio.write(str(pathlib.Path(folder) / f"{name}.glb"), **moving)
