#!/usr/bin/env python3
"""Values of Mitsuba's roughdielectric for pairs of directions near the mirrored and the refracted one.

usage: bsdf.py OUT.json
"""
import json
import pathlib
import sys

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
N = 1.52
rng, rows = np.random.default_rng(7), []
for alpha in (0.05, 0.1, 0.3, 0.6):
    bsdf = mi.load_dict({"type": "roughdielectric", "distribution": "ggx", "alpha": alpha, "int_ior": N, "ext_ior": 1.0})
    while len(rows) % 30 or not rows or rows[-1]["alpha"] != alpha:
        v = rng.normal(size=3)
        v /= np.linalg.norm(v)
        h = np.array([*rng.normal(size=2) * alpha, 1.0])
        h /= np.linalg.norm(h)
        eta, c = (N if v[2] > 0 else 1 / N), v @ h
        s2 = 1 - (1 - c * c) / eta**2
        if len(rows) % 2:
            o = 2 * c * h - v
        elif s2 > 0:
            o = h * (c / eta - np.sign(c) * np.sqrt(s2)) - v / eta
        else:
            continue
        si = mi.SurfaceInteraction3f()
        si.wi = mi.Vector3f(*v)
        value = float(np.array(bsdf.eval(mi.BSDFContext(), si, mi.Vector3f(*(o / np.linalg.norm(o)))))[0])
        if value > 1e-2:
            rows.append({"alpha": alpha, "wi": v.tolist(), "wo": (o / np.linalg.norm(o)).tolist(), "value": value})
pathlib.Path(sys.argv[1]).write_text("[\n" + ",\n".join(map(json.dumps, rows)) + "\n]\n")
