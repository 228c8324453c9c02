"""Cracked glass as a plain callable, for pipelines of whatever framework."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ._drawing import CrackDrawing, seed_of_image

__all__ = ["CrackedGlass"]


class CrackedGlass:
    """``image -> image`` behind broken glass.

    Args:
        recipe, severity, bank: as of :class:`starbreak.albumentations.CrackedGlass`.
        seed: an image's crack depends on it, the epoch and the image alone.
        p: probability that the glass is broken.

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
        recipe: str | dict[str, Any] | None = None,
        severity: int | Sequence[int] | None = None,
        bank: str | None = None,
        seed: int = 0,
        p: float = 1.0,
    ) -> None:
        if not 0.0 <= p <= 1.0:
            raise ValueError(f"p {p}: expected 0 to 1")
        self.drawing = CrackDrawing(recipe, severity, bank)
        self.seed = seed
        self.p = p
        self.epoch = 0

    def set_epoch(self, epoch: int) -> None:
        """Draws other cracks from now on, the same for the same number; before workers start."""
        self.epoch = int(epoch)

    def __call__(self, image: np.ndarray, key: str | None = None) -> np.ndarray:
        """The image behind broken glass; an image that is spared comes back itself.

        Args:
            image: uint8, H×W or H×W×3.
            key: what tells images apart, such as a path; without it the pixels do.
        """
        seed = seed_of_image(self.seed, self.epoch, key, image)
        return self.drawing.crack(image, seed) if self.drawing.is_drawn(seed, self.p) else image
