"""Types of the compiled part of the package; the docstrings are available at run time."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, Protocol, SupportsIndex, TypeAlias, final, overload

import numpy as np
import numpy.typing as npt

_Image: TypeAlias = npt.NDArray[np.uint8]
_Path: TypeAlias = str | PathLike[str]
_RecipeLike: TypeAlias = Recipe | str | dict[str, Any]
_Boxes: TypeAlias = Sequence[Sequence[float]] | npt.NDArray[np.floating[Any]]
_Size: TypeAlias = Sequence[SupportsIndex] | npt.NDArray[np.integer[Any]]
_Numbers: TypeAlias = Sequence[float] | npt.NDArray[np.floating[Any]]
_Set: TypeAlias = Mapping[str, Any] | Sequence[str]
_Channels: TypeAlias = Literal["rgb", "bgr", "rgba", "bgra", "gray"]

class _Pillow(Protocol):
    @property
    def mode(self) -> str: ...
    @property
    def __array_interface__(self) -> dict[str, Any]: ...

__all__ = [
    "CrackNetwork",
    "Cracked",
    "LightFilter",
    "PatternBank",
    "ReadyCrack",
    "Recipe",
    "SimulationError",
    "__version__",
    "_call",
    "_run",
    "blake3_hex",
    "cameras",
    "corrupt",
    "crack",
    "crack_file",
    "divergence",
    "evaluate",
    "item_seed",
    "json_schema",
    "presets",
    "simulate",
    "street_scene",
]

__version__: str

class SimulationError(RuntimeError): ...

def _run(words: Sequence[_Path]) -> int: ...
def _call(words: Sequence[_Path], recorded: Sequence[_Path], tell: Callable[..., object]) -> Any: ...

@final
class Recipe:
    def __new__(
        cls,
        preset: str = "windshield-spiderweb",
        *,
        severity: SupportsIndex | None = None,
        camera: str | None = None,
        set: _Set | None = None,
        max_memory: SupportsIndex | None = None,
    ) -> Recipe: ...
    @staticmethod
    def from_toml(text: str, *, name: _Path = "recipe") -> Recipe: ...
    @staticmethod
    def from_file(path: _Path) -> Recipe: ...
    @staticmethod
    def from_dict(tables: Mapping[str, Any]) -> Recipe: ...
    def replace(
        self,
        set: _Set | None = None,
        *,
        camera: str | None = None,
        max_memory: SupportsIndex | None = None,
    ) -> Recipe: ...
    def to_toml(self, *, comments: bool = False) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    @property
    def sha256(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, tuple[str, int]]: ...
    @staticmethod
    def _restored(text: str, max_memory: SupportsIndex) -> Recipe: ...

@final
class CrackNetwork:
    @staticmethod
    def from_json(text: str) -> CrackNetwork: ...
    @staticmethod
    def from_file(path: _Path) -> CrackNetwork: ...
    def to_json(self) -> str: ...
    def to_svg(self) -> str: ...
    def _repr_svg_(self) -> str: ...
    def save(self, path: _Path, *, replace: bool = False) -> None: ...
    @property
    def nodes(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def segments(self) -> dict[str, npt.NDArray[Any]]: ...
    @property
    def model(self) -> Literal["paper", "physics", "imported"]: ...
    @property
    def seed(self) -> int | None: ...
    @property
    def unit(self) -> Literal["px", "mm"]: ...
    @property
    def damage_class(self) -> str | None: ...
    @property
    def pane(self) -> dict[str, Any]: ...
    @property
    def impacts(self) -> list[dict[str, Any]]: ...
    @property
    def fallen(self) -> list[list[float]]: ...
    @property
    def summary(self) -> dict[str, Any]: ...
    def __len__(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __reduce__(self) -> tuple[Any, tuple[str]]: ...

@final
class Cracked:
    def __new__(
        cls,
        image: _Image,
        region: _Image,
        crack: _Image,
        network: CrackNetwork | None,
        facts: dict[str, Any],
        damage: list[dict[str, float | None] | None],
        intact: bool,
    ) -> Cracked: ...
    @property
    def image(self) -> _Image: ...
    @property
    def region(self) -> _Image: ...
    @property
    def crack(self) -> _Image: ...
    @property
    def network(self) -> CrackNetwork | None: ...
    @property
    def facts(self) -> dict[str, Any]: ...
    @property
    def damage(self) -> list[dict[str, float | None] | None]: ...
    @property
    def intact(self) -> bool: ...
    def _repr_png_(self) -> bytes: ...
    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]: ...

@final
class ReadyCrack:
    def __new__(
        cls,
        recipe: _RecipeLike | None = None,
        seed: SupportsIndex = 0,
        size: _Size = (1242, 375),
        *,
        network: CrackNetwork | None = None,
    ) -> ReadyCrack: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def intact(self) -> bool: ...
    @property
    def network(self) -> CrackNetwork | None: ...
    @property
    def facts(self) -> dict[str, Any]: ...
    def crack_mask(self) -> _Image: ...
    @overload
    def over(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        out: None = None,
        channels: _Channels | None = None,
        boxes: _Boxes,
        full: bool = False,
    ) -> Cracked: ...
    @overload
    def over(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        out: None = None,
        channels: _Channels | None = None,
        boxes: _Boxes | None = None,
        full: Literal[True],
    ) -> Cracked: ...
    @overload
    def over(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        out: _Image | None = None,
        channels: _Channels | None = None,
        boxes: None = None,
        full: Literal[False] = False,
    ) -> _Image: ...
    @overload
    def over(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        out: _Image | None = None,
        channels: _Channels | None = None,
        boxes: _Boxes | None = None,
        full: bool = False,
    ) -> _Image | Cracked: ...
    def estimate_environment(
        self, image: _Image | _Pillow, *, channels: _Channels | None = None
    ) -> dict[str, Any] | None: ...
    def set_environment(self, environment: Mapping[str, Any] | None = None) -> None: ...
    @property
    def environment(self) -> dict[str, Any] | None: ...
    def __reduce__(self) -> tuple[Any, tuple[Any, ...]]: ...

@final
class LightFilter:
    def __new__(cls) -> LightFilter: ...
    def next(self, environment: Mapping[str, Any] | None, elapsed_s: float) -> dict[str, Any] | None: ...
    @property
    def n_lights(self) -> int: ...

@final
class PatternBank:
    def __new__(cls, path: _Path) -> PatternBank: ...
    def __len__(self) -> int: ...
    def __getitem__(self, index: SupportsIndex, /) -> CrackNetwork: ...
    def __iter__(self) -> Iterator[CrackNetwork]: ...
    @property
    def path(self) -> Any: ...
    @property
    def sizes(self) -> list[tuple[int, int]]: ...
    @property
    def seed(self) -> int: ...
    @property
    def sha256(self) -> str: ...
    @property
    def recipe(self) -> Recipe: ...
    def index_for(
        self, seed: SupportsIndex, *, name: _Path | None = None, sample_index: SupportsIndex = 0
    ) -> int: ...
    def pattern(self, index: SupportsIndex, size: _Size) -> ReadyCrack: ...
    @overload
    def crack(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        name: _Path | None = None,
        sample_index: SupportsIndex = 0,
        index: SupportsIndex | None = None,
        boxes: _Boxes,
        full: bool = False,
    ) -> Cracked: ...
    @overload
    def crack(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        name: _Path | None = None,
        sample_index: SupportsIndex = 0,
        index: SupportsIndex | None = None,
        boxes: _Boxes | None = None,
        full: Literal[True],
    ) -> Cracked: ...
    @overload
    def crack(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        name: _Path | None = None,
        sample_index: SupportsIndex = 0,
        index: SupportsIndex | None = None,
        boxes: None = None,
        full: Literal[False] = False,
    ) -> _Image: ...
    @overload
    def crack(
        self,
        image: _Image | _Pillow,
        seed: SupportsIndex = 0,
        *,
        name: _Path | None = None,
        sample_index: SupportsIndex = 0,
        index: SupportsIndex | None = None,
        boxes: _Boxes | None = None,
        full: bool = False,
    ) -> _Image | Cracked: ...
    def __reduce__(self) -> tuple[Any, tuple[Any, str]]: ...

def simulate(
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    size: _Size = (1242, 375),
) -> CrackNetwork: ...
@overload
def crack(
    image: _Image | _Pillow,
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    *,
    severity: SupportsIndex | None = None,
    name: _Path | None = None,
    sample_index: SupportsIndex = 0,
    network: CrackNetwork | None = None,
    boxes: _Boxes,
    full: bool = False,
) -> Cracked: ...
@overload
def crack(
    image: _Image | _Pillow,
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    *,
    severity: SupportsIndex | None = None,
    name: _Path | None = None,
    sample_index: SupportsIndex = 0,
    network: CrackNetwork | None = None,
    boxes: _Boxes | None = None,
    full: Literal[True],
) -> Cracked: ...
@overload
def crack(
    image: _Image | _Pillow,
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    *,
    severity: SupportsIndex | None = None,
    name: _Path | None = None,
    sample_index: SupportsIndex = 0,
    network: CrackNetwork | None = None,
    boxes: None = None,
    full: Literal[False] = False,
) -> _Image: ...
@overload
def crack(
    image: _Image | _Pillow,
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    *,
    severity: SupportsIndex | None = None,
    name: _Path | None = None,
    sample_index: SupportsIndex = 0,
    network: CrackNetwork | None = None,
    boxes: _Boxes | None = None,
    full: bool = False,
) -> _Image | Cracked: ...
def corrupt(
    image: _Image | _Pillow,
    corruption_name: str = "windshield-spiderweb",
    severity: SupportsIndex = 1,
    *,
    seed: SupportsIndex = 0,
) -> _Image: ...
def blake3_hex(data: bytes | bytearray | memoryview) -> str: ...
def crack_file(
    data: bytes | bytearray | memoryview,
    name: _Path,
    recipe: _RecipeLike | None = None,
    seed: SupportsIndex = 0,
    *,
    bank: PatternBank | None = None,
    sample_index: SupportsIndex = 0,
    n_samples: SupportsIndex = 1,
) -> list[tuple[str, bytes]]: ...
def street_scene() -> tuple[_Image, list[dict[str, Any]]]: ...
def item_seed(seed: SupportsIndex, name: _Path, sample_index: SupportsIndex = 0) -> int: ...
def presets() -> dict[str, str]: ...
def cameras() -> dict[str, str]: ...
def json_schema() -> dict[str, Any]: ...
def evaluate(
    source: _Path | None = None,
    *,
    clean: _Path,
    cracked: _Path | None = None,
    ground_truth: _Path | None = None,
    regions: _Path | None = None,
    cracked_set: _Path | None = None,
    protocol: Literal["coco", "kitti", "bdd"] | None = None,
    tau: _Numbers = (),
    iou_thresholds: _Numbers = (),
    max_dets: Sequence[SupportsIndex] | npt.NDArray[np.integer[Any]] = (),
    area_ranges: Mapping[str, Sequence[float]] = {},
    class_agnostic: bool = False,
    gt_id_zero_quirk: bool = False,
    output: _Path | None = None,
    replace: bool = False,
    detector: str | None = None,
    condition: str | None = None,
    replicates: SupportsIndex = 1000,
    score_threshold: float = 0.3,
    worst: SupportsIndex = 6,
    seed: SupportsIndex = 0,
    threads: SupportsIndex = 0,
) -> dict[str, Any]: ...
def divergence(
    *sets: _Path,
    limit: SupportsIndex | None = None,
    alpha: float = 0.5,
    bootstrap: SupportsIndex = 1000,
    permutations: SupportsIndex = 999,
    splits: SupportsIndex = 100,
    seed: SupportsIndex = 0,
    side: SupportsIndex = 256,
    background: Literal["black", "gray", "white"] = "black",
    model: _Path | None = None,
    layer: str | None = None,
    threads: SupportsIndex = 0,
) -> dict[str, Any]: ...
