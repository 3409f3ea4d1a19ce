"""Writes two scenes of thin, small and fine things before a wall of 3 m that is 1.5 m away.

    python3 scenes.py FOLDER [SEED]

fence.toml: pickets, two bare trees, signs with glyphs, checkered wall and ground, shadows of the trees.
wires.toml: sagging wires, slanted rods, balls, some of them mirrors, stripes that converge.
box.obj: the cube of fence.toml.
front.toml: the wall, of 1024 pixels a side.

Widths are 1 to 4 pixels of a wall of 1024 pixels. The seed alone decides where things are.
"""
import math
import random
import sys
from pathlib import Path

SKY = "[background]\nzenith = [0.25, 0.45, 0.85]\nhorizon = [0.9, 0.9, 0.85]\nnadir = [0.12, 0.2, 0.08]\n"
FRONT = """[[wall]]
name = "front"
lower_left = [-1.5, -1.5, -1.5]
lower_right = [1.5, -1.5, -1.5]
upper_left = [-1.5, 1.5, -1.5]
pixels = [1024, 1024]
"""
SQUARE = '[meshes.square]\nbuiltin = "square"\n'
CUBE = """v -.5 -.5 -.5
v .5 -.5 -.5
v .5 .5 -.5
v -.5 .5 -.5
v -.5 -.5 .5
v .5 -.5 .5
v .5 .5 .5
v -.5 .5 .5
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
"""
# Letters and figures in five rows of three cells, from the top.
GLYPHS = ["111100111100111", "101101111101101", "111100111001111", "111010010010111", "111101101101101",
          "101101111001001", "111001010010010", "111001111100111", "111101111101101", "111010010010010"]


def numbers(values):
    return "[" + ", ".join(f"{value:.5f}" for value in values) + "]"


def material(name, diffuse, mirror=0.0, texture=None):
    text = f"[materials.{name}]\ndiffuse = {numbers(diffuse)}\n"
    if mirror:
        text += f"mirror = {numbers([mirror] * 3)}\nspecular = [0.7, 0.7, 0.7]\nshininess = 200\n"
    return text + (f'texture = "{texture}"\n' if texture else "")


def checker(name, light, dark, repeats):
    colours = f"{numbers(light)}, {numbers(dark)}"
    return f"[textures.{name}]\nchecker = {{ colours = [{colours}] }}\nrepeats = {numbers(repeats)}\n"


def thing(shape, name, position, rotation=(0, 0, 0), scale=(1, 1, 1)):
    return (f'[[object]]\n{shape}\nmaterial = "{name}"\nposition = {numbers(position)}\n'
            f"rotation_degrees = {numbers(rotation)}\nscale = {numbers(scale)}\n")


def rod(a, b, radius, name):
    """Returns a thin spheroid from a to b."""
    length = math.dist(a, b)
    x, y, z = ((q - p) / length for p, q in zip(a, b))
    rotation = (0, math.degrees(math.atan2(z, y)), -math.degrees(math.asin(max(-1, min(1, x)))))
    shape = f"spheroid = {{ equatorial_radius = {radius:.5f}, polar_radius = {length / 2:.4f} }}"
    return thing(shape, name, [(p + q) / 2 for p, q in zip(a, b)], rotation)


def branch(rng, start, direction, length, radius, depth):
    """Returns a branch and those that grow from it."""
    text = rod(start, [s + length * d for s, d in zip(start, direction)], radius, "bark")
    for _ in range(3 if depth else 0):
        turned = [d + rng.uniform(-0.75, 0.75) for d in direction]
        turned[1] += 0.15
        size = math.hypot(*turned)
        at = length * rng.uniform(0.55, 0.98)
        foot = [s + at * d for s, d in zip(start, direction)]
        text += branch(rng, foot, [c / size for c in turned], length * rng.uniform(0.55, 0.75),
                       max(0.0035, radius * 0.6), depth - 1)
    return text


