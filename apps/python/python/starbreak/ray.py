"""Cracked images at the scale of a cluster, by Ray Data.

The files are those of ``starbreak generate folder:SOURCE`` with the same recipe and seed, to the byte,
for any number of workers and after the death of any of them: each image's crack depends on its name and
the seed alone, and an image's record, which is written last, says that it is whole.
"""

from __future__ import annotations

import functools
import json
import posixpath
import uuid
from typing import Any

try:
    import ray
    import ray.data
    from pyarrow import fs as arrow_fs
except ImportError as error:
    raise ImportError('starbreak.ray needs Ray Data: pip install "ray[data]"') from error

from . import PatternBank, Recipe, crack_file

__all__ = ["crack_dataset"]

_EXTENSIONS = (".png", ".jpg", ".jpeg")


def crack_dataset(
    source: str,
    output: str,
    *,
    recipe: Recipe | str | dict[str, Any] | None = None,
    bank: str | None = None,
    seed: int = 0,
    n_samples: int = 1,
    filesystem: arrow_fs.FileSystem | None = None,
    batch_size: int = 16,
    concurrency: int | None = None,
) -> dict[str, Any]:
    """Breaks the glass before all images of a folder, on all workers of a Ray cluster.

    Args:
        source: folder, or URI of one in an object store (``s3://…``, ``gs://…``), which Arrow opens.
            PNG and JPEG files in it and below are read; names that begin with a dot are left out.
        output: folder or URI that all is written into, with the names of the source:
            ``NAME`` (``sample_K/NAME`` for several samples), and below ``starbreak`` ``regions``,
            ``cracks`` and ``provenance``.
        recipe: recipe, name of a preset or tables of a recipe; ``windshield-star`` without it.
        bank: a file that ``starbreak patterns`` wrote, in place of a recipe; each worker opens it, so it
            lies where all see it.
        seed: any number; the same one gives the same images.
        n_samples: cracked versions of each image.
        filesystem: an Arrow file system for both, in place of what the URIs say.
        batch_size: images that a worker takes at a time.
        concurrency: most workers at a time; all that the cluster has without it.

    Returns:
        ``{"n_made", "n_kept", "n_failed", "failed": [{"name", "error"}, …]}``: images made now, those that
        were there from an earlier run of the same recipe and seed, and those that could not be read.

    Raises:
        ValueError: for a recipe that makes no sense, a source without images, an output that another
            recipe or seed has made.
        OSError: where source or output cannot be read or written.
    """
    if n_samples < 1:
        raise ValueError(f"n_samples {n_samples}: expected 1 or more")
    if bank is not None and recipe is not None:
        raise ValueError("a bank has its recipe; give one of both")
    toml = None if bank is not None else _recipe_of(recipe).to_toml()
    source_fs, source_root = _open(source, filesystem)
    output_fs, output_root = _open(output, filesystem)
    names = _names(source_fs, source_root)
    if not names:
        raise ValueError(f"{source}: there is no PNG or JPEG file in it")
    engine = _engine(toml, bank)
    _claim(output_fs, output_root, {"recipe_sha256": engine.recipe_sha256, "bank": engine.bank_sha256, "seed": seed, "samples": n_samples})
    items = [{"name": name, "sample_idx": idx} for name in names for idx in range(n_samples)]
    task = functools.partial(
        _crack_batch,
        toml=toml,
        bank=bank,
        seed=seed,
        n_samples=n_samples,
        source=(source_fs, source_root),
        output=(output_fs, output_root),
    )
    blocks = max(1, min(len(items) // batch_size, 4096))
    made = ray.data.from_items(items, override_num_blocks=blocks).map_batches(
        task, batch_size=batch_size, concurrency=concurrency
    )
    counts = {"made": 0, "kept": 0, "failed": 0}
    failed = []
    for row in made.iter_rows():
        counts[row["state"]] += 1
        if row["state"] == "failed":
            failed.append({"name": row["name"], "error": row["error"]})
    failed.sort(key=lambda entry: entry["name"])
    return {**{f"n_{state}": n for state, n in counts.items()}, "failed": failed}


class _Engine:
    """What breaks images: a recipe, or a bank with its own."""

    def __init__(self, toml: str | None, bank: str | None) -> None:
        self.bank = None if bank is None else PatternBank(bank)
        self.recipe = None if toml is None else Recipe.from_toml(toml)
        self.recipe_sha256 = (self.bank.recipe if self.recipe is None else self.recipe).sha256
        self.bank_sha256 = None if self.bank is None else self.bank.sha256

    def crack(self, data: bytes, name: str, seed: int, sample_idx: int, n_samples: int) -> list[tuple[str, bytes]]:
        return crack_file(
            data, name, self.recipe, seed, bank=self.bank, sample_index=sample_idx, n_samples=n_samples
        )


@functools.lru_cache(maxsize=2)
def _engine(toml: str | None, bank: str | None) -> _Engine:
    """Once per worker."""
    return _Engine(toml, bank)


def _crack_batch(batch: dict[str, Any], *, toml, bank, seed, n_samples, source, output) -> dict[str, list[str]]:
    engine = _engine(toml, bank)
    rows: dict[str, list[str]] = {"name": [], "state": [], "error": []}
    for name, sample_idx in zip(batch["name"], batch["sample_idx"]):
        name = str(name)
        state, error = "made", ""
        try:
            if not _make(engine, name, int(sample_idx), seed, n_samples, source, output):
                state = "kept"
        except (ValueError, OSError, RuntimeError) as reason:
            state, error = "failed", str(reason)
        rows["name"].append(name)
        rows["state"].append(state)
        rows["error"].append(error)
    return rows


def _make(engine, name, sample_idx, seed, n_samples, source, output) -> bool:
    """Whether there was something to do: an image whose record is there is whole."""
    source_fs, source_root = source
    output_fs, output_root = output
    image_name = name if n_samples == 1 else f"sample_{sample_idx}/{name}"
    record = posixpath.join(output_root, "starbreak", "provenance", posixpath.splitext(image_name)[0] + ".json")
    if output_fs.get_file_info(record).type == arrow_fs.FileType.File:
        return False
    with source_fs.open_input_stream(posixpath.join(source_root, name)) as stream:
        data = stream.read()
    for file_name, content in engine.crack(data, name, seed, sample_idx, n_samples):
        _write(output_fs, posixpath.join(output_root, file_name), content)
    return True


def _write(filesystem: arrow_fs.FileSystem, path: str, content: bytes) -> None:
    """All of it or nothing: an object store does that itself, a file gets its name at the end."""
    if not isinstance(filesystem, arrow_fs.LocalFileSystem):
        with filesystem.open_output_stream(path) as stream:
            stream.write(content)
        return
    folder, name = posixpath.split(path)
    filesystem.create_dir(folder, recursive=True)
    temporary = posixpath.join(folder, f".starbreak-{uuid.uuid4().hex}-{name}")
    with filesystem.open_output_stream(temporary) as stream:
        stream.write(content)
    filesystem.move(temporary, path)


def _open(place: str, filesystem: arrow_fs.FileSystem | None) -> tuple[arrow_fs.FileSystem, str]:
    if filesystem is not None:
        return filesystem, place.rstrip("/")
    if "://" in place:
        found, path = arrow_fs.FileSystem.from_uri(place)
        return found, path.rstrip("/")
    return arrow_fs.LocalFileSystem(), posixpath.abspath(place)


def _names(filesystem: arrow_fs.FileSystem, root: str) -> list[str]:
    found = filesystem.get_file_info(arrow_fs.FileSelector(root, recursive=True))
    names = [info.path[len(root) :].lstrip("/") for info in found if info.type == arrow_fs.FileType.File]
    return sorted(
        name
        for name in names
        if name.lower().endswith(_EXTENSIONS) and not any(part.startswith(".") for part in name.split("/"))
    )


def _claim(filesystem: arrow_fs.FileSystem, root: str, identity: dict[str, Any]) -> None:
    """Refuses an output that something else has made; two recipes never mix in one folder."""
    path = posixpath.join(root, "starbreak", "ray.json")
    text = json.dumps(identity, indent=2, sort_keys=True) + "\n"
    if filesystem.get_file_info(path).type != arrow_fs.FileType.File:
        _write(filesystem, path, text.encode())
        return
    with filesystem.open_input_stream(path) as stream:
        found = json.loads(stream.read())
    for key, wanted in identity.items():
        if found.get(key) != wanted:
            raise ValueError(
                f"{root}: made with {key} {found.get(key)!r}, not {wanted!r}; give another output, or the same "
                "recipe and seed"
            )


def _recipe_of(recipe: Recipe | str | dict[str, Any] | None) -> Recipe:
    if isinstance(recipe, Recipe):
        return recipe
    if isinstance(recipe, dict):
        return Recipe.from_dict(recipe)
    return Recipe(recipe or "windshield-star")
