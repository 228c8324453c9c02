"""Broken glass as a transform for Albumentations 2.0.8 (MIT) and AlbumentationsX.

>>> import albumentations as A
>>> from starbreak.albumentations import CrackedGlass
>>> transform = A.Compose([CrackedGlass("paper", severity=(1, 3), p=1.0)], seed=7)
>>> image = np.full((120, 200, 3), 128, np.uint8)
>>> transform(image=image)["image"].shape
(120, 200, 3)
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

try:
    from albumentations.core.transforms_interface import DualTransform
    from albumentations.core.type_definitions import Targets
except ImportError as error:
    if getattr(error, "name", None) != "albumentations":
        raise ImportError(f"Albumentations is installed and cannot be imported: {error}") from error
    raise ImportError(
        "starbreak.albumentations needs Albumentations: pip install albumentations==2.0.8 (MIT), or "
        "albumentationsx (AGPL)"
    ) from error

_IS_X = hasattr(DualTransform, "sample_parameters")
if _IS_X:
    from albumentations.core.transform_params import SampledParams

from . import Recipe
from ._drawing import CrackDrawing, Image, Path, RecipeLike, Severity, collected_region, whole

__all__ = ["CameraFault", "CrackedGlass"]

_TARGETS = ("image", "images", "mask", "masks", "bboxes", "keypoints")


class CrackedGlass(DualTransform):  # type: ignore[misc]
    """Break the glass in front of the camera.

    Args:
        recipe: a ``Recipe``, the name of a preset, or tables as a dict; default
            ``windshield-spiderweb``.
        severity: 1 to 5, or a range ``(least, most)`` from which one is drawn for each image; for
            presets only. Without it the preset is used unchanged.
        bank: file or folder written by ``starbreak patterns``, instead of a recipe.
        crack_seed: with it, an image's crack, and whether it has one, depend only on this seed, the
            epoch (:meth:`set_epoch`) and the image, and are the same for any number of workers.
            Without it cracks are drawn from the random numbers of the pipeline
            (``A.Compose(…, seed=)``), of which each worker has a copy.
        key: name of the argument that identifies the image, a path or a number, passed beside it
            (``transform(image=image, path="a.png")`` with ``key="path"``); without it the pixels
            identify the image.
        region_key: name under which the result has the region mask, uint8 H×W, 255 where pixels are
            affected; all zeros if the transform was called but, by ``p``, left the image unchanged.
            If a ``OneOf`` or a ``Compose`` with its own ``p`` does not call the transform, the
            result has no such name. To let later transforms move the mask with the image, name it in
            ``A.Compose(additional_targets={region_key: "mask"})``.
        p: probability.

    Targets: ``image`` uint8 H×W or H×W×3; ``images`` (and ``volume``, if the frames are there) N of
    them behind one crack, as in a video; ``mask``, ``masks``, ``bboxes`` and ``keypoints`` stay the
    same, since glass moves no object. ``to_dict`` does not include the epoch.

    Raises:
        ValueError: at construction for invalid parameters; later for images that are not uint8.
        OSError: for a bank that cannot be read.
    """

    # AlbumentationsX names the plurals, too.
    _targets = tuple(
        target for target in Targets if target.name in {"IMAGE", "IMAGES", "MASK", "MASKS", "BBOXES", "KEYPOINTS"}
    )

    def __init__(
        self,
        recipe: RecipeLike | None = None,
        severity: Severity | None = None,
        bank: Path | None = None,
        crack_seed: int | None = None,
        key: str | None = None,
        region_key: str | None = None,
        p: float = 0.5,
    ) -> None:
        if key is not None and crack_seed is None:
            raise ValueError("a key tells which crack of a seed an image gets; give crack_seed, too")
        if region_key is not None and (not isinstance(region_key, str) or region_key in ("", *_TARGETS, key)):
            raise ValueError(f"region_key {region_key!r}: expected a name that is no target of its own, such as 'region'")
        if key is not None and (not isinstance(key, str) or key in ("", *_TARGETS)):
            raise ValueError(f"key {key!r}: expected the name of what tells images apart, such as 'path'")
        if isinstance(severity, Iterable):
            severity = tuple(severity)
        if crack_seed is not None:
            crack_seed = whole("crack_seed", crack_seed, 0, 2**64 - 1)
        self._drawing = CrackDrawing(recipe, severity, bank, p, crack_seed)
        super().__init__(p=p)
        # What `to_dict` writes.
        self.recipe = recipe.to_dict() if isinstance(recipe, Recipe) else recipe
        self.severity = tuple(map(int, severity)) if isinstance(severity, Iterable) else severity and int(severity)
        self.bank = None if bank is None else os.fspath(bank)
        self.crack_seed = crack_seed
        self.key = key
        self.region_key = region_key

    def set_epoch(self, epoch: int) -> None:
        """Draw different cracks for each epoch number; call it before workers start."""
        self._drawing.epoch = epoch

    def apply(self, img: Image, seed_of_image: int, **params: Any) -> Image:
        return self._drawing.crack([img], seed_of_image)[0]

    def apply_to_images(self, images: Image, seed_of_image: int, **params: Any) -> Image:
        return np.stack(self._drawing.crack(list(images), seed_of_image))

    def apply_to_mask(self, mask: Any, **params: Any) -> Any:
        self._drawing.refuse_moved("masks, boxes and key points")
        return mask

    apply_to_masks = apply_to_bboxes = apply_to_keypoints = apply_to_mask

    def get_transform_init_args_names(self) -> tuple[str, ...]:
        return ("recipe", "severity", "bank", "crack_seed", "key", "region_key")

    @property
    def targets_as_params(self) -> list[str]:
        return [] if self.key is None else [self.key]

    def _own_seed(self, data: dict[str, Any]) -> int:
        if self.key is not None and data.get(self.key) is None:
            raise ValueError(f"CrackedGlass tells images apart by {self.key!r}; give it beside the image")
        first = _first_image(data)
        if self.key is None and first is None:
            return 0  # there is nothing to crack
        return self._drawing.seed_of(first, None if self.key is None else data[self.key])

    def _draw(self, data: dict[str, Any], random_generator: np.random.Generator) -> dict[str, int]:
        own = self.crack_seed is not None
        return {"seed_of_image": self._own_seed(data) if own else int(random_generator.integers(0, 2**53))}

    def _run(self, base: Callable[..., Any], force_apply: bool, data: dict[str, Any]) -> Any:
        """The library's call, plus the region; with `crack_seed`, that seed decides about `p`."""
        is_spared = False
        if self.crack_seed is not None and not (force_apply or self.replay_mode):
            is_spared = not self._drawing.is_drawn(self._own_seed(data))
            force_apply = True
        with collected_region(self.region_key is not None) as regions:
            result = data if is_spared else base(force_apply=force_apply, **data)
        first = _first_image(data)
        if self.region_key is not None and first is not None:
            region = regions[0] if regions else np.zeros(first.shape[:2], np.uint8)
            result = {**result, self.region_key: region}
        return result

    if _IS_X:

        def sample_parameters(self, params: Any, data: dict[str, Any], targets: Any, sampling: Any) -> Any:
            return SampledParams(params=self._draw(data, sampling.random_generator))

        def apply_in_invocation(self, invocation: Any, /, *args: Any, force_apply: bool, **data: Any) -> Any:
            def base(**named: Any) -> Any:
                return super(CrackedGlass, self).apply_in_invocation(invocation, *args, **named)

            return self._run(base, force_apply, data)

    else:

        def get_params_dependent_on_data(self, params: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
            return self._draw(data, self.random_generator)

        def __call__(self, *args: Any, force_apply: bool = False, **data: Any) -> Any:
            def base(**named: Any) -> Any:
                return super(CrackedGlass, self).__call__(*args, **named)

            return self._run(base, force_apply, data)


def _first_image(data: dict[str, Any]) -> Image | None:
    """The first image to crack."""
    if data.get("image") is not None:
        image: Image = data["image"]
        return image
    for name in ("images", "volume", "volumes"):
        frames = data.get(name)
        if frames is not None and len(frames):
            first: Image = frames[0][0] if name == "volumes" else frames[0]
            return first
    return None


#: The same under the name of what it does with presets such as ``noise``.
CameraFault = CrackedGlass
