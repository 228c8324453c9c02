"""No leak."""

import gc
import sys

import numpy as np
import pytest
import starbreak
from conftest import picture

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="memory is read in /proc")


def resident_kib():
    gc.collect()
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def test_memory_is_flat_over_many_calls(small):
    image = picture(32, 48)
    bad = image.astype(np.float32)
    ready = starbreak.ReadyCrack(small, 1, (48, 32))

    def calls(n):
        for k in range(n):
            ready.over(image, k)
            ready.over(image[::-1], k, full=True, boxes=[[0, 0, 9, 9]])
            starbreak.Recipe("paper", set={"fracture.particles": 300 + k % 7})
            for refused in (lambda: ready.over(bad), lambda: starbreak.Recipe("nothing"), lambda: ready.over(None)):
                with pytest.raises((TypeError, ValueError)):
                    refused()
            if k % 10 == 0:
                network = starbreak.simulate(small, k, (48, 32))
                network.segments, network.nodes, network.to_json()
                starbreak.crack(image, small, k, full=True).facts

    calls(300)
    before = resident_kib()
    calls(1500)
    grown = resident_kib() - before
    # A leaked image of 4.6 kB a call would be 7000 KiB.
    assert grown < 1500, f"{grown} KiB more"
