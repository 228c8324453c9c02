"""The package itself: how fast it imports, what it needs, whether its stubs are true."""

import pickle
import subprocess
import sys
from importlib import metadata, resources
from pathlib import Path

import numpy as np
import pytest
import starbreak

PROJECT = Path(__file__).parent.parent / "pyproject.toml"


def test_import_is_quick_and_brings_only_itself():
    code = (
        "import sys, time, numpy; before = set(sys.modules); start = time.perf_counter(); import starbreak; "
        "print(time.perf_counter() - start, *sorted(set(sys.modules) - before))"
    )
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split() for _ in range(5)]
    assert min(float(seconds) for seconds, *_ in runs) < 0.1
    others = {name for _, *names in runs for name in names if name.split(".")[0] != "starbreak"}
    assert others <= set(sys.stdlib_module_names), others


def test_numpy_is_the_only_dependency():
    needed = [need for need in metadata.requires("starbreak") or [] if "extra" not in need]
    assert [need.split(">")[0] for need in needed] == ["numpy"]
    assert metadata.version("starbreak") == starbreak.__version__


def test_stubs_are_those_of_the_built_module():
    assert resources.files("starbreak").joinpath("py.typed").is_file()
    check = [sys.executable, "-m", "mypy.stubtest", "--mypy-config-file", str(PROJECT), "starbreak._starbreak"]
    done = subprocess.run(check, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_types_are_what_the_stubs_say(tmp_path):
    program = tmp_path / "program.py"
    program.write_text(
        "import numpy as np, numpy.typing as npt, starbreak\n"
        "image = np.zeros((9, 9, 3), np.uint8)\n"
        "a: npt.NDArray[np.uint8] = starbreak.crack(image)\n"
        "b: starbreak.Cracked = starbreak.crack(image, full=True)\n"
        "c: starbreak.Cracked = starbreak.crack(image, boxes=[[0, 0, 1, 1]])\n"
        "d: npt.NDArray[np.uint8] = starbreak.corrupt(image, 'paper', severity=3)\n"
        "def of(bank: starbreak.PatternBank, ready: starbreak.ReadyCrack, full: bool) -> None:\n"
        "    starbreak.crack(image, full=full)\n"
        "    bank.crack(image, full=full)\n"
        "    ready.over(image, full=full)\n"
        "    for network in bank:\n"
        "        network.save('network.json')\n"
        "starbreak.evaluate(clean='a', tau=np.array([0.1]), max_dets=np.array([1]))\n"
        "starbreak.crack_file(bytearray(b''), 'a.png')\n"
    )
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    program.write_text("import starbreak\nx: int = starbreak.simulate()\nstarbreak.crack(3)\nstarbreak.Recipe(sevrity=2)\n")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", program], capture_output=True, text=True, check=False)
    assert done.stdout.count("error:") >= 3, done.stdout


def test_values_survive_a_pickle(small):
    network = starbreak.simulate(small, 3, (128, 96))
    for value in (small, network):
        again = pickle.loads(pickle.dumps(value))
        assert again == value and type(again) is type(value)
    assert hash(pickle.loads(pickle.dumps(small))) == hash(small)
    with pytest.raises(AttributeError):
        small.anything = 1


def copy_of(value):
    return pickle.loads(pickle.dumps(value))


def test_a_ready_crack_is_made_again_from_its_pickle(small, image):
    network = starbreak.simulate(small, 3, (128, 96))
    for words in ({}, {"network": network}):
        ready = starbreak.ReadyCrack(small, 5, (128, 96), **words)
        again = copy_of(ready)
        assert (again.size, again.facts, again.network) == (ready.size, ready.facts, ready.network)
        np.testing.assert_array_equal(again.over(image), ready.over(image))
        assert len(pickle.dumps(ready)) < 20_000 + len(pickle.dumps(network))


def test_a_ready_crack_of_a_bank_is_read_again(command, tmp_path, image):
    command("patterns", "-n", 3, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    ready = starbreak.PatternBank(tmp_path).pattern(-1, (128, 96))
    again = copy_of(ready)
    assert again.facts == ready.facts
    np.testing.assert_array_equal(again.over(image), ready.over(image))


def test_a_cracked_image_has_an_image_and_masks_of_its_size():
    image = np.zeros((9, 12, 3), np.uint8)
    mask = image[..., 0]

    def made(image=image, region=mask, crack=mask, network=None, intact=False):
        return starbreak.Cracked(image, region, crack, network, {}, [], intact)

    assert made().region is mask
    for wrong, says in [
        ({"image": 1.0}, "image is of type float"),
        ({"image": np.zeros((1, 1, 1, 9, 12), np.uint8)}, r"image has shape \(1, 1, 1, 9, 12\)"),
        ({"region": image}, r"region has shape \(9, 12, 3\); expected \(height, width\)"),
        ({"crack": mask.astype(float)}, "crack has dtype float64"),
        ({"crack": mask[1:]}, "crack is 12 x 8 px, the image 12 x 9 px"),
        ({"network": 5}, "network = 5"),
        ({"intact": 1}, "intact = 1"),
    ]:
        with pytest.raises((TypeError, ValueError), match=says):
            made(**wrong)


def test_a_cracked_image_is_all_in_its_pickle(small, image):
    full = starbreak.crack(image, small, 5, boxes=[[0, 0, 60, 60]])
    again = copy_of(full)
    for name in ("image", "region", "crack"):
        np.testing.assert_array_equal(getattr(again, name), getattr(full, name))
    for name in ("network", "facts", "damage", "intact"):
        assert getattr(again, name) == getattr(full, name)
    assert repr(again) == repr(full)


def test_a_limit_of_memory_refuses_before_the_work_and_survives_a_pickle(image):
    recipe = starbreak.Recipe("windshield-star", max_memory=64 << 20)
    for one in (recipe, copy_of(recipe), starbreak.Recipe("windshield-star").replace(max_memory=64 << 20)):
        assert one == recipe and one.to_toml() == starbreak.Recipe("windshield-star").to_toml()
        with pytest.raises(ValueError, match='set fracture.mesh = "fast", or raise that limit .*max_memory'):
            starbreak.crack(image, one)
    with pytest.raises(ValueError, match="max_memory = 5; expected a whole number from 67108864"):
        starbreak.Recipe(max_memory=5)
