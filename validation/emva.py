"""The sensor's noise, measured by the program of EMVA 1288 (emva1288 of PyPI): emva.py RAW_FRAMES.

RAW_FRAMES is crates/sensor/examples/raw_frames, which makes raw frames of a sensor whose numbers are known. The
program knows nothing of them: it fits gain, dark noise and nonuniformities to pairs and stacks of frames."""

import subprocess
import sys

import numpy as np

# The program asks numpy 1 for it.
np.asfarray = lambda values: np.asarray(values, dtype=float)

from emva1288.process.data import Data1288  # noqa: E402
from emva1288.process.results import Results1288  # noqa: E402
from emva1288.process.routines import get_int_imgs  # noqa: E402

WIDTH, HEIGHT = 640, 480
WHITE_E, GAIN = 10_000.0, 0.5
# Photons per electron, which says nothing of the sensor.
PHOTONS = 2.0
EXPOSURE_NS = 20e6
STACK = 100


def frames(level, seed, n):
    command = [sys.argv[1], repr(level), str(seed), str(n)]
    raw = subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout
    return list(np.frombuffer(raw, "<u2").reshape(n, HEIGHT, WIDTH))


def of(images):
    """Sums as the program's own loader makes them."""
    return get_int_imgs(images)


def of_pair(images):
    whole = of(images)
    return {
        "sum": int(whole["sum"].sum()),
        "pvar": int(whole["pvar"].sum()),
        "dmean": float(whole["dmean"]),
        "L": whole["L"],
    }


levels = [k / 40 for k in range(1, 45)]
temporal = {0.0: of_pair(frames(0.0, 1, 2))}
for k, level in enumerate(levels):
    temporal[level * WHITE_E * PHOTONS] = of_pair(frames(level, 100 + 10 * k, 2))
spatial = {
    0.0: of(frames(0.0, 10_000, STACK)),
    0.5 * WHITE_E * PHOTONS: of(frames(0.5, 20_000, STACK)),
}
data = {
    "width": WIDTH,
    "height": HEIGHT,
    "temporal": {EXPOSURE_NS: temporal},
    "spatial": {EXPOSURE_NS: spatial},
}
results = Results1288(Data1288(data, loglevel=40).data, loglevel=40)

# Dark current of 400 e/s at 25 C, doubled twice at 39 C, in 20 ms.
dark_e = 400 * 4 * 0.02
rows = [
    ("gain K, DN/e", results.K, GAIN),
    ("dark noise, e", results.sigma_d, np.sqrt(12.0**2 + dark_e)),
    ("DSNU, e", results.DSNU1288, 6.0),
    ("PRNU, %", results.PRNU1288, 1.2),
]
failed = False
print(f"{'':16} {'measured':>10} {'set':>10}  error")
for name, measured, expected in rows:
    error = measured / expected - 1
    verdict = "ok" if abs(error) <= 0.02 else "FAIL"
    failed |= verdict == "FAIL"
    print(f"{name:16} {measured:10.4f} {expected:10.4f}  {100 * error:+.2f} % (at most 2 %: {verdict})")
sys.exit(1 if failed else 0)
