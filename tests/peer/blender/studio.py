"""What all scenes that Blender writes for us are made with: an empty file, cameras, lights, principled materials, the exporter."""
import math

import bpy
import numpy
from io_scene_gltf2.blender.com.gltf2_blender_material_helpers import create_settings_group, get_gltf_node_name
from mathutils import Vector

numpy.bool = bool  # Blender 3.4's glTF add-on names what numpy 1.24 has dropped.

WIDTH, HEIGHT, FPS = 256, 192, 24


def empty_file():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y, render.fps = WIDTH, HEIGHT, FPS


def look_at(thing, target):
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def add_camera(eye, target, fov=40, orthographic=None):
    """fov: degrees, from the lower to the upper edge; orthographic: the width shown, instead."""
    data = bpy.data.cameras.new("camera")
    if orthographic:
        data.type, data.ortho_scale = "ORTHO", orthographic
    else:
        data.sensor_fit, data.angle = "VERTICAL", math.radians(fov)
    camera = bpy.data.objects.new("camera", data)
    bpy.context.collection.objects.link(camera)
    camera.location = eye
    look_at(camera, target)
    bpy.context.scene.camera = camera
    return camera


def add_light(kind, position, target=(0, 0, 0), color=(1, 1, 1), **settings):
    """kind: POINT, SPOT or SUN; settings: of bpy.types.Light."""
    data = bpy.data.lights.new(kind.lower(), kind)
    data.color = color
    for key, value in settings.items():
        setattr(data, key, value)
    light = bpy.data.objects.new(kind.lower(), data)
    bpy.context.collection.objects.link(light)
    light.location = position
    look_at(light, target)
    return light


def material(name, **inputs):
    """A principled material; inputs by the names of its sockets, with _ for spaces: Base_Color, Emission_Strength, …"""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    surface = made.node_tree.nodes["Principled BSDF"]
    surface.inputs["IOR"].default_value = 1.5
    for key, value in inputs.items():
        surface.inputs[key.replace("_", " ")].default_value = (*value, 1) if isinstance(value, tuple) else value
    if inputs.get("Specular") == 0:
        say_to_exporter(made, Specular=0.0)
    return made


def say_to_exporter(made, **values):
    """What glTF has and Blender's surface has not, in the add-on's own node: Thickness; Specular, which as the surface's own 0 would be
    written as a colour of 0, and that still reflects at grazing angles."""
    name = get_gltf_node_name()
    node = made.node_tree.nodes.new("ShaderNodeGroup")
    node.node_tree = bpy.data.node_groups.get(name) or create_settings_group(name)
    for key, value in values.items():
        node.inputs[key].default_value = value


def matte(name, color):
    """As near to Lambert's as Principled comes: without its specular part."""
    return material(name, Base_Color=color, Roughness=1.0, Specular=0.0)


def glass(name):
    """Clear, with a volume behind it."""
    made = material(name, Base_Color=(1.0, 1.0, 1.0), Roughness=0.0, Transmission=1.0)
    say_to_exporter(made, Thickness=1.0)
    return made


def lamp(name, color, strength):
    return material(name, Base_Color=(0.0, 0.0, 0.0), Specular=0.0, Emission=color, Emission_Strength=strength)


def last_made(surface=None, smooth=False, name=None):
    """The object that an operator has just made."""
    made = bpy.context.object
    if surface:
        made.data.materials.append(surface)
    if smooth:
        bpy.ops.object.shade_smooth()
    if name:
        made.name = name
    return made


def add_floor(surface, size=20, z=0):
    bpy.ops.mesh.primitive_plane_add(size=size, location=(0, 0, z))
    return last_made(surface, name="floor")


def add_panel(position, target, size, strength, color=(1.0, 1.0, 1.0)):
    """A square that emits."""
    bpy.ops.mesh.primitive_plane_add(size=size, location=position)
    panel = last_made(lamp("panel", color, strength), name="panel")
    panel.rotation_euler = (Vector(target) - panel.location).to_track_quat("Z", "Y").to_euler()
    return panel


def write(path, **options):
    bpy.ops.export_scene.gltf(
        filepath=path, export_format="GLB", export_cameras=True, export_lights=True,
        convert_lighting_mode="COMPAT", export_original_specular=True,
        **{"export_apply": True, "export_animations": False, **options})
