"""Renders glTF files by Blender's Cycles as Shisen shows them.

    blender --background --python render.py -- OUT SIDE SAMPLES FILE...

writes OUT/NAME.png for each file NAME.glb, and OUT/sky.png without its things, by its first camera, SIDE pixels wide and
high. Only light that comes straight from lights or the sky counts, and what mirrors and glass show of it: surfaces that
scatter do not light each other. Materials are those of Blender's importer, but for these, which it or Cycles has in
another way:

- Ambient light is as bright everywhere: what scatters shines by itself. The sky lights nothing that scatters.
- Cycles does not let light through glass to a point. For shadow rays glass is as transparent as Fresnel's equations say.
- Blender's density of a volume lets another colour through than glTF's attenuation.
- Blender blends the border of a spot's cone by a smooth step. Here it is glTF's square of a linear function.
- Masks are seen as such by Eevee alone.
- Cycles knows a border between two media by the ratio of their indices: the hull of the water in the glass has it, and
  the glass's own border in the water is left out but for its shadow.
- The importer counts 683 lumens to a watt. Here watts are what lumens are in Shisen: white reflects what it gets.
"""
import json
import math
import struct
import sys
from pathlib import Path

import bpy
import numpy

# Debian's numpy no longer has a name that the importer uses.
numpy.bool = bool
# Shisen's light around a model.
AMBIENT = 0.05
SKY = ((0.17, 0.14, 0.11), (0.90, 0.90, 0.87), (0.30, 0.50, 0.85))


