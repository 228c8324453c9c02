"""`docs/run_commands.py` is red where a page is wrong, says where, and runs what is right."""

import pathlib
import subprocess
import sys

import pytest

SCRIPT = pathlib.Path(__file__).parents[3] / "docs/run_commands.py"

RIGHT = """# A page

`starbreak crack photo.png --seed 7`, `cargo xtask links`, `validation/run laws`.

```sh
cargo build                          # not ours
starbreak crack photo.png -o out \\
  --set fracture.mesh=fast           # the "photo" is made up
starbreak recipe --list > list.txt
```

<!-- not run: needs a cluster -->
```sh
starbreak merge /shared/cracked-* -o cracked
```
"""


@pytest.fixture
def run(program, tmp_path):
    """Runs the script on a page of this text; its exit code, what it prints and its errors."""
    pytest.importorskip("imageio_ffmpeg", reason="imageio-ffmpeg is not installed; run `cargo xtask test`")

    def run(text):
        page = tmp_path / "page.md"
        page.write_text(text)
        done = subprocess.run([sys.executable, SCRIPT, program, page], capture_output=True, text=True, check=False)
        return done.returncode, done.stdout, done.stderr

    return run


def test_a_page_that_is_right_runs(run):
    code, said, errors = run(RIGHT)
    assert (code, errors) == (0, "")
    assert "2 run, 2 not run, 0 failed" in said
    assert "needs a cluster:\n    page.md:14: starbreak merge" in said


@pytest.mark.parametrize(
    ("right", "wrong", "error"),
    [
        ("--set fracture.mesh=fast", "--no-such-flag", "page.md:7: starbreak crack photo.png"),
        ("photo.png -o", "no-photo.png -o", "page.md:7: starbreak crack no-photo.png"),
        ("--seed 7", "--sead 7", "page.md:3: starbreak crack photo.png --sead 7\n    starbreak crack has no flag --sead"),
        ("xtask links", "xtask lynx", "page.md:3: cargo xtask lynx\n    xtask has no task lynx"),
        ("run laws", "run lows", "page.md:3: validation/run lows\n    validation/run has no step lows"),
        ("cargo build ", "python3 docs/no.py", "page.md:6: python3 docs/no.py\n    the repository has no docs/no.py"),
        ("merge /shared", "marge /shared", "page.md:14: starbreak marge"),
    ],
)
def test_a_page_that_is_wrong_is_red_and_says_where(run, right, wrong, error):
    assert right in RIGHT
    code, _, errors = run(RIGHT.replace(right, wrong))
    assert code == 1
    assert f"error: {error}" in errors
