"""Scenes of the duel: rooms. Every surface has one lobe that both renderers define alike."""
import bpy

import studio

QUARTER = 1.5707963267948966
LAMP = 0.5  # the side of the room's lamp


def shell(white, left, right):
    """Five walls of a box of side 2 about the origin, open towards the camera at -y; in the middle of the ceiling a square of LAMP is left."""
    for place, turn, surface in (((0, 0, -1), (0, 0, 0), white), ((0, 1, 0), (QUARTER, 0, 0), white),
                                 ((-1, 0, 0), (0, QUARTER, 0), left), ((1, 0, 0), (0, -QUARTER, 0), right)):
        bpy.ops.mesh.primitive_plane_add(size=2, location=place, rotation=turn)
        studio.last_made(surface)
    inner = LAMP / 2
    rings = [[(-side, -side, 1), (side, -side, 1), (side, side, 1), (-side, side, 1)] for side in (1, inner)]
    mesh = bpy.data.meshes.new("ceiling")
    mesh.from_pydata(rings[0] + rings[1], [], [[(i + 1) % 4, i, 4 + i, 4 + (i + 1) % 4] for i in range(4)])
    mesh.materials.append(white)
    bpy.context.collection.objects.link(bpy.data.objects.new("ceiling", mesh))


def box(surface, low, high, turn=0.0):
    bpy.ops.mesh.primitive_cube_add(size=1, location=[(a + b) / 2 for a, b in zip(low, high)], rotation=(0, 0, turn))
    made = studio.last_made(surface)
    made.scale = [b - a for a, b in zip(low, high)]
    return made


def ball(surface, place, radius):
    """Of so many faces that its normals are nearly a sphere's."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=7, radius=radius, location=place)
    return studio.last_made(surface, smooth=True)


def cornell_room():
    studio.empty_file()
    white = studio.matte("white", (0.73, 0.73, 0.73))
    shell(white, studio.matte("red", (0.55, 0.06, 0.05)), studio.matte("green", (0.1, 0.42, 0.09)))
    studio.add_panel((0, 0, 1), (0, 0, 0), LAMP, 18, (1.0, 0.8, 0.5))
    studio.add_camera((0, -3.6, 0), (0, 0, 0), fov=32)
    return white


def cornell():
    """The room with a low and a tall block."""
    white = cornell_room()
    box(white, (0.05, -0.65, -1), (0.65, -0.05, -0.4), -0.3)
    box(white, (-0.65, -0.05, -1), (-0.05, 0.55, 0.2), 0.3)


def cornell_glass():
    """The room with a ball of glass and one of rough metal."""
    cornell_room()
    ball(studio.glass("glass"), (0.42, -0.35, -0.62), 0.38)
    ball(studio.material("metal", Base_Color=(1.0, 1.0, 1.0), Metallic=1.0, Roughness=0.3), (-0.4, 0.3, -0.55), 0.45)


def window():
    """A furnished room, lit by nothing but the sky through one window."""
    studio.empty_file()
    wall, wood = studio.matte("wall", (0.75, 0.73, 0.68)), studio.matte("wood", (0.4, 0.24, 0.13))
    box(wood, (-2.5, -3, -0.1), (2.5, 2, 0))
    box(wall, (-2.5, -3, 2.6), (2.5, 2, 2.7))
    box(wall, (-2.5, 2, 0), (2.5, 2.2, 2.6))
    box(wall, (-2.5, -3.2, 0), (2.5, -3, 2.6))
    box(studio.matte("blue wall", (0.25, 0.35, 0.5)), (2.5, -3.2, 0), (2.7, 2.2, 2.6))
    for low, high in (((-3, 0), (-0.8, 2.6)), ((1.1, 0), (2.2, 2.6)), ((-0.8, 0), (1.1, 0.8)), ((-0.8, 2.2), (1.1, 2.6))):
        box(wall, (-2.7, low[0], low[1]), (-2.5, high[0], high[1]))  # around the window
    box(wood, (-0.9, -0.2, 0.7), (0.8, 0.9, 0.76))
    for x in (-0.85, 0.69):
        for y in (-0.15, 0.79):
            box(wood, (x, y, 0), (x + 0.06, y + 0.06, 0.7))
    box(studio.matte("chest", (0.5, 0.45, 0.35)), (1.5, 1.2, 0), (2.4, 1.95, 1.0))
    ball(studio.matte("bowl", (0.6, 0.15, 0.08)), (0.1, 0.4, 0.93), 0.17)
    ball(studio.matte("vase", (0.2, 0.45, 0.4)), (1.95, 1.55, 1.22), 0.22)
    box(studio.matte("rug", (0.45, 0.1, 0.1)), (-1.6, -1.2, 0), (1.4, 1.4, 0.015))
    studio.add_camera((1.5, -2.8, 1.5), (-0.35, 0.6, 0.95), fov=58)
