"""`starbreak evaluate` against pycocotools and scalabel, on sets that other seeds make.

    cargo build --release -p starbreak-cli
    python3 validation/evaluation_peers.py [SEED ...]

MS-COCO: the generator of the reference cases, ../shared/reference/eval/gen_coco_ref.py, is run with
each seed; it asks pycocotools. All arrays that `starbreak evaluate --curves` writes must be equal
to the last bit, the twelve numbers, too; in the region cases with coverages that starbreak takes
from the masks itself.
BDD100K: random frames, evaluated by `scalabel.eval.detect.evaluate_det`; all its numbers.
Needs pycocotools, scalabel and pydantic<2 from PyPI.
"""
import contextlib
import io
import json
import logging
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
STARBREAK = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "starbreak"
GENERATOR = ROOT.parent / "shared" / "reference" / "eval" / "gen_coco_ref.py"


def run(*args):
    return subprocess.run([STARBREAK, "evaluate", "--json", "--quiet", *map(str, args)], capture_output=True, text=True)


def evaluate(*args):
    done = run(*args)
    if done.returncode:
        raise SystemExit(f"starbreak evaluate {args}: {done.stderr}")
    return json.loads(done.stdout)


def n_different(a, b):
    a, b = np.asarray(a, dtype="<f8") + 0.0, np.asarray(b, dtype="<f8") + 0.0
    if a.shape != b.shape:
        return f"shape {a.shape} {b.shape}"
    return int((a.view("<u8") != b.view("<u8")).sum())


def is_refused(case):
    """Whether labels and detections have no category in common where that matters: `evaluate` must refuse it, pycocotools answers 0."""
    if json.loads((case / "params.json").read_text()).get("useCats") == 0:
        return False
    labels, detections = (json.loads((case / name).read_text()) for name in ("gt.json", "dt.json"))
    known = {category["id"] for category in labels["categories"]}
    if not detections or any(detection["category_id"] in known for detection in detections):
        return False
    done = run("--ground-truth", case / "gt.json", "--clean", case / "dt.json")
    if done.returncode != 2 or "have categories that the labels lack" not in done.stderr:
        raise SystemExit(f"{case.name} should be refused: {done.stderr}")
    return True


def coco_case(case, work):
    given = json.loads((case / "params.json").read_text())
    args = ["--ground-truth", case / "gt.json", "--clean", case / "dt.json", "--gt-id-zero-quirk", "--curves", work / "curves"]
    if given.get("useCats") == 0:
        args += ["--class-agnostic"]
    if "iouThrs" in given:
        args += ["--iou-thresholds", ",".join(map(repr, given["iouThrs"]))]
    if "maxDets" in given:
        args += ["--max-dets", ",".join(map(str, given["maxDets"]))]
    is_region = "dt_area_override" in given
    if "areaRng" in given and not is_region:
        for name, (least, most) in zip(given["areaRngLbl"], given["areaRng"]):
            args += ["--area-range", f"{name}={least!r},{most!r}"]
    if is_region:
        if case.name != "region_cov":
            return None
        masks = np.load(case / "masks.npz")
        (work / "masks").mkdir()
        for image in json.loads((case / "gt.json").read_text())["images"]:
            bits = np.unpackbits(masks[str(image["id"])])[: image["width"] * image["height"]]
            mask = bits.reshape(image["height"], image["width"]) * np.uint8(255)
            Image.fromarray(mask).save(work / "masks" / f"{pathlib.Path(image['file_name']).stem}.png")
        args += ["--regions", work / "masks", "--tau", "0,0.05,0.2"]
    said = evaluate(*args)
    found = {}
    if is_region:
        for a, tau in enumerate(["0", "0.05", "0.2"], start=1):
            for name in ["precision", "recall", "scores"]:
                theirs = np.load(case / "ref" / f"{name}.npy")[..., a : a + 1, -1:]
                ours = np.load(work / "curves" / "clean" / f"region_tau_{tau}" / f"{name}.npy")
                found[f"{name} tau {tau}"] = n_different(ours, theirs), theirs.size
        return found
    for name in ["precision", "recall", "scores"]:
        theirs = np.load(case / "ref" / f"{name}.npy")
        found[name] = n_different(np.load(work / "curves" / "clean" / f"{name}.npy"), theirs), theirs.size
    stats = json.loads((case / "ref" / "stats.json").read_text())["stats"]
    if stats is not None:
        found["stats"] = n_different(said["clean"]["coco_stats"], stats), 12
    return found


