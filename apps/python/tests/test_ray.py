"""The pipeline on a real local Ray: two worker processes, one of which is killed."""

import json
import os
import pathlib
import shutil
import signal

import numpy as np
import pytest
import starbreak
import starbreak.ray
from conftest import SMALL, picture
from fsspec.implementations.local import LocalFileSystem
from PIL import Image
from pyarrow import fs

# With faults behind the lens, too.
RECIPE = starbreak.Recipe("paper", set={**SMALL, "noise.white_e": 300, "pixels.hot_per_mpx": 2000})
N_IMAGES = 12


# One cluster at a time: workers are killed by what they are called.
pytestmark = [pytest.mark.usefixtures("cluster"), pytest.mark.xdist_group("ray")]


@pytest.fixture(scope="session")
def source(tmp_path_factory):
    """A folder with PNG and JPEG files at two levels, and what is not to be read."""
    folder = tmp_path_factory.mktemp("source")
    (folder / "sub").mkdir()
    for k in range(N_IMAGES):
        name = f"sub/{k}.jpg" if k % 3 == 0 else f"{k}.png"
        Image.fromarray(picture(seed=k)).save(folder / name)
    Image.fromarray(picture()).save(folder / ".hidden.png")
    (folder / "notes.txt").write_text("no image")
    return folder


@pytest.fixture(scope="session")
def of_the_command(command, source, tmp_path_factory):
    """What `starbreak generate` makes of the source: K samples by a recipe or a bank."""
    made = {}

    def files(n_samples=1, bank=None):
        if (n_samples, bank) not in made:
            folder = tmp_path_factory.mktemp("command")
            (folder / "recipe.toml").write_text(RECIPE.to_toml())
            by = ["--recipe", folder / "recipe.toml"] if bank is None else ["--bank", bank]
            command("generate", f"folder:{source}", "-o", folder / "out", "--seed", 5, "--samples", n_samples, *by)
            made[n_samples, bank] = files_in(folder / "out")
        return made[n_samples, bank]

    return files


def files_in(folder):
    """Images, masks and records by their names; not what a run keeps or carries along."""
    folder = pathlib.Path(folder)
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    keep = ("starbreak/regions/", "starbreak/cracks/", "starbreak/provenance/")
    return {
        name: path.read_bytes()
        for name, path in files.items()
        if name.startswith(keep) or not (name.startswith("starbreak/") or name.endswith(".txt"))
    }


def run(source, output, **words):
    return starbreak.ray.crack_dataset(source, output, **{"recipe": RECIPE, "seed": 5, "batch_size": 2, **words})


@pytest.mark.parametrize("words", [{}, {"concurrency": 1, "batch_size": 5}], ids=["two workers", "one worker"])
def test_the_files_are_those_of_the_command(source, of_the_command, tmp_path, words):
    counts = run(source, tmp_path / "out", **words)
    assert counts == {"n_made": N_IMAGES, "n_kept": 0, "n_failed": 0, "failed": []}
    assert len(of_the_command()) == 4 * N_IMAGES
    assert files_in(tmp_path / "out") == of_the_command()

    times = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}
    assert run(source, tmp_path / "out", **words)["n_kept"] == N_IMAGES
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")} == times, "nothing is written"


def test_samples_uris_and_file_systems(source, of_the_command, tmp_path):
    counts = run(f"file://{source}", f"file://{tmp_path}/out", n_samples=2)
    assert counts["n_made"] == 2 * N_IMAGES
    assert files_in(tmp_path / "out") == of_the_command(n_samples=2)


def test_an_object_store_is_a_file_system(source, of_the_command, tmp_path):
    """Where files are not put in place by renaming, as in an object store."""
    store = fs.SubTreeFileSystem(str(tmp_path), fs.LocalFileSystem())
    shutil.copytree(source, tmp_path / "bucket/in")
    for folder in ("", "sub"):
        for kind in ("", "starbreak/regions", "starbreak/cracks", "starbreak/provenance"):
            (tmp_path / "bucket/out" / kind / folder).mkdir(parents=True, exist_ok=True)
    assert run("bucket/in", "bucket/out", filesystem=store)["n_made"] == N_IMAGES
    assert files_in(tmp_path / "bucket/out") == of_the_command()


