#!/usr/bin/env python3
"""A crack in a sheet before a thin lens, traced by Mitsuba 3: one profile across the crack per case of cases.json.

usage: chain.py CASES.json OUT.json [NAME...]

Coordinates are the camera's: x right, y down, z along the optical axis; mm; the inner face meets the axis at the
origin. (Mitsuba keeps rays off surfaces by about 1e-4 (1 + |p|), so the sheet must be near the origin.) The crack
is a box of air in the glass that ends 2 um below the faces. The light is a function of direction alone: what goes
out by the outer face sees sky and ground, what comes back by the inner face sees the cabin, one light or one that runs
with the sine of the elevation from straight down to straight up. Light that the faces hold comes to the edges, which
are black, but for the furnaces, whose edges shine as all else does. Light that Mitsuba's rough surfaces lose, for they
follow one reflection between facets, is measured in the same scene under light of 1 from everywhere, edges included,
and added as that of a white surface under half of either side.

Light is unpolarized at every surface, as in most renderers, but for the cases that say otherwise.
"""
import json
import pathlib
import sys
import time

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")


def T(matrix=None):
    return mi.ScalarTransform4f() if matrix is None else mi.ScalarTransform4f(matrix)


def case_of(base, case):
    """The case with what it leaves out, and with what follows from it."""
    c = {**base, **case}
    n, rake, psi = c["index"], np.radians(c["rake_deg"]), np.radians(c["crack_deg"])
    # Sheet: x, y down the slope, outward normal.
    c["along"] = np.array([np.cos(psi), np.sin(psi), 0.0])
    left = np.array([np.sin(psi), -np.cos(psi), 0.0])
    depth = c["thickness_mm"] * c["depth_fraction"]
    lean = np.tan(np.radians(c["tilt_deg"]))
    c["down"] = depth * (lean * left + np.array([0, 0, -1.0]))
    # The line of sight through the middle of the frame meets the crack half way down.
    tan = np.sin(rake) / np.sqrt(n * n - np.sin(rake) ** 2)
    middle = c["thickness_mm"] - 0.5 * depth
    on_axis = np.array([0, middle * tan, middle])
    c["outer"] = on_axis - 0.5 * c["down"] + np.array([*c["offset_mm"], 0.0])
    c["axes"] = np.array([[1, 0, 0], [0, np.cos(rake), np.sin(rake)], [0, -np.sin(rake), np.cos(rake)]])
    c["reach_mm"] = (0.12 * c["distance_mm"] + 4) / np.cos(rake)
    # Where the middle of the crack is in the frame.
    x, y, z = c["axes"].T @ np.array([*c["offset_mm"], 0.0]) + [0, 0, c["distance_mm"]]
    c["middle"] = np.array([c["size"][0] / 2 + c["f_px"] * x / z, c["size"][1] / 2 + c["f_px"] * y / z])
    c["half"] = int(min(*c["middle"], *(np.array(c["size"]) - c["middle"])))
    c["first"] = np.round(c["middle"]).astype(int) - c["half"]
    pitch = np.radians(c["pitch_deg"])
    c["up"] = np.array([0, -np.cos(pitch), np.sin(pitch)])
    return c


def radiance(c, d):
    """Light from direction d (…, 3)."""
    normal = c["axes"][2]
    sine = d @ c["up"]
    out = np.where(sine > 0, c["horizon"] + (c["zenith"] - c["horizon"]) * sine, c["ground"])
    if "cone_deg" in c:  # dark around a cone of view
        out = np.where(d[..., 2] > np.cos(np.radians(c["cone_deg"])), out, 0.0)
    if "sun" in c:
        out = out + c["sun"]["radiance"] * (d @ np.array(c["sun"]["to"]) > np.cos(np.radians(c["sun"]["radius_deg"])))
    low, high = c["cabin"] if isinstance(c["cabin"], list) else (c["cabin"], c["cabin"])
    return np.where(d @ normal > 0, out, low + (high - low) * (1 + sine) / 2)


