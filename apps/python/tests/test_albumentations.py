"""The transform in pipelines of Albumentations 2.0.8; validation/python_loaders.py has AlbumentationsX."""

import doctest
import importlib
import json
import multiprocessing
import pickle
import subprocess
import sys

import albumentations as A
import numpy as np
import pytest
import starbreak
from conftest import SMALL, picture
from starbreak.albumentations import CrackedGlass

RECIPE = starbreak.Recipe("paper", set=SMALL)


def test_examples_in_the_docstrings_run():
    module = importlib.import_module("starbreak.albumentations")
    result = doctest.testmod(module)
    assert (result.failed, result.attempted > 0) == (0, True)


def glass(**words):
    return CrackedGlass(**{"recipe": RECIPE, "crack_seed": 7, "p": 1.0, **words})


def test_an_image_is_cracked_as_by_the_library(image):
    cracked = A.Compose([glass(key="path")])(image=image, path="a.png")["image"]
    np.testing.assert_array_equal(cracked, starbreak.crack(image, RECIPE, 7, name="a.png"))
    assert (cracked != image).any()
    gray = np.ascontiguousarray(image[..., 0])
    cracked = A.Compose([glass(key="path")])(image=gray, path="a.png")["image"]
    np.testing.assert_array_equal(cracked, starbreak.crack(gray, RECIPE, 7, name="a.png"))


