"""`evaluate` and `divergence` say what the command says."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import starbreak
from conftest import picture
from PIL import Image

CATEGORIES = [{"id": 1, "name": "car"}, {"id": 3, "name": "person"}]


@pytest.fixture(scope="module")
def labeled(tmp_path_factory):
    """Thirty labeled images in two categories, with boxes found, missed and made up."""
    folder = tmp_path_factory.mktemp("labeled")
    draw = np.random.default_rng(1)
    images, annotations, found = [], [], {"clean": [], "cracked": []}
    for image_id in range(1, 31):
        name = f"{image_id:03}.png"
        images.append({"id": image_id, "file_name": name, "width": 128, "height": 96})
        for _ in range(3):
            x, y, width, height = map(float, draw.integers([0, 0, 10, 10], [90, 60, 38, 36]))
            category = int(draw.choice([1, 3]))
            annotations.append(
                {"id": len(annotations) + 1, "image_id": image_id, "category_id": category, "iscrowd": 0}
                | {"bbox": [x, y, width, height], "area": width * height}
            )
            for side, chance in (("clean", 0.9), ("cracked", 0.6)):
                if draw.random() < chance:
                    shift = float(draw.normal(0, 1.5))
                    box = [x + shift, y, width, height]
                    score = round(float(draw.random()), 3)
                    found[side].append({"image_id": image_id, "category_id": category, "bbox": box, "score": score})
    (folder / "images").mkdir()
    regions = folder / "regions"
    regions.mkdir()
    for image in images:
        Image.fromarray(picture(seed=image["id"])).save(folder / "images" / image["file_name"])
        mask = np.zeros((96, 128), np.uint8)
        mask[:, : 20 + 2 * image["id"]] = 255
        Image.fromarray(mask).save(regions / image["file_name"])
    truth = {"images": images, "annotations": annotations, "categories": CATEGORIES}
    (folder / "labels.json").write_text(json.dumps(truth))
    for side, boxes in found.items():
        (folder / f"{side}.json").write_text(json.dumps(boxes))
    return folder


def test_evaluate_says_what_the_command_prints(command, labeled):
    files = [labeled / name for name in ("labels.json", "clean.json", "cracked.json", "regions")]
    labels, clean, cracked, regions = files
    said = command("evaluate", "--ground-truth", labels, "--clean", clean, "--cracked", cracked, "--json")
    ours = starbreak.evaluate(ground_truth=labels, clean=clean, cracked=cracked)
    assert ours == json.loads(said.stdout)
    assert 0.1 < ours["cracked"]["coco_stats"][0] < ours["clean"]["coco_stats"][0] < 1
    said = command(
        *("evaluate", "--ground-truth", labels, "--clean", clean, "--cracked", cracked, "--json"),
        *("--regions", regions, "--tau", "0.1,0.5"),
    )
    for tau in ([0.1, 0.5], np.array([0.1, 0.5])):
        ours = starbreak.evaluate(ground_truth=labels, clean=clean, cracked=cracked, regions=regions, tau=tau)
        assert ours == json.loads(said.stdout)
    said = command(
        *("evaluate", "--ground-truth", labels, "--clean", clean, "--json", "--class-agnostic"),
        *("--iou-thresholds", "0.3", "--max-dets", "1,50", "--area-range", "few=0,500"),
    )
    ours = starbreak.evaluate(
        ground_truth=labels,
        clean=clean,
        class_agnostic=True,
        iou_thresholds=[0.3],
        max_dets=[1, 50],
        area_ranges={"few": (0, 500)},
    )
    assert ours == json.loads(said.stdout)


def test_evaluate_writes_the_report_of_the_command(command, labeled, tmp_path):
    words = ["--ground-truth", labeled / "labels.json", "--clean", labeled / "clean.json"]
    words += ["--cracked", labeled / "cracked.json", "--regions", labeled / "regions"]
    said = command("evaluate", *words, "--json", "--replicates", 50, "--seed", 4, "-o", tmp_path / "theirs")
    ours = starbreak.evaluate(
        ground_truth=labeled / "labels.json",
        clean=labeled / "clean.json",
        cracked=labeled / "cracked.json",
        regions=labeled / "regions",
        replicates=50,
        seed=4,
        output=tmp_path / "ours",
        threads=1,
    )
    assert ours == json.loads(said.stdout)
    names = sorted(os.listdir(tmp_path / "theirs"))
    assert sorted(os.listdir(tmp_path / "ours")) == names and "report.html" in names
    for name in ("numbers.csv", "table.tex", "failures.jsonl"):
        assert (tmp_path / "ours" / name).read_text() == (tmp_path / "theirs" / name).read_text(), name


def test_divergence_says_what_the_command_prints(command, labeled, tmp_path, small):
    cracked = tmp_path / "cracked"
    cracked.mkdir()
    for name in os.listdir(labeled / "images"):
        image = np.asarray(Image.open(labeled / "images" / name))
        Image.fromarray(starbreak.crack(image, small, 1, name=name)).save(cracked / name)
    sets = [f"clean=folder:{labeled / 'images'}", f"cracked=folder:{cracked}"]
    said = command(
        *("divergence", *sets, "--json", "--bootstrap", 20, "--permutations", 19, "--splits", 5),
        *("--seed", 3, "--side", 64, "--limit", 25),
    )
    ours = starbreak.divergence(
        *sets, bootstrap=20, permutations=19, splits=5, seed=3, side=64, limit=25, threads=1
    )
    assert ours == json.loads(said.stdout)
    assert ours["pairs"][0]["n_a"] == 25


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda f: starbreak.evaluate(clean=f / "clean.json"), "no labels"),
        (lambda f: of(f, source="coco:here"), "both hold labels; give one of them"),
        (lambda f: of(f, source="coco:here", ground_truth="nowhere.json"), "both hold labels; give one of them"),
        (lambda f: compared(f, layer="x"), "layer is one of a model; give model, too"),
        (lambda f: compared(f, form="networks"), "has no image that can be read (0 failed)"),
        (lambda f: compared(f, form="networks"), "or with networks (JSON)"),
        (lambda f: starbreak.evaluate("voc:here", clean=f / "clean.json"), "voc"),
        (lambda f: of(f, protocol="voc"), "coco, kitti, bdd"),
        (lambda f: of(f, tau=[0.1]), "tau is about the region; give regions or a damaged set"),
        (lambda f: of(f, regions=f / "regions", tau=[2.0]), "shares from 0 to 1"),
        (lambda f: of(f, regions=f / "regions", class_agnostic=True), "class-agnostic matching: only for"),
        (lambda f: of(f, score_threshold=float("nan")), "expected 0 to 1"),
        (lambda f: of(f, replicates=3), "replicates = 3; expected a whole number from 20 to 1000000"),
        (lambda f: of(f, worst=101), "worst = 101; expected a whole number from 0 to 100"),
        (lambda f: of(f, clean=f / "labels.json"), "labels.json"),
        (lambda f: starbreak.divergence(f"folder:{f / 'images'}"), "two sets or more"),
        (lambda f: starbreak.divergence("folder:a", "folder:a"), "two sets are called"),
        (lambda f: starbreak.divergence("folder:a", "folder:b", background="blue"), "black, gray, white"),
        (lambda f: starbreak.divergence("folder:a", "folder:b", bootstrap=10**7), "from 0 to 1000000"),
        (lambda f: starbreak.divergence("folder:a", "folder:b", side=10**6), "from 0 to 8192"),
        (lambda f: starbreak.divergence("folder:a", "folder:b", limit=0), "limit = 0"),
    ],
)
def test_what_makes_no_sense_is_a_value_error(call, says, labeled):
    with pytest.raises(ValueError) as raised:
        call(labeled)
    assert says in str(raised.value)
    assert "--" not in str(raised.value), "a flag of the command"


def of(folder, **options):
    return starbreak.evaluate(**({"ground_truth": folder / "labels.json", "clean": folder / "clean.json"} | options))


def compared(folder, form="folder", **options):
    return starbreak.divergence(f"a={form}:{folder / 'images'}", f"b={form}:{folder / 'images'}", **options)


def test_folders_that_are_not_there_are_os_errors(labeled, tmp_path):
    for name in ("regions", "cracked_set"):
        with pytest.raises(FileNotFoundError) as raised:
            of(labeled, cracked=labeled / "cracked.json", **{name: tmp_path / "nowhere"})
        assert raised.value.filename == str(tmp_path / "nowhere")
    with pytest.raises(NotADirectoryError) as raised:
        of(labeled, output=labeled / "labels.json", replicates=20)
    assert raised.value.errno == 20 and "labels.json" in raised.value.filename


def test_a_report_takes_the_place_of_a_report_alone(labeled, tmp_path):
    out = tmp_path / "out"
    for seed in (1, 2):
        of(labeled, output=out, replicates=20, seed=seed)
    (out / "numbers.csv").write_text("mine")
    with pytest.raises(FileExistsError, match="replace=True"):
        of(labeled, output=out, replicates=20)
    assert (out / "numbers.csv").read_text() == "mine"
    of(labeled, output=out, replicates=20, replace=True)
    assert (out / "numbers.csv").read_text() != "mine"
    found = tmp_path / "own" / "evaluation.json"
    found.parent.mkdir()
    found.write_bytes((labeled / "clean.json").read_bytes())
    for replace in (False, True):
        with pytest.raises(OSError):
            of(labeled, clean=found, output=found.parent, replicates=20, replace=replace)
    assert found.read_bytes() == (labeled / "clean.json").read_bytes() and os.listdir(found.parent) == ["evaluation.json"]


def test_files_that_are_not_there_are_os_errors(labeled, tmp_path):
    with pytest.raises(OSError, match="nowhere"):
        of(labeled, clean=tmp_path / "nowhere.json")
    with pytest.raises(OSError, match="nowhere"):
        starbreak.divergence(f"a=folder:{tmp_path / 'nowhere'}", f"b=folder:{labeled / 'images'}")


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent as a signal")
def test_ctrl_c_ends_the_reading_of_images(tmp_path):
    folder = tmp_path / "images"
    folder.mkdir()
    Image.fromarray(picture(700, 1200)).save(folder / "0.png")
    for k in range(1, 2000):
        os.link(folder / "0.png", folder / f"{k}.png")
    program = (
        # What is started in the background of a shell ignores the signal, and its children do.
        "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "import starbreak\nprint('begun', flush=True)\n"
        f"starbreak.divergence('a=folder:{folder}', 'b=folder:{folder}', bootstrap=0, side=0, threads=1)"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout.readline() == "begun\n"
    time.sleep(0.5)
    child.send_signal(signal.SIGINT)
    try:
        # All 4000 would take minutes.
        _, complaint = child.communicate(timeout=30)
    finally:
        child.kill()
    assert "KeyboardInterrupt" in complaint