def fence(rng):
    def box(name, centre, size, roll=0.0):
        return thing('mesh = "box"', name, centre, (0, 0, roll), size)

    text = "ambient = [0.1, 0.1, 0.12]\n" + SKY + SQUARE + '[meshes.box]\nfile = "box.obj"\n'
    text += checker("bricks", [0.62, 0.25, 0.18], [0.85, 0.8, 0.72], [44, 60])
    text += checker("paving", [0.8, 0.8, 0.76], [0.2, 0.2, 0.22], [70, 30])
    text += material("bricks", [1, 1, 1], texture="bricks") + material("paving", [0.9] * 3, texture="paving")
    text += material("bark", [0.12, 0.08, 0.05]) + material("paint", [0.88, 0.88, 0.85])
    text += material("ink", [0.03, 0.03, 0.04]) + material("sign", [0.8, 0.75, 0.2])
    text += '[[light]]\ntype = "point"\nposition = [2.5, 4, 1]\n'
    text += thing('mesh = "square"', "bricks", [2.6, 0.1, -7], (0, 90, 0), (7, 1, 6))
    text += thing('mesh = "square"', "paving", [0, -1.5, -6.5], scale=(18, 1, 10))
    for k in range(46):
        centre = [0.2 * k - 4.6, -0.95 + rng.uniform(-0.02, 0.02), -4.2]
        text += box("paint" if k % 3 else "bark", centre, [rng.uniform(0.012, 0.03), 0.95, 0.01], rng.uniform(-1.5, 1.5))
    for y in (-1.2, -0.7):
        text += box("paint", [0, y, -4.22], [9.3, 0.018, 0.01])
    for x, z in ((-2.3, -4.6), (1.4, -5.0)):
        text += branch(rng, [x, -1.5, z], [0, 1, 0], 1.7, 0.045, 4)
    for _ in range(7):
        x, y, z = rng.uniform(-3.2, 2.2), rng.uniform(-0.2, 2.6), rng.uniform(-4, -3)
        cell = rng.uniform(0.009, 0.02)
        text += box("sign", [x + 12 * cell, y - 2 * cell, z - 0.02], [26 * cell, 8 * cell, 0.01])
        for k in range(6):
            for bit, on in enumerate(rng.choice(GLYPHS)):
                if on == "1":
                    text += box("ink", [x + (4 * k + bit % 3 + 1) * cell, y - bit // 3 * cell, z], [cell, cell, 0.01])
    return text


def wires(rng):
    text = "ambient = [0.08, 0.08, 0.1]\n" + SKY + SQUARE
    text += checker("stripes", [0.9, 0.88, 0.8], [0.1, 0.15, 0.3], [64, 1]) + material("stripes", [0.85] * 3, texture="stripes")
    text += material("steel", [0.06, 0.06, 0.07]) + material("white", [0.9] * 3) + material("green", [0.1, 0.55, 0.2])
    text += material("orange", [0.85, 0.4, 0.05]) + material("chrome", [0.1] * 3, mirror=0.8)
    text += '[[light]]\ntype = "directional"\ndirection = [0.4, -1, -0.35]\ncolour = [0.9, 0.9, 0.85]\n'
    text += thing('mesh = "square"', "stripes", [0, -1.5, -6], (25, 0, 0), (14, 1, 12))
    for _ in range(26):
        y, z, name = rng.uniform(-1.1, 2.9), rng.uniform(-5.5, -3), rng.choice(["steel", "steel", "white"])
        left, right, radius = y + rng.uniform(-0.6, 0.6), y + rng.uniform(-0.6, 0.6), rng.uniform(0.0025, 0.006)
        at = [(9 * t - 4.5, left + t * (right - left) - 0.5 * t * (1 - t), z) for t in (k / 8 for k in range(9))]
        text += "".join(rod(a, b, radius, name) for a, b in zip(at, at[1:]))
    for _ in range(40):
        x, z = rng.uniform(-4, 4), rng.uniform(-6, -2.8)
        foot, top = [x, rng.uniform(-1.5, 0), z], [x + rng.uniform(-0.5, 0.5), rng.uniform(0.3, 2.9), z]
        text += rod(foot, top, rng.uniform(0.003, 0.01), rng.choice(["steel", "white", "green"]))
    for k in range(190):
        centre = [rng.uniform(-4, 4), rng.uniform(-1.4, 3), rng.uniform(-7, -2.6)]
        shape = f"sphere = {{ radius = {rng.uniform(0.01, 0.07):.4f} }}"
        text += thing(shape, ["steel", "orange", "white", "green", "chrome"][k % 5], centre)
    return text


if __name__ == "__main__":
    folder, seed = Path(sys.argv[1]), int((sys.argv[2:] or ["7"])[0])
    (folder / "box.obj").write_text(CUBE)
    (folder / "front.toml").write_text(FRONT)
    for make in (fence, wires):
        (folder / f"{make.__name__}.toml").write_text(make(random.Random(seed)))
