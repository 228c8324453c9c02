"""Which crack an image gets, independent of the number of workers.

Each image has its own seed, from which its crack is drawn. It comes from the transform's seed, the
epoch and a key of the image, never from how many images a worker has seen. So the images that a
loader yields do not depend on its workers.
"""

from __future__ import annotations

import numbers
import operator
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any, SupportsIndex

import numpy as np
import numpy.typing as npt

from . import PatternBank, ReadyCrack, Recipe, item_seed

Image = npt.NDArray[np.uint8]
RecipeLike = Recipe | str | dict[str, Any]
Severity = int | Sequence[int]
Path = str | os.PathLike[str]

#: Receives the region mask of the first image of a call, if wanted.
_REGIONS: ContextVar[list[Image] | None] = ContextVar("regions", default=None)


class CrackDrawing:
    """Cracks from a recipe at given severities, or from a bank; shared by all transforms.

    Parameters are those of :class:`starbreak.transforms.CrackedGlass`.

    >>> drawing = CrackDrawing("paper", severity=(1, 3), p=0.25, seed=7)
    >>> drawing.severities
    (1, 2, 3)
    >>> 900 < sum(drawing.is_drawn(seed) for seed in range(4000)) < 1100
    True
    """

    def __init__(
        self,
        recipe: RecipeLike | None = None,
        severity: Severity | None = None,
        bank: Path | None = None,
        p: float = 1.0,
        seed: int | None = None,
    ) -> None:
        given: Any = p  # to type checkers a float is no Real
        if not isinstance(given, numbers.Real):
            raise TypeError(f"p = {p!r}; expected a probability from 0 to 1")
        if not 0.0 <= p <= 1.0:
            raise ValueError(f"p = {p}; expected a probability from 0 to 1")
        if bank is not None and (recipe is not None or severity is not None):
            raise ValueError("a bank has its recipe and severity; give a bank alone, or a recipe with severities")
        if seed is not None:
            item_seed(seed, "")  # raises for what is no seed
        if isinstance(severity, Iterable):
            severity = tuple(severity)
        self.p = float(p)
        self.seed = seed
        self._epoch = 0
        self._source = {"recipe": recipe, "severity": severity, "bank": bank}
        self.bank = None if bank is None else PatternBank(bank)
        self.severities = _severities(severity)
        self.recipes = () if self.bank else tuple(_recipe(recipe, one) for one in self.severities or (None,))
        recipes = (self.bank.recipe,) if self.bank else self.recipes
        self._moves = any("distortion" in one.to_dict() for one in recipes)

    def refuse_moved(self, targets: str) -> None:
        """Raise if the lens moves what labels name, which stay.

        >>> CrackDrawing("distortion").refuse_moved("boxes")
        Traceback (most recent call last):
        ValueError: [distortion] moves what boxes name, and they would stay; leave that table out
        >>> CrackDrawing("noise").refuse_moved("boxes")
        """
        if self._moves:
            raise ValueError(f"[distortion] moves what {targets} name, and they would stay; leave that table out")

    @property
    def epoch(self) -> int:
        """Number of the epoch; each number draws different cracks."""
        return self._epoch

    @epoch.setter
    def epoch(self, epoch: int) -> None:
        self._epoch = whole("epoch", epoch, 0, 2**64 - 1)

    def seed_of(self, image: Image | None, key: object = None) -> int:
        """The seed of an image's crack, from its key or, without one, from its pixels.

        Only every 16th row of pixels is used. Images that are equal there get equal cracks.

        >>> drawing = CrackDrawing("paper", seed=7)
        >>> image = np.zeros((32, 32, 3), np.uint8)
        >>> drawing.seed_of(image) == drawing.seed_of(image.copy())
        True
        >>> drawing.seed_of(image, "a.png") == drawing.seed_of(image, "b.png")
        False
        """
        if key is None:
            fit = refuse_unfit(image)
            key = f"pixels {fit.shape} {zlib.crc32(np.ascontiguousarray(fit[::16]).data):08x}"
        elif isinstance(key, bool) or not isinstance(key, str | os.PathLike | numbers.Real):
            raise TypeError(f"key is of type {type(key).__name__}; expected what tells images apart, a path or a number")
        return item_seed(self.seed or 0, os.fspath(key) if isinstance(key, os.PathLike) else str(key), self.epoch)

    def words(self, **others: object) -> str:
        """The arguments as text, together with others of a transform, for its ``repr``.

        >>> CrackDrawing("paper", severity=(1, 3), p=0.25).words(seed=7)
        "recipe='paper', severity=(1, 3), seed=7, p=0.25"
        """
        words = {**self._source, **others, "p": self.p}
        return ", ".join(f"{name}={value!r}" for name, value in words.items() if value is not None)

    def is_drawn(self, seed: int) -> bool:
        """Whether an image with this seed gets a crack, which has probability ``p``."""
        return item_seed(seed, "whether") / 2**53 < self.p

    def recipe_of(self, seed: int) -> Recipe:
        """The recipe for an image with this seed: that of a random severity.

        >>> drawing = CrackDrawing("paper", severity=(1, 2))
        >>> drawing.recipe_of(4) in drawing.recipes
        True
        """
        return self.recipes[item_seed(seed, "severity") % len(self.recipes)]

    def crack_or_spare(self, frames: Sequence[Image], seed: int) -> Sequence[Image]:
        """Cracked frames, or the frames themselves with probability 1 - ``p``."""
        refuse_unfit(frames[0])
        if self.is_drawn(seed):
            return self.crack(frames, seed)
        regions = _REGIONS.get()
        if regions is not None and not regions:
            regions.append(np.zeros(frames[0].shape[:2], np.uint8))
        return frames

    def crack(self, frames: Sequence[Image] | Image, seed: int) -> list[Image]:
        """New images behind one crack, drawn by the seed; all frames must have one size.

        A frame is H×W, H×W×1 or H×W×3.
        """
        first = frames[0]
        refuse_unfit(first)
        size = (first.shape[1], first.shape[0])
        if self.bank is not None:
            ready = self.bank.pattern(self.bank.index_for(seed), size)
        else:
            ready = ReadyCrack(self.recipe_of(seed), seed, size)
        regions = _REGIONS.get()
        cracked = []
        for frame in frames:
            image = frame[..., 0] if frame.shape[2:] == (1,) else frame
            if regions is not None and not regions:
                full = ready.over(image, seed, full=True)
                regions.append(full.region)
                image = full.image
            else:
                image = ready.over(image, seed)
            cracked.append(image.reshape(frame.shape))
        return cracked


