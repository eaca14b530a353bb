"""blender -b --factory-startup -P write_scenes.py -- FOLDER [NAME …]: writes the scenes of the pairs, or those named, as glTF.
-- FOLDER duel: those of the duel, and a picture of a sky, sky.exr."""
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))

import fields
import light
import motion
import rooms
import shapes
import studio
import surfaces

DUEL = {scene.__name__: scene for scene in (
    rooms.cornell, rooms.cornell_glass, fields.rocks, fields.lanterns, rooms.window, fields.product)}
PAIRS = {scene.__name__: scene for scene in (
    shapes.primitives, shapes.modifiers, shapes.hierarchy, shapes.instances, surfaces.metals, surfaces.glasses, surfaces.textures,
    light.punctual, light.sharp_spot, light.soft_spot, light.lamps, motion.posed)}

folder, *wanted = sys.argv[sys.argv.index("--") + 1:]
if wanted == ["duel"]:
    scenes = DUEL
    fields.sky(str(pathlib.Path(folder) / "sky.exr"))
else:
    scenes = {name: make for name, make in PAIRS.items() if not wanted or name in wanted}
for name, make in scenes.items():
    make()
    moving = {"export_apply": False, "export_animations": True, "export_nla_strips": False} if make is motion.posed else {}
    studio.write(str(pathlib.Path(folder) / f"{name}.glb"), **moving)
