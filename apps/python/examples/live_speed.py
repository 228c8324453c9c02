"""How long `ReadyCrack.over` takes, with and without `out=`, and what copies and conversions cost beside it.

    python apps/python/examples/live_speed.py [ROUNDS]

Prints the median CPU time and the 99 % quantile of the wall clock in ms over ROUNDS frames (default 300) of a street, each
a little brighter or darker than the one before, so that each has a light of its own. One thread.
"""

import sys
import time

import numpy as np
import starbreak

#: Frames: KITTI's, and those of a full HD camera.
SIZES = [(1242, 375), (1920, 1080)]


def street(width, height):
    """The embedded street in another size, BGRA."""
    image, _ = starbreak.street_scene()
    rows = np.arange(height) * image.shape[0] // height
    columns = np.arange(width) * image.shape[1] // width
    rgb = image[rows][:, columns]
    return np.dstack([rgb[..., ::-1], np.full((height, width), 255, np.uint8)])


def timed(work, frames, n_rounds):
    """Median CPU time and 99 % quantile of the wall clock of some work on frames, each copied before, ms."""
    took, wall = [], []
    for k in range(n_rounds + 5):
        frame = frames[k % len(frames)].copy()
        began, began_s = time.thread_time(), time.perf_counter()
        work(frame)
        wall.append(1e3 * (time.perf_counter() - began_s))
        took.append(1e3 * (time.thread_time() - began))
    return np.median(took[5:]), np.percentile(wall[5:], 99)


def main():
    """Prints the table."""
    n_rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 300
    for width, height in SIZES:
        crack = starbreak.ReadyCrack("windshield-spiderweb", 7, (width, height))
        base = street(width, height).astype(np.int16)
        frames = [(base + shift).clip(0, 255).astype(np.uint8) for shift in (0, 6, -6, 12)]
        out, rgb = np.empty_like(frames[0]), np.empty((height, width, 3), np.uint8)

        def converted(frame):
            made = crack.over(np.ascontiguousarray(frame[..., 2::-1]))
            frame[..., :3] = made[..., ::-1]

        ways = {
            "over(rgba): a new array": crack.over,
            "over(rgb) between conversions from and to BGRA": converted,
            "over(bgra, out=other)": lambda frame: crack.over(frame, out=out, channels="bgra"),
            "over(bgra, out=bgra)": lambda frame: crack.over(frame, out=frame, channels="bgra"),
            "over(bgra[..., :3], out=itself), by a kept frame": lambda frame: crack.over(
                frame[..., :3], out=frame[..., :3], channels="bgr"
            ),
            "copy of BGRA": lambda frame: np.copyto(out, frame),
            "BGRA to RGB by NumPy": lambda frame: np.copyto(rgb, frame[..., 2::-1]),
            "light of BGRA": lambda frame: crack.estimate_environment(frame, channels="bgra"),
        }
        print(f"{width} x {height}, {100 * crack.over(frames[0][..., :3], full=True).facts['region_fraction']:.0f} % affected")
        for name, work in ways.items():
            p50, p99 = timed(work, frames, n_rounds)
            print(f"  {p50:6.2f} ms CPU {p99:6.2f} ms p99  {name}")
        crack.set_environment(crack.estimate_environment(frames[0], channels="bgra"))
        p50, p99 = timed(ways["over(bgra, out=bgra)"], frames, n_rounds)
        print(f"  {p50:6.2f} ms CPU {p99:6.2f} ms p99  over(bgra, out=bgra) under one light (set_environment)")


if __name__ == "__main__":
    main()
