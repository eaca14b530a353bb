"""A glTF file imported and set up for Cycles, as much like Tessera as Cycles can be set. A job: scene, width, height, bounces, threads,
and perhaps frame, camera (eye, target, fov; glTF's axes), environment (a picture), rotate (it, in degrees)."""
import math

import bpy
import numpy
from mathutils import Vector

numpy.bool = bool  # Blender 3.4's glTF add-on names what numpy 1.24 has dropped.


def set_up(job, change_material):
    """change_material: what to make of each imported one, of lobes.py."""
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
        change_material(material)
    scene.frame_set(job.get("frame", 1) - 1)  # frame 1 is the time 0, which the importer puts at 0
    place_camera(scene, job)
    surround(scene, job)
    settle(scene, job)
    return scene


def render(scene, samples, seed, output):
    scene.cycles.samples, scene.cycles.seed, scene.render.filepath = samples, seed, output
    bpy.ops.render.render(write_still=True)


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
    render.use_file_extension = False
    render.dither_intensity = 0
    settings = render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth, settings.exr_codec = "OPEN_EXR", "RGBA", "32", "ZIP"
    scene.view_settings.view_transform = "Raw"
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    bounces = job["bounces"]
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.transparent_max_bounces, cycles.volume_bounces, cycles.min_light_bounces = 64, 0, 0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.light_sampling_threshold = cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
