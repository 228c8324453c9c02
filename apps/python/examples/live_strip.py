"""Makes docs/figures/live.jpg: a camera pans over a street, its frames go through `starbreak pipe`, and a stone hits.

    python apps/python/examples/live_strip.py [STARBREAK]

STARBREAK is the command; default: the one on PATH.
"""

import json
import pathlib
import subprocess
import sys

import numpy as np
import starbreak
from PIL import Image

#: Frames of 600 x 375 px, 10 per second.
WIDTH, N_FRAMES = 600, 26
#: Those that are shown: before, the crack's first frame, half grown, and long after.
SHOWN = (0, 10, 13, 25)


def main():
    """Makes it."""
    command = sys.argv[1] if len(sys.argv) > 1 else "starbreak"
    street, _ = starbreak.street_scene()
    shifts = np.linspace(0, street.shape[1] - WIDTH, N_FRAMES).astype(int)
    frames = [np.ascontiguousarray(street[:, shift : shift + WIDTH]) for shift in shifts]
    flags = "--pixels rgb24 --fps 10 --impact-at 1 --grow --growth-time 0.6 --seed 5 --json"
    words = [command, "pipe", "--size", f"{WIDTH}x{street.shape[0]}", *flags.split()]
    done = subprocess.run(words, input=b"".join(frame.tobytes() for frame in frames), capture_output=True, check=True)
    print(json.loads(done.stderr.splitlines()[-1])["latency_ms"])
    made = np.frombuffer(done.stdout, np.uint8).reshape(N_FRAMES, *frames[0].shape)
    gap = 6
    sheet = np.full((2 * street.shape[0] + gap, 2 * WIDTH + gap, 3), 255, np.uint8)
    for place, k in enumerate(SHOWN):
        y, x = place // 2 * (street.shape[0] + gap), place % 2 * (WIDTH + gap)
        sheet[y : y + street.shape[0], x : x + WIDTH] = made[k]
    path = pathlib.Path(__file__).parents[3] / "docs/figures/live.jpg"
    Image.fromarray(sheet).save(path, quality=88)


if __name__ == "__main__":
    main()
