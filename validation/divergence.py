#!/usr/bin/env python3
"""Distances between sets against SciPy, NumPy, Pillow and scikit-learn, for many seeds; sets of
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
from sklearn.covariance import ledoit_wolf_shrinkage

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


def document(seed):
    """The families of the reference, with expected values."""
    r = np.random.default_rng(seed)
    given, expected = dict(hist=[], gauss=[], frechet=[], mmd=[]), dict(hist=[], gauss=[], frechet=[], mmd=[])
    for n in (2, 8, 64, 256, 4096):
        for alpha in (0.0, 1e-10, 0.5, 1.0):
            p, q = r.integers(0, 1000, (2, n)).astype(float) + (alpha == 0)
            given["hist"].append(dict(p=p.tolist(), q=q.tolist(), alpha=alpha))
            expected["hist"].append(measures(p, q, alpha))
    for d in (1, 2, 5, 16, 64):
        a, b = r.normal(size=(2, d, d))
        s0, s1, m0, m1 = a @ a.T + np.eye(d) / 2, b @ b.T + np.eye(d) / 2, *r.normal(size=(2, d))
        entry = dict(m0=m0.tolist(), S0=s0.tolist(), m1=m1.tolist(), S1=s1.tolist())

        def kl(m0, s0, m1, s1):
            i = np.linalg.inv(s1)
            return 0.5 * (np.trace(i @ s0) + (m1 - m0) @ i @ (m1 - m0) - d + np.linalg.slogdet(s1)[1] - np.linalg.slogdet(s0)[1])
        given["gauss"].append(entry)
        expected["gauss"].append(dict(kl=kl(m0, s0, m1, s1), kl_rev=kl(m1, s1, m0, s0)))
        given["frechet"].append(entry)
        expected["frechet"].append(dict(d2=((m0 - m1) ** 2).sum() + np.trace(s0 + s1 - 2 * sqrtm(s0 @ s1).real)))
    for n, m, d in ((5, 7, 3), (20, 20, 8), (50, 40, 16)):
        x, y = r.normal(size=(n, d)), r.normal(0.3, 1.2, size=(m, d))
        cubic = lambda a, b: (a @ b.T / d + 1) ** 3
        rbf = lambda a, b: np.exp(-((a[:, None] - b[None]) ** 2).sum(-1) / 200)
        inside = lambda k, a: (k(a, a).sum() - np.trace(k(a, a))) / (len(a) * (len(a) - 1))
        given["mmd"].append(dict(X=x.tolist(), Y=y.tolist()))
        expected["mmd"].append(dict(kid_unbiased=inside(cubic, x) + inside(cubic, y) - 2 * cubic(x, y).mean(),
                                    cmmd_biased_x1000=1000 * (rbf(x, x).mean() + rbf(y, y).mean() - 2 * rbf(x, y).mean())))
    return given, expected


def known_answers(folder):
    worst = {}
    for seed in SEEDS:
        given, expected = document(seed)
        path = folder / "given.json"
        path.write_text(json.dumps(given))
        got = run("--histograms", path)
        for family, entries in expected.items():
            for want, have in zip(entries, got[family], strict=True):
                for key, value in want.items():
                    error = abs(have[key] - value) / abs(value)
                    worst[family, key] = max(worst.get((family, key), 0), error)
    failed = 0
    for (family, key), error in worst.items():
        limit = 1e-8 if family == "frechet" else 1e-12
        failed += error > limit
        print(f"{family:8} {key:18} {len(SEEDS)} seeds, worst {error:.1e} of {limit:.0e}: {'ok' if error <= limit else 'FAIL'}")
    return failed


def shrinkage(folder):
    r = np.random.default_rng(3)
    a, b = r.normal(size=(40, 12)) * np.arange(1, 13), r.normal(size=(300, 12)) * np.arange(1, 13)
    np.save(folder / "a.npy", a)
    np.save(folder / "b.npy", b)
    got = run("--features", folder / "a.npy", folder / "b.npy", "--bootstrap", 0, "--permutations", 0, "--splits", 0)
    error = max(abs(x - ledoit_wolf_shrinkage(y)) for x, y in zip(got["activations"]["shrinkage"], (a, b)))
    print(f"shrinkage against scikit-learn: worst {error:.1e} of 1e-12: {'ok' if error < 1e-12 else 'FAIL'}")
    return error >= 1e-12


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
        (half / image.name).symlink_to(image)
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
        print(f"  {Path(activations['origin']).name}: {activations['n_dimensions']} values")
        for measure, estimate in activations["measures"].items():
            print(f"  {measure:15} {estimate['value']:.5g} floor {estimate['floor']} p {estimate['p_value']}")
        wrong = (expected == "same" and seen > 1) or (expected == "differ" and seen < 3)
        failed += wrong
        print(f"  {seen} of 5 features with p < 0.05, expected {expected}: {'FAIL' if wrong else 'ok'}")
    return failed


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    sys.exit(bool(known_answers(folder) + shrinkage(folder) + histograms(folder) + real_images(folder)))
