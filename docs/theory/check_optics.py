"""Checks docs/theory/optics.md by a program of its own: python3 check_optics.py PATH/TO/starbreak

Needs numpy and Pillow. The picture must be what its maps say; a straight crack must have the width that Snell's law
gives it, and the profile of a box spread by a disc.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

PRESETS = [
    "windshield-star", "windshield-bullseye", "windshield-combination",
    "windshield-long-crack", "tempered-cover", "lens-cover-star",
]
N = 1.52


def light(code):
    s = np.asarray(code, dtype=np.float64) / 255
    return np.where(s <= 0.04045, s / 12.92, ((s + 0.055) / 1.055) ** 2.4)


def code(x):
    x = np.clip(x, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def crack(folder, picture, *args):
    out = folder / "out"
    command = [sys.argv[1], "crack", str(picture), "-o", str(out), *args]
    subprocess.run(command, check=True, capture_output=True)
    pixels = np.asarray(Image.open(out / picture.name).convert("RGB")).astype(int)
    maps = {
        path.name.split(".")[1]: np.load(path).astype(np.float64)
        for path in out.glob(f"{picture.stem}.*.npy")
    }
    return pixels, maps


def sets(*pairs):
    return [word for pair in pairs for word in ("--set", pair)]


def at(image, u, v):
    """Light between the middles of pixels."""
    height, width = image.shape[:2]
    u, v = np.clip(u - 0.5, 0, width - 1), np.clip(v - 0.5, 0, height - 1)
    x, y = u.astype(int), v.astype(int)
    s, t = (u - x)[..., None], (v - y)[..., None]
    right, below = np.minimum(x + 1, width - 1), np.minimum(y + 1, height - 1)
    top = image[y, x] + s * (image[y, right] - image[y, x])
    bottom = image[below, x] + s * (image[below, right] - image[below, x])
    return top + t * (bottom - top)


def maps(folder, scene):
    """Samples that the crack touches and those of them that are not within 1 code of what the maps
    say: where light comes from elsewhere, and where none does."""
    image = light(np.asarray(Image.open(scene).convert("RGB")))
    height, width = image.shape[:2]
    rows = []
    for preset in PRESETS:
        pixels, m = crack(
            folder, scene, "--preset", preset, "--seed", "1", "--maps",
            *sets("impact.position=[0.5,0.5]"),
        )
        u = np.arange(width) + 0.5 + m["displacement"][..., 0]
        v = (np.arange(height) + 0.5)[:, None] + m["displacement"][..., 1]
        lit = (image * (1 - m["attenuation"][..., None]) + m["added"]
               + m["elsewhere"][..., None] * at(image, u, v))
        touched = (m["attenuation"] != 0) | (m["added"] != 0).any(axis=-1) | (m["elsewhere"] != 0)
        change = np.abs(pixels - code(lit))
        own = touched & (m["elsewhere"] == 0)
        for where, is_off in (("own", own), ("elsewhere", touched & ~own)):
            found = change[is_off]
            if found.size:
                rows.append((preset, where, found.size, (found > 1).mean(), found.max()))
    return rows


def disc(x, radius):
    u = np.clip(x / radius, -1, 1)
    return 0.5 + (u * np.sqrt(1 - u * u) + np.arcsin(u)) / np.pi


def straight(folder):
    """A crack across a level sheet at X mm beside the axis: its width and its profile."""
    width, height, distance, thickness, f, aperture = 1242, 375, 100.0, 4.0, 721.5377, 1.0
    picture = folder / "dark.png"
    Image.new("RGB", (width, height)).save(picture)
    rows = []
    for beside in (20.0, 40.0, 60.0):
        drawing = folder / "line.svg"
        at_mm = 100 + beside
        drawing.write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100">'
            f'<path d="M{at_mm} 0V100" stroke="red"/></svg>'
        )
        _, m = crack(
            folder, picture, "--network", str(drawing), "--maps",
            *sets("glass.kind=annealed", f"glass.distance_m={distance / 1e3}", "glass.rake_deg=0",
                  f"glass.thickness_mm={thickness}", "glass.axis_at=[0.5,0.5]",
                  "camera.focal_length_mm=4", "camera.f_number=4", "camera.focus_distance_m=1000",
                  "camera.scene_distance_m=infinity"),
        )
        row = m["attenuation"][height // 2]
        # Through which point of the near face the far end is seen.
        entry = beside
        for _ in range(100):
            sine = entry / np.hypot(entry, distance) / N
            entry = beside - thickness * sine / np.sqrt(1 - sine * sine)
        left, right = (width / 2 + f * x / distance for x in (entry, beside))
        sharp = right - left
        # Half way into the sheet, which looks 1/n as deep from the lens.
        radius = 0.5 * aperture * f * (1 / (distance + 0.5 * thickness / N) - 1e-6)
        x = np.arange(width) + 0.5 + (np.arange(32)[:, None] + 0.5) / 32 - 0.5
        box = lambda r: (disc(x - left, r) - disc(x - right, r)).mean(axis=0)
        fits = {r: np.sqrt(np.mean((row - box(radius * r))[row > 0] ** 2))
                for r in np.arange(0.94, 1.06, 0.002)}
        rows.append((beside, row.sum() / sharp, min(fits, key=fits.get), min(fits.values()), row.max()))
    return rows


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    subprocess.run([sys.argv[1], "demo", "-o", str(folder / "demo")], check=True, capture_output=True)
    for preset, where, n, share, most in maps(folder, folder / "demo" / "scene.png"):
        print(f"picture by its maps, {preset}, light from {where}: {100 * share:.1f} % of {n} samples "
              f"are off by more than 1 code, {most:.0f} at most")
    for beside, ratio, size, rms, peak in straight(folder):
        print(f"straight crack {beside:.0f} mm beside the axis: width over Snell's {ratio:.4f}, "
              f"disc over that of a lens {size:.3f}, rms {rms:.5f} of a peak of {peak:.3f}")
