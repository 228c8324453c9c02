"""Sets made by `starbreak generate` against their sources, both loaded by public tools.

    python validation/dataset_round_trips.py target/release/starbreak

KITTI and COCO are the real data of ../shared/data, where it is; BDD100K and YOLO sets are written here in the layouts of
their tools, over pictures that are drawn here. Needs requirements-loaders.txt. Ends with 1 if one differs.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

HERE = pathlib.Path(__file__).resolve().parent
SHARED = HERE.parent.parent / "shared" / "data"


def picture(path, k):
    path.parent.mkdir(parents=True, exist_ok=True)
    y, x = np.mgrid[0:180, 0:320]
    codes = np.stack([(x * 3 + k * 40) % 256, (y * 2) % 256, (x + y) % 256], axis=2)
    Image.fromarray(codes.astype(np.uint8)).save(path, quality=92)


def bdd(root):
    frames = []
    for k in range(6):
        name = f"{k:08x}-{k:08x}.jpg"
        picture(root / "images/100k/val" / name, k)
        labels = [
            {"id": f"{k}{j}", "category": kind, "attributes": {"occluded": bool(j), "truncated": False},
             "box2d": {"x1": 10.5 + j, "y1": 20.25, "x2": 90.75 + j, "y2": 110.0}}
            for j, kind in enumerate(["car", "pedestrian", "traffic light"])
        ]
        frames.append({"name": name, "attributes": {"weather": "clear"}, "timestamp": 10000,
                       "labels": None if k == 3 else labels})
    path = root / "labels/det_20/det_val.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(frames))


def yolo(root):
    for k in range(6):
        part = "train" if k < 4 else "val"
        picture(root / f"images/{part}/{k}.jpg", k)
        label = root / f"labels/{part}/{k}.txt"
        label.parent.mkdir(parents=True, exist_ok=True)
        label.write_text("".join(f"{j} 0.{5 + j} 0.5 0.25 0.4\n" for j in range(3)))
    (root / "data.yaml").write_text(
        f"path: {root}\ntrain: images/train\nval: images/val\nnames:\n  0: car\n  1: dog\n  2: cat\n")


def main():
    starbreak = pathlib.Path(sys.argv[1]).resolve()
    is_good = True
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        sources = {"kitti": SHARED / "kitti", "coco": SHARED / "coco96", "bdd": work / "bdd", "yolo": work / "yolo"}
        bdd(sources["bdd"])
        yolo(sources["yolo"])
        for name, source in sources.items():
            if not source.exists():
                print(f"SKIPPED {name}: no ../shared/data")
                continue
            for more in ([], ["--limit", "2"]):
                out = work / f"out-{name}-{len(more)}"
                subprocess.run([starbreak, "generate", f"{name}:{source}", "-o", out, "--quiet", *more], check=True)
                what = "whole" if not more else "two images"
                print(f"== {name}, {what}", flush=True)
                check = [sys.executable, "-W", "ignore", HERE / "dataset_loaders.py", source, out, name]
                ran = subprocess.run(check + (["--subset"] if more else []), text=True, stdout=subprocess.PIPE)
                # Without what the loaders say of themselves.
                print("\n".join(line for line in ran.stdout.splitlines() if ": " in line or line == "same"), flush=True)
                is_good &= ran.returncode == 0
    sys.exit(not is_good)


main()
