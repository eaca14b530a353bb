"""Scenes of materials and textures."""
import bpy
import numpy

import studio


def spheres(surfaces, columns):
    rows = (len(surfaces) + columns - 1) // columns
    for i, surface in enumerate(surfaces):
        place = (1.15 * (i % columns - (columns - 1) / 2), 0, 1.15 * ((rows - 1) / 2 - i // columns))
        bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, radius=0.5, location=place)
        studio.last_made(surface, smooth=True, name=surface.name)
    studio.add_camera((0, -6.5, 0), (0, 0, 0), fov=33)


def metals():
    """Metals and plastics by roughness; a coat. Shown under an environment."""
    studio.empty_file()
    made = studio.material
    gold, red = (1.0, 0.77, 0.34), (0.7, 0.08, 0.05)
    roughness = (0.0, 0.2, 0.5, 1.0)
    spheres([made(f"gold {r}", Base_Color=gold, Metallic=1.0, Roughness=r) for r in roughness]
            + [made(f"plastic {r}", Base_Color=red, Roughness=r) for r in roughness]
            + [made("matte", Base_Color=red, Roughness=1.0, Specular=0.0), made("half metal", Base_Color=gold, Metallic=0.5, Roughness=0.3),
               made("coat", Base_Color=red, Roughness=0.6, Clearcoat=1.0, Clearcoat_Roughness=0.0),
               made("rough coat", Base_Color=(0.05, 0.2, 0.6), Metallic=1.0, Roughness=0.6, Clearcoat=0.7, Clearcoat_Roughness=0.2)], 4)


def glasses():
    """What lets light through, as volumes; shown under an environment, which sees through them."""
    studio.empty_file()

    def glass(name, color=(1.0, 1.0, 1.0), roughness=0.0, ior=1.5, inside=None):
        made = studio.material(name, Base_Color=color, Roughness=roughness, Transmission=1.0, IOR=ior)
        nodes, links = made.node_tree.nodes, made.node_tree.links
        studio.say_to_exporter(made, Thickness=1.0)
        if inside:
            volume = nodes.new("ShaderNodeVolumeAbsorption")
            volume.inputs["Color"].default_value, volume.inputs["Density"].default_value = (*inside, 1), 1.0
            links.new(volume.outputs["Volume"], nodes["Material Output"].inputs["Volume"])
        return made

    spheres([glass("clear"), glass("water", ior=1.33), glass("diamond", ior=2.4), glass("green", color=(0.4, 0.9, 0.5)),
             glass("frosted .2", roughness=0.2), glass("frosted .5", roughness=0.5), glass("frosted 1", roughness=1.0),
             glass("absorbing", inside=(0.9, 0.5, 0.2))], 4)


def image(name, texels, color_space="sRGB"):
    """texels: rows from the lower one, RGBA in 0…1."""
    height, width, _ = texels.shape
    made = bpy.data.images.new(name, width, height, alpha=True)
    made.colorspace_settings.name = color_space
    made.pixels.foreach_set(texels.astype(numpy.float32).ravel())
    made.update()
    made.pack()
    return made


def picture_of(function, size=128):
    """An image's texels: function takes u, v (up) in 0…1 and gives R, G, B, A."""
    v, u = numpy.mgrid[0:size, 0:size] / size + 0.5 / size
    return numpy.stack([numpy.broadcast_to(channel, u.shape) for channel in function(u, v)], axis=-1)


def checks(u, v, n=8):
    return (numpy.floor(u * n) + numpy.floor(v * n)) % 2


def painted(name, link, **inputs):
    """A material with images: link gets its nodes, a function that adds an image node, its links, its surface."""
    made = studio.material(name, **inputs)
    tree = made.node_tree

    def add(picture):
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = picture
        return node

    link(tree.nodes, add, tree.links, tree.nodes["Principled BSDF"].inputs)
    return made


def colored(u, v):
    dark = checks(u, v)
    return 0.15 + 0.7 * dark * u, 0.15 + 0.7 * dark * v, 0.6 - 0.4 * dark, 1.0


def bumps(u, v):
    """A normal map of a wave along each axis."""
    x, y = 0.5 * numpy.sin(40 * u), 0.5 * numpy.sin(40 * v)
    size = numpy.sqrt(x * x + y * y + 1)
    return 0.5 + 0.5 * x / size, 0.5 + 0.5 * y / size, 0.5 + 0.5 / size, 1.0


def textures():
    """Colour, roughness and metal, normals, alpha, coordinates that are moved, vertex colours, emission: one each."""
    studio.empty_file()
    color = image("color", picture_of(colored))
    numbers = image("numbers", picture_of(lambda u, v: (0.0, 0.1 + 0.8 * u, checks(u, v, 4), 1.0)), "Non-Color")
    normals = image("normals", picture_of(bumps, 256), "Non-Color")
    holes = image("holes", picture_of(lambda u, v: (0.8, 0.5, 0.2, checks(u, v, 6))))
    glow = image("glow", picture_of(lambda u, v: (checks(u, v, 4) * u, checks(u, v, 4) * 0.5, 0.2 * v, 1.0)))

    def with_color(nodes, add, links, inputs):
        links.new(add(color).outputs["Color"], inputs["Base Color"])

    def with_numbers(nodes, add, links, inputs):
        split = nodes.new("ShaderNodeSeparateRGB")
        links.new(add(numbers).outputs["Color"], split.inputs[0])
        links.new(split.outputs["G"], inputs["Roughness"])
        links.new(split.outputs["B"], inputs["Metallic"])

    def with_normals(nodes, add, links, inputs):
        bend = nodes.new("ShaderNodeNormalMap")
        links.new(add(normals).outputs["Color"], bend.inputs["Color"])
        links.new(bend.outputs["Normal"], inputs["Normal"])

    def with_holes(nodes, add, links, inputs):
        node = add(holes)
        links.new(node.outputs["Color"], inputs["Base Color"])
        links.new(node.outputs["Alpha"], inputs["Alpha"])

    def moved(nodes, add, links, inputs):
        node, mapping, coordinates = add(color), nodes.new("ShaderNodeMapping"), nodes.new("ShaderNodeUVMap")
        mapping.inputs["Location"].default_value = (0.1, 0.3, 0)
        mapping.inputs["Rotation"].default_value = (0, 0, 0.5)
        mapping.inputs["Scale"].default_value = (2, 0.7, 1)
        links.new(coordinates.outputs["UV"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], node.inputs["Vector"])
        links.new(node.outputs["Color"], inputs["Base Color"])

    def glowing(nodes, add, links, inputs):
        links.new(add(glow).outputs["Color"], inputs["Emission"])

    matte = {"Roughness": 1.0, "Specular": 0.0}
    clip, blend = (painted(name, with_holes, **matte) for name in ("clip", "blend"))
    clip.blend_method, blend.blend_method = "CLIP", "BLEND"
    spheres([painted("color", with_color, **matte), painted("numbers", with_numbers, Base_Color=(0.9, 0.6, 0.4)),
             painted("normals", with_normals, Base_Color=(0.6, 0.6, 0.6), Roughness=0.4),
             painted("normals of metal", with_normals, Base_Color=(0.9, 0.9, 0.9), Metallic=1.0, Roughness=0.2),
             clip, blend, painted("moved", moved, **matte), painted("glowing", glowing, Base_Color=(0.0, 0.0, 0.0), Emission_Strength=2.0, **matte),
             studio.matte("vertex colors", (1.0, 1.0, 1.0))], 3)
    mesh = bpy.context.scene.objects["vertex colors"].data
    colors = mesh.color_attributes.new("Color", "BYTE_COLOR", "CORNER")
    for corner in mesh.loops:
        x, y, z = mesh.vertices[corner.vertex_index].co
        colors.data[corner.index].color = (0.5 + x, 0.5 + y, 0.5 + z, 1)
