"""Makes the numbers of paper-optics.md.

    starbreak demo --preset paper -o DEMO --seed 3; python3 docs/theory/check_paper_optics.py DEMO

Renders the cracks of a demo folder by the formulas of the page and compares the pictures with
those in the folder. Needs numpy and Pillow. The recipe must be the preset `paper`, or that with
`optics.far_focus_blur=crack-and-scene`.
"""

import json
import math
import sys

import numpy as np
from PIL import Image

AZIMUTH, ZENITH, LIGHT, KERNEL, SIGMA = math.radians(35), math.radians(45), 200.0, 15, 2.6


def half_plane(distance, p, q):
    """Area of the unit square behind an edge with the unit normal (p, q)."""
    a, b = max(abs(p), abs(q)), min(abs(p), abs(q))
    if b < 1e-6:
        return np.clip(0.5 + distance / a, 0, 1)
    r, i = (a + b) / 2, (a - b) / 2
    square = lambda x: np.maximum(x, 0) ** 2
    ends = square(distance + r) - square(distance + i)
    starts = square(distance - i) - square(distance - r)
    return np.minimum((ends - starts) / (2 * a * b), 1)


def strip(at, half, p, q):
    return half_plane(at + half, p, q) - half_plane(at - half, p, q)


def blur(image):
    half = KERNEL // 2
    taps = np.exp(-0.5 * (np.arange(-half, half + 1) / SIGMA) ** 2)
    taps /= taps.sum()
    padded = np.pad(image, ((half, half), (half, half), (0, 0)), "reflect")
    height, width = image.shape[:2]
    rows = sum(tap * padded[:, k : k + width] for k, tap in enumerate(taps))
    return sum(tap * rows[k : k + height] for k, tap in enumerate(taps))


def read(folder, name, mode=None):
    picture = Image.open(f"{folder}/{name}.png")
    return np.array(picture.convert(mode) if mode else picture).astype(float)


def main(folder):
    scene = read(folder, "scene", "RGB")
    with open(f"{folder}/network.json", encoding="utf-8") as file:
        network = json.load(file)
    with open(f"{folder}/far-focus.json", encoding="utf-8") as file:
        both = "crack-and-scene" in file.read()
    x, y = np.array(network["nodes"]["x"]), np.array(network["nodes"]["y"])
    start, end = np.array(network["segments"]["from"]), np.array(network["segments"]["to"])
    dx, dy = x[end] - x[start], y[end] - y[start]
    length = np.hypot(dx, dy)
    nx, ny = -dy / length, dx / length
    energy = (abs(math.cos(AZIMUTH) * nx + math.sin(AZIMUTH) * ny)
              + abs(math.cos(ZENITH) * nx + math.sin(ZENITH) * ny)) / 2
    print(f"{len(energy)} segments: E from {energy.min():.4f} to {energy.max():.4f}")
    for name, divisor in (("sum", energy.sum()), ("max", energy.max()),
                          ("mean", energy.mean()), ("one", 1.0)):
        level = LIGHT * energy / divisor
        print(f"  {name:4} I_c: {level.min():.3f} to {level.max():.3f}, median "
              f"{np.median(level):.3f}")

    height, width = scene.shape[:2]
    covered, weighted = np.zeros((height, width)), np.zeros((height, width))
    for k in range(len(energy)):
        ux, uy = dx[k] / length[k], dy[k] / length[k]
        middle_x, middle_y = x[start[k]] + dx[k] / 2, y[start[k]] + dy[k] / 2
        x0, x1 = sorted((x[start[k]], x[end[k]]))
        y0, y1 = sorted((y[start[k]], y[end[k]]))
        x0, x1 = max(0, int(x0 - 2)), min(width, int(x1 + 3))
        y0, y1 = max(0, int(y0 - 2)), min(height, int(y1 + 3))
        px, py = np.meshgrid(np.arange(x0, x1) + 0.5 - middle_x,
                             np.arange(y0, y1) + 0.5 - middle_y)
        along, across = ux * px + uy * py, ux * py - uy * px
        share = strip(across, 0.5, uy, ux) * strip(along, length[k] / 2, ux, uy)
        covered[y0:y1, x0:x1] += share
        weighted[y0:y1, x0:x1] += share * energy[k] / energy.max()
    drawn = covered >= 0.5 / 255
    bright = np.where(drawn, weighted / np.maximum(covered, 1e-12), 0)[..., None]
    mask = np.where(drawn, np.minimum(covered, 1), 0)[..., None]

    if both:
        far = blur(scene * (1 - mask) + mask * bright * LIGHT)
    else:
        far = scene * (1 - blur(mask)) + blur(mask * bright) * LIGHT
    short = blur(scene) * (1 - mask) + mask * bright * LIGHT
    for name, own in (("far-focus", far), ("short-focus", short)):
        theirs, region = read(folder, name, "RGB"), read(folder, f"{name}.region", "L") > 0
        own = np.where(region[..., None], np.floor(own + 0.5), scene)
        apart = np.abs(own - theirs)
        outside = (theirs != scene).any(-1) & ~region
        print(f"{name}: region {region.mean():.1%} of the frame, changed outside "
              f"{outside.sum()} of {(~region).sum()} px; own rendering differs by at most "
              f"{apart.max():.0f} level, in {np.count_nonzero(apart)} of {apart.size} samples")
    reach, grown = KERNEL // 2, np.zeros_like(drawn)
    framed = np.pad(drawn, reach)
    for j in range(KERNEL):
        for i in range(KERNEL):
            grown |= framed[j : j + height, i : i + width]
    same = np.array_equal(grown, read(folder, "far-focus.region", "L") > 0)
    print(f"region = crack pixels dilated by {reach} px: {same}")


if len(sys.argv) != 2:
    sys.exit(__doc__)
main(sys.argv[1])
