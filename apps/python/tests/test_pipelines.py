"""What docs/python-pipelines.md and the examples show: sets in public readers, a list of transforms in a trainer."""

import io
import json
import os
import pathlib
import runpy
import subprocess
import sys
import types

import albumentations as A
import numpy as np
import pytest
import starbreak
from conftest import picture
from PIL import Image

PROJECT = pathlib.Path(__file__).parents[3]
PAGE = (PROJECT / "docs/python-pipelines.md").read_text()


def blocks(kind):
    return [part.split("```")[0] for part in PAGE.split(f"```{kind}\n")[1:]]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """A COCO set of three images with boxes."""
    folder = tmp_path_factory.mktemp("source")
    for name in ("images", "annotations"):
        (folder / name).mkdir()
    for k in range(3):
        Image.fromarray(picture(seed=k)).save(folder / f"images/{k}.png")
    box = {"category_id": 1, "area": 1200, "iscrowd": 0}
    coco = {
        "images": [{"id": k, "file_name": f"{k}.png", "width": 128, "height": 96} for k in range(3)],
        "annotations": [{"id": k, "image_id": k % 3, "bbox": [10 * k, 20, 30, 40], **box} for k in range(5)],
        "categories": [{"id": 1, "name": "car"}],
    }
    (folder / "annotations/instances_train.json").write_text(json.dumps(coco))
    return folder


def test_the_python_of_the_page_runs():
    assert len(blocks("python")) == 1
    exec(compile(blocks("python")[0], "python-pipelines.md", "exec"), {})


def test_public_readers_have_images_regions_and_boxes_of_a_set(command, source, tmp_path, monkeypatch):
    import webdataset as wds

    monkeypatch.setenv("HF_HOME", str(tmp_path / "hf"))
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    command("generate", f"coco:{source}", "-o", tmp_path / "out", "--set", "fracture.mesh=fast")
    (tmp_path / "shards").mkdir()
    names = {"cracked": str(tmp_path / "out"), "shards": str(tmp_path / "shards")}
    program = "\n".join(blocks("python set"))
    assert len(blocks("python set")) == 3
    exec(compile(program, "python-pipelines.md", "exec"), names)

    expected = {}
    for k in range(3):
        image = picture(seed=k)
        recipe = starbreak.Recipe(set={"fracture.mesh": "fast"})
        full = starbreak.crack(image, recipe, 0, name=f"images/{k}.png", full=True)
        boxes = [[10 * n, 20, 30, 40] for n in range(5) if n % 3 == k]
        expected[str(k)] = (full.image, full.region, boxes)
        assert (full.image != image).any()

    assert len(names["folder"]) == 3
    found = sorted(np.asarray(row["image"]).tobytes() for row in names["folder"])
    assert found == sorted(image.tobytes() for image, _, _ in expected.values())
    for k, row in enumerate(names["dataset"]):
        image, region, boxes = expected[str(k)]
        np.testing.assert_array_equal(np.asarray(row["image"]), image)
        np.testing.assert_array_equal(np.asarray(row["region"]), region)
        assert row["boxes"] == boxes
    samples = list(wds.WebDataset(f"{tmp_path}/shards/cracked-000000.tar", shardshuffle=False))
    assert [sample["__key__"] for sample in samples] == ["0", "1", "2"]
    for sample in samples:
        image, region, boxes = expected[sample["__key__"]]
        np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(sample["png"]))), image)
        np.testing.assert_array_equal(np.asarray(Image.open(io.BytesIO(sample["region.png"]))), region)
        assert json.loads(sample["boxes.json"]) == boxes


