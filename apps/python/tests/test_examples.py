"""The examples run, and the README shows the one that made its picture."""

import pathlib
import subprocess
import sys

import numpy as np
import pytest
import starbreak
from PIL import Image

PACKAGE = pathlib.Path(__file__).parents[1]
PROJECT = PACKAGE.parents[1]


def test_the_readme_has_the_example_and_its_picture(tmp_path):
    text = (PACKAGE / "examples" / "street.py").read_text()
    readme = (PROJECT / "README.md").read_text()
    assert f"```python\n{text}```" in readme
    done = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "region_share" in done.stdout
    made = np.asarray(Image.open(tmp_path / "cracked.jpg")).astype(int)
    shown = np.asarray(Image.open(PROJECT / "docs/figures/python-street.jpg")).astype(int)
    # Two versions of a JPEG library differ by a code or two.
    assert np.abs(made - shown).mean() < 0.5
    street, _ = starbreak.street_scene()
    assert np.abs(made - street).mean() > 0.5


@pytest.mark.parametrize("page", ["docs/python.md", "docs/live.md"])
def test_the_python_of_a_page_runs(page, tmp_path):
    parts = (PROJECT / page).read_text().split("```python\n")
    is_run = [not part.rstrip().split("\n")[-1].startswith("<!-- not run: ") for part in parts]
    blocks = [block for block, runs in zip(parts[1:], is_run) if runs]
    assert blocks
    program = "\n".join(block.split("```")[0] for block in blocks)
    Image.fromarray(starbreak.street_scene()[0]).save(tmp_path / "photo.png")
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