class Nodes:
    """The nodes of a material, a light or the world."""

    def __init__(self, owner):
        owner.use_nodes = True
        self.tree = owner.node_tree

    def find(self, kind):
        return next((node for node in self.tree.nodes if node.type == kind), None)

    def add(self, kind, *inputs, **settings):
        """Returns the first output of a new node; inputs are sockets, values, or None."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for number, value in enumerate(inputs):
            self.put(node.inputs[number], value)
        return node.outputs[0]

    def maths(self, operation, *inputs, **settings):
        return self.add("Math", *inputs, operation=operation, **settings)

    def put(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif value is not None:
            socket.default_value = value

    def value(self, socket):
        """What goes into a socket: another one, a value, or None."""
        if socket.links:
            return socket.links[0].from_socket
        return None if socket.hide_value else socket.default_value


def clear_shadow(nodes, surface, ior):
    """Returns a surface that is bent glass to the eye, and unbent glass to shadows."""
    geometry, path = nodes.add("NewGeometry").node, nodes.add("LightPath").node
    # Fresnel's node takes the reciprocal within a body; unbent light leaves by the angle it came in by.
    sign = nodes.maths("MULTIPLY_ADD", geometry.outputs["Backfacing"], -2.0, 1.0)
    reflected = nodes.add("Fresnel", nodes.maths("POWER", ior, sign))
    share = nodes.maths("SUBTRACT", 1.0, reflected)
    return nodes.add("MixShader", path.outputs["Is Shadow Ray"], surface, nodes.add("BsdfTransparent", share))


def paint(material):
    """Changes a material of the importer."""
    nodes = Nodes(material)
    facets, output = nodes.find("BSDF_PRINCIPLED"), nodes.find("OUTPUT_MATERIAL")
    facets.distribution = "MULTI_GGX"
    inputs = facets.inputs
    surface = facets.outputs[0]
    if inputs["Metallic"].default_value + inputs["Transmission"].default_value == 0:
        colour = nodes.value(inputs["Base Color"])
        lit = nodes.add("BsdfDiffuse", colour, 0.0, nodes.value(inputs["Normal"]))
        # Seen, but not from where light scatters.
        scatters = nodes.add("LightPath").node.outputs["Is Diffuse Ray"]
        glow = nodes.add("Emission", colour, nodes.maths("MULTIPLY_ADD", scatters, -AMBIENT, AMBIENT))
        surface = nodes.add("AddShader", lit, glow)
        material.cycles.sample_as_light = False
    if material.blend_method == "CLIP":
        is_there = nodes.maths("GREATER_THAN", nodes.value(inputs["Alpha"]), material.alpha_threshold)
        for link in inputs["Alpha"].links:
            nodes.tree.links.remove(link)
        inputs["Alpha"].default_value = 1
        surface = nodes.add("MixShader", is_there, nodes.add("BsdfTransparent"), surface)
    if inputs["Transmission"].default_value > 0:
        surface = clear_shadow(nodes, surface, inputs["IOR"].default_value)
    nodes.put(output.inputs["Surface"], surface)
    volume = nodes.find("VOLUME_ABSORPTION")
    if volume and min(volume.inputs["Color"].default_value) == 1:
        nodes.tree.nodes.remove(volume)
    elif volume:
        # Cycles absorbs the density times what the colour is short of white.
        density, colour = volume.inputs["Density"].default_value, volume.inputs["Color"].default_value
        # Without a density there is no body: Cycles adds those up that are within one another.
        lost = [-density * math.log(channel) for channel in colour[:3]]
        volume.inputs["Density"].default_value = max(lost)
        volume.inputs["Color"].default_value = [1 - each / max(lost) for each in lost] + [1]


def shine(light, described):
    light.shadow_soft_size = 0
    if light.type == "SUN":
        light.angle = 0
    if light.type == "SPOT":
        inner, outer = (math.cos(described["spot"][name]) for name in ("innerConeAngle", "outerConeAngle"))
        light.type = "POINT"
        nodes = Nodes(light)
        normal = nodes.tree.nodes.new("ShaderNodeTexCoord").outputs["Normal"]
        along = nodes.tree.nodes.new("ShaderNodeSeparateXYZ")
        nodes.put(along.inputs[0], normal)
        slope = 1 / (inner - outer)
        share = nodes.maths("MULTIPLY_ADD", along.outputs["Z"], -slope, -outer * slope, use_clamp=True)
        nodes.put(nodes.find("EMISSION").inputs["Strength"], nodes.maths("POWER", share, 2.0))


def sky(scene):
    world = scene.world = bpy.data.worlds.new("sky")
    world.cycles_visibility.diffuse = False
    nodes = Nodes(world)
    parts = nodes.tree.nodes.new("ShaderNodeSeparateXYZ")
    nodes.put(parts.inputs[0], nodes.add("TexCoord"))
    height = nodes.maths("MULTIPLY_ADD", parts.outputs["Z"], 0.5, 0.5)
    colours = nodes.add("ValToRGB", height)
    stops = colours.node.color_ramp.elements
    stops.new(0.5)
    for stop, colour in zip(stops, SKY):
        stop.color = (*colour, 1)
    nodes.put(nodes.find("BACKGROUND").inputs["Color"], colours)


def set_up(scene, side, samples):
    scene.camera = next(thing for thing in scene.objects if thing.type == "CAMERA")
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x = render.resolution_y = side
    render.dither_intensity = 0
    render.image_settings.file_format = "PNG"
    scene.view_settings.view_transform = "Standard"
    cycles.samples = samples
    cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = cycles.transparent_max_bounces = 32
    cycles.diffuse_bounces = 0
    cycles.blur_glossy = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0


def load(file):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(file), convert_lighting_mode="COMPAT")
    raw = file.read_bytes()
    described = json.loads(raw[20:20 + struct.unpack_from("<I", raw, 12)[0]])["extensions"]["KHR_lights_punctual"]["lights"]
    things = bpy.context.scene.objects
    lights = [thing for thing in things if thing.type == "LIGHT"]
    # A light's number in the file is in its node's name.
    for thing in lights:
        shine(thing.data, described[int(thing.name.split()[-1])])
    for material in bpy.data.materials:
        paint(material)


def main(out, side, samples, *files):
    for file in map(Path, files):
        load(file)
        scene = bpy.context.scene
        sky(scene)
        set_up(scene, int(side), int(samples))
        scene.render.filepath = str(Path(out) / file.stem) + ".png"
        bpy.ops.render.render(write_still=True)
    for thing in scene.objects:
        thing.hide_render = True
    scene.render.filepath = str(Path(out) / "sky.png")
    bpy.ops.render.render(write_still=True)


if bpy.app.version[0] != 3:
    sys.exit(f"Blender {bpy.app.version_string} names its nodes otherwise than Blender 3")
main(*sys.argv[sys.argv.index("--") + 1:])
