"""Scores pictures of the front wall against references, as FovVideoVDP does for a viewer who looks at one place of it.

    python3 jod.py JOBS.json

JOBS.json is a list of {"name", "tests": [files], "references": [files], "look": [yaw, pitch], "least"}. More than one
file is a sequence at 60 Hz; angles are degrees, positive to the right and up. The wall is 3 m wide, 1.5 m from the eye,
and shows white with 100 cd/m2. Prints a table; the exit status is 1 where a score is below its least.

A score is in JOD: 10 where no difference is seen, 9 where three of four people tell the pictures apart. Beside it
are, by distance from what is looked at, the mean difference in codes of 255, and of a sequence how much the difference
changes over time.
"""
import json
import sys

import numpy
import pyfvvdp
import torch
from PIL import Image

WIDTH, DISTANCE = 3.0, 1.5
RINGS = ((0, 8), (8, 15), (15, 25), (25, 35), (35, 60))


def pictures(files):
    return numpy.stack([numpy.asarray(Image.open(file).convert("RGB"), numpy.float32) / 255 for file in files], -1)


def score(job):
    tests, references = pictures(job["tests"]), pictures(job["references"])
    height, width = tests.shape[:2]
    yaw, pitch = numpy.radians(job["look"])
    gaze = numpy.array([numpy.tan(yaw), -numpy.tan(pitch) / numpy.cos(yaw), 1.0])
    middle = numpy.array([width, height]) / 2 - 0.5
    fixation = middle + gaze[:2] * DISTANCE / WIDTH * width
    metric = pyfvvdp.fvvdp(
        display_photometry=pyfvvdp.fvvdp_display_photo_eotf(Y_peak=100, contrast=1000, EOTF="sRGB", E_ambient=0),
        display_geometry=pyfvvdp.fvvdp_display_geometry(
            (width, height), fov_horizontal=2 * numpy.degrees(numpy.arctan(WIDTH / 2 / DISTANCE))),
        foveated=True, heatmap=None, quiet=True, device=torch.device("cpu"))
    if tests.shape[-1] == 1:
        jod, _ = metric.predict(tests[..., 0], references[..., 0], dim_order="HWC", fixation_point=fixation)
    else:
        jod, _ = metric.predict(tests, references, dim_order="HWCF", frames_per_second=60, fixation_point=fixation)
    row, column = numpy.mgrid[0:height, 0:width]
    ray = numpy.stack([(column - middle[0]) * WIDTH / width, (row - middle[1]) * WIDTH / width, numpy.full(row.shape, DISTANCE)], -1)
    cosine = ray @ gaze / numpy.linalg.norm(ray, axis=-1) / numpy.linalg.norm(gaze)
    angle = numpy.degrees(numpy.arccos(numpy.clip(cosine, -1, 1)))
    off = 255 * (tests - references).mean(2)
    rings = [(angle >= a) & (angle < b) for a, b in RINGS]
    return float(jod), [numpy.abs(off).mean(-1)[ring].mean() for ring in rings], [off.std(-1)[ring].mean() for ring in rings]


failed = False
rings = " ".join(f"{f'{a}-{b}':>6}" for a, b in RINGS)
print(f"{'':16}    JOD asked    codes off, at {rings} degrees, and their change")
for job in json.load(open(sys.argv[1])):
    jod, off, change = score(job)
    is_below = jod < job["least"]
    failed |= is_below
    text = " ".join(f"{value:6.2f}" for value in off)
    if len(job["tests"]) > 1:
        text += " " + " ".join(f"{value:6.2f}" for value in change)
    print(f"{job['name']:16} {jod:6.2f} {job['least']:5.2f}{' <' if is_below else '  '} {'':14}{text}", flush=True)
sys.exit(failed)
