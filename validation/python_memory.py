"""Memory of the Python package over 10,000 calls: resident, after the first 1,000 and every 3,000.

    pip install ./apps/python numpy
    python3 validation/python_memory.py BANK

BANK is a folder that `starbreak patterns -n 20 --size 320x240 -o BANK` wrote. Each call breaks an image
out of the bank, with masks and damage every tenth time; every hundredth makes fresh physics and reads
the columns of its network. Ends with an error if memory grows by more than 4 MiB after the first 1,000.
"""
import gc
import sys

import numpy as np
import starbreak


def resident_mib():
    gc.collect()
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS")) / 1024


def main():
    bank = starbreak.PatternBank(sys.argv[1])
    image = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    first = None
    for k in range(10_000):
        bank.crack(image, k, full=k % 10 == 0, boxes=[[0, 0, 90, 90]] if k % 10 == 0 else None)
        if k % 100 == 0:
            network = starbreak.simulate("windshield-star", k, (320, 240))
            network.segments, network.nodes, network.to_json()
        if k % 3000 == 1000 or k == 9_999:
            now = resident_mib()
            first = first or now
            print(f"after {k:5d} calls: {now:.1f} MiB resident")
    grown = now - first
    print(f"grown by {grown:+.1f} MiB over 9,000 calls: {'ok' if grown < 4 else 'FAIL'}")
    sys.exit(grown >= 4)


main()
