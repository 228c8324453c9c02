"""The verbs of the command `starbreak`, in this process, and the command itself."""

from __future__ import annotations

import logging
import os
import signal
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

from ._starbreak import Recipe, _call, _run

_Path: TypeAlias = str | os.PathLike[str]
_RecipeLike: TypeAlias = Recipe | str | dict[str, Any] | os.PathLike[str] | None
_Progress: TypeAlias = Callable[[int, int, str], object] | bool

_LOG = logging.getLogger("starbreak")


def main() -> None:
    """The command `starbreak`, as the wheel installs it."""
    # Python's own handler waits for Python code, of which none runs until the command ends.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    words = sys.argv[1:]
    # Behind two dashes flags are inputs.
    n_flags = words.index("--") if "--" in words else len(words)
    library = _library_of_onnxruntime(words[:n_flags])
    sys.exit(_run(["starbreak", *words[:n_flags], *library, *words[n_flags:]]))


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
    recipe: a `Recipe`, the name of a preset, tables as a dict, or the path of a file (`pathlib.Path`).
    progress: a function of items done, all items (0 if not known) and what they are called; or
    True for a bar of tqdm where that is installed.
    options: the flags, with `_` for `-`: `n=3` is `-n 3`, `damaged_set="out"` is
    `--damaged-set out`, True a flag without a value, None or False no flag, a list, tuple or array
    the flag for each entry, a dict `NAME=VALUE` for each.

    What the command would print is logged by the logger `starbreak`: warnings and errors of single
    items as warnings, the rest as info. If only some items fail, the result counts them. Raises
    `ValueError` where the command ends with exit code 2, `SimulationError` where it ends with 1
    without a result. Ctrl-C finishes what has begun, as the command does; `evaluate`, `timeline`,
    `merge` and the report of `study` run to their end, and a second Ctrl-C does not wait for it.

    >>> import starbreak
    >>> starbreak.command("recipe", preset="paper", severity=2)["recipe"][:10]
    'schema = 1'
    >>> starbreak.command("recipe", preset="papr")
    Traceback (most recent call last):
        ...
    ValueError: unknown preset `papr`; did you mean `paper`?
    """
    return call(verb, inputs, recipe, progress, options, {})


def call(
    verb: str,
    inputs: Sequence[_Path],
    recipe: _RecipeLike,
    progress: _Progress,
    options: Mapping[str, Any],
    unrecorded: Mapping[str, Any],
) -> Any:
    """Runs a verb as `command` does, with options beside those that records show."""
    begin = ["starbreak", verb, "--json"]
    end, more = (
        [word for name, value in some.items() for word in _flag(name, value)] for some in (options, unrecorded)
    )
    library = _library_of_onnxruntime(end)
    if inputs:
        # What begins with a dash is an input here, too.
        end += ["--", *(os.fspath(word) for word in inputs)]
    with _recipe_flags(recipe) as (flags, recorded), _listener(progress) as listener:
        return _call([*begin, *library, *flags, *more, *end], [*begin, *recorded, *end], listener)


def generate(source: _Path, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Damages a whole dataset: `starbreak generate SOURCE -o OUTPUT`; see `command`."""
    return command("generate", source, output=output, recipe=recipe, **options)


def patterns(number: int, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Makes a bank of cracks: `starbreak patterns -n NUMBER -o OUTPUT`; see `command`."""
    return command("patterns", number=number, output=output, recipe=recipe, **options)


def video(clip: _Path, output: _Path, recipe: _RecipeLike = None, **options: Any) -> Any:
    """Damages a video, by cracks or other faults: `starbreak video CLIP -o OUTPUT`; see `command`."""
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


def _library_of_onnxruntime(flags: Sequence[str]) -> list[str]:
    """The flag for the package onnxruntime of this Python, where flags ask for ONNX Runtime and name no library."""
    asked = [word.partition("=")[2] for word in flags if word.startswith("--runtime=")]
    asked += [value for word, value in zip(flags, flags[1:]) if word == "--runtime"]
    is_named = any(word.partition("=")[0] == "--onnxruntime" for word in flags)
    wants_it = asked[-1:] in (["auto"], ["onnxruntime"]) or (not asked and "--cuda" in flags)
    if not wants_it or is_named or os.environ.get("ORT_DYLIB_PATH"):
        return []
    from importlib.util import find_spec
    from pathlib import Path

    try:
        spec = find_spec("onnxruntime")
        folders = spec.submodule_search_locations if spec else None
        files = sorted(Path(folders[0], "capi").iterdir()) if folders else []
    except (OSError, ValueError):
        return []
    names = ("libonnxruntime.", "onnxruntime.dll")
    return [f"--onnxruntime={file}" for file in files if file.name.startswith(names)][:1]


def _flag(name: str, value: Any) -> list[str]:
    flag = f"-{name}" if len(name) == 1 else "--" + name.replace("_", "-")
    value = _plain(value)
    if value is None or value is False:
        return []
    if value is True:
        return [flag]
    if isinstance(value, Mapping):
        return [f"{flag}={key}={_toml(_plain(one))}" for key, one in value.items()]
    if isinstance(value, list):
        return [word for one in value for word in _flag(name, one)]
    # In one word, so that a value may begin with a dash.
    return [f"{flag}={value}"]


def _plain(value: Any) -> Any:
    """A number, text, mapping or list, of what NumPy and others have in their place."""
    if isinstance(value, (str, Mapping)):
        return value
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if hasattr(value, "tolist"):
        return value.tolist()
    return list(value) if isinstance(value, Iterable) else value


def _toml(value: Any) -> str:
    # Text alone is taken as text; in a list it is quoted, as in JSON.
    import json

    return value if isinstance(value, str) else json.dumps(value)


@contextmanager
def _recipe_flags(recipe: _RecipeLike) -> Iterator[tuple[list[str], list[str]]]:
    """The flags of a recipe, and those that records show: a file of ours has another path each time."""
    if recipe is None:
        yield [], []
    elif isinstance(recipe, str):
        yield [f"--preset={recipe}"], [f"--preset={recipe}"]
    elif isinstance(recipe, os.PathLike):
        yield [f"--recipe={os.fspath(recipe)}"], [f"--recipe={os.fspath(recipe)}"]
    else:
        import tempfile

        whole = Recipe.from_dict(recipe) if isinstance(recipe, dict) else recipe
        # Its name is what a study calls the condition.
        name = f"recipe-{whole.sha256[:8]}.toml"
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, name)
            with open(path, "w", encoding="utf-8") as file:
                file.write(whole.to_toml())
            yield [f"--recipe={path}"], [f"--recipe={name}"]


@contextmanager
def _listener(progress: _Progress) -> Iterator[Callable[..., None]]:
    bars: list[Any] = []
    bar_of = _tqdm() if progress is True else None

    def listen(kind: str, *said: Any) -> None:
        if kind == "say":
            _LOG.info("%s", said[0])
        elif kind == "note":
            is_grave = said[0].startswith(("warning: ", "error: "))
            _LOG.log(logging.WARNING if is_grave else logging.INFO, "%s", said[0])
        elif callable(progress):
            progress(*said)
        elif bar_of is not None:
            done, total, what = said
            # One step follows the other, each with its own bar.
            if not bars or done <= bars[-1].n:
                bars.append(bar_of(total=total or None, unit=f" {what}"))
            bars[-1].update(done - bars[-1].n)

    try:
        yield listen
    finally:
        for bar in bars:
            bar.close()


def _tqdm() -> Callable[..., Any] | None:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return None
    return tqdm  # type: ignore[no-any-return]
