"""What is no argument is named: which one, what was given, what is meant."""

import itertools
import json
import pathlib

import numpy as np
import pytest
import starbreak
from conftest import picture

FRAME = np.full((9, 12, 3), 90, np.uint8)
PAPER = {"fracture": {"model": "paper", "particles": 50}}


def evaluated(**words):
    return starbreak.evaluate(ground_truth="labels.json", clean="clean.json", **words)


def compared(**words):
    return starbreak.divergence("folder:a", "folder:b", **words)


#: A call for each whole number of the package, and its range.
WHOLE = {
    "seed": (lambda n: starbreak.crack(FRAME, PAPER, n), 0, 2**64 - 1),
    "seed of simulate": (lambda n: starbreak.simulate(PAPER, n), 0, 2**64 - 1),
    "seed of item_seed": (lambda n: starbreak.item_seed(n, "a"), 0, 2**64 - 1),
    "sample_index": (lambda n: starbreak.item_seed(1, "a", n), 0, 2**64 - 1),
    "sample_index of crack": (lambda n: starbreak.crack(FRAME, PAPER, name="a", sample_index=n), 0, 2**64 - 1),
    "sample_index of crack without a name": (lambda n: starbreak.crack(FRAME, PAPER, sample_index=n), 0, 2**64 - 1),
    "sample_index of crack_file": (lambda n: starbreak.crack_file(b"", "a.png", PAPER, sample_index=n), 0, 2**32 - 1),
    "n_samples": (lambda n: starbreak.crack_file(b"", "a.png", PAPER, n_samples=n), 1, 2**32 - 1),
    "severity": (lambda n: starbreak.Recipe("paper", severity=n), 1, 5),
    "severity of crack": (lambda n: starbreak.crack(FRAME, "paper", severity=n), 1, 5),
    "severity of corrupt": (lambda n: starbreak.corrupt(FRAME, "paper", n), 1, 5),
    "width in size": (lambda n: starbreak.simulate(PAPER, size=(n, 9)), 1, 32768),
    "height in size": (lambda n: starbreak.ReadyCrack(PAPER, size=(9, n)), 1, 32768),
    "replicates": (lambda n: evaluated(replicates=n), 20, 10**6),
    "worst": (lambda n: evaluated(worst=n), 0, 100),
    "threads": (lambda n: evaluated(threads=n), 0, 1024),
    "max_dets": (lambda n: evaluated(max_dets=[n]), 1, 2**32 - 1),
    "limit": (lambda n: compared(limit=n), 1, 2**64 - 1),
    "bootstrap": (lambda n: compared(bootstrap=n), 0, 10**6),
    "permutations": (lambda n: compared(permutations=n), 0, 10**6),
    "splits": (lambda n: compared(splits=n), 0, 10**6),
    "side": (lambda n: compared(side=n), 0, 8192),
    "threads of divergence": (lambda n: compared(threads=n), 0, 1024),
}


@pytest.mark.parametrize("name", WHOLE)
def test_whole_numbers_are_named_with_value_and_range(name):
    call, least, most = WHOLE[name]
    expected = f"expected a whole number from {least} to {most}"
    for wrong in (least - 1, most + 1, -(10**30), 10**30, np.int64(-1)):
        with pytest.raises(ValueError) as raised:
            call(wrong)
        said = str(raised.value)
        assert said.startswith(f"{name.split(' of ')[0]} = ") and expected in said, (wrong, said)
        assert str(int(wrong)) in said
    for wrong in (2.5, "7", None, True, np.float64(2), np.True_, [1], object()):
        if wrong is None and name in ("severity", "severity of crack", "limit"):
            continue
        with pytest.raises(TypeError) as raised:
            call(wrong)
        said = str(raised.value)
        assert said.startswith(f"{name.split(' of ')[0]} = ") and expected in said, (wrong, said)


def test_numbers_of_numpy_are_whole_numbers():
    for kind in (np.uint8, np.int16, np.uint64, np.int64):
        assert starbreak.item_seed(kind(7), "a", kind(2)) == starbreak.item_seed(7, "a", 2)
        assert starbreak.Recipe("paper", severity=kind(2)) == starbreak.Recipe("paper", severity=2)
    assert starbreak.item_seed(np.array(7), "a") == starbreak.item_seed(7, "a")
    assert starbreak.item_seed(np.uint64(2**64 - 1), "a") == starbreak.item_seed(2**64 - 1, "a")


