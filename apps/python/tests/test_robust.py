"""Whatever array comes in: right, or a clear error, never a crash."""

import threading

import numpy as np
import pytest
import starbreak
from conftest import picture


class Subclass(np.ndarray):
    """An array with a name of its own."""


def laid_out(image):
    """The same picture in memory laid out in other ways."""
    wide = np.zeros((image.shape[0] * 2, image.shape[1] * 3, 3), np.uint8)
    wide[::2, ::3] = image
    odd = np.zeros(image.nbytes + 1, np.uint8)[1:].reshape(image.shape)
    odd[:] = image
    frozen = image.copy()
    frozen.flags.writeable = False
    return {
        "strides": wide[::2, ::3],
        "rows upside down": image[::-1].copy()[::-1],
        "channels swapped": image[..., ::-1].copy()[..., ::-1],
        "all backwards": image[::-1, ::-1, ::-1].copy()[::-1, ::-1, ::-1],
        "Fortran order": np.asfortranarray(image),
        "planar": np.ascontiguousarray(image.transpose(2, 0, 1)).transpose(1, 2, 0),
        "crop": np.pad(image, ((3, 4), (5, 6), (0, 0)))[3:-4, 5:-6],
        "odd address": odd,
        "read-only": frozen,
        "from bytes": np.frombuffer(image.tobytes(), np.uint8).reshape(image.shape),
        "big-endian": image.astype(">u1"),
        "subclass": image.view(Subclass),
        "masked": np.ma.masked_array(image),
    }


def test_any_layout_gives_the_same_picture(image, small):
    expected = starbreak.crack(image, small, 1)
    assert (expected != image).any()
    for name, other in laid_out(image).items():
        before = other.copy()
        cracked = starbreak.crack(other, small, 1)
        np.testing.assert_array_equal(cracked, expected, err_msg=name)
        np.testing.assert_array_equal(other, before, err_msg=f"{name}: the input was changed")
        assert type(cracked) is np.ndarray, name
        assert cracked.flags.c_contiguous and cracked.flags.writeable and cracked.dtype == np.uint8, name
        assert not np.shares_memory(cracked, other), name


def test_a_gray_picture_in_any_layout(image, small):
    gray = np.ascontiguousarray(image[..., 1])
    expected = starbreak.crack(gray, small, 1)
    assert expected.shape == gray.shape
    for name, other in {"channel": image[..., 1], "flipped": gray[:, ::-1].copy()[:, ::-1]}.items():
        np.testing.assert_array_equal(starbreak.crack(other, small, 1), expected, err_msg=name)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (picture().astype(np.float32), "dtype float32; expected uint8"),
        (picture().astype(np.float64) / 255, "dtype float64"),
        (picture().astype(np.int8), "dtype int8"),
        (picture().astype(np.uint16), "dtype uint16"),
        (picture().astype(">u2"), "dtype >u2"),
        (picture().astype(bool), "dtype bool"),
        (picture().astype(object), "dtype object"),
        (picture().astype("S1"), "dtype"),
        (np.zeros((4, 4), "M8[s]"), "dtype datetime64"),
        (np.zeros((4, 4), [("r", "u1")]), "dtype"),
        (np.zeros((96, 128, 5), np.uint8), "shape (96, 128, 5)"),
        (np.zeros((96, 128, 1), np.uint8), "shape (96, 128, 1)"),
        (np.zeros((3, 96, 128), np.uint8), "shape (3, 96, 128)"),
        (np.zeros((2, 96, 128, 3), np.uint8), "shape (2, 96, 128, 3)"),
        (np.zeros(7, np.uint8), "shape (7,)"),
        (np.uint8(3) + np.zeros((), np.uint8), "ndarray"),
        (np.zeros((0, 0, 3), np.uint8), "the frame is 0 x 0 px"),
        (np.zeros((0, 5), np.uint8), "the frame is 5 x 0 px"),
        (np.zeros((5, 0, 3), np.uint8), "the frame is 0 x 5 px"),
        (np.broadcast_to(np.uint8(1), (40_000, 40_000, 3)), "the frame is 40000 x 40000 px"),
        (np.broadcast_to(np.uint8(1), (1, 32_769)), "the frame is 32769 x 1 px"),
        (np.broadcast_to(np.uint8(1), (2**40, 2**20)), "the frame is"),
        (None, "NoneType"),
        ([[1, 2], [3, 4]], "list"),
        ("photo.png", "str"),
        (b"bytes", "bytes"),
        (memoryview(b"abcd"), "memoryview"),
    ],
    ids=lambda value: value if isinstance(value, str) else type(value).__name__,
)
def test_what_is_no_picture_is_refused(wrong, says, small):
    for call in (lambda: starbreak.crack(wrong, small), lambda: starbreak.corrupt(wrong, "paper")):
        with pytest.raises((ValueError, TypeError)) as raised:
            call()
        assert says in str(raised.value)
        assert "\n" not in str(raised.value)


