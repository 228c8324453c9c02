"""Cracked glass as a transform of Albumentations: of 2.0.8 (MIT) and of AlbumentationsX.

>>> import albumentations as A
>>> from starbreak.albumentations import CrackedGlass
>>> transform = A.Compose([CrackedGlass("paper", severity=(1, 3), p=1.0)], seed=7)
>>> image = np.full((120, 200, 3), 128, np.uint8)
>>> transform(image=image)["image"].shape
(120, 200, 3)
"""

from __future__ import annotations

from collections.abc import Sequence
from contextvars import ContextVar
from typing import Any

import numpy as np

try:
    from albumentations.core.transforms_interface import DualTransform
    from albumentations.core.type_definitions import Targets
except ImportError as error:
    raise ImportError(
        "starbreak.albumentations needs Albumentations: pip install albumentations==2.0.8 (MIT), or "
        "albumentationsx (AGPL)"
    ) from error

if hasattr(DualTransform, "sample_parameters"):
    from albumentations.core.transform_params import SampledParams

from ._drawing import CrackDrawing, seed_of_image

__all__ = ["CrackedGlass"]

# Where a call leaves its region masks, if it is asked for them.
_REGIONS: ContextVar[list[np.ndarray] | None] = ContextVar("regions", default=None)


class CrackedGlass(DualTransform):
    """The glass in front of the camera is broken.

    Args:
        recipe: name of a preset or tables of a recipe; ``windshield-star`` without it.
        severity: 1 to 5, or ``(least, most)``, of which one is drawn for each image; scales presets.
            Without it the preset as it is.
        bank: file or folder that ``starbreak patterns`` wrote, in place of a recipe.
        crack_seed: with it, an image's crack depends on this seed, the epoch (:meth:`set_epoch`) and
            the image alone, and is the same for any number of workers. Without it cracks are drawn
            from the random numbers of the pipeline (``A.Compose(…, seed=)``), which each worker has
            a copy of.
        key: name of the target that tells images apart, a path or a number
            (``transform(image=image, path="a.png")`` with ``key="path"``); without it the pixels do.
        region_key: name under which the result has the region mask, uint8 H×W, 255 where the crack
            counts; zeros where the transform was not applied. Named in
            ``A.Compose(additional_targets={region_key: "mask"})`` it moves with the image later on.
        p: probability.

    Targets: ``image`` uint8 H×W or H×W×3, ``images`` N of them behind one crack, as in a video;
    ``mask``, ``masks``, ``bboxes`` and ``keypoints`` stay as they are: glass moves no object.

    Raises:
        ValueError: at construction for parameters that make no sense; later for images that are not
            uint8.
        OSError: for a bank that cannot be read.
    """

    _targets = (Targets.IMAGE, Targets.MASK, Targets.BBOXES, Targets.KEYPOINTS)

    def __init__(
        self,
        recipe: str | dict[str, Any] | None = None,
        severity: int | Sequence[int] | None = None,
        bank: str | None = None,
        crack_seed: int | None = None,
        key: str | None = None,
        region_key: str | None = None,
        p: float = 0.5,
    ) -> None:
        if not 0.0 <= p <= 1.0:
            raise ValueError(f"p {p}: expected 0 to 1")
        if key is not None and crack_seed is None:
            raise ValueError("a key tells which crack of a seed an image gets; give crack_seed, too")
        self.drawing = CrackDrawing(recipe, severity, bank)
        # With a seed of its own whether the glass is broken is a part of what that seed draws.
        super().__init__(p=p if crack_seed is None else 1.0)
        self.recipe = recipe
        self.severity = severity if severity is None or isinstance(severity, int) else tuple(severity)
        self.bank = bank
        self.crack_seed = crack_seed
        self.key = key
        self.region_key = region_key
        self.probability = p
        self.epoch = 0

    def set_epoch(self, epoch: int) -> None:
        """Draws other cracks from now on, the same for the same number; before workers start."""
        self.epoch = int(epoch)

    def _draw(self, data: dict[str, Any], random_generator: np.random.Generator) -> dict[str, Any]:
        if self.crack_seed is None:
            return {"seed_of_image": int(random_generator.integers(0, 2**53)), "is_broken": True}
        key = None if self.key is None else str(data[self.key])
        seed = seed_of_image(self.crack_seed, self.epoch, key, _first_image(data))
        return {"seed_of_image": seed, "is_broken": self.drawing.is_drawn(seed, self.probability)}

    def apply_with_params(self, params: Any, *args: Any, **data: Any) -> dict[str, Any]:
        regions: list[np.ndarray] = []
        token = _REGIONS.set(regions if self.region_key is not None else None)
        try:
            result = super().apply_with_params(params, *args, **data)
        finally:
            _REGIONS.reset(token)
        if regions:
            result[self.region_key] = regions[0]
        return result

    def apply(self, img: np.ndarray, seed_of_image: int, is_broken: bool, **params: Any) -> np.ndarray:
        if not is_broken:
            return img
        regions = _REGIONS.get()
        if regions is None:
            return self.drawing.crack(img, seed_of_image)
        cracked = self.drawing.crack(img, seed_of_image, full=True)
        regions.append(cracked.region)
        return cracked.image

    def apply_to_images(
        self, images: np.ndarray, seed_of_image: int, is_broken: bool, **params: Any
    ) -> np.ndarray:
        if not is_broken:
            return images
        ready = self.drawing.ready(images[0].shape[1::-1], seed_of_image)
        regions = _REGIONS.get()
        cracked = np.empty_like(images)
        for frame, image in enumerate(images):
            if regions is not None and frame == 0:
                first = ready.over(image, seed_of_image, full=True)
                regions.append(first.region)
                cracked[frame] = first.image
            else:
                cracked[frame] = ready.over(image, seed_of_image)
        return cracked

    def apply_to_mask(self, mask: np.ndarray, **params: Any) -> np.ndarray:
        return mask

    def apply_to_bboxes(self, bboxes: np.ndarray, **params: Any) -> np.ndarray:
        return bboxes

    def apply_to_keypoints(self, keypoints: np.ndarray, **params: Any) -> np.ndarray:
        return keypoints

    @property
    def targets_as_params(self) -> list[str]:
        return [] if self.key is None else [self.key]

    def get_base_init_args(self) -> dict[str, Any]:
        return {"p": self.probability}

    def get_transform_init_args_names(self) -> tuple[str, ...]:
        return ("recipe", "severity", "bank", "crack_seed", "key", "region_key")

    def _with_region(self, result: Any, data: dict[str, Any]) -> Any:
        if self.region_key is not None and self.region_key not in result:
            result = {**result, self.region_key: np.zeros(_first_image(data).shape[:2], np.uint8)}
        return result

    if hasattr(DualTransform, "sample_parameters"):
        # AlbumentationsX.

        def sample_parameters(self, params: Any, data: dict[str, Any], targets: Any, sampling: Any) -> Any:
            return SampledParams(params=self._draw(data, sampling.random_generator))

        def apply_in_invocation(self, invocation: Any, /, *args: Any, force_apply: bool, **data: Any) -> Any:
            result = super().apply_in_invocation(invocation, *args, force_apply=force_apply, **data)
            return self._with_region(result, data)

    else:

        def get_params_dependent_on_data(self, params: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
            return self._draw(data, self.random_generator)

        def __call__(self, *args: Any, force_apply: bool = False, **data: Any) -> Any:
            result = super().__call__(*args, force_apply=force_apply, **data)
            return self._with_region(result, data)


def _first_image(data: dict[str, Any]) -> np.ndarray:
    return data["image"] if data.get("image") is not None else data["images"][0]
