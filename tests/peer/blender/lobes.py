"""Imported materials as Cycles is to show them: what it has for what Tessera does, or one lobe each that both define alike."""


def settle(material):
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


def reduce(material):
    """To a single lobe: emission, clear glass, GGX with a fixed colour, or Lambert's."""
    tree = material.node_tree
    for surface in [node for node in tree.nodes if node.type == "BSDF_PRINCIPLED"] if tree else []:
        values = surface.inputs
        if any(values["Emission"].default_value[:3]):
            only = lobe(tree, "ShaderNodeEmission", values, {"Color": "Emission", "Strength": "Emission Strength"})
        elif values["Transmission"].default_value:
            only = lobe(tree, "ShaderNodeBsdfGlass", values, {"Color": "Base Color", "IOR": "IOR"})
            only.distribution = "SHARP"
        elif values["Metallic"].default_value:
            only = lobe(tree, "ShaderNodeBsdfGlossy", values, {"Color": "Base Color", "Roughness": "Roughness"})
            only.distribution = "GGX"
        else:
            only = lobe(tree, "ShaderNodeBsdfDiffuse", values, {"Color": "Base Color"})
        for link in list(surface.outputs[0].links):
            tree.links.new(only.outputs[0], link.to_socket)
