"""Digests of images that OpenCV and Pillow have resized, for tests/resize.rs.

pip install opencv-python-headless==5.0.0.93 pillow==11.3.0 numpy; python make.py > digests.txt
"""

import hashlib
import sys

import cv2
import numpy as np
import PIL
from PIL import Image


def pattern(width, height):
    """An image of noise that is a formula: no two of its neighbors are alike."""
    x = np.arange(width, dtype=np.uint32)[None, :, None]
    y = np.arange(height, dtype=np.uint32)[:, None, None]
    c = np.arange(3, dtype=np.uint32)[None, None, :]
    noise = (x * np.uint32(73856093)) ^ (y * np.uint32(19349663)) ^ (c * np.uint32(83492791))
    return np.ascontiguousarray(((noise >> np.uint32(7)) & np.uint32(255)).astype(np.uint8))


SIZES = [
    (640, 480, 416, 312), (1242, 375, 416, 125), (1242, 375, 640, 193), (1280, 720, 640, 360),
    (500, 333, 640, 426), (427, 640, 427, 640), (640, 480, 352, 352), (352, 352, 704, 704),
    (704, 704, 352, 352), (1056, 1056, 352, 352), (1408, 704, 352, 352), (100, 50, 37, 91),
    (37, 91, 100, 50), (1, 1, 5, 7), (5, 7, 1, 1), (1, 9, 4, 3), (9, 1, 3, 4), (2, 2, 3, 3),
    (3, 3, 2, 2), (640, 427, 640, 214), (333, 500, 111, 250), (17, 13, 16, 12), (16, 12, 17, 13),
    (97, 89, 96, 178), (255, 1, 254, 1), (1, 255, 1, 128), (64, 48, 32, 24), (65, 49, 32, 24),
    (200, 100, 640, 320), (480, 640, 312, 416), (612, 612, 416, 416), (419, 640, 352, 352),
]
rng = np.random.default_rng(20261121)
SIZES += [tuple(int(side) for side in rng.integers(1, 120, 4)) for _ in range(80)]

HOW = {
    "linear": lambda image, size: cv2.resize(image, size, interpolation=cv2.INTER_LINEAR),
    "area": lambda image, size: cv2.resize(image, size, interpolation=cv2.INTER_AREA),
    "antialiased": lambda image, size: np.asarray(
        Image.fromarray(image).resize(size, Image.Resampling.BILINEAR)
    ),
}

print(f"# opencv {cv2.__version__}, pillow {PIL.__version__}, numpy {np.__version__}")
for width, height, new_width, new_height in SIZES:
    image = pattern(width, height)
    for how, resize in HOW.items():
        resized = np.ascontiguousarray(resize(image, (new_width, new_height)))
        assert resized.shape == (new_height, new_width, 3), sys.exit("shape")
        digest = hashlib.sha256(resized.tobytes()).hexdigest()[:16]
        print(how, width, height, new_width, new_height, digest)
