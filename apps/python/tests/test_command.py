"""The verbs of the command from Python, and the command that the wheel installs."""

import json
import logging
import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import numpy as np
import pytest
import starbreak
from PIL import Image

SMALL = {"fracture": {"model": "paper", "particles": 300, "neighbour_radius_px": 20.0}}


@pytest.fixture
def images(tmp_path):
    folder = tmp_path / "images"
    folder.mkdir()
    street, _ = starbreak.street_scene()
    for k in range(3):
        Image.fromarray(street[:96, 40 * k : 40 * k + 160]).save(folder / f"{k}.png")
    return folder


def files_of(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(Path(folder).rglob("*"))
        if path.is_file() and path.suffix == ".png"
    }


def test_generate_is_that_of_the_command_and_tells_its_progress(images, tmp_path, caplog):
    told = []
    with caplog.at_level(logging.INFO, logger="starbreak"):
        result = starbreak.generate(
            f"folder:{images}",
            tmp_path / "python",
            starbreak.Recipe("windshield-star", severity=2),
            seed=3,
            progress=lambda *said: told.append(said),
        )
    assert told[-1] == (3, 3, "images")
    assert any("3" in record.message for record in caplog.records), caplog.records
    again = starbreak.command(
        "generate", f"folder:{images}", o=tmp_path / "flags", preset="windshield-star",
        severity=2, seed=3,
    )  # fmt: skip
    assert files_of(tmp_path / "python") == files_of(tmp_path / "flags")
    assert len(files_of(tmp_path / "python")) > 3
    assert result.keys() == again.keys()


def test_a_dict_of_flags_and_a_recipe_say_the_same(images, tmp_path):
    image = images / "0.png"
    sets = {"impact.position": [0.3, 0.5], "impact.speed_m_s": 31.0}
    by_flag = tmp_path / "by-flag.png"
    starbreak.command("crack", image, output=by_flag, preset="windshield-star", set=sets)
    by_recipe = tmp_path / "by-recipe.png"
    recipe = starbreak.Recipe("windshield-star", set=sets)
    starbreak.command("crack", image, output=by_recipe, recipe=recipe)
    whole = np.asarray(Image.open(image))
    cracked = starbreak.crack(whole, recipe, name="0.png")
    assert np.array_equal(np.asarray(Image.open(by_flag)), cracked)
    assert by_flag.read_bytes() == by_recipe.read_bytes()


def test_patterns_sweep_and_video(images, tmp_path):
    bank = starbreak.patterns(2, tmp_path / "bank", "windshield-star", size="160x96")
    assert bank["bank"].endswith("patterns.bank")
    over = "camera.focus_distance_m=far,1"
    swept = starbreak.sweep(images / "0.png", tmp_path / "sweep", over, "windshield-star")
    assert Path(tmp_path / "sweep").is_dir() and swept
    clip = starbreak.video(images, tmp_path / "clip", "windshield-star", impact_at=0, fps=10)
    assert clip["n_frames"] == 3


def test_what_is_wrong_is_said_as_by_the_command(images, tmp_path):
    with pytest.raises(ValueError, match="did you mean `windshield-star`"):
        starbreak.generate(f"folder:{images}", tmp_path / "x", "windscreen-star")
    with pytest.raises(ValueError, match="--smaples.*--samples"):
        starbreak.generate(f"folder:{images}", tmp_path / "x", smaples=2)
    with pytest.raises(ValueError, match="no such file or folder"):
        starbreak.detect(f"folder:{images}", tmp_path / "none.onnx", tmp_path / "x.json")
    with pytest.raises(ValueError, match="breaks no glass"):
        starbreak.command("evaluate", f"folder:{images}", clean="x", preset="paper")
    assert not (tmp_path / "x").exists()


def test_onnx_runtime_is_that_of_this_python(images, tmp_path, monkeypatch, caplog):
    onnx = pytest.importorskip("onnx", reason="onnx is not installed; run `cargo xtask test`")
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed; run `cargo xtask test`")
    # A detector in the form of YOLOX that always sees the same thing.
    found = np.zeros((1, 21, 85), np.float32)
    found[0, 3, :6] = 0.5, 0.5, 1, 1, 0.9, 0.8
    floats = onnx.TensorProto.FLOAT
    graph = onnx.helper.make_graph(
        [onnx.helper.make_node("Identity", ["found"], ["output"])],
        "detector",
        [onnx.helper.make_tensor_value_info("images", floats, [1, 3, 32, 32])],
        [onnx.helper.make_tensor_value_info("output", floats, [1, 21, 85])],
        [onnx.numpy_helper.from_array(found, "found")],
    )
    model = tmp_path / "yolox.onnx"
    onnx.save(onnx.helper.make_model(graph, opset_imports=[onnx.helper.make_opsetid("", 13)], ir_version=8), model)
    # No other Python is there to ask.
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("ORT_DYLIB_PATH", raising=False)
    said = {
        name: starbreak.detect(f"folder:{images}", model, tmp_path / f"{name}.json", runtime=name)
        for name in ("rten", "onnxruntime", "auto")
    }
    assert said["rten"]["runtime"] == "rten"
    for name in ("onnxruntime", "auto"):
        assert said[name]["runtime"].startswith("ONNX Runtime of commit ")
        assert said[name]["n_detections"] == said["rten"]["n_detections"] > 0
        assert (tmp_path / f"{name}.json").read_bytes() == (tmp_path / "rten.json").read_bytes()


