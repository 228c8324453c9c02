#!/usr/bin/env python3
"""The transforms in a real torch DataLoader, in torchvision v2 and in AlbumentationsX.

usage: python_loaders.py
needs requirements-torch.txt and the package starbreak; a line for each check, ends with 1 if one fails.
"""
import hashlib
import json
import pathlib
import pickle
import runpy
import sys
import warnings

import albumentations as A
import numpy as np
import PIL.Image
import starbreak
import starbreak.albumentations
import starbreak.torchvision
import starbreak.transforms
import torch
import torchvision
from torch.utils.data import DataLoader, Dataset
from torchvision import tv_tensors
from torchvision.transforms import v2

EXAMPLES = pathlib.Path(__file__).parents[1] / "apps/python/examples"
SMALL = {"fracture.particles": 300, "fracture.neighbour_radius_px": 20.0}
RECIPE = starbreak.Recipe("paper", set=SMALL)
N_ITEMS = 24


def picture(seed, height=96, width=128):
    return np.random.default_rng(seed).integers(0, 255, (height, width, 3), np.uint8)


def channels_first(image):
    return torch.from_numpy(image).permute(2, 0, 1)


class Pictures(Dataset):
    """Items by their index, through a transform of one of the three kinds."""

    def __init__(self, kind, transform):
        self.kind, self.transform = kind, transform

    def __len__(self):
        return N_ITEMS

    def __getitem__(self, idx):
        image = picture(idx)
        if self.kind == "plain":
            return channels_first(self.transform(image, idx))
        if self.kind == "torchvision":
            return self.transform(tv_tensors.Image(channels_first(image)))
        return channels_first(self.transform(image=image, idx=idx)["image"])


def kinds():
    crack = {"recipe": RECIPE, "p": 0.8}
    return {
        "plain": starbreak.transforms.CrackedGlass(**crack, seed=7),
        "torchvision": v2.Compose([starbreak.torchvision.CrackedGlass(**crack, crack_seed=7)]),
        "AlbumentationsX": A.Compose([starbreak.albumentations.CrackedGlass(**crack, crack_seed=7, key="idx")], seed=1),
    }


def check_loaders():
    """Fork and spawn, 0, 1, 2 and 4 workers, shuffled: the same set of images."""
    for kind, transform in kinds().items():
        sets = {}
        for method, n_workers in [(None, 0), *((m, n) for m in ("fork", "spawn") for n in (1, 2, 4))]:
            loader = DataLoader(
                Pictures(kind, transform),
                batch_size=5,
                shuffle=True,
                num_workers=n_workers,
                multiprocessing_context=method,
            )
            images = [image for batch in loader for image in batch]
            sets[method, n_workers] = sorted(hashlib.sha256(image.numpy().tobytes()).hexdigest() for image in images)
        assert len(set(sets[None, 0])) == N_ITEMS
        differing = [key for key, digests in sets.items() if digests != sets[None, 0]]
        assert not differing, (kind, differing)
        print(f"  {kind}: {len(sets)} loaders, {N_ITEMS} images each, one set {sets[None, 0][0][:12]}…")


def check_torchvision_images():
    """PIL, tv_tensors.Image and plain tensors, color and gray: the pixels of starbreak.crack."""
    image = picture(1)
    transform = starbreak.torchvision.CrackedGlass(RECIPE, crack_seed=7, p=1.0)
    for kind, array in {"RGB": image, "L": np.ascontiguousarray(image[..., 0])}.items():
        expected = starbreak.crack(array, RECIPE, transform._drawing.seed_of(array))
        made = transform(PIL.Image.fromarray(array))
        assert isinstance(made, PIL.Image.Image) and made.mode == kind
        np.testing.assert_array_equal(np.asarray(made), expected)
        tensor = torch.from_numpy(array.reshape(96, 128, -1)).permute(2, 0, 1)
        seed = transform._drawing.seed_of(array.reshape(96, 128, -1) if kind == "RGB" else array[..., np.newaxis])
        expected = torch.from_numpy(starbreak.crack(array, RECIPE, seed).reshape(96, 128, -1)).permute(2, 0, 1)
        for like in (tensor, tv_tensors.Image(tensor)):
            made = transform(like)
            assert type(made) is type(like) and made.shape == like.shape
            assert torch.equal(torch.as_tensor(made), expected)
    for wrong in (PIL.Image.fromarray(image).convert("P"), torch.zeros(3, 32, 32), torch.zeros(5, 32, 32, dtype=torch.uint8)):
        try:
            transform(wrong)
        except ValueError as error:
            print(f"  refused: {error}")
        else:
            raise AssertionError(f"{wrong} was taken")


def check_torchvision_words():
    """A transform of torchvision says what it draws."""
    said = repr(starbreak.torchvision.CrackedGlass("paper", severity=(1, 3), crack_seed=7))
    assert said == "CrackedGlass(recipe='paper', severity=(1, 3), crack_seed=7, p=0.5)", said


