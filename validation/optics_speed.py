#!/usr/bin/env python3
"""The physical optics timed beside image filters that stand in for it, in one run on one thread.

usage: optics_speed.py PATH_TO_STARBREAK [ROUNDS]

Peers: OpenCV's Gaussian blur of 15 x 15, sigma 2.6, and Albumentations' GlassBlur (its two modes, defaults
otherwise), Defocus of radius 7, RandomSunFlare and Spatter. None of them shows a crack: they are what an
augmentation pipeline would use instead, or a lower bound of any blur. Each round times every peer and then
starbreak, so that a machine that slows down slows all of them; wall clock of both. Frames: RGB, 8 bits.
"""
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
os.environ["NO_ALBUMENTATIONS_UPDATE"] = "1"

import albumentations
import cv2
import numpy as np

cv2.setNumThreads(1)
SIZES = ((1242, 375), (1920, 1080))
# Calls per round: as many as take about a tenth of a second, so that a median is one of calls.
BUDGET_S, MAX_CALLS = 0.1, 25


def scene(width, height):
    """A frame with gradients, edges and noise; the peers' times hardly depend on it."""
    rng = np.random.default_rng(0)
    y, x = np.mgrid[0:height, 0:width]
    plain = np.stack([x * 255 // width, y * 255 // height, ((x // 40 + y // 40) % 2) * 180], axis=-1)
    return np.clip(plain + rng.normal(0, 6, plain.shape), 0, 255).astype(np.uint8)


def peers():
    """Name and function of each; the transforms draw their own parameters at every call."""
    pipeline = {
        "Albumentations GlassBlur, fast": albumentations.GlassBlur(mode="fast", p=1),
        "Albumentations GlassBlur, exact": albumentations.GlassBlur(mode="exact", p=1),
        "Albumentations Defocus, r = 7": albumentations.Defocus(radius=(7, 7), p=1),
        "Albumentations RandomSunFlare": albumentations.RandomSunFlare(p=1),
        "Albumentations Spatter": albumentations.Spatter(p=1),
    }
    yield "OpenCV GaussianBlur 15 x 15", lambda image: cv2.GaussianBlur(image, (15, 15), 2.6)
    for name, transform in pipeline.items():
        yield name, lambda image, transform=transform: transform(image=image)["image"]


def calls_ms(call, image):
    """Times of some calls; one that is slow is made once."""
    times, end = [], time.perf_counter() + BUDGET_S
    while not times or (len(times) < MAX_CALLS and time.perf_counter() < end):
        start = time.perf_counter()
        call(image)
        times.append(1e3 * (time.perf_counter() - start))
    return times


def main():
    starbreak, rounds = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 5
    scenes = {size: scene(*size) for size in SIZES}
    theirs, ours = {}, {}
    for call_round in range(-1, rounds):
        for size, image in scenes.items():
            for name, call in peers():
                times = calls_ms(call, image)
                # The first round is not counted: caches, lazy imports, clock of the processor.
                if call_round >= 0:
                    theirs.setdefault((name, size), []).append(statistics.median(times))
        with tempfile.TemporaryDirectory() as folder:
            bench = [starbreak, "bench", "--model", "optics", "--runs", "5", "--seed", str(max(call_round, 0))]
            result = subprocess.run([*bench, "--json", "--quiet", "-o", folder], check=True, capture_output=True)
        for case in json.loads(result.stdout)["optics"]["cases"]:
            if call_round >= 0:
                size = (case["width_px"], case["height_px"])
                radius = case["radius_px"]
                still = case["still_ms"]["median"]
                frame = case["stages_ms"]["next_frame"]["median"]
                ours.setdefault((f"starbreak, r = {radius:g} px: a still", size), []).append(still)
                ours.setdefault((f"starbreak, r = {radius:g} px: a next frame", size), []).append(frame)
    columns = " | ".join(f"{f'{width} x {height}':>20}" for width, height in SIZES)
    print(f"{rounds} rounds, medians (least-greatest of the rounds), ms on one thread")
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")
    print(f"OpenCV {cv2.__version__}, Albumentations {albumentations.__version__}, NumPy {np.__version__}")
    print(f"  {'':38} | {columns}")
    names = list(dict.fromkeys(name for name, _ in [*ours, *theirs]))
    for name in names:
        cells = []
        for size in SIZES:
            times = (ours | theirs)[name, size]
            cells.append(f"{statistics.median(times):8.2f} ({min(times):.1f}-{max(times):.1f})")
        print(f"  {name:38} | " + " | ".join(f"{cell:>20}" for cell in cells))
    print("time of a peer over that of starbreak, r = 7.2 px: a still / a next frame")
    for name in (name for name in names if not name.startswith("starbreak")):
        cells = []
        for size in SIZES:
            peer = statistics.median(theirs[name, size])
            still, frame = (
                statistics.median(ours[f"starbreak, r = 7.2 px: {what}", size]) for what in ("a still", "a next frame")
            )
            cells.append(f"{peer / still:8.1f} / {peer / frame:.0f}")
        print(f"  {name:38} | " + " | ".join(f"{cell:>20}" for cell in cells))
    judge(ours)


def judge(ours):
    """Beside the budgets of the design."""
    median = {key: statistics.median(times) for key, times in ours.items()}
    kitti, hd = SIZES
    still, frame = "starbreak, r = {} px: a still", "starbreak, r = {} px: a next frame"
    checks = [
        ("a still at 1242 x 375 <= 3 ms", median[still.format("7.2"), kitti], 3.0),
        ("a next frame at 1242 x 375 <= 0.25 ms", median[frame.format("7.2"), kitti], 0.25),
        ("a still at 1920 x 1080 <= 12 ms", median[still.format("7.2"), hd], 12.0),
        ("a next frame at 1920 x 1080 <= 1 ms", median[frame.format("7.2"), hd], 1.0),
        ("r = 35 over r = 7.2, a still at 1242 x 375 <= 4", median[still.format("35"), kitti] / median[still.format("7.2"), kitti], 4.0),
        ("r = 35 over r = 7.2, a still at 1920 x 1080 <= 4", median[still.format("35"), hd] / median[still.format("7.2"), hd], 4.0),
    ]
    print("budgets of the design, which are for a star, not for the spider's web of the default preset:")
    for what, value, limit in checks:
        print(f"  {what:50} {value:8.2f} {'ok' if value <= limit else 'MISSED'}")


if __name__ == "__main__":
    main()
