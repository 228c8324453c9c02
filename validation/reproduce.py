#!/usr/bin/env python3
"""docs/reproduce.md from top to bottom, and the paper's Table 1 with what is at hand.

reproduce.py STARBREAK. The page's commands are run by docs/run_commands.py, with ../shared/data in the place of what it
makes up: 96 images of MS-COCO, and YOLOX-nano and FastestDet for the paper's three networks. All else is made up
there (of KITTI 3 images are at hand, of which nothing can be said), so no number of it is printed. Then a study of
the 96 images with both networks, whose numbers stand beside the paper's. Needs the packages of
xtask/test-requirements.txt. Ends with 1 if a command of the page fails.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared/data"
# The paper's Table 1, MS-COCO with Faster R-CNN, in percent: clean, overlaid photographs, simulated.
PAPER = {
    ("person", "ap50"): (0.035, 0.024, 0.024),
    ("vehicle", "ap50"): (2.14, 1.45, 1.87),
    ("food", "ap50"): (35.34, 28.07, 30.65),
    ("person", "ap75"): (0.032, 0.022, 0.023),
    ("vehicle", "ap75"): (1.56, 1.05, 1.07),
    ("food", "ap75"): (24.59, 18.85, 22.00),
}


def run_page(starbreak, folder):
    """Runs the page; what is at hand takes the place of what is made up."""
    places = {
        "COCO": "coco96",
        "yolov8n.onnx": "onnx/yolox_nano.onnx",
        "pvt.onnx": "onnx/FastestDet.onnx",
        "fasterrcnn.onnx": "onnx/yolox_nano.onnx",
    }
    for name, path in places.items():
        link = folder / name
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(SHARED / path)
    command = [sys.executable, ROOT / "docs/run_commands.py", starbreak, "--inputs", folder, "docs/reproduce.md"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    ran = [line for line in done.stdout.splitlines() if " run, " in line]
    print("docs/reproduce.md:", *(ran if done.returncode == 0 else ["FAIL", done.stdout, done.stderr]), sep="\n")
    return done.returncode


def percent(estimate):
    value = estimate.get("value")
    return f"{value * 100:5.1f}" if value is not None else f"  -- ({estimate.get('refused', 'none')})"


def interval(estimate):
    return f" [{estimate['low'] * 100:.1f}, {estimate['high'] * 100:.1f}]" if "low" in estimate else ""


def table(starbreak, folder):
    """AP of supercategories in the region, and what is lost there, beside the paper's."""
    models = [SHARED / "onnx" / name for name in ("yolox_nano.onnx", "FastestDet.onnx")]
    command = [starbreak, "study", f"coco:{SHARED / 'coco96'}", "--presets", "paper", "-o", folder, "--quiet"]
    command += [word for model in models for word in ("--model", model)]
    subprocess.run(list(map(str, command)), check=True)
    study = json.loads((folder / "evaluation.json").read_text())
    tau = study["provenance"]["settings"]["tau"]
    in_region = {"kind": "in_region", "tau": tau}
    print(f"\nMS-COCO, 96 images, `study --presets paper`: objects in the region (tau {tau}), percent")
    for one in study["evaluations"]:
        print(f"{one['detector']}: n, clean, Sim, difference with 95 % interval | the paper's clean, Sim")
        for (group, metric), (clean, _, sim) in PAPER.items():
            rows = (row for row in one["paired"] if row["scope"] == in_region and row["metric"] == metric)
            row = next(row for row in rows if row["group"] == {"kind": "supercategory", "name": group})
            numbers = "  ".join([percent(row["clean"]), percent(row["cracked"]), percent(row["delta"])])
            print(f"  {metric} {group:8} {row['n_objects']:4}  {numbers}{interval(row['delta'])} | {clean} {sim}")
        for row in one["failures"]["rates"]:
            if row["group"]["kind"] == "all" and row["scope"] in (in_region, {"kind": "out_of_region", "tau": tau}):
                where = "in the region" if row["scope"] == in_region else "outside"
                rate = row["failure_rate"]
                print(f"  lost {where}: {percent(rate)} %{interval(rate)} of {row['n_found_clean']} found clean")
    print("distances of pixels, clean against Sim, nats: JS, and that of two halves of one set")
    for one in study["divergence"]["tables"]:
        if one["measure"].startswith("JS"):
            floor = max(value for value in one["noise_floor"] if value is not None)
            print(f"  {one['feature']:14} {one['values'][0][1]['value']:.5f}  {floor:.5f}")


if __name__ == "__main__":
    if not (SHARED / "coco96").is_dir():
        print("SKIPPED: there is no ../shared/data/coco96")
        sys.exit()
    with tempfile.TemporaryDirectory() as work:
        work = pathlib.Path(work)
        (work / "inputs").mkdir()
        failed = run_page(sys.argv[1], work / "inputs")
        table(sys.argv[1], work / "study")
    sys.exit(failed)
