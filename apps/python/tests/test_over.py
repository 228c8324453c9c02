"""`ReadyCrack.over` into arrays that are there already: the same codes, no frame allocated, nothing else touched."""

import pickle
import sys
import threading
import tracemalloc

import numpy as np
import pytest
import starbreak
from conftest import picture

SIZE = (128, 96)

#: What works where the pixels lie, and what needs the frame as a whole: rain and cracks, coats, sensor, lens, blur.
RECIPES = {
    "star": starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast"}),
    "noisy": starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast", "optics.noise_shot": 1e-3}),
    "rain": starbreak.Recipe("rain"),
    "muddy": starbreak.Recipe("muddy"),
    "noise": starbreak.Recipe("noise"),
    "defocus": starbreak.Recipe("defocus"),
    "short": starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast", "camera.focus_distance_m": "short"}),
    "glare": starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast", "optics.veiling_glare": 0.1}),
}


@pytest.fixture(scope="module", params=[*RECIPES, "paper"])
def crack(request, small):
    recipe = small if request.param == "paper" else RECIPES[request.param]
    return starbreak.ReadyCrack(recipe, 5, SIZE)


@pytest.fixture(scope="module")
def star():
    return starbreak.ReadyCrack(RECIPES["star"], 5, SIZE)


def bgra_of(image, alpha=7):
    return np.dstack([image[..., ::-1], np.full(image.shape[:2], alpha, np.uint8)])


def test_out_has_the_codes_of_over_in_any_order_of_colors(crack, image):
    expected = crack.over(image, 3)
    assert (expected != image).any()
    out = np.zeros_like(image)
    assert crack.over(image, 3, out=out) is out
    np.testing.assert_array_equal(out, expected)
    for channels, order in [("rgb", [0, 1, 2]), ("bgr", [2, 1, 0])]:
        given = np.ascontiguousarray(image[..., order])
        np.testing.assert_array_equal(crack.over(given, 3, channels=channels)[..., order], expected)
        crack.over(given, 3, out=given, channels=channels)
        np.testing.assert_array_equal(given[..., order], expected)
    bgra = bgra_of(image)
    crack.over(bgra, 3, out=bgra, channels="bgra")
    np.testing.assert_array_equal(bgra[..., 2::-1], expected)
    assert (bgra[..., 3] == 7).all()
    rgba = np.dstack([image, bgra[..., 3]])
    np.testing.assert_array_equal(crack.over(rgba, 3, out=np.empty_like(rgba), channels="rgba")[..., :3], expected)
    np.testing.assert_array_equal(crack.over(rgba, 3, out=np.empty_like(rgba)), crack.over(rgba, 3))
    gray = image[..., 0].copy()
    np.testing.assert_array_equal(crack.over(gray, 3, out=np.empty_like(gray), channels="gray"), crack.over(gray, 3))


def views(buffer):
    """Views of a buffer of 4 bytes a pixel, larger than the picture: rows, pixels and samples in every way."""
    height, width = SIZE[1], SIZE[0]
    tall, wide = buffer[: 2 * height], buffer[:height]
    return {
        "part": wide[:, 5 : width + 5, :3],
        "padded": wide[:, :width],
        "flipped": wide[::-1, :width],
        "mirrored": wide[:, width - 1 :: -1],
        "turned": wide[:, :width, 2::-1],
        "every other row": tall[::2, :width],
        "every other pixel": wide[:, : 2 * width : 2],
        "transposed": buffer[:width, :height].transpose(1, 0, 2),
        "planes": buffer.reshape(-1)[: 3 * height * width].reshape(3, height, width).transpose(1, 2, 0),
    }


@pytest.mark.parametrize("way", list(views(np.zeros((300, 300, 4), np.uint8))))
def test_any_strides_are_written_and_nothing_beside(crack, image, way):
    buffer = np.random.default_rng(0).integers(0, 255, (300, 300, 4), np.uint8)
    out = views(buffer)[way]
    n = out.shape[2]
    source = image if n == 3 else np.dstack([image, out[..., 3]])
    mark = np.zeros(buffer.shape, bool)
    views(mark)[way][...] = True
    before = buffer.copy()
    expected = crack.over(source, 3)
    crack.over(source, 3, out=out)
    np.testing.assert_array_equal(out, expected)
    np.testing.assert_array_equal(buffer[~mark], before[~mark])
    # And in place.
    out[...] = source
    crack.over(out, 3, out=out)
    np.testing.assert_array_equal(out, expected)
    np.testing.assert_array_equal(buffer[~mark], before[~mark])


