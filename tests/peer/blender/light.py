"""Scenes of light."""
import bpy

import studio


def room():
    surface = studio.matte("wall", (0.7, 0.7, 0.7))
    studio.add_floor(surface, 12)
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 4, 3), rotation=(1.5707963, 0, 0))
    studio.last_made(surface, name="wall")
    for x in (-2.5, 0, 2.5):
        bpy.ops.mesh.primitive_cube_add(size=1, location=(x, 0.5, 0.5), rotation=(0, 0, 0.4 + x))
        studio.last_made(studio.matte(f"box {x}", (0.8, 0.4, 0.3)))
    studio.add_camera((0, -9, 4), (0, 0.5, 1.2))


def punctual():
    """A point, a spot whose edge is all soft, one with a sharp edge under a parent that is scaled, a sun."""
    studio.empty_file()
    room()
    studio.add_light("POINT", (-2.5, -1, 2), energy=120, color=(1, 0.7, 0.4))
    studio.add_light("SPOT", (0, -2, 4), (0, 0.5, 0.5), energy=500, color=(0.4, 0.7, 1), spot_size=0.7, spot_blend=1.0)
    parent = bpy.data.objects.new("parent", None)
    bpy.context.collection.objects.link(parent)
    parent.scale, parent.location = (2, 0.5, 1.5), (0.5, 0, 0)
    spot = studio.add_light("SPOT", (1, -1, 2), (1.2, 1, 0), energy=300, spot_size=0.6, spot_blend=0.0)
    spot.parent = parent
    studio.add_light("SUN", (0, 0, 5), (1, 2, 0), energy=0.3)


def sharp_spot():
    """A spot alone, its edge sharp."""
    studio.empty_file()
    room()
    studio.add_light("SPOT", (0, -3, 4), (0, 0.5, 0.5), energy=500, spot_size=0.9, spot_blend=0.0)


def soft_spot():
    """A spot alone, soft from its axis on."""
    studio.empty_file()
    room()
    studio.add_light("SPOT", (0, -3, 4), (0, 0.5, 0.5), energy=500, spot_size=0.9, spot_blend=1.0)


def lamps():
    """A closed room lit by things that emit: a panel, a sphere, a monkey."""
    studio.empty_file()
    white = studio.matte("white", (0.73, 0.73, 0.73))
    sides = {(0, 0, -2): white, (0, 0, 2): white, (0, 2, 0): white, (-2, 0, 0): studio.matte("red", (0.6, 0.06, 0.05)),
             (2, 0, 0): studio.matte("green", (0.12, 0.45, 0.09))}
    for place, surface in sides.items():
        bpy.ops.mesh.primitive_plane_add(size=4, location=place, rotation=(1.5707963 * bool(place[1]), 1.5707963 * bool(place[0]), 0))
        studio.last_made(surface)
    studio.add_panel((0, 0, 1.98), (0, 0, 0), 1.2, 8, (1.0, 0.9, 0.7))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.25, location=(-1.2, 0.4, -1.3))
    studio.last_made(studio.lamp("bulb", (0.4, 0.6, 1.0), 12), smooth=True)
    bpy.ops.mesh.primitive_monkey_add(size=1, location=(0.9, 0.6, -1.4))
    studio.last_made(studio.lamp("glowing", (1.0, 0.3, 0.1), 2), smooth=True)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(-0.2, 0.8, -1.5), rotation=(0, 0, 0.5))
    studio.last_made(white)
    studio.add_camera((0, -7.2, 0), (0, 0, 0), fov=39)
