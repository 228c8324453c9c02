"""The verbs of the command `starbreak`, in this process, and the command itself."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from ._starbreak import Recipe, _call, _run

_Path: TypeAlias = str | os.PathLike[str]
_RecipeLike: TypeAlias = Recipe | str | dict[str, Any] | None
_Progress: TypeAlias = Callable[[int, int, str], object] | bool

_LOG = logging.getLogger("starbreak")


def main() -> None:
    """The command `starbreak`, as the wheel installs it."""
    sys.exit(_run(["starbreak", *sys.argv[1:]]))


def command(
    verb: str,
    *inputs: _Path,
    recipe: _RecipeLike = None,
    progress: _Progress = False,
    **options: Any,
) -> Any:
    """Runs a verb of the command in this process and returns what `starbreak VERB --json` prints.

    verb: `generate`, `study`, …, as `starbreak help` lists them.
    inputs: what stands on the command line without a flag.
    recipe: a `Recipe`, the name of a preset, or tables as a dict.
    progress: a function of items done, all items (0 if not known) and what they are called; or
    True for a bar of tqdm where that is installed.
    options: the flags, with `_` for `-`: `n=3` is `-n 3`, `damaged_set="out"` is
    `--damaged-set out`, True a flag without a value, None or False no flag, a list or tuple the
    flag for each entry, a dict `NAME=VALUE` for each.

    What the command would print is logged by the logger `starbreak`, remarks and warnings as
    warnings. Raises `ValueError` where the command ends with exit code 2, and `SimulationError`
    where all the work failed. Ctrl-C finishes what has begun, as the command does.

    >>> import starbreak
    >>> starbreak.command("recipe", preset="paper", severity=2)["recipe"][:10]
    'schema = 1'
    >>> starbreak.command("recipe", preset="papr")
    Traceback (most recent call last):
        ...
    ValueError: unknown preset `papr`; did you mean `paper`?
    """
    with _recipe_flags(recipe) as flags, _listener(progress) as listener:
        words = ["starbreak", verb, "--json", *flags]
        for name, value in options.items():
            words += _flag(name, value)
        # What begins with a dash is an input here, too.
        words += ["--", *(os.fspath(word) for word in inputs)] if inputs else []
        return _call(words, listener)


def generate(source: _Path, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Damages a whole dataset: `starbreak generate SOURCE -o OUTPUT`; see `command`."""
    return command("generate", source, output=output, recipe=recipe, **options)


def patterns(number: int, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Makes a bank of cracks: `starbreak patterns -n NUMBER -o OUTPUT`; see `command`."""
    return command("patterns", number=number, output=output, recipe=recipe, **options)


def video(clip: _Path, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Adds a static or growing crack to a video: `starbreak video CLIP -o OUTPUT`; see `command`."""
    return command("video", clip, output=output, recipe=recipe, **options)


def detect(source: _Path, model: _Path, output: _Path, **options: Any) -> Any:
    """Runs an ONNX detector over a dataset: `starbreak detect SOURCE --model MODEL -o OUTPUT`."""
    return command("detect", source, model=model, output=output, **options)


def study(
    source: _Path,
    model: _Path | Sequence[_Path],
    output: _Path,
    recipe: _RecipeLike = None,
    **options: Any,
) -> Any:
    """Damages a dataset, detects and reports: `starbreak study SOURCE --model MODEL -o OUTPUT`."""
    return command("study", source, model=model, output=output, recipe=recipe, **options)


def sweep(
    image: _Path, output: _Path, over: str, recipe: _RecipeLike = None, **options: Any
) -> Any:
    """One crack over the values of a parameter: `starbreak sweep IMAGE -o OUTPUT --over OVER`."""
    return command("sweep", image, output=output, over=over, recipe=recipe, **options)


def _flag(name: str, value: Any) -> list[str]:
    flag = f"-{name}" if len(name) == 1 else "--" + name.rstrip("_").replace("_", "-")
    if value is None or value is False:
        return []
    if value is True:
        return [flag]
    if isinstance(value, Mapping):
        return [word for key, one in value.items() for word in (flag, f"{key}={_toml(one)}")]
    if isinstance(value, (list, tuple)):
        return [word for one in value for word in _flag(name, one)]
    # In one word, so that a value may begin with a dash.
    text = os.fspath(value) if isinstance(value, os.PathLike) else str(value)
    return [flag, text] if len(name) == 1 else [f"{flag}={text}"]


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    if isinstance(value, Sequence) or hasattr(value, "tolist") and getattr(value, "ndim", 0):
        return "[" + ", ".join(_toml(one) for one in value) + "]"
    return str(value)


@contextmanager
def _recipe_flags(recipe: _RecipeLike) -> Iterator[list[str]]:
    if recipe is None:
        yield []
    elif isinstance(recipe, str):
        yield [f"--preset={recipe}"]
    else:
        import tempfile

        whole = Recipe.from_dict(recipe) if isinstance(recipe, dict) else recipe
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "recipe.toml")
            with open(path, "w", encoding="utf-8") as file:
                file.write(whole.to_toml())
            yield [f"--recipe={path}"]


@contextmanager
def _listener(progress: _Progress) -> Iterator[Callable[..., None]]:
    bars: dict[str, Any] = {}
    bar_of = _tqdm() if progress is True else None

    def listen(kind: str, *said: Any) -> None:
        if kind == "say":
            _LOG.info("%s", said[0])
        elif kind == "note":
            _LOG.warning("%s", said[0])
        elif callable(progress):
            progress(*said)
        elif bar_of is not None:
            done, total, what = said
            if what not in bars:
                bars[what] = bar_of(total=total or None, unit=f" {what}")
            bars[what].update(done - bars[what].n)

    try:
        yield listen
    finally:
        for bar in bars.values():
            bar.close()


def _tqdm() -> Callable[..., Any] | None:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm  # type: ignore[no-any-return]