def test_a_bank_gives_the_files_of_the_command(command, source, of_the_command, tmp_path):
    bank = tmp_path / "bank"
    command("patterns", "-n", 3, "-o", bank, "--size", "128x96", "--set", "fracture.mesh=fast")
    assert run(source, tmp_path / "out", recipe=None, bank=bank)["n_made"] == N_IMAGES
    assert files_in(tmp_path / "out") == of_the_command(bank=bank)
    with pytest.raises(ValueError, match="bank_sha256"):
        run(source, tmp_path / "out", recipe=starbreak.PatternBank(bank).recipe)


class DeadlyDisk(fs.LocalFileSystem):
    """Kills the process that first puts the crack mask of image 5 in its place."""

    def __init__(self, marker):
        super().__init__()
        self.marker = marker

    def __reduce__(self):
        return DeadlyDisk, (self.marker,)

    def move(self, src, dest):
        if dest.endswith("starbreak/cracks/5.png") and not os.path.exists(self.marker):
            pathlib.Path(self.marker).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        super().move(src, dest)


class DeadlyFiles(LocalFileSystem):
    """Kills the process that first opens the crack mask of image 5 for writing."""

    def __init__(self, marker):
        super().__init__(auto_mkdir=True)
        self.marker = marker

    def _open(self, path, mode="rb", **words):
        if path.endswith("starbreak/cracks/5.png") and mode == "wb" and not os.path.exists(self.marker):
            pathlib.Path(self.marker).touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return super()._open(path, mode=mode, **words)


