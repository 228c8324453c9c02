"""Which crack an image gets: the same for any number of workers.

A crack is drawn for each image from a seed. The seed of an image comes from the transform's own
seed, the epoch and a key of the image, never from how many images a worker has seen: so the set of
images that a loader gives does not depend on its workers. Without a seed of its own a transform
draws from the random numbers of its framework.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import Any

import numpy as np

from . import PatternBank, ReadyCrack, Recipe, crack, item_seed


class CrackDrawing:
    """Cracks by a recipe, scaled to severities, or out of a bank.

    Parameters are those of :class:`starbreak.albumentations.CrackedGlass`.

    >>> drawing = CrackDrawing("paper", severity=(1, 3))
    >>> drawing.severities
    (1, 2, 3)
    """

    def __init__(
        self,
        recipe: Recipe | str | dict[str, Any] | None = None,
        severity: int | Sequence[int] | None = None,
        bank: str | None = None,
    ) -> None:
        if bank is not None and (recipe is not None or severity is not None):
            raise ValueError("a bank has its recipe and severity; give a bank alone, or a recipe with severities")
        self.bank = None if bank is None else PatternBank(bank)
        self.severities = _severities(severity)
        self.recipes: tuple[Recipe, ...] = ()
        if self.bank is None:
            self.recipes = tuple(_recipe(recipe, severity) for severity in self.severities or (None,))

    def choose(self, seed: int) -> int:
        """Place of the recipe that the seed draws.

        >>> CrackDrawing("paper", severity=(1, 3)).choose(5) in (0, 1, 2)
        True
        """
        return item_seed(seed, "severity") % max(len(self.recipes), 1)

    def crack(self, image: np.ndarray, seed: int, *, full: bool = False) -> Any:
        """The image behind glass that the seed breaks: as :func:`starbreak.crack`."""
        if self.bank is not None:
            return self.bank.crack(image, seed, full=full)
        return crack(image, self.recipes[self.choose(seed)], seed, full=full)

    def ready(self, size: tuple[int, int], seed: int) -> ReadyCrack:
        """The same crack ready for several images of one size, width and height in pixels."""
        if self.bank is not None:
            return self.bank.pattern(self.bank.index_for(seed), size)
        return ReadyCrack(self.recipes[self.choose(seed)], seed, size)

    @staticmethod
    def is_drawn(seed: int, p: float) -> bool:
        """Whether the seed falls into the share ``p``.

        >>> sum(CrackDrawing.is_drawn(seed, 0.25) for seed in range(4000)) // 100
        10
        """
        return item_seed(seed, "whether") / 2**53 < p


def seed_of_image(seed: int, epoch: int, key: str | None, image: np.ndarray) -> int:
    """The seed of an image's crack, from its key or, without one, from its pixels.

    Every 16th row stands for the pixels. Images that are equal there get equal cracks.

    >>> image = np.zeros((32, 32, 3), np.uint8)
    >>> seed_of_image(1, 0, None, image) == seed_of_image(1, 0, None, image.copy())
    True
    >>> seed_of_image(1, 0, "a.png", image) == seed_of_image(1, 1, "a.png", image)
    False
    """
    if key is None:
        rows = np.ascontiguousarray(image[::16])
        key = f"pixels {image.shape} {zlib.crc32(rows):08x}"
    return item_seed(seed, key, epoch)


def _severities(severity: int | Sequence[int] | None) -> tuple[int, ...]:
    if severity is None:
        return ()
    ends = (severity, severity) if isinstance(severity, (int, np.integer)) else tuple(severity)
    if len(ends) != 2 or not 1 <= ends[0] <= ends[1] <= 5:
        raise ValueError(f"severity {severity!r}: expected 1 to 5, or a pair (least, most) of these")
    return tuple(range(int(ends[0]), int(ends[1]) + 1))


def _recipe(recipe: Recipe | str | dict[str, Any] | None, severity: int | None) -> Recipe:
    if isinstance(recipe, Recipe) and severity is None:
        return recipe
    if isinstance(recipe, dict) and severity is None:
        return Recipe.from_dict(recipe)
    if recipe is None or isinstance(recipe, str):
        preset = recipe or "windshield-star"
        return Recipe(preset) if severity is None else Recipe(preset, severity=severity)
    raise ValueError("severities scale presets only; give the name of a preset, or leave severity out")
