#!/usr/bin/env python3
"""What lies on the glass and stray light: time of a frame beside the field's libraries, in one run.

usage: deposit_peers.py FAULTS_SPEED

FAULTS_SPEED is the example of the crate `starbreak` of that name: its `ready` is the time until the first frame, of
glass that is made anew. Peers: NRTK's drops on a lens, imagecorruptions, AlbumentationsX. One thread, medians.
Needs requirements-deposits.txt.
"""
import importlib.metadata
import os
import subprocess
import sys
import time
import warnings

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["ALBUMENTATIONS_NO_TELEMETRY"] = "1"
warnings.simplefilter("ignore")

import albumentations as A
import cv2
import imagecorruptions
import numpy as np
import skimage.filters
from nrtk.impls.perturb_image.environment import WaterDropletPerturber

cv2.setNumThreads(1)
SIZES = ((1242, 375), (1280, 720))
OURS = ("rain", "fogged", "muddy", "dusty", "greasy", "frosted", "scratched", "ghosts", "star-burst", "glare")


def picture(width, height):
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    return np.dstack([(7 * x) % 256, (7 * y) % 256, (7 * (x + y)) % 256]).astype(np.uint8)


def median_ms(call, image, runs):
    call(image)
    times = []
    for _ in range(runs):
        begin = time.perf_counter()
        call(image)
        times.append((time.perf_counter() - begin) * 1e3)
    return sorted(times)[runs // 2]


def main():
    # scikit-image has renamed an argument that imagecorruptions uses.
    gaussian = skimage.filters.gaussian
    imagecorruptions.corruptions.gaussian = lambda x, sigma, multichannel=False: gaussian(
        x, sigma, channel_axis=-1 if multichannel else None)
    np.float_ = np.float64

    def corrupted(name):
        return lambda image: imagecorruptions.corrupt(image, severity=3, corruption_name=name)

    def transformed(name):
        transform = A.Compose([getattr(A, name)(p=1.0)], seed=1)
        return lambda image: transform(image=image)["image"]

    drops = WaterDropletPerturber(seed=1)
    peers = [("NRTK", "WaterDropletPerturber", lambda image: drops.perturb(image=image), 1)]
    peers += [("imagecorruptions", name, corrupted(name), 5) for name in ("frost", "fog", "spatter", "snow")]
    names = ("RandomRain", "Spatter", "RandomSunFlare", "LensFlare", "RandomFog", "WaterRefraction")
    peers += [("AlbumentationsX", name, transformed(name), 9) for name in names if hasattr(A, name)]
    frames = [picture(*size) for size in SIZES]
    print("ms of a frame, 1242 x 375 and 1280 x 720")
    for library in ("nrtk", "imagecorruptions", "albumentationsx"):
        print(f"  {library} {importlib.metadata.version(library)}")
    for line in subprocess.run([sys.argv[1]], capture_output=True, text=True, check=True).stdout.splitlines()[1:]:
        name, next_a, ready_a, next_b, ready_b = line.split()
        if name in OURS:
            print(f"starbreak         {name:24} {next_a:>9} {next_b:>9}   first {ready_a:>8} {ready_b:>8}")
    for library, name, call, runs in peers:
        try:
            times = [median_ms(call, frame, runs) for frame in frames]
            print(f"{library:17} {name:24} {times[0]:9.1f} {times[1]:9.1f}", flush=True)
        except Exception as error:  # noqa: BLE001
            print(f"{library:17} {name:24} {type(error).__name__}: {error}", flush=True)


if __name__ == "__main__":
    main()