def test_frames_of_a_pipe_are_for_a_process_of_their_own():
    with pytest.raises(ValueError, match="pipe reads standard input and writes standard output, .* ReadyCrack.over"):
        starbreak.command("pipe", size="8x8", pixels="gray")


def test_an_interrupt_ends_the_work_and_is_raised(images, tmp_path):
    text = (
        "import signal, sys, threading, os, starbreak\n"
        # In the background of a shell it would be ignored.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "try:\n"
        f"    starbreak.generate({'folder:' + str(images)!r}, {str(tmp_path / 'long')!r},\n"
        "                       samples=10000, threads=1)\n"
        "except KeyboardInterrupt:\n"
        "    sys.exit(7)\n"
    )
    ended = subprocess.run([sys.executable, "-c", text], timeout=60, check=False)
    assert ended.returncode == 7


def test_a_listener_that_raises_ends_the_work(images, tmp_path):
    def listen(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        starbreak.generate(f"folder:{images}", tmp_path / "x", samples=2000, progress=listen)


def test_the_wheel_has_the_command(tmp_path):
    program = Path(sysconfig.get_path("scripts")) / ("starbreak" + (".exe" if os.name == "nt" else ""))
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    assert version.stdout.split() == ["starbreak", starbreak.__version__]
    wrong = subprocess.run([program, "demo", "--preset", "papr"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2
    assert wrong.stderr == "error: unknown preset `papr`; did you mean `paper`?\n"
    listed = subprocess.run([program, "recipe", "--list", "--json"], capture_output=True, text=True, check=True)
    names = [preset["name"] for preset in json.loads(listed.stdout)["presets"]]
    assert names == list(starbreak.presets())


def test_items_that_fail_are_counted_and_warned_of(images, tmp_path, caplog):
    (images / "broken.png").write_bytes(b"no image")
    with caplog.at_level(logging.INFO, logger="starbreak"):
        result = starbreak.command("crack", *images.iterdir(), output=tmp_path / "out", recipe=SMALL)
    assert len(result["images"]) == 3 and len(result["failed"]) == 1
    warned = [record.message for record in caplog.records if record.levelno == logging.WARNING]
    assert any("1 of 4 images failed" in text for text in warned), warned
    with pytest.raises(ValueError, match="broken.png"):
        starbreak.command("crack", images / "broken.png", output=tmp_path / "one", recipe=SMALL)


def test_what_options_may_be(images, tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(starbreak.Recipe.from_dict(SMALL).to_toml())
    for name, recipe, flag, seed in (
        ("a.png", SMALL, np.True_, np.int64(4)),
        ("b.png", file, True, 4),
    ):
        starbreak.command(
            "crack", images / "0.png", output=tmp_path / name, recipe=recipe, replace=flag, seed=seed
        )
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    sets = {"impact.position": np.array([0.5, 0.25]), "optics.model": "paper"}
    text = starbreak.command("recipe", preset="paper", set=sets, quiet=True)["recipe"]
    assert "position = [0.5, 0.25]" in text.replace("\n", " "), text
    # An output that begins with a dash, and its record, which shows no folder of a passing file.
    here = os.getcwd()
    os.chdir(tmp_path)
    try:
        starbreak.command("crack", images / "0.png", o="-odd", recipe=SMALL)
    finally:
        os.chdir(here)
    assert (tmp_path / "-odd" / "0.json").is_file()


def test_each_step_has_a_bar_of_its_own(monkeypatch, images, tmp_path):
    bars = []

    class Bar:
        def __init__(self, total, unit):
            self.total, self.unit, self.n, self.is_closed = total, unit, 0, False
            bars.append(self)

        def update(self, n):
            assert n > 0
            self.n += n

        def close(self):
            self.is_closed = True

    monkeypatch.setattr("starbreak._command._tqdm", lambda: Bar)
    starbreak.generate(f"folder:{images}", tmp_path / "set", SMALL, progress=True)
    starbreak.command("verify", tmp_path / "set", source=f"folder:{images}", regenerate=2, progress=True)
    assert [bar.n for bar in bars if bar.unit == " images"][0] == 3
    assert all(bar.is_closed and bar.n <= (bar.total or bar.n) for bar in bars)


def test_what_only_looks_like_pillow_is_no_image():
    class Tensor:
        def mode(self):
            return "RGB"

    with pytest.raises(TypeError, match="is of type Tensor"):
        starbreak.crack(Tensor(), SMALL)
