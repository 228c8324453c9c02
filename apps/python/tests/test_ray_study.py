"""Studies on a real local Ray: the files and numbers of one machine, and a worker that is killed."""

import contextlib
import json
import os
import pathlib
import shutil
import signal
import threading
import time

import numpy as np
import pytest
import starbreak
import starbreak.ray
from conftest import SMALL, picture
from PIL import Image

# One cluster at a time: workers are killed by what they are called.
pytestmark = [pytest.mark.usefixtures("cluster"), pytest.mark.xdist_group("ray")]
onnx = pytest.importorskip("onnx", reason="onnx is not installed; run `cargo xtask test`")

N_IMAGES = 10
STUDY = {"presets": ["paper"], "severities": [1, 5], "set": SMALL, "replicates": 20, "worst": 1}


@pytest.fixture
def world(tmp_path, monkeypatch):
    """A working folder with images of MS-COCO, one of them broken, and a detector that sees a box in each."""
    root = tmp_path / "coco"
    (root / "val2017").mkdir(parents=True)
    (root / "annotations").mkdir()
    images, annotations = [], []
    for k in range(1, N_IMAGES + 1):
        name = f"{k:012}.png"
        Image.fromarray(picture(seed=k)).save(root / "val2017" / name)
        images.append({"id": k, "file_name": name, "width": 128, "height": 96})
        box = {"bbox": [20, 20, 60, 40], "area": 2400, "iscrowd": 0, "category_id": 1}
        annotations.append({"id": k, "image_id": k, **box})
    (root / "val2017" / f"{4:012}.png").write_bytes(b"no image")
    labels = {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "person"}]}
    (root / "annotations/instances_val2017.json").write_text(json.dumps(labels))
    # In the form of YOLOX: a person in the middle, as sure as a pixel is bright.
    found = np.zeros((1, 84, 85), np.float32)
    found[0, 3, :6] = 3, 3, 3.0, 2.8, 0, 1
    pick = np.zeros((1, 84, 85), np.float32)
    pick[0, 3, 4] = 1 / 255
    floats, tensor = onnx.TensorProto.FLOAT, onnx.numpy_helper.from_array
    nodes = [
        onnx.helper.make_node("Slice", ["images", "begin", "end"], ["pixel"]),
        onnx.helper.make_node("Reshape", ["pixel", "shape"], ["bright"]),
        onnx.helper.make_node("Mul", ["bright", "pick"], ["sure"]),
        onnx.helper.make_node("Add", ["sure", "found"], ["output"]),
    ]
    graph = onnx.helper.make_graph(
        nodes,
        "detector",
        [onnx.helper.make_tensor_value_info("images", floats, [1, 3, 64, 64])],
        [onnx.helper.make_tensor_value_info("output", floats, [1, 84, 85])],
        [
            tensor(np.array([0, 0, 24, 30]), "begin"),
            tensor(np.array([1, 1, 25, 31]), "end"),
            tensor(np.array([1, 1, 1]), "shape"),
            tensor(pick, "pick"),
            tensor(found, "found"),
        ],
    )
    model = onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 13)], ir_version=8)
    onnx.save(model, tmp_path / "yolox.onnx")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def files_in(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def on_one_machine(world):
    """The study of the plain call, moved out of the way."""
    found = starbreak.study("coco:coco", "yolox.onnx", "study", **STUDY)
    (world / "study").rename(world / "alone")
    return found


def test_files_and_numbers_are_those_of_one_machine(world):
    alone = on_one_machine(world)
    assert len(alone["evaluations"]) == 2
    for n_shards in (1, 3):
        found = starbreak.ray.study("coco:coco", "yolox.onnx", "study", n_shards=n_shards, **STUDY)
        assert found == alone
        assert files_in(world / "study") == files_in(world / "alone")
        # One image could not be used, and may be mended.
        assert len(list((world / "study-shards").iterdir())) == n_shards
        shutil.rmtree(world / "study-shards")
        (world / "study").rename(world / f"study-{n_shards}")
    (world / f"coco/val2017/{4:012}.png").write_bytes((world / f"coco/val2017/{5:012}.png").read_bytes())
    recipe = starbreak.Recipe("paper", set=SMALL)
    more = {"replicates": 20, "no_store": True}
    alone = starbreak.study("coco:coco", ["yolox.onnx"], "study", recipe, **more)
    (world / "study").rename(world / "removed")
    of_shards = starbreak.ray.study("coco:coco", ["yolox.onnx"], "study/", recipe, n_shards=2, **more)
    assert of_shards["evaluations"] == alone["evaluations"]
    # The report names the folder as it was given.
    told = {pathlib.Path(name) for name in ("report.html", "evaluation.json", "written.json")}
    found, expected = files_in(world / "study"), files_in(world / "removed")
    assert {name: found[name] for name in found.keys() - told} == {
        name: expected[name] for name in expected.keys() - told
    }
    assert not (world / "study-shards").exists()
    # It is whole: nothing is made again, and no shards either.
    assert starbreak.ray.study("coco:coco", ["yolox.onnx"], "study/", recipe, n_shards=2, **more) == of_shards
    assert not (world / "study-shards").exists()


def tasks_at_work():
    """Processes of Ray that do a step of a study."""
    for folder in pathlib.Path("/proc").iterdir():
        with contextlib.suppress(OSError):
            if folder.name.isdigit() and b"ray::study step" in (folder / "cmdline").read_bytes():
                yield int(folder.name)


def test_a_killed_worker_costs_only_what_it_had_not_written_down(world):
    alone = on_one_machine(world)
    killed = []

    def kill():
        while len(killed) < 2 and not (world / "study/report.html").exists():
            begun = list((world / "study-shards").glob("*/detections/*/*.jsonl"))
            for process in tasks_at_work() if begun else ():
                if process not in killed:
                    os.kill(process, signal.SIGKILL)
                    killed.append(process)
                    break
            time.sleep(0.02)

    killer = threading.Thread(target=kill, daemon=True)
    killer.start()
    found = starbreak.ray.study("coco:coco", "yolox.onnx", "study", n_shards=2, **STUDY)
    killer.join()
    assert killed, "no worker was killed"
    assert found == alone
    assert files_in(world / "study") == files_in(world / "alone")


def test_what_is_done_is_not_done_again(world):
    starbreak.study("coco:coco", "yolox.onnx", "study-shards/1-of-2", shard="1/2", **STUDY)
    done = {path: path.stat().st_mtime_ns for path in (world / "study-shards").rglob("*.png")}
    marks = {path: path.stat().st_ino for path in done}
    starbreak.ray.study("coco:coco", "yolox.onnx", "study", n_shards=2, **STUDY)
    kept = {path.stat().st_ino: path.stat().st_mtime_ns for path in (world / "study").rglob("*.png")}
    assert done
    for path, inode in marks.items():
        assert kept[inode] == done[path], path


def test_what_makes_no_sense_is_refused_before_a_task_begins(world):
    for match, words in [
        ("shard", {"shard": "1/2"}),
        ("join", {"join": ["x"]}),
        ("progress", {"progress": True}),
        ("share", {"output": "s3://bucket/study"}),
        ("dry_run", {"dry_run": False}),
        ("n_shards", {"n_shards": 0}),
        ("threads", {"threads": 0}),
        ("papper", {"presets": ["papper"]}),
        ("no such file", {"model": "none.onnx"}),
        ("smaples", {"smaples": 1}),
    ]:
        with pytest.raises(ValueError, match=match):
            starbreak.ray.study(**{"source": "coco:coco", "model": "yolox.onnx", "output": "study", **STUDY, **words})
    assert sorted(path.name for path in world.iterdir()) == ["coco", "yolox.onnx"]