def envmap(c, h=1024):
    theta, phi = np.meshgrid((np.arange(h) + 0.5) / h * np.pi, (np.arange(2 * h) + 0.5) / h * np.pi, indexing="ij")
    d = np.stack([np.sin(phi) * np.sin(theta), np.cos(theta), -np.cos(phi) * np.sin(theta)], -1)
    light = radiance(c, d)
    if "sun" in c:  # irradiance of what the pixels hold
        towards = d @ np.array(c["sun"]["to"])
        inside = towards > np.cos(np.radians(c["sun"]["radius_deg"]))
        cell = np.sin(theta) * (np.pi / h) ** 2
        c["sun"]["irradiance"] = float((c["sun"]["radiance"] * cell * towards)[inside].sum())
    return mi.Bitmap(np.repeat(light.astype(np.float32)[..., None], 3, -1))


def fresnel(cos, n):
    cos_t = np.sqrt(1 - (1 - cos * cos) / n**2)
    return (((cos - n * cos_t) / (cos + n * cos_t)) ** 2 + ((n * cos - cos_t) / (n * cos + cos_t)) ** 2) / 2


def white_light(c):
    """Half of the light of either side, that from outside through the sheet."""
    z, phi = np.meshgrid((np.arange(400) + 0.5) / 400, (np.arange(800) + 0.5) / 400 * np.pi, indexing="ij")
    r = np.sqrt(1 - z * z)
    d = np.stack([r * np.cos(phi), r * np.sin(phi), z], -1) @ c["axes"]
    outside = (2 * z * radiance({k: v for k, v in c.items() if k not in ("sun", "cone_deg")}, d)).mean() * ("cone_deg" not in c)
    if "sun" in c:
        outside += c["sun"]["irradiance"] * max(0, c["axes"][2] @ np.array(c["sun"]["to"])) / np.pi
    face = fresnel(np.cos(np.radians(c["rake_deg"])), c["index"])
    t, r = (1 - face) / (1 + face), 2 * face / (1 + face)
    return 0.5 * c["cabin"] + 0.5 * (t * outside + r * c["cabin"])


def box(centre, halves, bsdf):
    m = np.eye(4)
    for k, half in enumerate(halves):
        m[:3, k] = half
    m[:3, 3] = centre
    if np.linalg.det(m[:3, :3]) < 0:
        m[:3, 0] *= -1
    return {"type": "cube", "to_world": T(m), "bsdf": bsdf}


def scene(c, with_crack):
    axes, n, t, distance = c["axes"], c["index"], c["thickness_mm"], c["distance_mm"]
    width, height = c["size"]
    lens = {"type": "thinlens", "aperture_radius": c["focal_mm"] / c["f_number"] / 2, "focus_distance": c["focus_m"] * 1e3}
    d = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": c["max_depth"], "rr_depth": 1000},
        "env": {"type": "envmap", "bitmap": envmap(c)},  # also gives the sun its irradiance
        "sensor": {
            **lens,
            "fov": float(2 * np.degrees(np.arctan(0.5 * width / c["f_px"]))),
            "fov_axis": "x",
            "near_clip": 0.1,
            "to_world": T().look_at(origin=[0, 0, -distance], target=[0, 0, 0], up=[0, -1, 0]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "luminance", "rfilter": {"type": "box"}, "component_format": "float32",
                     "crop_offset_x": int(c["first"][0]), "crop_offset_y": int(c["first"][1]), "crop_width": 2 * c["half"], "crop_height": 2 * c["half"]},
            "sampler": {"type": "multijitter", "sample_count": c["spp"] if with_crack else 64},
        },
    }
    glass = {"type": "dielectric", "int_ior": n, "ext_ior": 1.0}
    reach = c["reach_mm"]
    half = 1.3 * reach + 10
    light = {"type": "area", "radiance": {"type": "rgb", "value": n * n * c.get("rim", 0.0)}}
    for k, (side, other) in enumerate(((0, 1), (0, 1), (1, 0), (1, 0))):
        sign, m = 1 - 2 * (k % 2), np.eye(4)
        m[:3, 0] = axes[2] * (t / 2 - 2e-3)
        m[:3, 1] = axes[other] * half * 0.99
        m[:3, 2] = np.cross(m[:3, 0], m[:3, 1])
        m[:3, 2] /= np.linalg.norm(m[:3, 2])
        m[:3, 3] = axes.T @ [0, 0, t / 2] + sign * 0.98 * half * axes[side]
        if m[:3, 2] @ axes[side] * sign > 0:  # facing inward
            m[:3, 1:3] *= -1
        d[f"edge{k}"] = {"type": "rectangle", "to_world": T(m), "bsdf": {"type": "diffuse", "reflectance": 0.0}}
        if c.get("rim", 0.0) > 0:
            d[f"edge{k}"]["emitter"] = light
    d["sheet"] = box(axes.T @ [0, 0, t / 2], [axes[0] * half, axes[1] * half, axes[2] * t / 2], glass)
    if with_crack:
        air = {"type": "dielectric", "int_ior": 1.0, "ext_ior": n}
        if c["alpha"] > 0:
            air = {"type": "roughdielectric", "distribution": "ggx", "alpha": c["alpha"], "int_ior": 1.0, "ext_ior": n}
        across = np.cross(c["along"], c["down"])
        across /= np.linalg.norm(across)
        short = 2e-3 / abs(c["down"][2])
        for k, shift in enumerate(c["shifts_mm"]):
            left = np.array([c["along"][1], -c["along"][0], 0])
            # 2 um short of the outer face, and of the inner one if it goes through.
            ends = short, 1 - (short if c["depth_fraction"] > 0.999 else 0)
            top, bottom = (c["outer"] + shift * left + c["down"] * e for e in ends)
            halves = [c["along"] * reach, (bottom - top) / 2, across * c["gap_mm"] / 2]
            d[f"crack{k}"] = box(axes.T @ ((top + bottom) / 2), [axes.T @ v for v in halves], air)
    return mi.load_dict(d)


