"""blender -b --factory-startup -P cycles.py -- JOB.json: imports a glTF file and renders it in Cycles, as much like Tessera as Cycles
can be set. JOB: scene, output (EXR), width, height, samples, bounces, seed, threads, and perhaps frame, camera (eye, target, fov; glTF's
axes), environment (a picture), rotate (it, in degrees)."""
import json
import math
import sys

import bpy
import numpy
from mathutils import Vector

numpy.bool = bool  # Blender 3.4's glTF add-on names what numpy 1.24 has dropped.


def main(job):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = 24
    # COMPAT: a light's intensity is the number in the file, in the unit in which surfaces emit.
    bpy.ops.import_scene.gltf(filepath=job["scene"], convert_lighting_mode="COMPAT")
    for light in bpy.data.lights:  # glTF's have no size
        if light.type == "SUN":
            light.angle = 0
        else:
            light.shadow_soft_size = 0
    for material in bpy.data.materials:
        settle_material(material)
    scene.frame_set(job.get("frame", 1) - 1)  # frame 1 is the time 0, which the importer puts at 0
    place_camera(scene, job)
    surround(scene, job)
    settle(scene, job)
    bpy.ops.render.render(write_still=True)


def settle_material(material):
    """Light that bounces between microfacets is kept, as Tessera keeps it; and what has no specular part becomes one lobe, Lambert's,
    which Principled's own diffuse part is not."""
    tree = material.node_tree
    for surface in [node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"] if tree else []:
        surface.distribution = "MULTI_GGX"
        values = surface.inputs
        if told_no_specular(tree):
            values["Specular"].default_value = 0
        if any(values[key].is_linked or values[key].default_value for key in ("Specular", "Metallic", "Transmission", "Clearcoat")):
            continue
        matte = lobe(tree, "ShaderNodeBsdfDiffuse", values, {"Color": "Base Color", "Normal": "Normal"})
        if values["Emission"].is_linked or any(values["Emission"].default_value[:3]):
            glow = lobe(tree, "ShaderNodeEmission", values, {"Color": "Emission", "Strength": "Emission Strength"})
            matte = joined(tree, "ShaderNodeAddShader", {0: matte, 1: glow})
        if values["Alpha"].is_linked or values["Alpha"].default_value < 1:
            clear = tree.nodes.new("ShaderNodeBsdfTransparent")
            share = joined(tree, "ShaderNodeMixShader", {1: clear, 2: matte})
            follow(tree, share.inputs[0], values["Alpha"])
            matte = share
        for link in list(surface.outputs[0].links):
            tree.links.new(matte.outputs[0], link.to_socket)


def told_no_specular(tree):
    """The importer leaves a specularFactor of 0 in the add-on's own node, where Cycles does not see it."""
    return any(node.type == "GROUP" and "Specular" in node.inputs and not node.inputs["Specular"].is_linked
               and node.inputs["Specular"].default_value == 0 for node in tree.nodes)


def follow(tree, to, source):
    """Gives one socket what another has: its link, or its value."""
    if source.is_linked:
        tree.links.new(source.links[0].from_socket, to)
    elif hasattr(source, "default_value"):
        to.default_value = source.default_value


def lobe(tree, kind, values, sockets):
    made = tree.nodes.new(kind)
    for mine, theirs in sockets.items():
        if mine != "Normal" or values[theirs].is_linked:
            follow(tree, made.inputs[mine], values[theirs])
    return made


def joined(tree, kind, parts):
    made = tree.nodes.new(kind)
    for place, part in parts.items():
        tree.links.new(part.outputs[0], made.inputs[place])
    return made


def to_blender(p):
    return Vector((p[0], -p[2], p[1]))


def place_camera(scene, job):
    cameras = [thing for thing in scene.objects if thing.type == "CAMERA"]
    if "camera" in job:
        wanted = job["camera"]
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scene.collection.objects.link(camera)
        camera.location = to_blender(wanted["eye"])
        camera.rotation_euler = (to_blender(wanted["target"]) - camera.location).to_track_quat("-Z", "Y").to_euler()
        camera.data.sensor_fit, camera.data.angle = "VERTICAL", math.radians(wanted["fov"])
        camera.data.clip_start, camera.data.clip_end = 1e-4, 1e6
    else:
        camera = cameras[0]
    scene.camera = camera


def surround(scene, job):
    """Blender's direction (x, y, z) is glTF's (x, z, -y): both find a picture's texel by the same rule."""
    world = bpy.data.worlds.new("world")
    scene.world = world
    world.use_nodes = True
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    if "environment" not in job:
        return
    nodes, links = world.node_tree.nodes, world.node_tree.links
    picture, direction, turn = (nodes.new(f"ShaderNode{kind}") for kind in ("TexEnvironment", "TexCoord", "Mapping"))
    picture.image = bpy.data.images.load(job["environment"])
    turn.inputs["Rotation"].default_value[2] = -math.radians(job.get("rotate", 0))
    links.new(direction.outputs["Generated"], turn.inputs["Vector"])
    links.new(turn.outputs["Vector"], picture.inputs["Vector"])
    links.new(picture.outputs["Color"], background.inputs["Color"])


def settle(scene, job):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = job["width"], job["height"], 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.filepath, render.use_file_extension = job["output"], False
    render.dither_intensity = 0
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    scene.view_settings.view_transform = "Raw"
    cycles.device, cycles.samples, cycles.seed = "CPU", job["samples"], job["seed"]
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    bounces = job["bounces"]
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces, cycles.volume_bounces, cycles.min_light_bounces = 64, 0, 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"


with open(sys.argv[sys.argv.index("--") + 1], encoding="utf-8") as file:
    main(json.load(file))
