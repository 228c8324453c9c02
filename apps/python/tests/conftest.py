"""What the tests share: a street, a small crack, and the command."""

import os
import pathlib
import shutil
import subprocess

import numpy as np
import pytest
import starbreak

#: A crack of the paper's model that fits small pictures and is made in a few milliseconds.
SMALL = {
    "fracture.particles": 300,
    "fracture.neighbour_radius_px": 20.0,
    "impact.position": [0.2, 0.4],
    "impact.direction_deg": 20.0,
}


def picture(height=96, width=128, seed=0):
    """A picture that is nowhere flat: a gradient with noise, H x W x 3."""
    rows, columns = np.mgrid[0:height, 0:width]
    base = 40 + 120 * rows / max(height, 1) + 30 * np.sin(columns / 7)
    noise = np.random.default_rng(seed).integers(0, 25, (height, width, 3))
    return (base[..., None] + noise).clip(0, 255).astype(np.uint8)


@pytest.fixture
def image():
    return picture()


@pytest.fixture(scope="session")
def small():
    return starbreak.Recipe("paper", set=SMALL)


@pytest.fixture(scope="session")
def program():
    """The command `starbreak`, which the project's test command builds and names."""
    program = os.environ.get("STARBREAK_TEST_COMMAND") or shutil.which("starbreak")
    if program is None:
        pytest.skip("STARBREAK_TEST_COMMAND names no command to compare with; run `cargo xtask test`")
    return program


@pytest.fixture(scope="session")
def command(program):
    """Runs the command."""

    def run(*words, ok=True):
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True, check=False)
        assert not ok or done.returncode == 0, done.stderr
        return done

    return run


@pytest.fixture(scope="session")
def cluster():
    """A Ray of this machine with two workers."""
    import ray

    # Workers find the modules of the tests.
    words = {"env_vars": {"PYTHONPATH": str(pathlib.Path(__file__).parent)}}
    ray.init(num_cpus=2, include_dashboard=False, logging_level="ERROR", log_to_driver=False, runtime_env=words)
    context = ray.data.DataContext.get_current()
    context.enable_progress_bars = context.print_on_execution_start = False
    yield
    ray.shutdown()
