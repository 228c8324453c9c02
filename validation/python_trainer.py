#!/usr/bin/env python3
"""The example of a training with Ultralytics: one epoch of a model from its configuration, no weights.

usage: python_trainer.py STARBREAK
needs requirements-torch.txt and the package starbreak; with Albumentations 2.0.8 on the path the
images are cracked, with AlbumentationsX the training is refused; ends with 1 if not.
"""
import contextlib
import io
import os
import pathlib
import runpy
import subprocess
import sys
import tempfile

import numpy as np
import PIL.Image

EXAMPLE = pathlib.Path(__file__).parents[1] / "apps/python/examples/train_ultralytics.py"
N_IMAGES = 8


def make_set(folder):
    """Blue pictures with a thing in the middle of each."""
    for kind in ("images", "labels"):
        (folder / kind / "train").mkdir(parents=True)
    for k in range(N_IMAGES):
        image = np.random.default_rng(k).integers(0, 60, (96, 128, 3), np.uint8)
        image[..., 2] += 150
        PIL.Image.fromarray(image).save(folder / f"images/train/{k}.png")
        (folder / f"labels/train/{k}.txt").write_text("0 0.5 0.5 0.4 0.4\n")
    data = folder / "data.yaml"
    data.write_text(f"path: {folder}\ntrain: images/train\nval: images/train\nnames: {{0: thing}}\n")
    return data


def train(folder, bank):
    """The images that were cracked, before and after, in one epoch."""
    os.environ.update(YOLO_CONFIG_DIR=str(folder), YOLO_AUTOINSTALL="false", YOLO_VERBOSE="false")
    import ultralytics

    print(f"Ultralytics {ultralytics.__version__}, YOLO11n from its configuration")
    example = runpy.run_path(str(EXAMPLE))
    glass, pairs = example["CrackedGlassBgr"], []
    own = glass.apply

    def apply(self, img, **params):
        pairs.append((img, own(self, img, **params)))
        return pairs[-1][1]

    glass.apply = apply
    words = {"epochs": 1, "imgsz": 96, "batch": 4, "workers": 0, "device": "cpu", "plots": False}
    words |= {"amp": False, "val": False, "project": str(folder), "exist_ok": True}
    words |= dict.fromkeys(("hsv_h", "hsv_s", "hsv_v"), 0.0)
    model = ultralytics.YOLO("yolo11n.yaml")
    with contextlib.redirect_stdout(io.StringIO()):
        example["train"](model, data=str(make_set(folder)), bank=str(bank), **words)
    assert model.trainer.epoch == 0 and all(np.isfinite(float(loss)) for loss in model.trainer.tloss.values())
    return pairs


def main(program):
    import albumentations

    is_x = not albumentations.__version__.startswith("2.0.")
    print(f"Albumentations{'X' if is_x else ''} {albumentations.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        subprocess.run(
            [program, "patterns", "-n", "3", "-o", folder / "bank", "--size", "96x96", "--quiet"], check=True
        )
        try:
            pairs = train(folder, folder / "bank")
        except RuntimeError as refused:
            print(f"  refused: {refused}")
            return not is_x
    changed = sum(bool((before != after).any()) for before, after in pairs)
    blue_first = sum(bool(before[..., 0].mean() > before[..., 2].mean()) for before, _ in pairs)
    print(f"  one epoch: {len(pairs)} of {N_IMAGES} images behind glass, {changed} changed, {blue_first} in BGR")
    return is_x or not (0 < len(pairs) < N_IMAGES and changed == blue_first == len(pairs))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