def test_a_number_that_no_float_holds_is_out_of_range():
    for call in (lambda n: evaluated(score_threshold=n), lambda n: evaluated(tau=[n], regions="r")):
        for wrong in (10**400, -(10**400)):
            with pytest.raises(ValueError, match="inf"):
                call(wrong)


def test_an_index_of_any_size_is_an_index_error(command, tmp_path):
    command("patterns", "-n", 2, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    bank = starbreak.PatternBank(tmp_path)
    assert bank[np.int64(-1)] == bank[1]
    assert len(list(bank)) == 2
    for wrong in (2, -3, 10**30, -(10**30)):
        for call in (
            lambda n: bank[n],
            lambda n: bank.pattern(n, (128, 96)),
            lambda n: bank.crack(picture(), index=n),
        ):
            with pytest.raises(IndexError, match=f"has no pattern {wrong}"):
                call(wrong)
    for wrong in (1.0, "1", True, slice(1)):
        with pytest.raises(TypeError, match="index = .* expected a whole number"):
            bank[wrong]
    with pytest.raises(ValueError, match="sample_index = -1"):
        bank.index_for(1, sample_index=-1)


#: A call with an argument of another kind, and what is said of it.
KINDS = [
    (lambda: starbreak.crack(FRAME, PAPER, network=5), "network = 5 (int); expected a starbreak.CrackNetwork"),
    (lambda: starbreak.crack(FRAME, PAPER, full=1), "full = 1 (int); expected True or False"),
    (lambda: starbreak.ReadyCrack(PAPER, network="a"), "network = 'a' (str); expected a starbreak.CrackNetwork"),
    (lambda: starbreak.ReadyCrack(PAPER, 1, (12, 9)).over(FRAME, full=0), "full = 0 (int); expected True or False"),
    (lambda: starbreak.Recipe(5), "preset = 5 (int); expected text"),
    (lambda: starbreak.Recipe(camera=5), "camera = 5 (int); expected text"),
    (lambda: starbreak.Recipe().replace(camera=5), "camera = 5 (int); expected text"),
    (lambda: starbreak.Recipe().to_toml(comments=1), "comments = 1 (int); expected True or False"),
    (lambda: starbreak.Recipe.from_toml(b"a"), "text = b'a' (bytes); expected text"),
    (lambda: starbreak.Recipe.from_dict(5), "tables = 5 (int); expected a dict of tables"),
    (lambda: starbreak.Recipe.from_file(5), "path = 5 (int); expected text or a path"),
    (lambda: starbreak.CrackNetwork.from_file(b"a"), "path = b'a' (bytes); expected text or a path"),
    (lambda: starbreak.CrackNetwork.from_json(5), "text = 5 (int); expected text"),
    (lambda: starbreak.PatternBank(b"a"), "path = b'a' (bytes); expected text or a path"),
    (lambda: starbreak.corrupt(FRAME, 5), "corruption_name = 5 (int); expected text"),
    (lambda: starbreak.crack_file("a", "a.png"), "data = 'a' (str); expected the bytes of a file"),
    (lambda: starbreak.crack_file(b"", "a.png", bank="a"), "bank = 'a' (str); expected a starbreak.PatternBank"),
    (lambda: evaluated(tau=0.5), "tau = 0.5 (float); expected a list of numbers"),
    (lambda: evaluated(tau="0.5"), "tau = '0.5' (str); expected a list of numbers"),
    (lambda: evaluated(tau=["a"]), "tau = ['a'] (list); expected a list of numbers"),
    (lambda: evaluated(max_dets=5), "max_dets = 5 (int); expected a list of whole numbers"),
    (lambda: evaluated(detector=5), "detector = 5 (int); expected text"),
    (lambda: evaluated(protocol=5), "protocol = 5 (int); expected text"),
    (lambda: evaluated(cracked=5), "cracked = 5 (int); expected text or a path"),
    (lambda: evaluated(score_threshold="a"), "score_threshold = 'a' (str); expected a number"),
    (lambda: evaluated(area_ranges=5), "area_ranges = 5 (int); expected a dict of names"),
    (lambda: starbreak.divergence("folder:a", 5), "sets[1] = 5 (int); expected text or a path"),
    (lambda: compared(alpha=True), "alpha = True (bool); expected a number"),
    (lambda: compared(background=5), "background = 5 (int); expected text"),
]


@pytest.mark.parametrize(("call", "says"), KINDS, ids=[says.split(";")[0] for _, says in KINDS])
def test_an_argument_of_another_kind_is_named(call, says):
    with pytest.raises(TypeError) as raised:
        call()
    assert str(raised.value).startswith(says)


def test_a_range_of_areas_has_two_ends():
    with pytest.raises(ValueError, match=r"area_ranges = {'a': \[0, 1, 2\]} \(dict\); expected a dict of names"):
        evaluated(area_ranges={"a": [0, 1, 2]})


@pytest.mark.parametrize(
    ("key", "value", "says"),
    [
        ("camera.f_number", "x", 'invalid type: string "x", expected a number'),
        ("camera.blades", 2.5, "invalid type: floating point `2.5`, expected a whole number"),
        ("fracture.mesh", 5, "expected text"),
        ("fracture.model", "a", "unknown word `a`, expected one of `physics`, `paper`, `none`"),
    ],
)
def test_the_kind_of_a_key_is_said_in_words(key, value, says):
    with pytest.raises(ValueError) as raised:
        starbreak.Recipe(set={key: value})
    assert str(raised.value) == f'set["{key}"]: {key}: {says}'


@pytest.mark.parametrize("size", [[12, 9], np.array([12, 9]), FRAME.shape[1::-1], (np.int32(12), np.uint8(9)), range(12, 6, -3)])
def test_a_size_is_any_sequence_of_two(size):
    assert starbreak.ReadyCrack(PAPER, 1, size).size == (12, 9)
    assert starbreak.simulate(PAPER, 1, size) == starbreak.simulate(PAPER, 1, (12, 9))


@pytest.mark.parametrize("size", [(12,), FRAME.shape, [], 12, None, "ab", (12.0, 9), itertools.count(1)])
def test_what_is_no_size_is_said(size):
    with pytest.raises((TypeError, ValueError), match="size.* expected (width and height|a whole number)"):
        starbreak.simulate(PAPER, 1, size)


@pytest.mark.parametrize("size", [{12, 9}, {12: 1, 9: 2}, iter((12, 9))])
def test_a_size_has_an_order_and_an_end(size):
    with pytest.raises(TypeError, match="^size = .*; expected width and height in px"):
        starbreak.simulate(PAPER, 1, size)


def test_a_name_is_text_or_a_path():
    path = pathlib.Path("a") / "b.png"
    assert starbreak.item_seed(7, path) == starbreak.item_seed(7, "a/b.png")
    by_path = starbreak.crack(FRAME, PAPER, 7, name=path)
    np.testing.assert_array_equal(by_path, starbreak.crack(FRAME, PAPER, 7, name="a/b.png"))
    with pytest.raises(ValueError, match="b.png:1:1"):
        starbreak.Recipe.from_toml("=", name=path)
    for wrong in (5, b"a.png", ["a"]):
        with pytest.raises(TypeError, match="name = .* expected text or a path"):
            starbreak.item_seed(7, wrong)


@pytest.mark.parametrize(
    ("error", "wrong", "says"),
    [
        (ValueError, [float("nan"), 0, 5, 5], "[nan, 0, 5, 5]"),
        (ValueError, [0, 0, float("inf"), 5], "[0, 0, inf, 5]"),
        (ValueError, [0, 0, 10**400, 5], "[0, 0, inf, 5]"),
        (ValueError, [5, 0, 3.5, 5], "[5, 0, 3.5, 5]"),
        (ValueError, [0, 5, 3, 4], "[0, 5, 3, 4]"),
        (ValueError, np.array([0.0, 5, 3, 4]), "[0, 5, 3, 4]"),
        (ValueError, [0, 0, 1], "[0, 0, 1]"),
        (ValueError, [0, 0, 1, 1, 0.9], "[0, 0, 1, 1, 0.9]"),
        (TypeError, 7, "7 (int)"),
        (TypeError, {0, 1, 2, 3}, "{0, 1, 2, 3} (set)"),
        (TypeError, [0, 0, True, 5], "[0, 0, True, 5] (list)"),
        (TypeError, [0, 0, 5j, 5], "[0, 0, 5j, 5] (list)"),
        (TypeError, [0, 0, np.complex64(5), 5], f"{[0, 0, np.complex64(5), 5]!r} (list)"),
        (TypeError, "abcd", "'abcd' (str)"),
        (TypeError, None, "None"),
    ],
)
def test_a_box_that_is_none_is_named(error, wrong, says, small):
    with pytest.raises(error) as raised:
        starbreak.crack(FRAME, small, boxes=[[0, 0, 1, 1], wrong])
    assert f"boxes[1] = {says}; expected x0, y0, x1, y1 in px" in str(raised.value)


def test_boxes_without_a_pixel_of_the_frame_have_no_damage(small):
    boxes = np.array([[3.0, 3, 3, 9], [100, 100, 120, 120], [-5, -5, 4, 4]])
    damage = starbreak.crack(FRAME, small, boxes=boxes).damage
    assert damage[:2] == [None, None] and damage[2] is not None
    for wrong in (5, {(0, 0, 1, 1)}, iter([(0, 0, 1, 1)])):
        with pytest.raises(TypeError, match="^boxes = .*; expected a list of boxes"):
            starbreak.crack(FRAME, small, boxes=wrong)


@pytest.mark.parametrize(
    ("tables", "says"),
    [
        ({"camera": {"f_number": float("nan")}}, "camera.f_number = nan (float); expected a finite number"),
        ({"camera": {"f_number": np.float32("inf")}}, "camera.f_number = inf (float); expected a finite number"),
        ({"camera": {"f_number": None}}, "camera.f_number = None; expected a value; leave the key out"),
        ({"camera": object()}, "camera = <object object"),
        ({"impact": [{"position": [0.5, float("nan")]}]}, "impact[0].position[1] = nan"),
        ({"camera": {"f_number": 10**30}}, "camera.f_number = 1000000000000000000000000000000 (int); expected a number of"),
        ({"camera": {2: 3}}, "camera has the key 2 (int); expected text"),
        ({1: 2}, "the recipe has the key 1 (int); expected text"),
    ],
)
def test_a_value_that_no_recipe_has_is_named_by_its_key(tables, says):
    for call in (starbreak.Recipe.from_dict, starbreak.simulate):
        with pytest.raises(ValueError) as raised:
            call(tables)
        assert says in str(raised.value)


def test_a_recipe_inside_of_itself_ends():
    tables = {"camera": []}
    tables["camera"].append(tables)
    with pytest.raises(ValueError, match="more than 16 deep"):
        starbreak.Recipe.from_dict(tables)


@pytest.mark.parametrize(
    ("error", "wrong", "says"),
    [
        (ValueError, {"camera.f_number": float("nan")}, "camera.f_number = nan"),
        (ValueError, {5: 1}, "set has the key 5 (int); expected text"),
        (TypeError, 5, "set = 5 (int); expected a dict"),
        (TypeError, "camera.f_number=2", "or a list"),
    ],
)
def test_what_cannot_be_set_is_named(error, wrong, says):
    with pytest.raises(error) as raised:
        starbreak.Recipe(set=wrong)
    assert says in str(raised.value)


def test_what_is_no_recipe_is_named():
    for wrong in (5, 2.5, ["paper"], picture()):
        with pytest.raises(TypeError, match="recipe = .*; expected a starbreak.Recipe, the name of a preset or a dict"):
            starbreak.simulate(wrong)


def test_masked_entries_are_no_codes(image, small):
    masked = np.ma.masked_array(image)
    masked[3, 4] = np.ma.masked
    for wrong in (masked, masked[..., 0]):
        with pytest.raises(ValueError, match=r"masked entries.*filled\(0\)"):
            starbreak.crack(wrong, small)
    starbreak.crack(masked.filled(0), small)


def test_a_text_that_is_no_network_is_said_in_a_sentence(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    with pytest.raises(ValueError, match="^the text is not a crack network: missing key"):
        starbreak.CrackNetwork.from_json("{}")
    with pytest.raises(ValueError, match='a.json" is not a crack network: missing key'):
        starbreak.CrackNetwork.from_file(tmp_path / "a.json")


def test_what_is_wrong_in_a_network_is_said_in_words():
    network = json.loads(starbreak.simulate(PAPER, 1, (12, 9)).to_json())
    for key, value, says in [
        ("seed", 2.5, "invalid type: floating point `2.5`, expected a whole number at line 1"),
        ("nodes", 5, "invalid type: integer `5`, expected a table at line 1"),
        ("model", "a", "unknown word `a`, expected one of"),
    ]:
        with pytest.raises(ValueError) as raised:
            starbreak.CrackNetwork.from_json(json.dumps(network | {key: value}))
        assert says in str(raised.value)


def test_a_network_in_mm_asks_for_a_pane():
    network = starbreak.simulate({"fracture": {"mesh": "fast"}}, 1, (128, 96))
    with pytest.raises(ValueError, match="use a preset of the physics, such as"):
        starbreak.crack(picture(), "paper", network=network)
