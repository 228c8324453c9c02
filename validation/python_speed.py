#!/usr/bin/env python3
"""Images per second of CrackedGlass beside corruptions of the field, the cost of the call and its memory.

usage: python_speed.py COMMAND EXAMPLE
COMMAND is `starbreak`, which makes the banks; EXAMPLE is `crack_speed`, an example of the crate
`starbreak` that does the same call in Rust. Single thread; the least of several rounds, all in one run; needs
requirements-speed.txt and the package starbreak as a release wheel.
"""
import pathlib
import subprocess
import sys
import tempfile
import time
import tracemalloc

import albumentations as A
import cv2
import imagecorruptions
import numpy as np
import skimage.filters
import starbreak
from starbreak.albumentations import CrackedGlass

SIZES = [(1242, 375), (1280, 720)]
ONE_PIXEL = "ReadyCrack.over of one pixel: the call itself"
COPY = "image.copy(): of which the call does one"


def glass_blur(image, severity=1):
    """Of imagecorruptions 1.1.2, whose call of skimage has an argument that skimage has renamed since."""

    def gaussian(x, sigma, multichannel):
        return skimage.filters.gaussian(x, sigma=sigma, channel_axis=-1 if multichannel else None)

    imagecorruptions.corruptions.gaussian = gaussian
    return imagecorruptions.corrupt(image, corruption_name="glass_blur", severity=severity)


def seconds(call, budget_s=3.0):
    """The least time of a call; at least two of them."""
    call()
    times, start = [], time.perf_counter()
    while len(times) < 2 or (time.perf_counter() - start < budget_s and len(times) < 200):
        before = time.perf_counter()
        call()
        times.append(time.perf_counter() - before)
    return min(times)


def median_of_call(call, n):
    times = []
    for _ in range(n):
        before = time.perf_counter()
        call()
        times.append(time.perf_counter() - before)
    return float(np.median(times))


def peers():
    return {
        "GlassBlur": A.GlassBlur(p=1.0),
        "Defocus": A.Defocus(p=1.0),
        "Spatter": A.Spatter(p=1.0),
        "RandomRain": A.RandomRain(p=1.0),
        "RandomSunFlare": A.RandomSunFlare(p=1.0),
    }


def rates(image, bank):
    """Mean over draws within each transform: a round of 20 seeds, the least of three rounds."""
    cracked = {"CrackedGlass, bank": CrackedGlass(bank=bank, p=1.0), "CrackedGlass, fresh": CrackedGlass(p=1.0)}
    made = {}
    for name, transform in {**cracked, **peers()}.items():
        n = 5 if name in ("GlassBlur", "CrackedGlass, fresh") else 20
        rounds = []
        for _ in range(3):
            pipeline = A.Compose([transform], seed=1)
            before = time.perf_counter()
            for _ in range(n):
                pipeline(image=image)
            rounds.append((time.perf_counter() - before) / n)
        made[name] = 1 / min(rounds)
    made["imagecorruptions glass_blur"] = 1 / seconds(lambda: glass_blur(image), budget_s=1.0)
    return made


def overhead(image, bank_path):
    """Times of calls, s; that of one pixel is the glue's. The input stays, so that any caller copies it once."""
    bank = starbreak.PatternBank(bank_path)
    height, width = image.shape[:2]
    ready = bank.pattern(0, (width, height))
    whole = median_of_call(lambda: ready.over(image, 1), 60)
    transform = CrackedGlass(bank=bank_path, p=1.0)
    pipeline = A.Compose([transform], seed=1)
    spared = A.Compose([CrackedGlass(bank=bank_path, p=0.0)], seed=1)
    tiny = np.zeros((1, 1, 3), np.uint8)
    ready_tiny = starbreak.ReadyCrack("paper", 1, (1, 1))
    return {
        "PatternBank.crack": median_of_call(lambda: bank.crack(image, 1, index=0), 60),
        "ReadyCrack.over": whole,
        ONE_PIXEL: median_of_call(lambda: ready_tiny.over(tiny, 1), 2000),
        COPY: median_of_call(image.copy, 200),
        "A.Compose that spares": median_of_call(lambda: spared(image=image), 200),
        "A.Compose([CrackedGlass])": median_of_call(lambda: pipeline(image=image), 60),
    }


def beside_rust(image, bank_path, example):
    """The least of five medians, in turns: of the call in Python and of the same in Rust, s."""
    height, width = image.shape[:2]
    ready = starbreak.PatternBank(bank_path).pattern(0, (width, height))
    python, rust = [], []
    with tempfile.NamedTemporaryFile() as pixels:
        image.tofile(pixels.name)
        words = [example, bank_path, str(width), str(height), pixels.name, "200"]
        for _ in range(5):
            python.append(median_of_call(lambda: ready.over(image, 1), 200))
            done = subprocess.run(words, check=True, capture_output=True, text=True)
            rust.append(float(done.stdout) / 1e3)
    return min(python), min(rust)


def memory():
    """Peaks in a call over the size of a large image that nothing changes: Python's, and the process's.

    1 in the process is the result alone; one more copy would be 2.
    """
    size = (8000, 6000)
    ready = starbreak.ReadyCrack(starbreak.Recipe(set={"impact.speed_m_s": 0.5}), 1, size)
    assert ready.intact
    image = np.full((size[1], size[0], 3), 128, np.uint8)
    tracemalloc.start()
    ready.over(image)
    traced = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    pathlib.Path("/proc/self/clear_refs").write_text("5")
    before = status("VmRSS")
    result = ready.over(image)
    return traced / result.nbytes, (status("VmHWM") - before) / result.nbytes


def status(key):
    lines = pathlib.Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) * 1024 for line in lines if line.startswith(key))


def main():
    command, example = sys.argv[1:3]
    cv2.setNumThreads(1)
    print(f"starbreak {starbreak.__version__}, Albumentations {A.__version__}, NumPy {np.__version__}; images/s, one thread")
    failed = 0
    for width, height in SIZES:
        image = np.random.default_rng(0).integers(0, 255, (height, width, 3), np.uint8)
        image = cv2.GaussianBlur(image, (0, 0), 3)
        with tempfile.TemporaryDirectory() as folder:
            words = [command, "patterns", "-n", "8", "-o", folder, "--size", f"{width}x{height}"]
            subprocess.run(words, check=True, capture_output=True)
            made = rates(image, folder)
            best = made["CrackedGlass, bank"]
            print(f"\n{width} x {height}")
            for name, rate in made.items():
                is_slower = name.startswith("CrackedGlass") or rate < best
                print(f"  {name:<30} {rate:9.2f}  bank is {best / rate:8.2f} times as fast {'' if is_slower else ' FASTER THAN THE BANK'}")
            times = overhead(image, folder)
            for name, time_s in times.items():
                print(f"  {name:<50} {time_s * 1e3:9.4f} ms")
            of_python, of_rust = beside_rust(image, folder, example)
            over = of_python / of_rust - 1
            print(f"  ReadyCrack.over {of_python * 1e3:.4f} ms, in Rust {of_rust * 1e3:.4f} ms: {100 * over:+.1f} %")
            failed += over > 0.05
    of_python, of_process = memory()
    print(f"\npeak memory in a call, in images: {of_python:.3f} by Python, {of_process:.3f} in the process")
    failed += of_process > 1.1
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
