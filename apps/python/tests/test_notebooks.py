"""The notebooks run from their first cell to their last, and show what they print."""

import json
import pathlib
import subprocess
import sys

import pytest

NOTEBOOKS = pathlib.Path(__file__).parents[1] / "notebooks"


def test_both_are_there():
    assert sorted(path.name for path in NOTEBOOKS.glob("*.ipynb")) == ["crack.ipynb", "train.ipynb"]


# The numbers of a training depend on the processor in their last digits.
@pytest.mark.parametrize(("name", "repeats"), [("crack.ipynb", True), ("train.ipynb", False)])
def test_a_notebook_runs_and_shows_what_it_prints(name, repeats, tmp_path):
    cells = json.loads((NOTEBOOKS / name).read_text())["cells"]
    cells = [cell for cell in cells if cell["cell_type"] == "code"]
    program = "\n".join("".join(cell["source"]) for cell in cells)
    done = subprocess.run([sys.executable, "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert any("image/jpeg" in output.get("data", {}) for output in outputs), "a notebook without a picture"
    shown = "".join("".join(output["text"]) for output in outputs if output["output_type"] == "stream")
    assert len(shown.splitlines()) == len(done.stdout.splitlines())
    if repeats:
        assert shown == done.stdout
