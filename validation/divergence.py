#!/usr/bin/env python3
"""Distances between sets against SciPy, NumPy and Pillow, for many seeds; sets of
real images that are near and far; usage: divergence.py STARBREAK"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.linalg import sqrtm
from scipy.spatial.distance import jensenshannon
from scipy.stats import entropy

STARBREAK = sys.argv[1]
SEEDS = range(40)


def run(*args):
    done = subprocess.run([STARBREAK, "divergence", *map(str, args), "--json", "-q"], capture_output=True, text=True)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)


def measures(p, q, alpha):
    p, q = (p + alpha) / (p + alpha).sum(), (q + alpha) / (q + alpha).sum()
    return dict(kl_pq=entropy(p, q), kl_qp=entropy(q, p), jeffreys=entropy(p, q) + entropy(q, p),
                js=jensenshannon(p, q) ** 2, w1_bins=np.abs(np.cumsum(p - q)).sum(),
                hellinger=np.sqrt(max(0, 1 - np.sqrt(p * q).sum())), tv=0.5 * np.abs(p - q).sum())


def known_answers(folder):
    """Histograms and feature vectors of random numbers."""
    worst = {}

    def compare(have, want):
        for key, value in want.items():
            worst[key] = max(worst.get(key, 0), abs(have[key] - value) / abs(value))

    for seed in SEEDS:
        r = np.random.default_rng(seed)
        given, expected = [], []
        for n in (2, 8, 64, 256, 4096):
            for alpha in (0.0, 1e-10, 0.5, 1.0):
                p, q = r.integers(0, 1000, (2, n)).astype(float) + (alpha == 0)
                given.append(dict(p=p.tolist(), q=q.tolist(), alpha=alpha))
                expected.append(measures(p, q, alpha))
        (folder / "given.json").write_text(json.dumps(given))
        for have, want in zip(run("--histograms", folder / "given.json")["hist"], expected, strict=True):
            compare(have, want)
        for n, m, d in ((5, 7, 3), (20, 20, 8), (50, 40, 16)):
            x, y = r.normal(size=(n, d)), r.normal(0.3, 1.2, size=(m, d))
            np.save(folder / "x.npy", x)
            np.save(folder / "y.npy", y)
            s0, s1 = np.cov(x, rowvar=False), np.cov(y, rowvar=False)
            cubic = lambda a, b: (a @ b.T / d + 1) ** 3
            inside = lambda a: (cubic(a, a).sum() - np.trace(cubic(a, a))) / (len(a) * (len(a) - 1))
            want = dict(frechet=((x.mean(0) - y.mean(0)) ** 2).sum() + np.trace(s0 + s1 - 2 * sqrtm(s0 @ s1).real),
                        kid=inside(x) + inside(y) - 2 * cubic(x, y).mean())
            compare(run("--features", folder / "x.npy", folder / "y.npy")["activations"], want)
    failed = 0
    for key, error in worst.items():
        limit = 1e-8 if key == "frechet" else 1e-12
        failed += error > limit
        print(f"{key:10} {len(SEEDS)} seeds, worst {error:.1e} of {limit:.0e}: {'ok' if error <= limit else 'FAIL'}")
    return failed


def histograms(folder):
    """Luma and color of images with alpha, gray and of different sizes, by Pillow and NumPy."""
    r = np.random.default_rng(5)
    pooled = []
    for name in ("a", "b"):
        (folder / name).mkdir()
        luma, color = np.zeros(256), np.zeros(4096)
        for at in range(6):
            w, h = r.integers(20, 200, 2)
            pixels = r.integers(0, 256 if name == "a" else 200, (h, w, 4), dtype=np.uint8)
            image = Image.fromarray(pixels, "RGBA")
            image = [image, image.convert("RGB"), image.convert("L")][at % 3]
            image.save(folder / name / f"{at}.png")
            rgb = np.asarray(image.convert("RGB"))
            if image.mode == "RGBA":
                c, alpha = pixels[..., :3].astype(int), pixels[..., 3:].astype(int)
                rgb = ((c * alpha + 127) // 255).astype(np.uint8)
            luma += np.bincount(np.asarray(Image.fromarray(rgb).convert("L")).ravel(), minlength=256)
            c = rgb.astype(int) >> 4
            color += np.bincount(((c[..., 0] * 16 + c[..., 1]) * 16 + c[..., 2]).ravel(), minlength=4096)
        pooled.append((luma, color))
    got = run(f"a=folder:{folder}/a", f"b=folder:{folder}/b", "--bootstrap", 0, "--permutations", 0, "--splits", 0)
    worst = 0
    for at, feature in enumerate(got["pairs"][0]["features"][:2]):
        want = measures(pooled[0][at], pooled[1][at], 0.5)
        for ours, theirs in (("kl_ab", "kl_pq"), ("kl_ba", "kl_qp"), ("js", "js"), ("tv", "tv")):
            worst = max(worst, abs(feature["measures"][ours]["value"] - want[theirs]) / want[theirs])
    print(f"luma256 and rgb16 of whole images against Pillow and NumPy: worst {worst:.1e} of 1e-12: {'ok' if worst < 1e-12 else 'FAIL'}")
    return worst >= 1e-12


def real_images(folder):
    """Halves of coco96 within their floor; its cracked twin seen by pairs only; KITTI and BDD100K far."""
    shared = Path(__file__).resolve().parent.parent.parent / "shared" / "data"
    if not shared.is_dir():
        print("SKIPPED real images: no ../shared/data")
        return 0
    images = sorted((shared / "coco96" / "val2017").iterdir())
    for place, image in enumerate(images):
        half = folder / f"half{place % 2}"
        half.mkdir(exist_ok=True)
        (half / image.name).write_bytes(image.read_bytes())
    subprocess.run([STARBREAK, "generate", f"coco:{shared}/coco96", "-o", folder / "twin", "--seed", "7", "-q"], check=True)
    model = shared / "onnx" / "yolox_nano.onnx"
    failed = 0
    for name, a, b, expected in (
            ("halves of coco96", f"a=folder:{folder}/half0", f"b=folder:{folder}/half1", "same"),
            ("coco96 and its cracked twin", f"a=coco:{shared}/coco96", f"b=coco:{folder}/twin", "differ"),
            ("coco96 and KITTI (3 frames)", f"a=coco:{shared}/coco96", f"b=folder:{shared}/kitti/image_2", "report"),
            ("coco96 and BDD100K (3 frames)", f"a=coco:{shared}/coco96", f"b=folder:{shared}/bdd", "report")):
        pair = run(a, b, "--model", model, "--bootstrap", 200)["pairs"][0]
        print(f"{name}: n {pair['n_a']} and {pair['n_b']}{', paired' if pair['is_paired'] else ''}")
        seen = 0
        for feature in pair["features"]:
            js = feature["measures"]["js"]
            seen += js["p_value"] < 0.05
            print(f"  {feature['feature']:15} JS {js['value']:.5f} {js['interval']} floor {js['floor']:.5f} effect {js['effect']:.2f} p {js['p_value']:.3f}"
                  f" KL {feature['measures']['kl_ab']['value']:.4f} {feature['measures']['kl_ba']['value']:.4f}")
        activations = pair["activations"]
        print(f"  {Path(activations['origin']).name}: {activations['n_dimensions']} values,"
              f" frechet {activations['frechet']:.5g}, kid {activations['kid']:.5g}")
        wrong = (expected == "same" and seen > 1) or (expected == "differ" and seen < 3)
        failed += wrong
        print(f"  {seen} of 5 features with p < 0.05, expected {expected}: {'FAIL' if wrong else 'ok'}")
    return failed


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    sys.exit(bool(known_answers(folder) + histograms(folder) + real_images(folder)))