def check_torchvision_targets():
    """Boxes, masks and labels stay; a video stands behind one crack; the region on request."""
    image = picture(1)
    transform = starbreak.torchvision.CrackedGlass(RECIPE, crack_seed=7, p=1.0, region_key="region")
    sample = {
        "image": tv_tensors.Image(channels_first(image)),
        "boxes": tv_tensors.BoundingBoxes([[3, 4, 50, 60]], format="XYXY", canvas_size=(96, 128)),
        "mask": tv_tensors.Mask(torch.arange(96 * 128).reshape(96, 128)),
        "labels": torch.tensor([2]),
        "name": "a.png",
    }
    made = transform(sample)
    for key in ("boxes", "mask", "labels", "name"):
        assert made[key] is sample[key], key
    full = starbreak.crack(image, RECIPE, transform._drawing.seed_of(image), full=True)
    np.testing.assert_array_equal(made["image"].permute(1, 2, 0).numpy(), full.image)
    assert isinstance(made["region"], tv_tensors.Mask)
    np.testing.assert_array_equal(made["region"].numpy(), full.region)
    flipped = v2.Compose([transform, v2.RandomHorizontalFlip(p=1.0)])(sample)
    np.testing.assert_array_equal(flipped["region"].numpy(), full.region[:, ::-1])

    frames = np.stack([image, image[::-1], image // 2])
    video = tv_tensors.Video(torch.from_numpy(frames).permute(0, 3, 1, 2))
    plain = starbreak.torchvision.CrackedGlass(RECIPE, crack_seed=7, p=1.0)
    made = plain(video)
    assert isinstance(made, tv_tensors.Video)
    ready = starbreak.ReadyCrack(RECIPE, plain._drawing.seed_of(image), (128, 96))
    for frame, cracked in zip(frames, made, strict=True):
        np.testing.assert_array_equal(cracked.permute(1, 2, 0).numpy(), ready.over(frame))

    spared = starbreak.torchvision.CrackedGlass(RECIPE, p=0.0, region_key="region")(sample)
    assert spared["image"] is sample["image"] and not spared["region"].any()
    torch.manual_seed(3)
    free = starbreak.torchvision.CrackedGlass(RECIPE, p=1.0)
    first = free(sample["image"])
    torch.manual_seed(3)
    assert torch.equal(first, free(sample["image"])) and not torch.equal(first, free(sample["image"]))


def check_albumentations_x():
    """What tests/test_albumentations.py asks of 2.0.8."""
    glass = starbreak.albumentations.CrackedGlass
    words = {"recipe": RECIPE, "crack_seed": 7, "p": 1.0}
    image = picture(1)
    full = starbreak.crack(image, RECIPE, 7, name="a", full=True)
    mask, boxes, points = picture(2)[..., 0], [[10.0, 20.0, 60.0, 70.0]], [[5.0, 6.0]]
    transform = A.Compose(
        [glass(**words, key="path", region_key="region"), A.HorizontalFlip(p=1.0), A.Crop(8, 4, 72, 64)],
        additional_targets={"region": "mask"},
    )
    made = transform(image=image, path="a")
    np.testing.assert_array_equal(made["image"], full.image[:, ::-1][4:64, 8:72])
    np.testing.assert_array_equal(made["region"], full.region[:, ::-1][4:64, 8:72])
    made = A.Compose(
        [glass(**words, key="path")],
        bbox_params=A.BboxParams(coord_format="pascal_voc", label_fields=["labels"]),
        keypoint_params=A.KeypointParams(coord_format="xy"),
    )(image=image, path="a", mask=mask, masks=np.stack([mask]), bboxes=boxes, labels=[1], keypoints=points)
    np.testing.assert_array_equal(made["image"], full.image)
    np.testing.assert_array_equal(made["mask"], mask)
    np.testing.assert_array_equal(made["masks"], [mask])
    np.testing.assert_allclose(made["bboxes"], boxes, atol=1e-4)
    np.testing.assert_allclose(made["keypoints"], points)

    frames = np.stack([image, image[:, ::-1]])
    made = A.Compose([glass(**words, key="path")])(images=frames, path="a")["images"]
    ready = starbreak.ReadyCrack(RECIPE, starbreak.item_seed(7, "a"), (128, 96))
    np.testing.assert_array_equal(made, [ready.over(frame) for frame in frames])

    for parameters in ({"key": "path"}, {"crack_seed": None}, {"recipe": "paper", "severity": (1, 3)}):
        transform = A.Compose([glass(**{**words, **parameters})], seed=5)
        again = A.from_dict(json.loads(json.dumps(A.to_dict(transform))))
        again.set_random_seed(5)
        copies = [transform, again, pickle.loads(pickle.dumps(transform))]
        results = [copy(image=image, path="a")["image"] for copy in copies]
        for other in results[1:]:
            np.testing.assert_array_equal(results[0], other, err_msg=str(parameters))
    spared = A.Compose([glass(**{**words, "p": 0.0}, region_key="region")])(image=image)
    np.testing.assert_array_equal(spared["image"], image)
    assert not spared["region"].any()
    n = sum(
        bool(A.Compose([glass(**{**words, "p": 0.25}, key="idx", region_key="region")])(image=image, idx=k)["region"].any())
        for k in range(100)
    )
    assert 7 <= n <= 43, n

    replay = A.ReplayCompose([glass(**{**words, "crack_seed": None})])
    made = replay(image=image)
    np.testing.assert_array_equal(A.ReplayCompose.replay(made["replay"], image=image)["image"], made["image"])


def check_examples():
    """The example of a training loop runs and learns."""
    losses = runpy.run_path(str(EXAMPLES / "train_torch.py"))["train"](n_epochs=3)
    print("  losses", *(f"{loss:.3f}" for loss in losses))
    assert losses[-1] < losses[0]


def main():
    print(f"torch {torch.__version__}, torchvision {torchvision.__version__}, AlbumentationsX {A.__version__}")
    torch.set_num_threads(1)
    warnings.filterwarnings("ignore", message="This DataLoader will create")
    failed = 0
    for name, check in [(name, value) for name, value in globals().items() if name.startswith("check_")]:
        try:
            check()
            print(f"{name}: ok: {check.__doc__.splitlines()[0]}")
        except Exception as error:  # a check of another kind still runs
            failed += 1
            print(f"{name}: FAIL: {type(error).__name__}: {error}")
    print(f"{failed} checks fail")
    return failed > 0


if __name__ == "__main__":
    sys.exit(main())
