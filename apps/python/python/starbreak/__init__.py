"""starbreak: the glass in front of a camera, broken by physics, as the camera then sees it."""

from ._starbreak import (
    Cracked,
    CrackNetwork,
    PatternBank,
    ReadyCrack,
    Recipe,
    SimulationError,
    __version__,
    cameras,
    corrupt,
    crack,
    divergence,
    evaluate,
    item_seed,
    json_schema,
    presets,
    simulate,
)

__all__ = [
    "CrackNetwork",
    "Cracked",
    "PatternBank",
    "ReadyCrack",
    "Recipe",
    "SimulationError",
    "__version__",
    "cameras",
    "corrupt",
    "crack",
    "divergence",
    "evaluate",
    "item_seed",
    "json_schema",
    "presets",
    "simulate",
]
