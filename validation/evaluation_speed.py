"""Time and memory of an evaluation of 5000 images, 35871 objects and 500000 detections.

    cargo build --release -p starbreak-cli
    python3 validation/evaluation_speed.py [ROUNDS]

Each tool reads both JSON files and gives the twelve numbers of MS-COCO, in turns, in a process of
its own. CPU seconds are user and system time; on a shared machine they are the robust figure.
`starbreak` also gives AP, AP50 and AP75 of each class and each pooled supercategory. Needs
pycocotools and faster-coco-eval from PyPI.
"""
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
STARBREAK = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "starbreak"
N_IMAGES, N_OBJECTS, N_DETECTIONS, N_CLASSES = 5000, 35871, 500_000, 80

PYCOCOTOOLS = """
import contextlib, io, json, sys
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval
with contextlib.redirect_stdout(io.StringIO()):
    truth = COCO(sys.argv[1]); e = COCOeval(truth, truth.loadRes(sys.argv[2]), 'bbox')
    e.evaluate(); e.accumulate(); e.summarize()
print(json.dumps([float(x) for x in e.stats]))
"""
FASTER = PYCOCOTOOLS.replace("pycocotools.coco ", "faster_coco_eval ").replace("pycocotools.cocoeval import COCOeval", "faster_coco_eval import COCOeval_faster as COCOeval")


def make(folder):
    import numpy as np

    rng = np.random.default_rng(0)
    classes = rng.permutation(np.arange(1, 91))[:N_CLASSES]
    share = rng.dirichlet(np.full(N_CLASSES, 0.5))
    images = [{"id": int(i), "width": 640, "height": 480, "file_name": f"{i:012d}.jpg"} for i in range(1, N_IMAGES + 1)]
    of = rng.integers(1, N_IMAGES + 1, N_OBJECTS)
    kind = classes[rng.choice(N_CLASSES, N_OBJECTS, p=share)]
    size = np.exp(rng.normal(4, 1, (N_OBJECTS, 2))).clip(2, 400)
    corner = rng.uniform(0, 1, (N_OBJECTS, 2)) * np.maximum([640, 480] - size, 1)
    boxes = np.round(np.hstack([corner, size]), 2)
    objects = [{"id": k + 1, "image_id": int(of[k]), "category_id": int(kind[k]), "bbox": boxes[k].tolist(),
                "area": round(float(boxes[k, 2] * boxes[k, 3] * 0.7), 2), "iscrowd": int(k % 97 == 0)} for k in range(N_OBJECTS)]
    n_near = N_DETECTIONS // 4
    near = rng.integers(0, N_OBJECTS, n_near)
    noise = rng.normal(0, 0.1, (n_near, 4)) * boxes[near][:, [2, 3, 2, 3]]
    good = boxes[near] + noise
    wild = np.hstack([rng.uniform(0, 500, (N_DETECTIONS - n_near, 2)), np.exp(rng.normal(4, 1, (N_DETECTIONS - n_near, 2)))])
    found = np.round(np.vstack([good, wild]), 3)
    found[:, 2:] = found[:, 2:].clip(0.5)
    image = np.concatenate([of[near], rng.integers(1, N_IMAGES + 1, N_DETECTIONS - n_near)])
    category = np.concatenate([kind[near], classes[rng.choice(N_CLASSES, N_DETECTIONS - n_near, p=share)]])
    score = np.round(np.concatenate([rng.beta(3, 2, n_near), rng.beta(1, 5, N_DETECTIONS - n_near)]), 5)
    order = rng.permutation(N_DETECTIONS)
    detections = [{"image_id": int(image[k]), "category_id": int(category[k]), "bbox": found[k].tolist(), "score": float(score[k])} for k in order]
    categories = [{"id": int(c), "name": f"class {c}", "supercategory": f"group {int(c) % 12}"} for c in sorted(classes)]
    truth = {"info": {}, "images": images, "annotations": objects, "categories": categories}
    (folder / "gt.json").write_text(json.dumps(truth))
    (folder / "dt.json").write_text(json.dumps(detections))


def run(command):
    """The twelve numbers, seconds of the clock and of the processor, and most memory in MiB."""
    begin = time.perf_counter()
    child = subprocess.Popen(list(map(str, command)), stdout=subprocess.PIPE)
    text = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    wall = time.perf_counter() - begin
    if status:
        raise SystemExit(f"{command} failed")
    said = json.loads(text)
    stats = said["clean"]["coco_stats"] if isinstance(said, dict) else said
    return stats, wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    if sys.argv[1:2] == ["--make"]:
        make(pathlib.Path(sys.argv[2]))
        return
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        # In a process of its own: a child counts the memory of its parent as its own.
        subprocess.run([sys.executable, __file__, "--make", folder], check=True)
        truth, said = folder / "gt.json", folder / "dt.json"
        print(f"{N_IMAGES} images, {N_OBJECTS} objects, {N_DETECTIONS} detections, {N_CLASSES} classes; "
              f"{(truth.stat().st_size + said.stat().st_size) / 1e6:.1f} MB of JSON; load {os.getloadavg()[0]:.1f}")
        tools = {
            "starbreak": [STARBREAK, "evaluate", "--ground-truth", truth, "--clean", said, "--json", "--quiet"],
            "faster-coco-eval": [sys.executable, "-c", FASTER, truth, said],
            "pycocotools": [sys.executable, "-c", PYCOCOTOOLS, truth, said],
        }
        runs = {name: [run(command)] for name, command in tools.items()}
        for _ in range(rounds - 1):
            for name in tools:
                if name != "pycocotools":
                    runs[name].append(run(tools[name]))
        expected = runs["pycocotools"][0][0]
        for name, all_runs in runs.items():
            off = max(abs(a - b) for a, b in zip(all_runs[0][0], expected))
            wall, cpu, mib = (min(r[i] for r in all_runs) for i in (1, 2, 3))
            print(f"{name:17} wall {wall:6.2f} s  CPU {cpu:6.2f} s (worst {max(r[2] for r in all_runs):.2f})  memory {mib:6.0f} MiB  "
                  f"largest difference to pycocotools {off:.1e}")
        _, _, cpu, mib = min(runs["starbreak"], key=lambda r: r[2])
        worst = max(r[3] for r in runs["starbreak"])
        is_good = cpu <= 1.2 and worst <= 300 and runs["starbreak"][0][0] == expected
        print(f"starbreak: {cpu:.2f} s of 1.2 s CPU, {worst:.0f} MiB of 300 MiB: {'kept' if is_good else 'NOT KEPT'}")
        sys.exit(0 if is_good else 1)


main()