@pytest.mark.parametrize("shape", [(1, 1, 3), (1, 1), (1, 9, 3), (9, 1), (2, 3, 3), (17, 4000, 3)])
def test_pictures_of_any_size_keep_it(shape):
    image = np.full(shape, 90, np.uint8)
    for preset in ("windshield-star", "paper"):
        recipe = starbreak.Recipe(preset, set={"fracture.mesh": "fast"} if preset != "paper" else None)
        try:
            cracked = starbreak.crack(image, recipe, 3, full=True)
        except (ValueError, starbreak.SimulationError) as refused:
            assert "\n" not in str(refused), shape
        else:
            assert cracked.image.shape == shape
            assert cracked.region.shape == shape[:2]


@pytest.mark.parametrize(
    "call",
    [
        lambda image: starbreak.crack(image, seed=-1),
        lambda image: starbreak.crack(image, seed=2**64),
        lambda image: starbreak.crack(image, "windshield-sta"),
        lambda image: starbreak.crack(image, {"camera": {"f_number": "two"}}),
        lambda image: starbreak.crack(image, {"camera": {"f_number": float("nan")}}),
        lambda image: starbreak.crack(image, {"camera": object()}),
        lambda image: starbreak.crack(image, {"camera": None}),
        lambda image: starbreak.crack(image, {1: 2}),
        lambda image: starbreak.corrupt(image, "windshield-star", severity=0),
        lambda image: starbreak.corrupt(image, "windshield-star", severity=6),
        lambda image: starbreak.corrupt(image, "windshield-star", severity=-300),
        lambda image: starbreak.corrupt(image, "glass_blur", severity=1),
        lambda image: starbreak.simulate(size=(0, 10)),
        lambda image: starbreak.simulate(size=(10**6, 10**6)),
        lambda image: starbreak.CrackNetwork.from_json("{}"),
        lambda image: starbreak.CrackNetwork.from_json(""),
        lambda image: starbreak.Recipe(camera="kiti"),
        lambda image: starbreak.Recipe(set=["camera.f_number"]),
        lambda image: starbreak.Recipe.from_toml("schema = 2"),
    ],
)
def test_wrong_parameters_are_value_errors(call, image):
    with pytest.raises(ValueError) as raised:
        call(image)
    assert len(str(raised.value)) > 10


def test_values_of_numpy_are_values(image):
    recipe = starbreak.Recipe("paper", set={"fracture.particles": np.int64(300), "impact.position": np.array([0.5, 0.5])})
    assert recipe.to_dict()["impact"][0]["position"] == [0.5, 0.5]
    np.testing.assert_array_equal(
        starbreak.crack(image, recipe, np.uint64(3)), starbreak.crack(image, recipe, 3)
    )


def test_files_are_os_errors(tmp_path):
    for call in (starbreak.Recipe.from_file, starbreak.CrackNetwork.from_file, starbreak.PatternBank):
        with pytest.raises(FileNotFoundError, match="nowhere"):
            call(tmp_path / "nowhere")
    (tmp_path / "patterns.bank").write_bytes(b"not a bank at all, but long enough to look at")
    with pytest.raises(OSError, match="patterns.bank"):
        starbreak.PatternBank(tmp_path)
    with pytest.raises(OSError):
        starbreak.simulate("paper").save(tmp_path)


def test_what_cannot_happen_is_a_simulation_error(image):
    # The frame does not show the cover of a camera that looks past it.
    recipe = starbreak.Recipe(set={"glass.axis_at": [0.0, 0.0], "impact.position": [0.0, 0.0], "fracture.mesh": "fast"})
    with pytest.raises(starbreak.SimulationError, match="shows no glass"):
        starbreak.crack(image, recipe)
    assert issubclass(starbreak.SimulationError, RuntimeError)


def test_threads_get_what_one_gets(image, small):
    recipe = starbreak.Recipe(set={"fracture.mesh": "fast"})
    alone = {(recipe_idx, seed): starbreak.crack(image, (small, recipe)[recipe_idx], seed) for recipe_idx in (0, 1) for seed in range(4)}
    wrong = []

    def work(start):
        for k in range(8):
            key = ((start + k) % 2, (start + k) % 4)
            if (starbreak.crack(image, (small, recipe)[key[0]], key[1]) != alone[key]).any():
                wrong.append(key)

    threads = [threading.Thread(target=work, args=(start,)) for start in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_other_threads_run_meanwhile():
    """The interpreter is free while glass breaks."""
    ticks, done = [0], threading.Event()

    def tick():
        while not done.is_set():
            ticks[0] += 1
            done.wait(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    before = ticks[0]
    # About a tenth of a second.
    starbreak.simulate("windshield-combination", 1)
    during = ticks[0] - before
    done.set()
    thread.join()
    assert during > 5, f"{during} ticks"