def test_a_bank_cracks_as_by_the_library(command, tmp_path, image):
    command("patterns", "-n", 3, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    bank = starbreak.PatternBank(tmp_path)
    transform = A.Compose([glass(recipe=None, bank=tmp_path, key="idx", region_key="region")])
    for idx in range(4):
        made = transform(image=image, idx=idx)
        full = bank.crack(image, 7, name=str(idx), full=True)
        np.testing.assert_array_equal(made["image"], full.image)
        np.testing.assert_array_equal(made["region"], full.region)
    assert A.from_dict(json.loads(json.dumps(A.to_dict(transform))))(image=image, idx=1)["image"].any()


@pytest.mark.filterwarnings("error")
def test_masks_boxes_and_keypoints_stay_as_they_are(image):
    transform = A.Compose(
        [glass()],
        bbox_params=A.BboxParams("pascal_voc", label_fields=["labels"]),
        keypoint_params=A.KeypointParams("xy"),
    )
    mask = picture(seed=3)[..., 0]
    masks = np.stack([mask, mask[::-1]])
    boxes, points = [[10.0, 20.0, 60.0, 70.0]], [[5.0, 6.0], [120.0, 90.0]]
    made = transform(
        image=image, mask=mask, masks=masks, bboxes=np.array(boxes), labels=["car"], keypoints=np.array(points)
    )
    assert (made["image"] != image).any()
    np.testing.assert_array_equal(made["mask"], mask)
    np.testing.assert_array_equal(made["masks"], masks)
    np.testing.assert_allclose(made["bboxes"], boxes, rtol=0, atol=1e-4)
    np.testing.assert_allclose(made["keypoints"], points)
    assert made["labels"] == ["car"]


@pytest.mark.parametrize("recipe", ["distortion", {"fracture": {"model": "none"}, "distortion": {"k1": 0.1}}])
def test_what_a_lens_moves_is_refused_beside_masks(image, recipe):
    transform = A.Compose([CrackedGlass(recipe, crack_seed=7, p=1.0)])
    assert (transform(image=image)["image"] != image).any()
    with pytest.raises(ValueError, match="distortion"):
        transform(image=image, mask=image[..., 0])


def test_the_frames_of_a_video_stand_behind_one_crack(image):
    frames = np.stack([image, image[:, ::-1], image // 2])
    made = A.Compose([glass(key="clip", region_key="region")])(images=frames, clip="c")
    ready = starbreak.ReadyCrack(RECIPE, starbreak.item_seed(7, "c"), (128, 96))
    for frame, cracked in zip(frames, made["images"], strict=True):
        np.testing.assert_array_equal(cracked, ready.over(frame))
    np.testing.assert_array_equal(made["region"], ready.over(frames[0], full=True).region)


def test_a_second_view_gets_the_same_crack(image):
    transform = A.Compose([glass(key="idx")], additional_targets={"right": "image"})
    made = transform(image=image, right=image[:, ::-1].copy(), idx=4)
    np.testing.assert_array_equal(made["right"], starbreak.crack(image[:, ::-1], RECIPE, 7, name="4"))


def test_the_region_moves_with_the_image_in_later_transforms(image):
    full = starbreak.crack(image, RECIPE, 7, name="a", full=True)
    assert full.region.any() and not full.region.all()
    names = {"key": "path", "region_key": "region"}
    made = A.Compose([glass(**names)])(image=image, path="a")
    np.testing.assert_array_equal(made["region"], full.region)
    moved = A.Compose(
        [glass(**names), A.HorizontalFlip(p=1.0), A.Crop(8, 4, 72, 64)], additional_targets={"region": "mask"}
    )(image=image, path="a")
    np.testing.assert_array_equal(moved["region"], full.region[:, ::-1][4:64, 8:72])
    np.testing.assert_array_equal(moved["image"], full.image[:, ::-1][4:64, 8:72])


@pytest.mark.parametrize("own_seed", [None, 7])
def test_without_a_crack_the_region_is_empty(image, own_seed):
    made = A.Compose([glass(p=0.0, crack_seed=own_seed, region_key="region")])(image=image)
    assert made["image"] is image or (made["image"] == image).all()
    assert made["region"].shape == image.shape[:2] and not made["region"].any()


def test_p_is_the_share_of_images_that_are_cracked():
    image = np.full((16, 16, 3), 128, np.uint8)
    keyed = A.Compose([glass(p=0.25, key="idx", region_key="region")])
    drawn = A.Compose([glass(p=0.25, crack_seed=None, region_key="region")], seed=3)
    for transform in (keyed, drawn):
        n_applied = sum(bool(transform(image=image, idx=idx)["region"].any()) for idx in range(200))
        assert 25 <= n_applied <= 75, "0.25 of 200 by four standard deviations"


def test_one_of_weighs_it_by_its_p_and_then_applies_it():
    one_of = A.OneOf([glass(p=0.5, region_key="region"), A.NoOp(p=0.5)], p=1.0)
    assert one_of.transforms_ps == [0.5, 0.5]
    always = A.OneOf([glass(p=0.01, key="idx", region_key="region")], p=1.0)
    image = np.full((16, 16, 3), 128, np.uint8)
    assert all(always(image=image, idx=idx)["region"].any() for idx in range(20))


def test_the_pipeline_s_seed_draws_where_it_has_none_of_its_own(image):
    def run(seed):
        transform = A.Compose([glass(crack_seed=None, p=0.5)], seed=seed)
        return [transform(image=image)["image"].tobytes() for _ in range(6)]

    assert run(1) == run(1) != run(2)
    assert len(set(run(1))) > 2, "cracks of one image"


def test_it_survives_a_dict_json_and_pickle(image):
    for words in (
        {"key": "path", "region_key": "region"},
        {"recipe": "paper", "severity": (1, 2)},
        {"recipe": "paper", "severity": 2, "p": 0.6},
        {"crack_seed": None, "p": 0.5},
    ):
        transform = A.Compose([glass(**words)], seed=5)
        state = json.dumps(A.to_dict(transform))
        again = A.from_dict(json.loads(state))
        assert json.dumps(A.to_dict(again)) == state
        again.set_random_seed(5)
        copies = [transform, again, pickle.loads(pickle.dumps(transform))]
        made = [copy(image=image, path="a.png") for copy in copies]
        for other in made[1:]:
            np.testing.assert_array_equal(made[0]["image"], other["image"], err_msg=str(words))
        if "region_key" in words:
            np.testing.assert_array_equal(made[0]["region"], made[1]["region"])


@pytest.mark.filterwarnings("ignore:.*ReplayMode")
def test_a_replay_gives_the_same_crack_to_another_image(image):
    other = image[::-1].copy()
    for words in ({"crack_seed": None}, {"key": "path"}):
        transform = A.ReplayCompose([glass(**words), A.HorizontalFlip(p=0.5)])
        made = transform(image=image, path="a.png")
        again = A.ReplayCompose.replay(made["replay"], image=image)
        np.testing.assert_array_equal(made["image"], again["image"])
        seed = made["replay"]["transforms"][0]["params"]["seed_of_image"]
        is_flipped = made["replay"]["transforms"][1]["applied"]
        expected = starbreak.crack(other, RECIPE, seed)
        replayed = A.ReplayCompose.replay(made["replay"], image=other)["image"]
        np.testing.assert_array_equal(replayed, expected[:, ::-1] if is_flipped else expected)


@pytest.mark.filterwarnings("ignore:.*ReplayMode")
def test_a_replay_of_a_spared_image_spares(image):
    transform = A.ReplayCompose([glass(p=1e-9, key="path")])
    made = transform(image=image, path="a.png")
    assert made["replay"]["transforms"][0]["applied"] is False
    np.testing.assert_array_equal(A.ReplayCompose.replay(made["replay"], image=image)["image"], image)


def test_an_epoch_draws_other_cracks(image):
    transform = glass(key="path")

    def run():
        return A.Compose([transform])(image=image, path="a.png")["image"].tobytes()

    first = run()
    transform.set_epoch(1)
    assert run() != first
    transform.set_epoch(0)
    assert run() == first


class Loader:
    """A data set in the way of a loader: reads an image, calls the pipeline."""

    def __init__(self, transform):
        self.transform = transform

    def __getitem__(self, idx):
        return self.transform(image=picture(seed=idx), path=f"{idx}.png")["image"].tobytes()


@pytest.mark.parametrize(("method", "key"), [("fork", None), ("fork", "path"), ("spawn", "path")])
def test_any_number_of_workers_makes_the_same_set(method, key):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system cannot {method}")
    transform = glass(key=key, p=0.7)
    transform.set_epoch(2)
    loader = Loader(A.Compose([transform], seed=1))
    expected = {loader[idx] for idx in range(8)}
    assert len(expected) == 8
    for n_workers in (1, 2, 4):
        with multiprocessing.get_context(method).Pool(n_workers) as pool:
            made = pool.imap_unordered(loader.__getitem__, range(8), chunksize=1)
            assert set(made) == expected, n_workers


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ValueError, {"p": 1.5}),
        (ValueError, {"severity": 6}),
        (ValueError, {"recipe": "no such preset"}),
        (ValueError, {"recipe": RECIPE, "severity": 2}),
        (ValueError, {"key": "path", "crack_seed": None}),
        (ValueError, {"region_key": "image"}),
        (ValueError, {"region_key": "mask"}),
        (ValueError, {"key": "path", "region_key": "path"}),
        (ValueError, {"region_key": 5}),
        (FileNotFoundError, {"recipe": None, "bank": "no/such/bank"}),
    ],
)
def test_wrong_parameters_are_refused_at_construction(error, words):
    with pytest.raises(error):
        glass(**words)