def test_views_of_the_input_that_overlap_in_part_are_refused(star):
    buffer = np.zeros((97, 130, 4), np.uint8)
    image = buffer[:96, :128]
    same = buffer[:96, :128]
    assert star.over(image, out=same) is same
    for out in (buffer[1:, :128], buffer[:96, 1:129], buffer[95::-1, :128], buffer[:96, 127::-1]):
        with pytest.raises(ValueError, match="image and out overlap in part; give two arrays that share no memory"):
            star.over(image, out=out)
    with pytest.raises(ValueError, match="overlap in part"):
        star.over(image[..., :3], out=image[..., 1:])
    # Side by side is no overlap.
    both = np.zeros((96, 256, 3), np.uint8)
    star.over(both[:, :128], out=both[:, 128:])
    star.over(both[:, ::2], out=both[:, 1::2])


def test_what_cannot_be_written_is_refused(star, image):
    read_only = np.empty_like(image)
    read_only.flags.writeable = False
    twice = np.lib.stride_tricks.as_strided(np.zeros((96, 128 * 3), np.uint8), image.shape, (128 * 3, 0, 1))
    for out, error, says in [
        (read_only, ValueError, "out is read-only; expected a writable array"),
        (np.broadcast_to(np.zeros(3, np.uint8), image.shape), ValueError, "out has several pixels in one place"),
        (twice, ValueError, "out has several pixels in one place of memory"),
        (np.zeros((96, 128, 4), np.uint8), ValueError, r"out has shape \(96, 128, 4\), image has \(96, 128, 3\)"),
        (np.zeros((96, 128, 3), np.float32), ValueError, "out has dtype float32; expected uint8"),
        (bytearray(96 * 128 * 3), TypeError, "out is of type bytearray; expected a numpy.ndarray"),
        (np.ma.array(image, mask=True), ValueError, "out has masked entries"),
    ]:
        with pytest.raises(error, match=says):
            star.over(image, out=out)
    with pytest.raises(ValueError, match="96 × 127 px|127 × 96 px"):
        star.over(image[:, 1:], out=np.zeros((96, 127, 3), np.uint8))
    for words in ({"full": True}, {"boxes": [[0, 0, 9, 9]]}):
        with pytest.raises(ValueError, match="out takes the image alone"):
            star.over(image, out=image, **words)


@pytest.mark.parametrize("words", [{}, {"out": np.zeros((96, 128, 3), np.uint8)}])
def test_channels_that_an_image_does_not_have_are_refused(star, image, words):
    for channels, error, says in [
        ("bgra", ValueError, 'channels = "bgra" is of 4 samples per pixel, but image has 3; expected "rgb" or "bgr"'),
        ("gray", ValueError, 'channels = "gray" is of 1 samples'),
        ("BGR", ValueError, """channels = 'BGR' .str.; expected "rgb", "bgr", "rgba", "bgra" or "gray\""""),
        (3, TypeError, "channels = 3 .int.; expected"),
    ]:
        with pytest.raises(error, match=says):
            star.over(image, channels=channels, **words)


def test_a_cracked_image_keeps_the_order_of_its_colors(star, image):
    full = star.over(image, 3, full=True)
    bgr = star.over(image[..., ::-1], 3, channels="bgr", full=True)
    np.testing.assert_array_equal(bgr.image[..., ::-1], full.image)
    np.testing.assert_array_equal(bgr.region, full.region)
    assert bgr.facts == full.facts


@pytest.mark.parametrize("channels", ["bgra", "bgr"])
def test_no_frame_is_allocated(channels):
    size = (1242, 375)
    crack = starbreak.ReadyCrack("windshield-star", 7, size)
    frame = np.random.default_rng(0).integers(0, 255, (375, 1242, len(channels)), np.uint8)
    out = np.empty_like(frame)
    crack.over(frame, out=out, channels=channels)
    tracemalloc.start()
    try:
        for seed in range(20):
            crack.over(frame, seed, out=out, channels=channels)
            crack.over(out, seed, out=out, channels=channels)
        # NumPy tells of its arrays; the memory of the package itself is counted by a test of the library.
        assert tracemalloc.get_traced_memory()[1] < frame.nbytes / 20
        frame.copy()
        assert tracemalloc.get_traced_memory()[1] >= frame.nbytes, "an array would be seen"
    finally:
        tracemalloc.stop()


