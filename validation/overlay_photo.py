#!/usr/bin/env python3
"""Photographs of broken glass over a scene against numpy and OpenCV, from files alone.

usage: overlay_photo.py PATH_TO_STARBREAK

A drawn star is the photograph: in color on black, on white, and cut out. Here it is shrunk by OpenCV (INTER_AREA) in
linear light, spread by a disc sampled 16 x 16 times per pixel, and put over the scene by I0 (1 - a) + W c; the paper's
optics by OpenCV's Gaussian blur. Then what a JPEG leaves in a black background, on which the default floor rests.
"""
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import cv2
import numpy as np

SIZE = (620, 188)
PER_PX = 3
SKY, ZENITH, GROUND = 0.9, 0.5, 0.2
FLOOR = 0.03


def decode(code):
    return np.where(code <= 0.04045, code / 12.92, ((code + 0.055) / 1.055) ** 2.4)


def encode(light):
    light = np.clip(light, 0, 1)
    return np.where(light <= 0.04045 / 12.92, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)


def star(rng, thickest=9):
    """Rays of many colors and widths on black, away from the border."""
    width, height = SIZE[0] * PER_PX, SIZE[1] * PER_PX
    image = np.zeros((height, width, 3), np.uint8)
    middle = np.array([width // 2, height // 2])
    for _ in range(70):
        angle, reach = rng.uniform(0, 2 * math.pi), rng.uniform(0.2, 0.9)
        end = middle + reach * middle * [math.cos(angle), math.sin(angle)]
        color = [int(c) for c in rng.integers(60, 256, 3)]
        cv2.line(image, middle.tolist(), end.astype(int).tolist(), color, int(rng.integers(1, thickest)), cv2.LINE_AA)
    return image


def disc(radius):
    reach, fine = math.ceil(radius + 1), 16
    at = (np.arange((2 * reach + 1) * fine) + 0.5) / fine - reach - 0.5
    inside = (at[:, None] ** 2 + at[None, :] ** 2 <= radius**2).astype(float)
    kernel = inside.reshape(2 * reach + 1, fine, 2 * reach + 1, fine).sum((1, 3))
    return kernel / kernel.sum()


def spread(planes, diameter, border):
    return planes if diameter == 0 else cv2.filter2D(planes, -1, disc(diameter / 2), borderType=border)


def run(starbreak, folder, photo, *flags):
    command = [starbreak, "crack", folder / "scene.png", "-o", folder / "out", "--overlay", photo, "--quiet", *flags]
    subprocess.run(command, check=True)
    record = json.loads((folder / "out/scene.json").read_text())
    mask = cv2.imread(str(folder / "out/scene.crack.png"), cv2.IMREAD_GRAYSCALE)
    return cv2.imread(str(folder / "out/scene.png")).astype(float), mask.astype(float), record


def planes_of(background, image):
    """Opacity and light at the size of the frame."""
    small = lambda plane: cv2.resize(plane, SIZE, interpolation=cv2.INTER_AREA)
    codes = image.astype(float) / 255
    if background == "black":
        light = decode(np.clip((codes - FLOOR) / (1 - FLOOR), 0, 1))
        return small(light), small(light)
    if background == "white":
        return small(1 - decode(np.clip(codes / (1 - FLOOR), 0, 1))), np.zeros((*SIZE[::-1], 3))
    alpha = codes[..., 3:]
    return np.repeat(small(alpha)[..., None], 3, 2), small(alpha * decode(codes[..., :3]))


def physical(starbreak, folder, photos, scene):
    # What a vertical plane sees of the sky (Chou and Saul: 2/3 pi of the zenith) and the ground.
    zenith = 2 / (3 * math.pi)
    white = (0.5 - zenith) * SKY + zenith * ZENITH + 0.5 * GROUND
    sets = [f"optics.{key}=[{value},{value},{value}]" for key, value in [("sky_horizon", SKY), ("sky_zenith", ZENITH), ("ground", GROUND)]]
    sets += ["glass.rake_deg=0", "glass.thickness_mm=0.1", "glass.distance_m=0.2"]
    before = decode(scene / 255)
    for background, image in photos.items():
        path = folder / f"{background}.png"
        cv2.imwrite(str(path), image)
        opacity, light = planes_of(background, image)
        for focus, more in [("far", []), ("far", ["camera.f_number=0.6"]), ("far", ["camera.focal_length_mm=100", "camera.f_number=6"]), ("short", [])]:
            flags = [part for key in [*sets, *more, f"camera.focus_distance_m={focus}"] for part in ("--set", key)]
            out, mask, record = run(starbreak, folder, path, *flags)
            camera = record["camera"]
            a, c = (spread(plane, camera["glass_disc_px"], cv2.BORDER_CONSTANT) for plane in (opacity, light))
            behind = spread(before, camera["scene_disc_px"], cv2.BORDER_REFLECT)
            error = np.abs(out - 255 * encode(behind * (1 - a) + white * c))
            mask_error = np.abs(mask - 255 * opacity.max(2)).max()
            print(f"physical, {background:5}, glass {camera['glass_disc_px']:6.2f} px, scene {camera['scene_disc_px']:5.2f} px: "
                  f"largest difference {error.max():.2f} levels, mean {error.mean():.3f}; mask {mask_error:.2f}")
            assert error.max() < 1.5 and error.mean() < 0.4 and mask_error < 1


def paper(starbreak, folder, photos, scene):
    blur = lambda image: cv2.GaussianBlur(image, (15, 15), 2.6, borderType=cv2.BORDER_REFLECT_101)
    gray = lambda light: encode(light @ [0.0722, 0.7152, 0.2126])
    for background, image in photos.items():
        opacity, light = planes_of(background, image)
        if background == "black":
            m, sent = encode(light.max(2)), gray(light)
        elif background == "white":
            m = 1 - encode(1 - opacity.max(2))
            sent = gray(1 - opacity) - (1 - m)
        else:
            m = opacity[..., 0]
            sent = m * gray(light / np.maximum(m, 1e-9)[..., None])
        m, sent = m[..., None], 200 * np.clip(sent, 0, None)[..., None]
        for focus, expected in [("far", scene * (1 - blur(m)[..., None]) + blur(sent)[..., None]), ("short", blur(scene) * (1 - m) + sent)]:
            out, _, _ = run(starbreak, folder, folder / f"{background}.png", "--preset", "paper", "--set", f"camera.focus_distance_m={focus}")
            error = np.abs(out - expected)
            print(f"paper, {background:5}, {focus:5}: largest difference {error.max():.2f} levels, mean {error.mean():.3f}")
            assert error.max() < 1.5 and error.mean() < 0.4


def jpeg_floor(rng):
    image = star(rng)
    background = cv2.dilate(image, np.ones((3, 3), np.uint8)).max(2) == 0
    for quality in (95, 90, 85, 75):
        read = cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_COLOR)
        codes = read.max(2)[background]
        light = decode(np.clip((codes / 255 - FLOOR) / (1 - FLOOR), 0, 1))
        print(f"JPEG of quality {quality}: {(codes > 255 * FLOOR).mean():.2%} of the black is above the floor; light that is left in it "
              f"{light.mean():.1e}, without the floor {decode(codes / 255).mean():.1e}")


def main():
    starbreak = sys.argv[1]
    rng = np.random.default_rng(1)
    noise = rng.integers(0, 256, (SIZE[1], SIZE[0], 3)).astype(np.uint8)
    scene = cv2.GaussianBlur(noise, (5, 5), 1.5).astype(float).round()
    black = star(rng)
    alpha = star(rng).max(2)
    cut_out = np.dstack([star(rng, 40) // 2 + 90, alpha])
    photos = {"black": black, "white": 255 - star(rng), "alpha": cut_out}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cv2.imwrite(str(folder / "scene.png"), scene.astype(np.uint8))
        physical(starbreak, folder, photos, scene)
        paper(starbreak, folder, photos, scene)
    jpeg_floor(rng)


if __name__ == "__main__":
    main()