def test_a_missing_key_and_other_dtypes_are_named(image):
    with pytest.raises(ValueError, match="'path'"):
        A.Compose([glass(key="path")])(image=image)
    with pytest.raises(ValueError, match="uint8"):
        A.Compose([glass()])(image=image.astype(np.float32))


def test_frames_may_lie_in_a_volume(image):
    frames = np.stack([image, image[::-1]])
    for words in ({}, {"key": "path"}, {"region_key": "region"}):
        transform = A.Compose([glass(**words)])
        beside = {"path": "a.png"} if "key" in words else {}
        made = transform(volume=frames, **beside)
        np.testing.assert_array_equal(made["volume"], transform(images=frames, **beside)["images"])
        assert ("region" in made) == ("region_key" in words)


def test_a_seed_of_numpy_and_severities_of_any_kind_are_written_down(image):
    transform = CrackedGlass("paper", severity=iter((1, 3)), crack_seed=np.int64(3), p=1.0)
    text = json.dumps(A.to_dict(A.Compose([transform])))
    again = A.from_dict(json.loads(text)).transforms[0]
    assert (again.crack_seed, tuple(again.severity)) == (3, (1, 3))
    assert transform.severity == (1, 3)


@pytest.mark.parametrize(
    ("error", "named", "words"),
    [
        (ValueError, "crack_seed = -1", {"crack_seed": -1}),
        (ValueError, "key 5", {"crack_seed": 1, "key": 5}),
        (ValueError, "key 'image'", {"crack_seed": 1, "key": "image"}),
        (ValueError, "key ''", {"crack_seed": 1, "key": ""}),
        (ValueError, "region_key ''", {"region_key": ""}),
    ],
)
def test_arguments_are_named(error, named, words):
    with pytest.raises(error, match=named):
        CrackedGlass("paper", **words)


def test_a_library_that_does_not_load_says_why(tmp_path):
    (tmp_path / "albumentations").mkdir()
    (tmp_path / "albumentations/__init__.py").write_text("import no_such_part")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\nimport starbreak.albumentations"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert "Albumentations is installed and cannot be imported: No module named 'no_such_part'" in done.stderr
