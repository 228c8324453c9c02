"""What Python makes is what the command makes, to the byte."""

import json

import numpy as np
import pytest
import starbreak
from conftest import picture
from PIL import Image

RECIPES = {
    "windshield-star": {"fracture.mesh": "fast"},
    "windshield-bullseye": {"fracture.mesh": "fast", "optics.noise_read": 0.01},
    "lens-cover-star": {"fracture.mesh": "fast", "camera.focus_distance_m": "short"},
    "paper": {"fracture.particles": 2000, "fracture.neighbour_radius_px": 30.0},
}


def flags(values):
    return [word for key, value in values.items() for word in ("--set", f"{key}={json.dumps(value)}")]


@pytest.mark.parametrize("preset", RECIPES)
@pytest.mark.parametrize("mode", ["RGB", "L"])
def test_crack_gives_image_and_masks_of_the_command(command, tmp_path, preset, mode):
    values = RECIPES[preset]
    image = picture(180, 320)
    image = image if mode == "RGB" else np.ascontiguousarray(image[..., 0])
    Image.fromarray(image).save(tmp_path / "photo.png")
    command("crack", tmp_path / "photo.png", "-o", tmp_path / "out", "--preset", preset, "--seed", 7, *flags(values))
    theirs = {
        kind: np.asarray(Image.open(tmp_path / "out" / f"photo{kind}.png")) for kind in ("", ".region", ".crack")
    }

    recipe = starbreak.Recipe(preset, set=values)
    cracked = starbreak.crack(image, recipe, seed=7, name="photo.png", full=True)
    np.testing.assert_array_equal(cracked.image, theirs[""], err_msg="image")
    np.testing.assert_array_equal(cracked.region, theirs[".region"], err_msg="region mask")
    np.testing.assert_array_equal(cracked.crack, theirs[".crack"], err_msg="crack mask")
    assert (cracked.image != image).any(), "a crack that changes nothing proves nothing"

    quick = starbreak.crack(image, recipe, seed=7, name="photo.png")
    np.testing.assert_array_equal(quick, theirs[""], err_msg="without masks and facts")

    record = json.loads((tmp_path / "out" / "photo.json").read_text())
    assert recipe.to_toml() == record["recipe"], "the recipe of the record"
    assert recipe.sha256 == record["recipe_sha256"]
    assert starbreak.item_seed(7, "photo.png") == record["item"]["seed"]
    assert cracked.facts["network"]["summary"] == record["network"]["summary"]
    assert cracked.facts["optics"] == record["optics"]
    assert cracked.facts["region_fraction"] == record["region_fraction"]


@pytest.mark.parametrize("preset", RECIPES)
def test_simulate_gives_the_network_file_of_the_command(command, tmp_path, preset):
    values = RECIPES[preset]
    file = tmp_path / "network.json"
    command("simulate", "-o", file, "--preset", preset, "--seed", 3, "--size", "640x360", *flags(values))
    network = starbreak.simulate(starbreak.Recipe(preset, set=values), 3, (640, 360))
    assert network.to_json() == file.read_text()
    assert starbreak.CrackNetwork.from_file(file) == network
    network.save(tmp_path / "again.json")
    assert (tmp_path / "again.json").read_bytes() == file.read_bytes()


def test_a_network_of_its_own_cracks_an_image_as_the_command_does(command, tmp_path, image, small):
    Image.fromarray(image).save(tmp_path / "photo.png")
    network = starbreak.simulate(small, 5, (128, 96))
    network.save(tmp_path / "network.json")
    (tmp_path / "recipe.toml").write_text(small.to_toml())
    command(
        *("crack", tmp_path / "photo.png", "-o", tmp_path / "out", "--recipe", tmp_path / "recipe.toml"),
        *("--network", tmp_path / "network.json", "--seed", 5),
    )
    theirs = np.asarray(Image.open(tmp_path / "out" / "photo.png"))
    ours = starbreak.crack(image, small, 5, name="photo.png", network=network)
    np.testing.assert_array_equal(ours, theirs)


