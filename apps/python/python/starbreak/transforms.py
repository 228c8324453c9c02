"""Broken glass as a plain callable, for pipelines of any framework."""

from __future__ import annotations

from ._drawing import CrackDrawing, Image, Path, RecipeLike, Severity, collected_region

__all__ = ["CameraFault", "CrackedGlass"]


class CrackedGlass:
    """A callable from an image to that image behind broken glass.

    Args:
        recipe: a ``Recipe``, the name of a preset, or tables as a dict; default
            ``windshield-spiderweb``.
        severity: 1 to 5, or a range ``(least, most)`` from which one is drawn for each image; for
            presets only. Without it the preset is used unchanged.
        bank: file or folder written by ``starbreak patterns``, instead of a recipe.
        seed: an image's crack depends only on this seed, the epoch and the image.
        p: probability that the glass is broken.
        region: whether to return the region mask as well.

    >>> import numpy as np
    >>> image = np.full((120, 200, 3), 128, np.uint8)
    >>> transform = CrackedGlass("paper", severity=3, seed=7)
    >>> np.array_equal(transform(image), CrackedGlass("paper", severity=3, seed=7)(image))
    True
    >>> transform.set_epoch(1)
    >>> np.array_equal(transform(image), CrackedGlass("paper", severity=3, seed=7)(image))
    False

    Raises:
        ValueError: at construction for invalid parameters; later for images that are not uint8.
        OSError: for a bank that cannot be read.
    """

    def __init__(
        self,
        recipe: RecipeLike | None = None,
        severity: Severity | None = None,
        bank: Path | None = None,
        seed: int = 0,
        p: float = 1.0,
        region: bool = False,
    ) -> None:
        self._drawing = CrackDrawing(recipe, severity, bank, p, seed)
        self._region = region

    def set_epoch(self, epoch: int) -> None:
        """Draw different cracks for each epoch number; call it before workers start."""
        self._drawing.epoch = epoch

    def __repr__(self) -> str:
        return f"CrackedGlass({self._drawing.words(seed=self._drawing.seed, region=self._region)})"

    def __call__(self, image: Image, key: object = None) -> Image | tuple[Image, Image]:
        """The image behind broken glass, or (with probability 1 - ``p``) the same object.

        Args:
            image: uint8, H×W or H×W×3.
            key: identifies the image, a path or a number; without it the pixels do.

        Returns:
            The image or, with ``region``, a pair of it and the region mask: uint8, H×W, 255 where
            pixels are affected.
        """
        seed = self._drawing.seed_of(image, key)
        with collected_region(self._region) as regions:
            cracked = self._drawing.crack_or_spare([image], seed)[0]
        return (cracked, regions[0]) if self._region else cracked


#: The same under the name of what it does with presets such as ``noise``.
CameraFault = CrackedGlass
