"""Faults of the camera beside broken glass."""

import numpy as np
import pytest

import starbreak
import starbreak.transforms

FRAME = np.full((120, 200, 3), 128, np.uint8)


@pytest.mark.parametrize(
    "preset",
    ["overexposed", "underexposed", "banding", "noise", "lines", "spots", "no-white-balance", "compression", "bit-errors"],
)
def test_a_fault_is_a_preset_like_any_other(preset):
    assert preset in starbreak.presets()
    # Of an even gray a codec loses nothing.
    scene = FRAME + np.arange(200, dtype=np.uint8)[:, None] % 61
    frame = starbreak.corrupt(scene, preset, severity=5, seed=7)
    assert frame.shape == scene.shape and frame.dtype == np.uint8
    assert (frame != scene).any()
    assert (frame == starbreak.crack(scene, preset, severity=5, seed=7)).all()


def test_a_transform_has_the_name_of_what_it_does():
    transform = starbreak.transforms.CameraFault("noise", severity=3, seed=7)
    again = starbreak.transforms.CrackedGlass("noise", severity=3, seed=7)
    assert (transform(FRAME) == again(FRAME)).all()


def test_the_noise_has_the_ratio_that_is_said():
    full = starbreak.crack(FRAME[:, :, 0], "noise", seed=3, full=True)
    # Gray 128 is 21.6 % of the light of white: 130 of 600 electrons, and 3 of reading.
    light = ((full.image / 255 + 0.055) / 1.055) ** 2.4
    expected = np.sqrt(0.2159 * 600 + 9) / 600
    assert abs(light.std() / expected - 1) < 0.03
    assert full.region.all()
    assert full.facts["faults"]["noise"]["snr_18"] == pytest.approx(10, abs=0.1)


def test_defects_stay_and_photons_do_not():
    pixels = starbreak.Recipe("pixels", severity=5)
    noise = starbreak.Recipe("noise")
    first, second = (starbreak.crack(FRAME, pixels, seed=seed) for seed in (1, 2))
    assert (first == second).all()
    first, second = (starbreak.crack(FRAME, noise, seed=seed) for seed in (1, 2))
    assert (first != second).any()


def test_a_fault_and_a_crack_go_together():
    both = starbreak.Recipe("windshield-spiderweb", set={"exposure.ev": -2})
    dark = starbreak.crack(FRAME, both, seed=4)
    bright = starbreak.crack(FRAME, "windshield-spiderweb", seed=4)
    assert dark.mean() < 0.7 * bright.mean()
