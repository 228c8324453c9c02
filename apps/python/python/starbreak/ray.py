"""Cracked images and studies of detectors at the scale of a cluster, with Ray.

Files and numbers equal those of ``starbreak generate`` and ``starbreak study`` on one machine to the byte, for any
number of workers and even if workers die: each image's crack depends only on its name and the seed, and what is
complete is not made again.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import posixpath
import shutil
import uuid
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

try:
    import ray
    import ray.data
    from pyarrow import fs as arrow_fs
except ImportError as error:
    raise ImportError('starbreak.ray needs Ray Data: pip install "ray[data]"') from error

from . import PatternBank, Recipe, blake3_hex, crack_file, item_seed
from ._command import call, command
from ._drawing import RecipeLike, recipe_of, whole

__all__ = ["crack_dataset", "study"]

_EXTENSIONS = (".png", ".jpg", ".jpeg")


def crack_dataset(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    recipe: RecipeLike | None = None,
    bank: str | os.PathLike[str] | None = None,
    seed: int = 0,
    n_samples: int = 1,
    filesystem: arrow_fs.FileSystem | None = None,
    batch_size: int = 16,
    concurrency: int | None = None,
) -> dict[str, Any]:
    """Break the glass in front of all images of a folder, on all workers of a Ray cluster.

    Args:
        source: folder, or its URI in an object store (``s3://…``, ``gs://…``), opened by Arrow.
            PNG and JPEG files in it and its subfolders are read, except names that begin with a dot.
        output: folder or URI for all results, with the names of the source: ``NAME``
            (``sample_K/NAME`` for several samples), and ``regions``, ``cracks`` and ``provenance``
            in ``starbreak``.
        recipe: a ``Recipe``, the name of a preset, or tables as a dict; default
            ``windshield-spiderweb``.
        bank: a file written by ``starbreak patterns``, instead of a recipe; each worker opens it, so
            all must have access to it.
        seed: 0 to 2**64 - 1; the same seed gives the same images.
        n_samples: number of cracked versions of each image.
        filesystem: an Arrow file system for source and output, instead of those of the URIs.
        batch_size: number of images that a worker takes at a time.
        concurrency: limit of concurrent workers; default: all of the cluster.

    Returns:
        ``{"n_made", "n_kept", "n_failed", "failed": [{"name", "sample", "error"}, …]}``: images made
        now; images that existed already, made from the same file (by an earlier run of the same
        recipe and seed, or by a worker that died later); and images that could not be read or
        cracked.

    Raises:
        ValueError: for an invalid recipe, a source without images or with two images whose masks
            would have the same name, an output of another recipe or seed or with other files in it.
        OSError: if the source cannot be listed or the output cannot be written.
    """
    n_samples = whole("n_samples", n_samples, 1, 2**32 - 1)
    batch_size = whole("batch_size", batch_size, 1, 2**32 - 1)
    if concurrency is not None:
        concurrency = whole("concurrency", concurrency, 1, 2**32 - 1)
    if bank is not None and recipe is not None:
        raise ValueError("a bank has its recipe; give one of both")
    item_seed(seed, "")  # raises for what is no seed
    job = _Job(
        toml=None if bank is not None else recipe_of(recipe).to_toml(),
        bank=None if bank is None else os.path.abspath(bank),
        seed=seed,
        n_samples=n_samples,
        source=_open(source, filesystem),
        output=_open(output, filesystem),
    )
    _refuse_recipe(*_engine(job.toml, job.bank))
    _refuse_nesting(job.source.root, job.output.root)
    names = _names(job.source)
    _claim(job)
    items = [{"name": name, "sample": sample} for name in names for sample in range(n_samples)]
    made = ray.data.from_items(items, override_num_blocks=max(1, min(len(items) // batch_size, 4096))).map_batches(
        job.crack_batch,
        batch_size=batch_size,
        compute=None if concurrency is None else ray.data.TaskPoolStrategy(size=concurrency),
    )
    counts = {"made": 0, "kept": 0, "failed": 0}
    failed = []
    for row in made.iter_rows():
        counts[row["state"]] += 1
        if row["state"] == "failed":
            failed.append({key: row[key] for key in ("name", "sample", "error")})
    failed.sort(key=lambda entry: (entry["name"], entry["sample"]))
    return {**{f"n_{state}": n for state, n in counts.items()}, "failed": failed}


def study(
    source: str | os.PathLike[str],
    model: str | os.PathLike[str] | Sequence[str | os.PathLike[str]],
    output: str | os.PathLike[str],
    recipe: RecipeLike | os.PathLike[str] | None = None,
    *,
    n_shards: int | None = None,
    threads: int = 1,
    **options: Any,
) -> Any:
    """Damage a dataset, detect and report, on all workers of a Ray cluster.

    Each task is one step of one shard: the clean images, or those of one condition, broken and looked at by each
    detector. A worker that dies costs what its task had not written down yet; another one goes on with it. At the
    end this process joins the shards and makes the report. The same call resumes an interrupted one; an output that
    is joined, or was begun by ``starbreak study``, is gone on with in this process alone.

    Args:
        source: the dataset, as for ``starbreak study``: ``coco:DIR``, …
        model: ONNX file, or several.
        output: folder of the study. Until it is joined, shards lie beside it in ``OUTPUT-shards``; they stay there
            if images could not be used, and the same call tries these again.
        recipe: as for ``starbreak.command``.
        n_shards: number of shards, of about equal size; default: one for each 100 images.
        threads: threads of each task, for which Ray sets aside as many processors: it waits for a machine that has them.
        options: flags of ``starbreak study``, as for ``starbreak.command``: ``presets=["windshield-star"]``. With
            ``cuda=True`` Ray sets aside a GPU for each task.

    All machines need the source, the models and the output under the same paths, relative ones from a working folder
    that all have.

    Returns:
        What ``starbreak study --json`` prints: the study, equal to that of one machine to the byte.

    Raises:
        ValueError: as ``starbreak.study``.
        ray.exceptions.RayError: if a task fails for another reason, or its worker dies four times.
    """
    for name in ("shard", "step", "join", "dry_run", "progress"):
        if name in options:
            raise ValueError(f"{name}: a study on a cluster has no such option; leave it out")
    if "://" in os.fspath(output):
        raise ValueError(f"{output}: a study writes files; give a folder of a file system that all machines share")
    threads = whole("threads", threads, 1, 2**16)
    options = {"model": model, "output": output, **options}
    plan = command("study", source, recipe=recipe, dry_run=True, **options)
    if n_shards is None:
        n_shards = max(1, plan["n_images"] // 100)
    n_shards = whole("n_shards", n_shards, 1, 2**32 - 1)
    folder = Path(os.path.abspath(output))
    parts = folder.with_name(f"{folder.name}-shards")
    shards = {f"{k}/{n_shards}": parts / f"{k}-of-{n_shards}" for k in range(1, n_shards + 1)}
    if (folder / "study.json").exists() and not any(part.exists() for part in shards.values()):
        return call("study", [source], recipe, False, options, {})
    step_on = _study_step.options(num_cpus=threads, num_gpus=1 if options.get("cuda") else 0, name="study step")
    tasks = [
        step_on.remote(
            os.getcwd(), source, recipe, {**options, "output": part, "shard": shard, "step": step, "threads": threads}
        )
        for shard, part in shards.items()
        for step in plan["steps"]
    ]
    n_unseen = 0
    try:
        while waiting := tasks:
            done, tasks = ray.wait(waiting)
            n_unseen += sum(ray.get(done))
    except ray.exceptions.RayTaskError as error:
        # What the command has refused is raised as it is.
        raise (error.cause if isinstance(error.cause, ValueError) else error) from None
    finally:
        for task in tasks:
            ray.cancel(task)
        if tasks:
            # They finish the image that they are at.
            ray.wait(tasks, num_returns=len(tasks), timeout=60)
    found = call("study", [source], recipe, False, options, {"join": list(shards.values())})
    if n_unseen == 0:
        for part in shards.values():
            _remove(part)
        with contextlib.suppress(OSError):  # another run has shards there
            parts.rmdir()
    return found


@ray.remote
def _study_step(folder: str, source: Any, recipe: Any, options: dict[str, Any]) -> int:
    """One step of one shard, in the working folder of the caller; the number of images that could not be used."""
    before = os.getcwd()
    with contextlib.suppress(OSError):  # absolute paths do without
        os.chdir(folder)
    try:
        return int(command("study", source, recipe=recipe, **options)["n_unseen"])
    finally:
        os.chdir(before)


def _remove(shard: Path) -> None:
    """Removes a shard, last what says what it is: an interrupted removal leaves one that can be gone on with."""
    for path in shard.iterdir():
        if path.is_dir():
            shutil.rmtree(path, ignore_errors=True)
    shutil.rmtree(shard, ignore_errors=True)


@dataclass(frozen=True)
class _Folder:
    """A folder of a file system; names in it are separated by slashes."""

    filesystem: arrow_fs.FileSystem
    root: str

    def place(self, *names: str) -> str:
        return posixpath.join(self.root, *names)

    def has(self, name: str) -> bool:
        found = self.filesystem.get_file_info(self.place(name))
        return bool(found.type == arrow_fs.FileType.File)

    def read(self, name: str) -> bytes:
        with self.filesystem.open_input_stream(self.place(name)) as stream:
            return bytes(stream.read())

    def write(self, name: str, content: bytes) -> None:
        """Write all or nothing: object stores do that themselves; a file is renamed at the end."""
        place = self.place(name)
        if not isinstance(self.filesystem, arrow_fs.LocalFileSystem):
            self._put(place, content)
            return
        folder, last = posixpath.split(place)
        self.filesystem.create_dir(folder, recursive=True)
        temporary = posixpath.join(folder, f".starbreak-{uuid.uuid4().hex}-{last}")
        self._put(temporary, content)
        self.filesystem.move(temporary, place)

    def _put(self, place: str, content: bytes) -> None:
        with self.filesystem.open_output_stream(place) as stream:
            stream.write(content)


@dataclass(frozen=True)
class _Job:
    """What each worker needs to know."""

    toml: str | None
    bank: str | None
    seed: int
    n_samples: int
    source: _Folder
    output: _Folder

    def crack_batch(self, batch: dict[str, Any]) -> dict[str, list[Any]]:
        """Crack images of the source into the output; returns a row for each."""
        items = [(str(name), int(sample)) for name, sample in zip(batch["name"], batch["sample"], strict=True)]
        states = [self._crack(name, sample) for name, sample in items]
        return {
            "name": [name for name, _ in items],
            "sample": [sample for _, sample in items],
            "state": [state for state, _ in states],
            "error": [error for _, error in states],
        }

    def _crack(self, name: str, sample: int) -> tuple[str, str]:
        recipe, bank = _engine(self.toml, self.bank)
        try:
            data = self.source.read(name)
            if self._has(name, sample, data):
                return "kept", ""
            files = crack_file(
                data, name, recipe, self.seed, bank=bank, sample_index=sample, n_samples=self.n_samples
            )
        except (ValueError, OSError, RuntimeError) as reason:
            return "failed", str(reason)
        for file_name, content in files:
            self.output.write(file_name, content)
        return "made", ""

    def _has(self, name: str, sample: int, data: bytes) -> bool:
        """Whether the output has all files of an image, made from these bytes."""
        tree = name if self.n_samples == 1 else f"sample_{sample}/{name}"
        place = f"starbreak/provenance/{posixpath.splitext(tree)[0]}.json"
        if not self.output.has(place):
            return False
        try:
            record = json.loads(self.output.read(place))
            files = [record[kind]["name"] for kind in ("output", "region", "crack") if kind in record]
            is_of_data = record["input"]["blake3"] == blake3_hex(data)
        except (ValueError, KeyError, TypeError):
            return False  # what is not whole is made again
        return is_of_data and all(map(self.output.has, files))


@functools.lru_cache(maxsize=2)
def _engine(toml: str | None, bank: str | None) -> tuple[Recipe | None, PatternBank | None]:
    """The recipe, or the bank with its own recipe; loaded once per worker."""
    return None if toml is None else Recipe.from_toml(toml), None if bank is None else PatternBank(bank)


def _refuse_recipe(recipe: Recipe | None, bank: PatternBank | None) -> None:
    """Raise what `crack_file` would for this recipe or bank, before any image is read."""
    with contextlib.suppress(OSError):  # there is no image in no bytes
        crack_file(b"", "any.png", recipe, bank=bank)


def _open(place: str | os.PathLike[str], filesystem: arrow_fs.FileSystem | None) -> _Folder:
    place = os.fspath(place)
    if filesystem is not None:
        return _Folder(filesystem, place.rstrip("/"))
    if "://" in place:
        found, path = arrow_fs.FileSystem.from_uri(place)
        return _Folder(found, path.rstrip("/"))
    return _Folder(arrow_fs.LocalFileSystem(), Path(place).resolve().as_posix())


def _refuse_nesting(source: str, output: str) -> None:
    for inner, outer in ((source, output), (output, source)):
        if f"{inner}/".startswith(f"{outer}/"):
            raise ValueError(f"{output}: an output does not lie in its source {source}, nor around it; give another")


def _names(source: _Folder) -> list[str]:
    found = source.filesystem.get_file_info(arrow_fs.FileSelector(source.root, recursive=True))
    files = (info.path[len(source.root) :].lstrip("/") for info in found if info.type == arrow_fs.FileType.File)
    names = sorted(
        name
        for name in files
        if name.lower().endswith(_EXTENSIONS) and not any(part.startswith(".") for part in name.split("/"))
    )
    if not names:
        raise ValueError(f"{source.root}: there is no PNG or JPEG file in it")
    by_mask: dict[str, str] = {}
    for name in names:
        other = by_mask.setdefault(posixpath.splitext(name)[0].lower(), name)
        if other != name:
            raise ValueError(
                f"{name}: differs from {other} only in its extension or in case, so that their masks would have "
                "one name; rename one of both"
            )
    return names


def _claim(job: _Job) -> None:
    """Refuse an output made by something else; two recipes never mix in one folder."""
    name = "starbreak/ray.json"
    recipe, bank = _engine(job.toml, job.bank)
    identity = {
        "bank_sha256": None if bank is None else bank.sha256,
        "recipe_sha256": None if recipe is None else recipe.sha256,
        "samples": job.n_samples,
        "seed": job.seed,
    }
    if not job.output.has(name):
        other = _any_file(job.output)
        if other is not None:
            raise ValueError(f"{job.output.root}: holds {other} of no earlier run; give a new or empty folder")
        job.output.write(name, (json.dumps(identity, indent=2) + "\n").encode())
        return
    try:
        found = json.loads(job.output.read(name))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise ValueError(f"{job.output.place(name)}: is damaged; give another output")
    for key, wanted in identity.items():
        if found.get(key) != wanted:
            raise ValueError(
                f"{job.output.root}: made with {key} {found.get(key)!r}, not {wanted!r}; give another output, or the "
                "same recipe and seed"
            )


def _any_file(folder: _Folder) -> str | None:
    """The path of any file in a folder or its subfolders."""
    below = arrow_fs.FileSelector(folder.root, allow_not_found=True, recursive=True)
    files = (info.path for info in folder.filesystem.get_file_info(below) if info.type == arrow_fs.FileType.File)
    return next(files, None)