@pytest.mark.parametrize("place", ["disk", "store"])
def test_the_death_of_a_worker_loses_nothing(source, of_the_command, tmp_path, place):
    marker = tmp_path / "killed"
    files = DeadlyDisk(str(marker))
    if place == "store":
        files = fs.PyFileSystem(fs.FSSpecHandler(DeadlyFiles(str(marker))))
    # Batches by name: 1, 10, 11, 2, 4 are whole when the worker dies, 5 has no record yet.
    counts = run(str(source), str(tmp_path / "out"), filesystem=files, batch_size=N_IMAGES // 2)
    assert marker.exists(), "no worker was killed"
    assert counts == {"n_made": N_IMAGES - 5, "n_kept": 5, "n_failed": 0, "failed": []}
    left = list((tmp_path / "out").rglob(".starbreak-*"))
    assert [path.name.split("-")[-1] for path in left] == (["5.png"] if place == "disk" else [])
    for path in left:
        path.unlink()
    assert files_in(tmp_path / "out") == of_the_command()


def test_broken_images_are_named_and_the_rest_is_made(source, of_the_command, tmp_path):
    shutil.copytree(source, tmp_path / "in")
    (tmp_path / "in/broken.png").write_bytes(b"no image")
    whole = (tmp_path / "in/1.png").read_bytes()
    (tmp_path / "in/1.png").write_bytes(whole[: len(whole) // 2])
    counts = run(tmp_path / "in", tmp_path / "out")
    assert [entry["name"] for entry in counts["failed"]] == ["1.png", "broken.png"]
    assert (counts["n_made"], counts["n_failed"]) == (N_IMAGES - 1, 2)
    assert "broken.png" in counts["failed"][1]["error"]
    rest = {name: data for name, data in of_the_command().items() if pathlib.Path(name).stem != "1"}
    assert files_in(tmp_path / "out") == rest

    (tmp_path / "in/1.png").write_bytes(whole)
    again = run(tmp_path / "in", tmp_path / "out")
    assert (again["n_made"], again["n_kept"], again["n_failed"]) == (1, N_IMAGES - 1, 1)
    assert files_in(tmp_path / "out") == of_the_command()


def test_what_makes_no_sense_is_refused_before_a_worker_starts(source, tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "alike").mkdir()
    for name in ("a.png", "A.jpg"):
        (tmp_path / "alike" / name).write_bytes(b"")
    (tmp_path / "out/starbreak").mkdir(parents=True)
    identity = {"bank_sha256": None, "recipe_sha256": RECIPE.sha256, "samples": 1, "seed": 4}
    (tmp_path / "out/starbreak/ray.json").write_text(json.dumps(identity))
    new = tmp_path / "new"
    for match, words in [
        ("seed 4", {"output": tmp_path / "out"}),
        ("no PNG", {"source": tmp_path / "empty"}),
        ("only in its extension", {"source": tmp_path / "alike"}),
        ("does not lie", {"output": source / "out"}),
        ("does not lie", {"source": tmp_path / "empty", "output": tmp_path}),
        ("give one of both", {"bank": "bank"}),
        ("n_samples", {"n_samples": 0}),
        ("batch_size", {"batch_size": 0}),
        ("seed", {"seed": -1}),
        ("preset", {"recipe": "no such preset"}),
    ]:
        with pytest.raises(ValueError, match=match):
            run(**{"source": source, "output": new, **words})
    with pytest.raises(FileNotFoundError):
        run(tmp_path / "nowhere", new)
    assert not new.exists()
    assert np.asarray(Image.open(source / "1.png")).shape == (96, 128, 3)


def test_an_output_with_other_files_is_refused(command, source, tmp_path):
    command("generate", f"folder:{source}", "-o", tmp_path / "set", "--seed", 9, "--limit", 1)
    before = {path: path.read_bytes() for path in (tmp_path / "set").rglob("*") if path.is_file()}
    with pytest.raises(ValueError, match="of no earlier run; give a new or empty folder"):
        run(source, tmp_path / "set")
    assert {path: path.read_bytes() for path in (tmp_path / "set").rglob("*") if path.is_file()} == before


def test_what_is_missing_or_made_from_another_file_is_made_again(source, of_the_command, tmp_path):
    shutil.copytree(source, tmp_path / "in")
    swapped, name = tmp_path / "in/1.png", "starbreak/provenance/2.json"
    good = swapped.read_bytes()
    swapped.write_bytes((tmp_path / "in/4.png").read_bytes())
    run(tmp_path / "in", tmp_path / "out")
    swapped.write_bytes(good)
    (tmp_path / "out/5.png").unlink()
    (tmp_path / "out/starbreak/regions/7.png").unlink()
    (tmp_path / "out" / name).write_text("{")
    counts = run(tmp_path / "in", tmp_path / "out")
    assert (counts["n_made"], counts["n_kept"]) == (4, N_IMAGES - 4)
    assert files_in(tmp_path / "out") == of_the_command()

    (tmp_path / "out/starbreak/ray.json").write_text("[]")
    (tmp_path / "in/1.png").unlink()
    with pytest.raises(ValueError, match=r"ray\.json: is damaged"):
        run(tmp_path / "in", tmp_path / "out")


@pytest.mark.parametrize(("key", "value"), [("output.format", "jpeg"), ("output.maps", True)])
def test_a_recipe_for_other_files_than_a_set_has_is_refused(source, tmp_path, key, value):
    with pytest.raises(ValueError, match=key):
        run(source, tmp_path / "out", recipe=starbreak.Recipe("paper", set={**SMALL, key: value}))
    assert not (tmp_path / "out").exists()


def test_a_bank_with_such_a_recipe_is_refused_as_well(command, source, tmp_path):
    words = ["--size", "128x96", "--set", "fracture.mesh=fast", "--set", "output.maps=true"]
    command("patterns", "-n", 1, "-o", tmp_path / "bank", *words)
    with pytest.raises(ValueError, match=r"output\.maps"):
        run(source, tmp_path / "out", recipe=None, bank=tmp_path / "bank")
    assert not (tmp_path / "out").exists()