def test_a_bank_gives_the_images_of_generate(command, tmp_path):
    source, bank_folder = tmp_path / "images", tmp_path / "bank"
    source.mkdir()
    images = {f"{k}.png": picture(90, 160, seed=k) for k in range(4)}
    # A size that the bank does not have, too.
    images["other.png"] = picture(120, 160, seed=9)
    for name, image in images.items():
        Image.fromarray(image).save(source / name)
    made = ["--preset", "windshield-star", "--set", "fracture.mesh=fast"]
    command("patterns", "-n", 3, "-o", bank_folder, "--size", "160x90", "--seed", 11, *made)
    command("generate", f"folder:{source}", "-o", tmp_path / "out", "--bank", bank_folder, "--seed", 2)

    bank = starbreak.PatternBank(bank_folder)
    assert (len(bank), bank.seed, bank.sizes) == (3, 11, [(160, 90)])
    assert bank.recipe == starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast"})
    for name, image in images.items():
        theirs = np.asarray(Image.open(tmp_path / "out" / name))
        np.testing.assert_array_equal(bank.crack(image, 2, name=name), theirs, err_msg=name)
        record = json.loads((tmp_path / "out/starbreak/provenance" / name.replace(".png", ".json")).read_text())
        assert bank.index_for(2, name=name) == record["pattern"]["idx"], name
        assert bank.sha256 == record["pattern"]["bank_sha256"]
        full = bank.crack(image, 2, name=name, full=True)
        np.testing.assert_array_equal(full.image, theirs, err_msg=name)
        region = np.asarray(Image.open(tmp_path / "out/starbreak/regions" / name))
        np.testing.assert_array_equal(full.region, region, err_msg=name)
        assert full.facts["pattern"] == record["pattern"]
    by_hand = starbreak.PatternBank(bank_folder / "patterns.bank").pattern(1, (160, 90))
    np.testing.assert_array_equal(by_hand.over(images["0.png"], 5), bank.crack(images["0.png"], 5, index=1))


def test_a_network_is_the_same_simulated_or_given(small):
    image = picture()
    for recipe in (small, starbreak.Recipe("windshield-star", set={"fracture.mesh": "fast"})):
        network = starbreak.simulate(recipe, 4, (128, 96))
        given = starbreak.crack(image, recipe, 4, network=network)
        np.testing.assert_array_equal(given, starbreak.crack(image, recipe, 4))


def test_recipes_are_refused_with_the_messages_of_the_command(command, tmp_path):
    cases = [
        ({"camera.fpx": 3}, None),
        ({"camera.f_number": -1.0}, None),
        ({"fracture.particles": 5}, None),
        ({"impact.3.speed_m_s": 30}, None),
        ({"fracture.mesh": "tiny"}, None),
        ({}, "schema = 1\n[camera]\nfpx = 1"),
        ({}, "schema = 1\n[camera\n"),
        ({}, "[camera]\nf_number = 2.0"),
    ]
    for values, text in cases:
        file = tmp_path / "recipe.toml"
        words = flags(values)
        if text is not None:
            file.write_text(text)
            words = ["--recipe", file]
        said = command("simulate", *words, ok=False)
        assert said.returncode == 2, (values, text)
        with pytest.raises(ValueError) as raised:
            starbreak.Recipe(set=values) if text is None else starbreak.Recipe.from_file(file)
        # What was given is named as it was given; what follows is the same.
        [(key, value)] = values.items() or [("", "")]
        theirs, ours = ("", "") if text is not None else (f"--set {key}={json.dumps(value)}", f'set["{key}"]')
        theirs = theirs.replace('"', '\\"')
        assert str(raised.value).startswith(ours), (values, text)
        assert f"error: {theirs}{str(raised.value)[len(ours):]}\n" == said.stderr, (values, text)
