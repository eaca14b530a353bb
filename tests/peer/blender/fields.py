"""Scenes of the duel: under the sky, under lamps, on a table. Every surface has one lobe that both renderers define alike."""
import math

import bpy
import numpy

import studio
from rooms import ball, box
from surfaces import image, picture_of


def sky(path):
    """A picture of all directions: a clear sky, a soft sun, a grey ground. Rows from the lower one."""
    height, width = 256, 512
    v, u = numpy.mgrid[0:height, 0:width]
    up = (v + 0.5) / height * math.pi - math.pi / 2
    around = (u + 0.5) / width * math.tau
    direction = numpy.stack([numpy.cos(up) * numpy.cos(around), numpy.cos(up) * numpy.sin(around), numpy.sin(up)], axis=-1)
    sun = numpy.array([-0.55, 0.62, 0.56]) / numpy.linalg.norm([-0.55, 0.62, 0.56])
    glow = numpy.exp(350 * (direction @ sun - 1))[..., None] * numpy.array([110.0, 95.0, 70.0])
    height_above = numpy.clip(direction[..., 2:], 0, 1)
    clear = (1 - height_above) ** 3 * numpy.array([0.9, 0.85, 0.8]) + (1 - (1 - height_above) ** 3) * numpy.array([0.25, 0.45, 0.9])
    texels = numpy.where(direction[..., 2:] > 0, clear + glow, numpy.array([0.2, 0.19, 0.17]))
    made = bpy.data.images.new("sky", width, height, float_buffer=True)
    made.pixels.foreach_set(numpy.concatenate([texels, numpy.ones((height, width, 1))], axis=-1).astype(numpy.float32).ravel())
    made.filepath_raw, made.file_format = path, "OPEN_EXR"
    made.save()


def hills(points, random, octaves):
    """Displacement at points (n, 3): waves in random directions, each octave finer and lower."""
    out = numpy.zeros(len(points))
    for octave in range(octaves):
        for _ in range(4):
            along = random.normal(size=3) * 1.5 * 1.9 ** octave
            out += 0.55 ** octave * numpy.sin(points @ along + random.uniform(0, math.tau))
    return out


def rocks():
    """Four boulders of 327,680 triangles, no two alike, on rough ground."""
    studio.empty_file()
    random = numpy.random.default_rng(7)
    places = (((-1.5, 0.2, 0.75), 1.0, (0.45, 0.4, 0.35)), ((1.2, 0.9, 0.8), 1.15, (0.3, 0.32, 0.36)),
              ((0.5, -1.5, 0.35), 0.55, (0.55, 0.38, 0.27)), ((-0.3, 2.9, 1.0), 1.5, (0.4, 0.42, 0.38)))
    for i, (place, radius, color) in enumerate(places):
        bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=8, radius=1, location=place)
        displace(studio.last_made(studio.matte(f"stone {i}", color), smooth=True), random, 8, lambda p, by: p * radius * (1 + 0.07 * by[:, None]))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=200, y_subdivisions=200, size=30)
    displace(studio.last_made(studio.matte("ground", (0.42, 0.36, 0.27)), smooth=True), random, 6,
             lambda p, by: p + 0.05 * by[:, None] * numpy.array([0, 0, 1]))
    studio.add_camera((0.4, -6.8, 2.3), (0, 0, 0.7), fov=36)


def displace(thing, random, octaves, move):
    """move: of points and the hills at each."""
    vertices = thing.data.vertices
    points = numpy.empty(3 * len(vertices))
    vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    vertices.foreach_set("co", move(points, hills(points, random, octaves)).ravel())
    thing.data.update()