def test_one_light_for_all_frames(star, image):
    dark = image // 4
    own = star.over(dark, 3)
    light = star.estimate_environment(image)
    assert star.environment is None
    star.set_environment(light)
    try:
        assert star.environment == light
        held = star.over(dark, 3)
        assert (held != own).any()
        np.testing.assert_array_equal(star.over(image, 3), starbreak.ReadyCrack(RECIPES["star"], 5, SIZE).over(image, 3))
        np.testing.assert_array_equal(star.over(dark, 3, out=np.empty_like(dark)), held)
        full = star.over(dark, 3, full=True)
        np.testing.assert_array_equal(full.image, held)
        assert full.facts["optics"]["environment"] == light
        assert pickle.loads(pickle.dumps(star)).environment is None
    finally:
        star.set_environment(None)
    np.testing.assert_array_equal(star.over(dark, 3, out=np.empty_like(dark)), own)
    assert star.estimate_environment(image[..., ::-1], channels="bgr") == light


def test_a_light_that_is_none_is_refused(star, small, image):
    light = star.estimate_environment(image)
    for wrong, error, says in [
        ("day", TypeError, "environment = 'day' .str.; expected a dict"),
        ({}, ValueError, 'environment has no "cabin"; expected sky_horizon, sky_zenith'),
        ({**light, "ground": [1, 2]}, ValueError, "ground in environment = .1, 2. .list.; expected red, green and blue"),
        ({**light, "ground": [1, 2, -1]}, ValueError, "each from 0 to 1000000"),
        ({**light, "ground": [1, 2, float("nan")]}, ValueError, "each from 0 to 1000000"),
        ({**light, "cabin": [[1, 2, 3]]}, ValueError, "cabin in environment = .*; expected two colors"),
    ]:
        with pytest.raises(error, match=says):
            star.set_environment(wrong)
    assert star.environment is None
    paper = starbreak.ReadyCrack(small, 1, SIZE)
    assert paper.estimate_environment(image) is None
    paper.set_environment(None)
    with pytest.raises(ValueError, match="the paper's optics know no light"):
        paper.set_environment(light)


def test_a_light_is_followed_without_flicker(star, image):
    light = star.estimate_environment(image)
    brighter = {**light, "ground": [1.005 * channel for channel in light["ground"]]}
    filter = starbreak.LightFilter()
    for k in range(100):
        assert filter.next(brighter if k % 2 else light, 0.04) == light
    assert filter.n_lights == 1
    lower = {**light, "ground": [0.8 * channel for channel in light["ground"]]}
    for _ in range(250):
        followed = filter.next(lower, 0.04)
    assert followed["ground"] == pytest.approx(lower["ground"], rel=0.02)
    assert filter.next(None, 0.04) == followed
    with pytest.raises(ValueError, match="elapsed_s = -1"):
        filter.next(light, -1)
    with pytest.raises(TypeError, match="elapsed_s = 'a'"):
        filter.next(light, "a")


def test_two_threads_put_one_crack_over_frames_of_their_own(crack):
    frames = [picture(seed=seed) for seed in range(8)]
    expected = [crack.over(frame, seed) for seed, frame in enumerate(frames)]
    wrong = []

    def work():
        out = np.empty_like(frames[0])
        for _ in range(10):
            for seed, frame in enumerate(frames):
                crack.over(frame, seed, out=out)
                if (out != expected[seed]).any():
                    wrong.append(seed)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_two_threads_do_not_write_one_array(star, image):
    """A second call for an array that a first one writes is refused, never mixed."""
    out = image.copy()
    outcomes = []

    def work():
        for _ in range(200):
            try:
                star.over(out, out=out)
                outcomes.append("done")
            except ValueError as error:
                outcomes.append(str(error))

    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(outcomes) == 400
    assert set(outcomes) <= {"done", "out is in use by another call; give each call an array of its own"}


@pytest.mark.skipif(sys.platform != "linux", reason="memory is read in /proc")
def test_memory_is_flat_over_frames_into_one_array(small):
    from test_memory import resident_kib

    for recipe in (small, RECIPES["star"], RECIPES["noise"]):
        crack = starbreak.ReadyCrack(recipe, 5, SIZE)
        frame = bgra_of(picture())

        def calls(n):
            for seed in range(n):
                crack.over(frame, seed, out=frame, channels="bgra")
                crack.over(frame[:, ::-1], seed, out=np.empty_like(frame), channels="bgra")

        calls(100)
        before = resident_kib()
        calls(300)
        # A leaked frame of 49 kB a call would be 28,000 KiB.
        assert resident_kib() - before < 4000
