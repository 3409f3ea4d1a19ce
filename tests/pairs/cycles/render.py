"""Renders glTF files by Blender's Cycles as Shisen shows them.

    blender --background --python render.py -- OUT SIDE SAMPLES FILE...

writes OUT/NAME.png, SIDE pixels wide and high, for each file NAME.glb, and OUT/sky.png without its things. Only light
that comes straight from lights or the sky counts, and what mirrors and glass show of it. Materials and lights are those
of Blender's importer, but for what it or Cycles has in another way than glTF or Shisen:

- What is neither metal nor glass scatters as Lambert says, not Disney. Ambient light is as bright everywhere: such
  surfaces shine by themselves, and the sky does not light them.
- Metal mirrors the sky alone.
- Cycles lets no light through glass to a point. Here glass is transparent to shadow rays as far as Fresnel says.
- A volume absorbs its density times what its colour is short of white; glTF's colour is what is left after a distance.
- The border of a spot's cone is a smooth step; glTF's is the square of a linear function.
- Masks are there for Eevee alone.
- The importer counts 683 lumens to a watt; here a watt is what a lumen is in Shisen.
"""
import math
import sys
from pathlib import Path

import bpy
import numpy

# The importer uses a name that numpy no longer has.
numpy.bool = bool
# Shisen's light around a model with lights: its sky from the nadir over the horizon to the zenith.
AMBIENT = 0.05
SKY = ((0.17, 0.14, 0.11), (0.90, 0.90, 0.87), (0.30, 0.50, 0.85))


class Nodes:
    """The nodes of a material, a light or the world."""

    def __init__(self, owner):
        owner.use_nodes = True
        self.tree = owner.node_tree

    def find(self, kind):
        return next((node for node in self.tree.nodes if node.type == kind), None)

    def put(self, socket, value):
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        elif value is not None:
            socket.default_value = value

    def add(self, kind, *inputs, output=0, **settings):
        """Returns an output of a new node; its inputs are sockets, values, or None."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in settings.items():
            setattr(node, name, value)
        for socket, value in zip(node.inputs, inputs):
            self.put(socket, value)
        return node.outputs[output]

    def maths(self, operation, *inputs, **settings):
        return self.add("Math", *inputs, operation=operation, **settings)


def inputs_of(material):
    return Nodes(material).find("BSDF_PRINCIPLED").inputs


def source(socket):
    """Returns what a socket is linked to, or its value; None for a direction that is not linked."""
    if socket.links:
        return socket.links[0].from_socket
    return None if socket.hide_value else socket.default_value


def paint(material):
    nodes, inputs = Nodes(material), inputs_of(material)
    facets = nodes.find("BSDF_PRINCIPLED")
    facets.distribution = "MULTI_GGX"
    surface = facets.outputs[0]
    path = nodes.tree.nodes.new("ShaderNodeLightPath").outputs
    if inputs["Transmission"].default_value > 0:
        # Fresnel's node takes the reciprocal within a body; unbent light leaves by the angle it came in by.
        inside = nodes.add("NewGeometry", output="Backfacing")
        index = nodes.maths("POWER", inputs["IOR"].default_value, nodes.maths("MULTIPLY_ADD", inside, -2.0, 1.0))
        share = nodes.maths("SUBTRACT", 1.0, nodes.add("Fresnel", index))
        surface = nodes.add("MixShader", path["Is Shadow Ray"], surface, nodes.add("BsdfTransparent", share))
        volume = nodes.find("VOLUME_ABSORPTION").inputs
        lost = [-volume["Density"].default_value * math.log(channel) for channel in volume["Color"].default_value[:3]]
        most = max(*lost, 1e-9)
        volume["Density"].default_value, volume["Color"].default_value = most, [1 - each / most for each in lost] + [1]
    elif inputs["Metallic"].default_value == 0:
        colour = source(inputs["Base Color"])
        # Seen, but not from where light scatters.
        glow = nodes.maths("MULTIPLY_ADD", path["Is Diffuse Ray"], -AMBIENT, AMBIENT)
        lit = nodes.add("BsdfDiffuse", colour, 0.0, source(inputs["Normal"]))
        surface = nodes.add("AddShader", lit, nodes.add("Emission", colour, glow))
        material.cycles.sample_as_light = False
    if material.blend_method == "CLIP":
        is_there = nodes.maths("GREATER_THAN", source(inputs["Alpha"]), material.alpha_threshold)
        surface = nodes.add("MixShader", is_there, nodes.add("BsdfTransparent"), surface)
    nodes.put(nodes.find("OUTPUT_MATERIAL").inputs["Surface"], surface)


def shine(light):
    light.shadow_soft_size = 0
    if light.type == "SUN":
        light.angle = 0
    elif light.type == "SPOT":
        outer = light.spot_size / 2
        inner, outer = math.cos(outer * (1 - light.spot_blend)), math.cos(outer)
        light.type = "POINT"
        nodes, slope = Nodes(light), 1 / (inner - outer)
        along = nodes.add("SeparateXYZ", nodes.add("TexCoord", output="Normal"), output="Z")
        share = nodes.maths("MULTIPLY_ADD", along, -slope, -outer * slope, use_clamp=True)
        nodes.put(nodes.find("EMISSION").inputs["Strength"], nodes.maths("POWER", share, 2.0))


def add_sky(scene):
    world = scene.world = bpy.data.worlds.new("sky")
    world.cycles_visibility.diffuse = False
    nodes = Nodes(world)
    height = nodes.add("SeparateXYZ", nodes.add("TexCoord"), output="Z")
    colours = nodes.add("ValToRGB", nodes.maths("MULTIPLY_ADD", height, 0.5, 0.5))
    stops = colours.node.color_ramp.elements
    stops.new(0.5)
    for stop, colour in zip(stops, SKY):
        stop.color = (*colour, 1)
    nodes.put(nodes.find("BACKGROUND").inputs["Color"], colours)


def set_up(scene, side, samples):
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = side
    scene.render.dither_intensity = 0
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples = samples
    cycles.use_denoising = False
    cycles.pixel_filter_type = "BOX"
    cycles.max_bounces = cycles.glossy_bounces = cycles.transmission_bounces = cycles.transparent_max_bounces = 32
    cycles.diffuse_bounces = cycles.blur_glossy = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0


def render(scene, path):
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


out, side, samples, *files = sys.argv[sys.argv.index("--") + 1:]
for file in files:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=file, convert_lighting_mode="COMPAT")
    scene = bpy.context.scene
    set_up(scene, int(side), int(samples))
    add_sky(scene)
    has_metal = any(inputs_of(material)["Metallic"].default_value > 0 for material in bpy.data.materials)
    for thing in scene.objects:
        if thing.type == "MESH":
            thing.visible_glossy = not has_metal
        elif thing.type == "LIGHT":
            shine(thing.data)
        else:
            scene.camera = thing
    for material in bpy.data.materials:
        paint(material)
    render(scene, f"{out}/{Path(file).stem}.png")
for thing in scene.objects:
    thing.hide_render = True
render(scene, f"{out}/sky.png")
