"""Images as Python has them: of Pillow, with alpha, in a notebook."""

import io

import numpy as np
import pytest
import starbreak
from conftest import picture
from PIL import Image


def test_images_of_pillow_and_with_alpha_are_taken(small):
    frame = picture()
    cracked = starbreak.crack(frame, small, 3)
    pillow = Image.fromarray(frame)
    assert np.array_equal(starbreak.crack(pillow, small, 3), cracked)
    alpha = np.arange(frame[..., 0].size, dtype=np.uint8).reshape(frame.shape[:2])
    both = starbreak.crack(np.dstack([frame, alpha]), small, 3)
    assert np.array_equal(both, np.dstack([cracked, alpha]))
    with pytest.raises(ValueError, match="mode 'P'|mode \"P\""):
        starbreak.crack(pillow.quantize(8), small)


def test_a_severity_is_of_a_preset():
    frame = picture()
    by_recipe = starbreak.crack(frame, starbreak.Recipe("windshield-star", severity=2), 3)
    assert np.array_equal(starbreak.crack(frame, "windshield-star", 3, severity=2), by_recipe)
    with pytest.raises(ValueError, match="severity scales a preset"):
        starbreak.crack(frame, {"fracture": {"model": "paper"}}, severity=2)


def test_notebooks_show_the_image_and_the_network(small):
    full = starbreak.crack(picture(), small, 3, full=True)
    shown = np.asarray(Image.open(io.BytesIO(full._repr_png_())))
    assert np.array_equal(shown, full.image)
    assert full.network._repr_svg_() == full.network.to_svg()
