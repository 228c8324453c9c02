#!/usr/bin/env python3
"""Writes where OpenCV's projection puts places of a frame, for crates/optics/tests/lens_faults.rs.

    pip install opencv-python-headless numpy
    python3 validation/lens_opencv.py > crates/optics/tests/data/opencv_projection.txt

A line is: projection, k1, k2, k3, k4, p1, p2, a place of a frame of 1242 x 375 px, and where the distorted camera shows
it, px from the frame's corner. OpenCV counts from the middle of the first pixel.
"""
import cv2
import numpy as np

F_PX, WIDTH, HEIGHT = 721.5377, 1242, 375
MATRIX = np.array([[F_PX, 0, WIDTH / 2 - 0.5], [0, F_PX, HEIGHT / 2 - 0.5], [0, 0, 1]])
BROWN = [
    (-0.3728, 0.2037, 0.0, 0.0, 0.0022, 0.0014),
    (0.12, -0.05, 0.01, 0.0, 0.0, 0.0),
    (-0.05, 0.0, 0.0, 0.0, -0.004, 0.003),
]
FISHEYE = [
    (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    (-0.02, 0.01, -0.003, 0.0005, 0.0, 0.0),
    (0.1, -0.04, 0.01, -0.002, 0.0, 0.0),
]

rng = np.random.default_rng(1)
places = np.column_stack([rng.uniform(0, WIDTH, 10), rng.uniform(0, HEIGHT, 10)]).round(2)
print(f"# OpenCV {cv2.__version__}, validation/lens_opencv.py")
for name, all_coefficients in (("brown", BROWN), ("fisheye", FISHEYE)):
    for k1, k2, k3, k4, p1, p2 in all_coefficients:
        rays = np.column_stack([(places - [WIDTH / 2, HEIGHT / 2]) / F_PX, np.ones(len(places))])
        zero = np.zeros(3)
        if name == "brown":
            moved, _ = cv2.projectPoints(rays, zero, zero, MATRIX, np.array([k1, k2, p1, p2, k3]))
        else:
            moved, _ = cv2.fisheye.projectPoints(
                rays.reshape(-1, 1, 3), zero, zero, MATRIX, np.array([k1, k2, k3, k4])
            )
        for (x, y), (u, v) in zip(places, moved.reshape(-1, 2) + 0.5):
            print(name, k1, k2, k3, k4, p1, p2, x, y, f"{u:.6f}", f"{v:.6f}")