#: Runs the tasks of an array one after the other, as `sbatch --wait` does beside each other.
SBATCH = """#!/bin/sh
for script; do :; done
n=$(sed -n 's/^#SBATCH.*--array=1-\\([0-9]*\\).*/\\1/p' "$script")
for task in $(seq "$n"); do
  SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=$n sh "$script" || exit 1
done
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Slurm is no program of Windows")
def test_the_slurm_array_of_the_page_makes_the_set_of_one_run(program, command, source, tmp_path):
    shards, join = blocks("sh")
    assert "--array=1-64" in shards and "/shared/" in join
    (tmp_path / "shards.sh").write_text(shards.replace("1-64", "1-3").replace("/shared", str(tmp_path)))
    (tmp_path / "sbatch").write_text(SBATCH)
    (tmp_path / "sbatch").chmod(0o755)
    (tmp_path / "starbreak").symlink_to(program)
    (tmp_path / "coco").symlink_to(source)
    command("patterns", "-n", 2, "-o", tmp_path / "bank", "--size", "128x96", "--set", "fracture.mesh=fast")
    command("generate", f"coco:{source}", "-o", tmp_path / "whole", "--bank", tmp_path / "bank", "--seed", 5)

    found = {**os.environ, "PATH": f"{tmp_path}{os.pathsep}{os.environ['PATH']}"}
    join = join.replace("/shared", str(tmp_path))
    done = subprocess.run(["sh", "-c", join], cwd=tmp_path, env=found, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert len(list(tmp_path.glob("cracked-*"))) == 3
    command("verify", tmp_path / "cracked")
    names = ["annotations/instances_train.json"]
    for folder in ("images", "starbreak/regions/images", "starbreak/cracks/images"):
        names += [f"{folder}/{k}.png" for k in range(3)]
    for name in names:
        assert (tmp_path / "cracked" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_fiftyone_is_told_where_images_and_labels_are(command, source, tmp_path, monkeypatch):
    """A stand-in looks where the importer looks; the importer itself does not load without its database."""
    command("generate", f"coco:{source}", "-o", tmp_path / "out", "--set", "fracture.mesh=fast")
    found = {}

    class Dataset:
        @staticmethod
        def from_dir(dataset_type, data_path, labels_path):
            assert dataset_type == "COCODetectionDataset"
            coco = json.loads(pathlib.Path(labels_path).read_text())
            found.update({image["file_name"]: pathlib.Path(data_path, image["file_name"]) for image in coco["images"]})

    known = types.SimpleNamespace(COCODetectionDataset="COCODetectionDataset")
    monkeypatch.setitem(sys.modules, "fiftyone", types.SimpleNamespace(Dataset=Dataset, types=known))
    (program,) = blocks("python fiftyone")
    exec(compile(program, "python-pipelines.md", "exec"), {"cracked": str(tmp_path / "out")})
    assert sorted(found) == ["0.png", "1.png", "2.png"]
    for path in found.values():
        assert Image.open(path).size == (128, 96)


def test_the_ultralytics_example_hands_over_a_list_that_its_compose_takes(command, tmp_path):
    """Its `Albumentations` makes `A.Compose(augmentations)`, seeds it, and calls it with a BGR image.

    validation/python_trainer.py trains a model of its own.
    """
    command("patterns", "-n", 2, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    example = runpy.run_path(str(PROJECT / "apps/python/examples/train_ultralytics.py"))

    class Model:
        def add_callback(self, event, callback):
            self.callback = (event, callback)

        def train(self, **words):
            self.words = words

    class Albumentations:
        transform = None

    model = Model()
    example["train"](model, data="coco8.yaml", bank=str(tmp_path), epochs=1)
    assert model.words["data"] == "coco8.yaml" and model.words["epochs"] == 1
    event, callback = model.callback
    assert event == "on_train_start"
    steps = types.SimpleNamespace(transforms=[Model(), Albumentations()])
    trainer = types.SimpleNamespace(train_loader=types.SimpleNamespace(dataset=types.SimpleNamespace(transforms=steps)))
    with pytest.raises(RuntimeError, match="albumentations==2.0.8"):
        callback(trainer)
    steps.transforms[1].transform = A.Compose([])
    callback(trainer)
    (glass,) = model.words["augmentations"]
    bank = starbreak.PatternBank(tmp_path)
    bgr = np.ascontiguousarray(picture()[..., ::-1])
    pipeline = A.Compose(model.words["augmentations"])
    pipeline.set_random_seed(11)
    made = [pipeline(image=bgr)["image"] for _ in range(12)]
    cracked = {bank.crack(picture(), index=index)[..., ::-1].tobytes() for index in range(2)}
    assert {image.tobytes() for image in made} == cracked | {bgr.tobytes()}
    assert glass.p == 0.5