def profile(c, image):
    """Means over lines along the crack, 1 px apart."""
    v, u = np.mgrid[: image.shape[0], : image.shape[1]] + 0.5
    u, v = u + c["first"][0] - c["middle"][0], v + c["first"][1] - c["middle"][1]
    # The crack's direction in the frame, from two points of the inner face.
    ends = [c["axes"].T @ (np.array([*c["offset_mm"], 0.0]) + s * c["along"]) + [0, 0, c["distance_mm"]] for s in (-1e-3, 1e-3)]
    a, b = (e[:2] / e[2] for e in ends)
    normal = np.array([a[1] - b[1], b[0] - a[0]]) / np.hypot(*(b - a))
    half = c["half"] - 1
    s = np.floor(u * normal[0] + v * normal[1]).astype(int)
    keep = (np.abs(u) < half) & (np.abs(v) < half) & (s >= -half) & (s < half)
    count = np.bincount((s + half)[keep], minlength=2 * half)
    total = np.bincount((s + half)[keep], image[keep], minlength=2 * half)
    return {"normal": normal.tolist(), "middle": c["middle"].tolist(), "half_px": half, "mean": [round(float(x), 5) for x in total / np.maximum(count, 1)]}


def main():
    definition = json.loads(pathlib.Path(sys.argv[1]).read_text())
    names, rows = sys.argv[3:], []
    for case in definition["cases"]:
        if names and case["name"] not in names:
            continue
        begun = time.time()
        mi.set_variant("scalar_spectral_polarized" if case.get("polarized") else "scalar_rgb")
        c = case_of(definition["base"], case)
        cracked, intact = (np.array(mi.render(scene(c, with_crack))).reshape(2 * c["half"], -1) for with_crack in (True, False))
        if c["alpha"] > 0:
            white = {**c, **dict.fromkeys(("horizon", "zenith", "ground", "cabin", "rim"), 1.0)}
            white.pop("sun", None)
            kept = np.array(mi.render(scene(white, True))).reshape(2 * c["half"], -1)
            cracked = cracked + (1 - kept) * white_light(c)
        row = {**definition["base"], **case, "outer_mm": c["outer"][:2].tolist(), "reach_mm": float(c["reach_mm"])}
        if "sun" in c:
            row["sun"] = c["sun"]
        row["profile"] = profile(c, cracked)
        row["intact"] = round(float(np.mean(profile(c, intact)["mean"])), 5)
        rows.append(row)
        print(f"{case['name']:24} intact {row['intact']:.4f}  cracked {min(row['profile']['mean']):.4f} to {max(row['profile']['mean']):.4f}  {time.time() - begun:.0f} s", flush=True)
    pathlib.Path(sys.argv[2]).write_text("[\n" + ",\n".join(json.dumps(row) for row in rows) + "\n]\n")


if __name__ == "__main__":
    main()