def lanterns():
    """600 small lamps of six colours among blocks, none nearer to one than a hand's breadth: what lights the picture is many lamps, not the
    spots of a few."""
    studio.empty_file()
    random = numpy.random.default_rng(11)
    studio.add_floor(studio.matte("ground", (0.5, 0.5, 0.5)), 40)
    block = studio.matte("block", (0.6, 0.57, 0.5))
    tops = {}
    for x in range(-9, 10, 2):
        for y in range(-5, 16, 2):
            tops[x, y] = random.uniform(0.3, 1.6)
            box(block, (x - 0.45, y - 0.45, 0), (x + 0.45, y + 0.45, tops[x, y]), random.uniform(-0.3, 0.3))
    colors = ((1.0, 0.6, 0.25), (1.0, 0.8, 0.5), (0.5, 0.7, 1.0), (1.0, 0.35, 0.3), (0.45, 1.0, 0.6), (0.9, 0.9, 1.0))
    for i, color in enumerate(colors):
        places = [place_between(tops, random) for _ in range(100)]
        level_squares(f"lamps {i}", studio.lamp(f"lamp {i}", color, 160), places, 0.06)
    studio.add_camera((0, -11, 6.5), (0, 1.5, 0), fov=38)


def place_between(tops, random):
    """tops: the heights of blocks that stand about whole places; half of a block's diagonal is .64."""
    while True:
        x, y, z = random.uniform(-10, 10), random.uniform(-6, 16), random.uniform(0.4, 2.6)
        if all(math.hypot(x - block[0], y - block[1]) > 0.75 or z > top + 0.15 for block, top in tops.items()):
            return x, y, z


def level_squares(name, surface, places, side):
    """One mesh."""
    corners = [(side * a, side * b) for a, b in ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(x + a, y + b, z) for x, y, z in places for a, b in corners], [],
                     [[4 * i + k for k in range(4)] for i in range(len(places))])
    mesh.materials.append(surface)
    bpy.context.collection.objects.link(bpy.data.objects.new(name, mesh))


def printed(name, function):
    """Paper, or what else is painted with a picture and has no gloss."""
    made = studio.matte(name, (1.0, 1.0, 1.0))
    tree = made.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = image(name, picture_of(function, 512))
    tree.links.new(node.outputs["Color"], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return made


def product():
    """A box and a tin with printed labels, a ball of glass and one of brushed metal, on a sweep of paper between two soft lamps."""
    studio.empty_file()
    waves = printed("waves", lambda u, v: (0.45 + 0.35 * numpy.sin(25 * u + 3 * numpy.sin(9 * v)), 0.3 + 0.2 * v, 0.55 - 0.3 * u, 1.0))
    rings = printed("rings", lambda u, v: (0.75 + 0 * u, 0.5 + 0.3 * numpy.cos(40 * numpy.hypot(u - 0.5, v - 0.5)), 0.25 + 0 * u, 1.0))
    grain = printed("grain", lambda u, v: (0.62 + 0.1 * numpy.sin(60 * v + 4 * numpy.sin(5 * u)), 0.55 + 0.08 * numpy.sin(60 * v), 0.45 + 0 * u, 1.0))
    studio.add_floor(grain, 12)
    bpy.ops.mesh.primitive_plane_add(size=12, location=(0, 3.5, 6), rotation=(math.pi / 2, 0, 0))
    studio.last_made(studio.matte("paper", (0.7, 0.7, 0.72)))
    bpy.ops.mesh.primitive_cube_add(size=1.3, location=(-1.15, 0.5, 0.65), rotation=(0, 0, 0.45))
    studio.last_made(waves)
    bpy.ops.mesh.primitive_cylinder_add(vertices=512, radius=0.55, depth=1.5, location=(0.35, 0.9, 0.75))
    studio.last_made(rings)
    ball(studio.glass("glass"), (0.15, -0.7, 0.42), 0.42)
    ball(studio.material("metal", Base_Color=(1.0, 1.0, 1.0), Metallic=1.0, Roughness=0.25), (1.5, 0.0, 0.5), 0.5)
    studio.add_panel((-3.2, -2.2, 3.4), (0, 0, 0.5), 2.2, 9, (1.0, 0.9, 0.78))
    studio.add_panel((3.6, -1.0, 2.6), (0, 0, 0.5), 1.4, 7, (0.75, 0.87, 1.0))
    studio.add_camera((0.2, -5.6, 2.0), (0.15, 0, 0.6), fov=32)