def coco(seed):
    n_bad = n_cases = n_numbers = n_refused = 0
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.executable, GENERATOR, folder, "24", str(seed)], check=True, capture_output=True)
        for case in sorted(pathlib.Path(folder).iterdir()):
            if is_refused(case):
                n_refused += 1
                continue
            with tempfile.TemporaryDirectory() as work:
                found = coco_case(case, pathlib.Path(work))
            if found is None:
                continue
            n_cases += 1
            n_numbers += sum(size for _, size in found.values())
            bad = {name: n for name, (n, _) in found.items() if n}
            if bad:
                n_bad += 1
                print(f"  {case.name}: numbers that differ: {bad}")
    print(f"MS-COCO, seed {seed}: {n_cases} cases, {n_numbers} numbers, {n_bad} cases differ, {n_refused} refused: no category in common")
    return n_bad == 0


def bdd(seed):
    from scalabel.eval.detect import evaluate_det
    from scalabel.label.typing import Category, Config, Frame, ImageSize

    names = ["pedestrian", "rider", "car", "truck", "bus", "train", "motorcycle", "bicycle", "traffic light", "traffic sign"]
    rng = np.random.default_rng(seed)
    truth, said = [], []
    for k in rng.permutation(60):
        name = f"{int(k) * 7919 % 1000:03d}.jpg"
        labels = []
        for i in range(int(rng.integers(0, 12))):
            x, y = rng.uniform(0, 1200), rng.uniform(0, 650)
            w, h = np.exp(rng.normal(3.5, 1, 2))
            labels.append({"id": str(i), "category": str(rng.choice(names)), "attributes": {"crowd": bool(rng.random() < 0.1), "ignored": bool(rng.random() < 0.05)},
                           "box2d": {"x1": x, "y1": y, "x2": x + w, "y2": y + h}})
        truth.append({"name": name, "labels": labels or None})
        found = []
        for i in range(int(rng.integers(0, 40))):
            if labels and rng.random() < 0.7:
                of = labels[int(rng.integers(len(labels)))]
                x1, y1, x2, y2 = (of["box2d"][c] + rng.normal() * 3 for c in ["x1", "y1", "x2", "y2"])
                category = of["category"]
            else:
                x1, y1 = rng.uniform(0, 1200), rng.uniform(0, 650)
                x2, y2 = x1 + 40, y1 + 40
                category = str(rng.choice(names))
            found.append({"id": str(i), "category": category, "score": round(float(rng.random()), 2),
                          "box2d": {"x1": min(x1, x2), "y1": min(y1, y2), "x2": max(x1, x2), "y2": max(y1, y2)}})
        said.append({"name": name, "labels": found})
    config = Config(imageSize=ImageSize(height=720, width=1280), categories=[Category(name=n) for n in names])
    # It talks while it works.
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        theirs = evaluate_det([Frame(**f) for f in truth], [Frame(**f) for f in said], config, nproc=1)
    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / n for n in ("gt.json", "dt.json")]
        for file, frames in zip(files, (truth, said)):
            file.write_text(json.dumps(frames))
        ours = evaluate("--ground-truth", files[0], "--clean", files[1], "--protocol", "bdd")["clean"]
    metrics = ["AP", "AP50", "AP75", "APs", "APm", "APl", "AR1", "AR10", "AR100", "ARs", "ARm", "ARl"]
    worst = 0.0
    for metric, stat in zip(metrics, ours["coco_stats"]):
        overall = getattr(theirs, metric)[-1]["OVERALL"]
        worst = max(worst, abs(overall - stat * 100)) if stat >= 0 else worst
    classes = {row["group"]["name"]: row for row in ours["groups"] if row["group"]["kind"] == "class"}
    few = set()
    for metric, key in [("AP", "ap"), ("AP50", "ap50"), ("AP75", "ap75")]:
        for name, row in classes.items():
            expected = getattr(theirs, metric)[0][name]
            if row[key]["value"] is not None:
                worst = max(worst, abs(expected - row[key]["value"] * 100))
            elif row["n_objects"] < 20:
                few.add(name)
            elif not np.isnan(expected):
                worst = float("inf")
    print(f"BDD100K, seed {seed}: 12 numbers and 3 per class for {len(classes) - len(few)} classes; worst difference {worst:.1e} points; "
          f"{len(few)} with fewer than 20 objects, refused")
    return worst <= 1e-9


def main():
    seeds = [int(a) for a in sys.argv[1:]] or [11, 2026]
    logging.disable(logging.INFO)
    good = [check(seed) for check in (coco, bdd) for seed in seeds]
    sys.exit(0 if all(good) else 1)


main()
