#!/usr/bin/env python3
"""The rendered image against OpenCV's Gaussian blur, and crack brightness against the equations, from files alone.

usage: opencv_render.py PATH_TO_STARBREAK

Black light (I_c = 0) leaves I(1 - G*M), G*(I(1 - M)) and (G*I)(1 - M); M comes from the written crack mask, whose
8 bits alone allow half a level, rounding another half. Brightness: pixels that one crack covers in full show I*E.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import cv2
import numpy as np

KERNEL, SIGMA = 15, 2.6


def crack(starbreak, folder, image, *overrides):
    path = folder / "scene.png"
    cv2.imwrite(str(path), image)
    sets = [part for override in overrides for part in ("--set", override)]
    subprocess.run([starbreak, "crack", path, "-o", folder / "out", "--preset", "paper", "--seed", "5", "--quiet", *sets], check=True)
    out = cv2.imread(str(folder / "out/scene.png")).astype(float)
    mask = cv2.imread(str(folder / "out/scene.crack.png"), cv2.IMREAD_GRAYSCALE).astype(float) / 255
    region = cv2.imread(str(folder / "out/scene.region.png"), cv2.IMREAD_GRAYSCALE) > 0
    return out, mask, region, json.loads((folder / "out/scene.json").read_text())


def blur(image):
    return cv2.GaussianBlur(image, (KERNEL, KERNEL), SIGMA, borderType=cv2.BORDER_REFLECT_101)


def main():
    starbreak = sys.argv[1]
    image = np.random.default_rng(1).integers(0, 256, (375, 1242, 3)).astype(np.uint8)
    scene, worst = image.astype(float), 0.0
    modes = {
        "far focus, crack blurred": (["optics.far_focus_blur=crack"], lambda m: scene * (1 - blur(m))[..., None]),
        "far focus, both blurred": (["optics.far_focus_blur=crack-and-scene"], lambda m: blur(scene * (1 - m[..., None]))),
        "short focus": (["camera.focus_distance_m=short"], lambda m: blur(scene) * (1 - m[..., None])),
    }
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for label, (overrides, expect) in modes.items():
            out, mask, region, _ = crack(starbreak, folder, image, "optics.light_intensity=[0,0,0]", *overrides)
            error = np.abs(out - expect(mask))[region].max()
            outside = int((out != scene)[~region].sum())
            print(f"{label:26} largest difference in the region {error:.3f} levels, changed samples outside {outside}")
            assert error <= 1.01 and outside == 0
            worst = max(worst, error)

        overrides = ["camera.focus_distance_m=short", "optics.normalization=one", "optics.line_width_px=4"]
        out, mask, _, record = crack(starbreak, folder, image, *overrides)
        size = f"{image.shape[1]}x{image.shape[0]}"
        network = folder / "network.json"
        command = [starbreak, "simulate", "--preset", "paper", "--seed", str(record["item"]["seed"]), "--size", size, "-o", network, "--quiet"]
        subprocess.run(command, check=True)
        data = json.loads(network.read_text())
        ends = np.array([[data["nodes"][c][k] for c in "xy"] for side in ("from", "to") for k in data["segments"][side]])
        first, last = np.split(ends, 2)
        way = last - first
        length = np.linalg.norm(way, axis=1)
        normal = way[:, ::-1] * [-1, 1] / length[:, None]
        azimuth, zenith = math.radians(35), math.radians(45)
        energy = sum(abs(normal @ [math.cos(a), math.sin(a)]) for a in (azimuth, zenith)) / 2
        errors = []
        for a, b, e, segment in zip(first, last, energy, length):
            middle = (a + b) / 2
            x, y = int(middle[0]), int(middle[1])
            to_middle = middle - first
            distance = np.abs(way[:, 0] * to_middle[:, 1] - way[:, 1] * to_middle[:, 0]) / length
            along = np.einsum("ij,ij->i", to_middle, way) / length
            close = (distance < 5) & (along > -5) & (along < length + 5)
            if segment > 12 and close.sum() == 1 and mask[y, x] == 1:
                errors.append(abs(out[y, x, 0] - 200 * e))
        print(f"brightness I*E             {len(errors)} lone cracks, largest difference {max(errors):.3f} levels")
        assert len(errors) >= 5 and max(errors) <= 0.51


if __name__ == "__main__":
    main()
