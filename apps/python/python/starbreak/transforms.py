"""Cracked glass as a plain callable, for pipelines of whatever framework."""

from __future__ import annotations

from ._drawing import CrackDrawing, Image, Path, RecipeLike, Severity, collected_region

__all__ = ["CrackedGlass"]


class CrackedGlass:
    """``image -> image`` behind broken glass.

    Args:
        recipe: a ``Recipe``, the name of a preset, or tables as a dict; ``windshield-spiderweb`` without it.
        severity: 1 to 5, or ``(least, most)``, of which one is drawn for each image; scales presets.
            Without it the preset as it is.
        bank: file or folder that ``starbreak patterns`` wrote, in place of a recipe.
        seed: an image's crack depends on it, the epoch and the image alone.
        p: probability that the glass is broken.
        region: whether to give the region mask, too.

    >>> import numpy as np
    >>> image = np.full((120, 200, 3), 128, np.uint8)
    >>> transform = CrackedGlass("paper", severity=3, seed=7)
    >>> np.array_equal(transform(image), CrackedGlass("paper", severity=3, seed=7)(image))
    True
    >>> transform.set_epoch(1)
    >>> np.array_equal(transform(image), CrackedGlass("paper", severity=3, seed=7)(image))
    False

    Raises:
        ValueError: at construction for parameters that make no sense; later for images that are not
            uint8.
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
        """Draws other cracks from now on, the same for the same number; before workers start."""
        self._drawing.epoch = epoch

    def __repr__(self) -> str:
        return f"CrackedGlass({self._drawing.words(seed=self._drawing.seed, region=self._region)})"

    def __call__(self, image: Image, key: object = None) -> Image | tuple[Image, Image]:
        """The image behind broken glass; an image that is spared comes back itself.

        Args:
            image: uint8, H×W or H×W×3.
            key: what tells images apart, a path or a number; without it the pixels do.

        Returns:
            The image or, with ``region``, a pair of it and the region mask: uint8, H×W, 255 where the
            crack counts.
        """
        seed = self._drawing.seed_of(image, key)
        with collected_region(self._region) as regions:
            cracked = self._drawing.crack_or_spare([image], seed)[0]
        return (cracked, regions[0]) if self._region else cracked