@contextmanager
def collected_region(is_wanted: bool) -> Iterator[list[Image]]:
    """Collects the region mask of the first image in its context."""
    regions: list[Image] = []
    token = _REGIONS.set(regions if is_wanted else None)
    try:
        yield regions
    finally:
        _REGIONS.reset(token)


def whole(name: str, given: object, least: int, most: int) -> int:
    """An integer within a range.

    >>> whole("epoch", np.int64(3), 0, 9)
    3
    >>> whole("epoch", -1, 0, 9)
    Traceback (most recent call last):
    ValueError: epoch = -1; expected a whole number from 0 to 9
    """
    said = f"{name} = {given!r}; expected a whole number from {least} to {most}"
    if isinstance(given, bool | np.bool_) or not isinstance(given, SupportsIndex):
        raise TypeError(said)
    number = operator.index(given)
    if not least <= number <= most:
        raise ValueError(said)
    return number


def refuse_unfit(image: object) -> Image:
    """The image; raises if it cannot be cracked, even if it would not get a crack.

    >>> refuse_unfit(np.zeros((2, 3, 4), np.uint8))
    Traceback (most recent call last):
    ValueError: image has shape (2, 3, 4); expected (height, width, 3) or (height, width)
    """
    if not isinstance(image, np.ndarray):
        kind = type(image).__name__
        raise TypeError(f"image is of type {kind}; expected a numpy.ndarray of uint8, H x W x 3 or H x W")
    if image.ndim not in (2, 3) or image.shape[2:] not in ((), (1,), (3,)):
        raise ValueError(f"image has shape {image.shape}; expected (height, width, 3) or (height, width)")
    if image.dtype != np.uint8:
        raise ValueError(f"image has dtype {image.dtype}; expected uint8, 0 to 255")
    if not image.size:
        raise ValueError(f"image has shape {image.shape}: there is no pixel in it")
    return image


def _severities(severity: Severity | None) -> tuple[int, ...]:
    if severity is None:
        return ()
    expected = "expected a whole number from 1 to 5, or a pair (least, most) of these"
    ends = tuple(severity) if isinstance(severity, Iterable) else (severity, severity)
    if any(isinstance(end, bool) or not isinstance(end, int | np.integer) for end in ends):
        raise TypeError(f"severity = {severity!r}; {expected}")
    if len(ends) != 2 or not 1 <= ends[0] <= ends[1] <= 5:
        raise ValueError(f"severity = {severity!r}; {expected}")
    return tuple(range(int(ends[0]), int(ends[1]) + 1))


def _recipe(recipe: RecipeLike | None, severity: int | None) -> Recipe:
    if severity is None:
        return recipe_of(recipe)
    if recipe is None:
        return Recipe(severity=severity)
    if isinstance(recipe, str):
        return Recipe(recipe, severity=severity)
    raise ValueError("severities scale presets only; give the name of a preset, or leave severity out")


def recipe_of(recipe: RecipeLike | None) -> Recipe:
    """The recipe given as itself, name or dict; None means ``Recipe()``.

    >>> recipe_of("paper") == recipe_of(Recipe("paper").to_dict())
    True
    """
    if isinstance(recipe, Recipe):
        return recipe
    if isinstance(recipe, dict):
        return Recipe.from_dict(recipe)
    if recipe is None:
        return Recipe()
    if isinstance(recipe, str):
        return Recipe(recipe)
    raise TypeError(f"recipe = {recipe!r}; expected a starbreak.Recipe, the name of a preset or a dict")
