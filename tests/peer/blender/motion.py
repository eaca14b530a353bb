"""Scenes that move: what skins, shape keys and keyframes look like at frame 13."""
import math

import bpy

import studio


def posed():
    """A bending cylinder, a cube that a shape key makes a ball of, a monkey that turns and flies."""
    studio.empty_file()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 0, 24
    studio.add_floor(studio.matte("floor", (0.6, 0.6, 0.6)))
    skinned((-2.5, 0, 0))
    morphed((0, 0, 1))
    bpy.ops.mesh.primitive_monkey_add(location=(2.6, 0, 1))
    monkey = studio.last_made(studio.matte("paint", (0.3, 0.6, 0.3)), smooth=True)
    for frame, turn, height in ((0, 0, 1), (24, math.pi, 2.5)):
        monkey.rotation_euler[2], monkey.location[2] = turn, height
        monkey.keyframe_insert("rotation_euler", frame=frame)
        monkey.keyframe_insert("location", frame=frame)
    studio.add_light("SUN", (0, 0, 10), (2, 3, 0), energy=2)
    studio.add_panel((-4, -4, 6), (0, 0, 0), 3, 5)
    studio.add_camera((0, -10, 4), (0, 0, 1.2))


def skinned(place):
    bpy.ops.object.armature_add(location=place)
    rig = bpy.context.object
    bpy.ops.object.mode_set(mode="EDIT")
    lower = rig.data.edit_bones[0]
    upper = rig.data.edit_bones.new("upper")
    upper.head, upper.tail, upper.parent = lower.tail, (0, 0, 2), lower
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_cylinder_add(radius=0.4, depth=2, location=(place[0], place[1], 1))
    skin = studio.last_made(studio.matte("skin", (0.8, 0.5, 0.4)))
    cut = skin.modifiers.new("cut", "REMESH")
    cut.mode, cut.octree_depth = "SMOOTH", 5
    bpy.ops.object.modifier_apply(modifier="cut")
    bpy.ops.object.select_all(action="DESELECT")
    skin.select_set(True)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.parent_set(type="ARMATURE_AUTO")
    bone = rig.pose.bones["upper"]
    bone.rotation_mode = "XYZ"
    for frame, angle in ((0, 0), (24, 1.8)):
        bone.rotation_euler[0] = bone.rotation_euler[2] = angle / 1.4
        bone.keyframe_insert("rotation_euler", frame=frame)


def morphed(place):
    bpy.ops.mesh.primitive_cube_add(size=1.6, location=place)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.subdivide(number_cuts=6)
    bpy.ops.object.mode_set(mode="OBJECT")
    made = studio.last_made(studio.matte("clay", (0.4, 0.5, 0.8)))
    made.shape_key_add(name="cube")
    ball = made.shape_key_add(name="ball")
    for point in ball.data:
        point.co = point.co.normalized()
    for frame, value in ((0, 0), (24, 1)):
        ball.value = value
        ball.keyframe_insert("value", frame=frame)
