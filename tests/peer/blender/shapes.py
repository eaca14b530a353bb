"""Scenes of shapes: primitives, modifiers, places."""
import math

import bpy
from mathutils import Matrix

import studio


def primitives():
    """One of each of Blender's meshes, flat and smooth, under a sun and a panel."""
    studio.empty_file()
    studio.add_floor(studio.matte("floor", (0.6, 0.6, 0.6)))
    colors = [(0.8, 0.2, 0.15), (0.2, 0.5, 0.8), (0.8, 0.65, 0.2), (0.3, 0.7, 0.3)]
    surfaces = [studio.matte(f"paint {i}", color) for i, color in enumerate(colors)]
    add = bpy.ops.mesh
    makers = [add.primitive_cube_add, add.primitive_uv_sphere_add, add.primitive_ico_sphere_add, add.primitive_cone_add,
              add.primitive_cylinder_add, add.primitive_torus_add, add.primitive_monkey_add, add.primitive_circle_add]
    for i, maker in enumerate(makers):
        filled = {"fill_type": "NGON"} if maker == add.primitive_circle_add else {}
        maker(location=(2.6 * (i % 4) - 3.9, 2.8 * (i // 4) - 1.2, 1.05), **filled)
        studio.last_made(surfaces[i % 4], smooth=i in (1, 4, 5, 6))
    studio.add_light("SUN", (0, 0, 10), target=(2, 3, 0), energy=1.5)
    studio.add_panel((-4, -4, 7), (0, 0, 0), 3, 6)
    studio.add_camera((0.5, -11, 6.5), (0, 0, 0.7))


def modifiers():
    """What modifiers make of meshes, as the exporter applies them."""
    studio.empty_file()
    studio.add_floor(studio.matte("floor", (0.5, 0.5, 0.55)))
    clay = studio.matte("clay", (0.75, 0.6, 0.5))

    def modified(maker, place, kind, smooth=True, **settings):
        maker(location=place)
        made = studio.last_made(clay, smooth)
        modifier = made.modifiers.new(kind.lower(), kind)
        for key, value in settings.items():
            setattr(modifier, key, value)
        return made

    add = bpy.ops.mesh
    modified(add.primitive_monkey_add, (-3.4, 1.5, 1.2), "SUBSURF", levels=2, render_levels=2)
    modified(add.primitive_cube_add, (0, 1.8, 1.1), "BEVEL", smooth=False, width=0.35, segments=4)
    modified(add.primitive_cube_add, (2.2, 2, 0.5), "ARRAY", smooth=False, count=3, relative_offset_displace=(0.9, 0.2, 0.45)).scale = (0.5,) * 3
    modified(add.primitive_torus_add, (-3.2, -1.6, 0.6), "MIRROR", use_axis=(True, True, False)).data.transform(
        Matrix.Translation((0.9, 0.4, 0)))
    clouds = bpy.data.textures.new("clouds", "CLOUDS")
    clouds.noise_scale = 0.4
    rock = modified(add.primitive_ico_sphere_add, (0.2, -1.4, 1.1), "SUBSURF", levels=4, render_levels=4)
    displaced = rock.modifiers.new("displace", "DISPLACE")
    displaced.texture, displaced.strength = clouds, 0.7
    modified(add.primitive_grid_add, (3.4, -1.6, 0.8), "SOLIDIFY", smooth=False, thickness=0.2)
    modified(add.primitive_cylinder_add, (5.4, 0.5, 1), "SIMPLE_DEFORM", smooth=False, deform_method="TWIST", angle=1.2)
    studio.add_light("SUN", (0, 0, 10), target=(3, 2, 0), energy=2)
    studio.add_panel((-5, -5, 7), (0, 0, 0), 3, 5, (1.0, 0.85, 0.7))
    studio.add_camera((1, -11, 7), (0.8, 0, 0.5))


def hierarchy():
    """Parents with scales of their own for each axis, mirrors among them, seen by an orthographic camera."""
    studio.empty_file()
    studio.add_floor(studio.matte("floor", (0.6, 0.6, 0.6)))
    parent = None
    for i in range(4):
        bpy.ops.mesh.primitive_monkey_add(size=1.4, location=(0, 0, 0))
        child = studio.last_made(studio.matte(f"paint {i}", (0.8, 0.2 + 0.2 * i, 0.3)), smooth=i % 2 == 0)
        if parent:
            child.parent = parent
        child.location = (1.5, 0.5, 0.1) if parent else (-3, -1, 1)
        child.rotation_euler = (0.1, 0.2, 0.5 * i)
        child.scale = [(1, 1, 1.3), (1.2, 0.8, 1), (-1, 1, 1), (1, 1.3, -0.9)][i]
        parent = child
    studio.add_light("SUN", (0, 0, 10), target=(2, 3, 0), energy=3)
    studio.add_camera((5, -7, 6), (0, 0, 0.8), orthographic=9)


def instances():
    """Linked duplicates: one mesh in many places."""
    studio.empty_file()
    studio.add_floor(studio.matte("floor", (0.5, 0.5, 0.5)))
    bpy.ops.mesh.primitive_monkey_add(size=0.8)
    first = studio.last_made(studio.matte("paint", (0.2, 0.5, 0.8)), smooth=True)
    for i in range(24):
        copy = first if i == 0 else bpy.data.objects.new(f"copy {i}", first.data)
        if i:
            bpy.context.collection.objects.link(copy)
        ring, angle = 1 + i // 8, math.tau * (i % 8) / 8 + 0.3 * (i // 8)
        copy.location = (1.6 * ring * math.cos(angle), 1.6 * ring * math.sin(angle), 0.5)
        copy.rotation_euler = (0.2 * i, 0, angle)
        copy.scale = (1 if i % 3 else -1, 1 + 0.1 * (i % 4), 1)
    studio.add_light("SUN", (0, 0, 10), target=(1, 4, 0), energy=2.5)
    studio.add_panel((0, 0, 6), (0, 0, 0), 2, 6)
    studio.add_camera((0, -11, 8), (0, 0, 0))
