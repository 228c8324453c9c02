"""Files that are read, written and made: what is said of those that cannot be."""

import os
import pickle
import shutil
import stat
import sys

import pytest
import starbreak

PAPER = {"fracture": {"model": "paper", "particles": 50}}


def test_an_error_of_a_file_has_its_number_and_name(tmp_path):
    path = tmp_path / "nowhere"
    for call in (starbreak.Recipe.from_file, starbreak.CrackNetwork.from_file):
        with pytest.raises(FileNotFoundError) as raised:
            call(path)
        error = raised.value
        assert (error.errno, error.strerror, error.filename) == (2, os.strerror(2), str(path))
        assert str(error) == f"[Errno 2] {os.strerror(2)}: {str(path)!r}"


def test_a_damaged_bank_is_an_os_error(command, tmp_path):
    command("patterns", "-n", 2, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    whole = (tmp_path / "patterns.bank").read_bytes()
    for at in range(0, len(whole), len(whole) // 20):
        (tmp_path / "patterns.bank").write_bytes(whole[:at] + bytes([whole[at] ^ 0x55]) + whole[at + 1 :])
        with pytest.raises(OSError, match="patterns.bank"):
            bank = starbreak.PatternBank(tmp_path)
            for n in range(2):
                bank.pattern(n, (128, 96)), bank[n]


def test_a_network_is_saved_into_a_folder_that_is_there(tmp_path, monkeypatch):
    network = starbreak.simulate(PAPER, 1, (12, 9))
    with pytest.raises(FileNotFoundError) as raised:
        network.save(tmp_path / "no" / "network.json")
    assert raised.value.filename == str(tmp_path / "no" / "network.json")
    assert os.listdir(tmp_path) == []
    monkeypatch.chdir(tmp_path)
    network.save("network.json")
    assert starbreak.CrackNetwork.from_file("network.json") == network


def test_a_network_takes_the_place_of_a_network_alone_unless_it_is_to_replace(tmp_path):
    one, two = (starbreak.simulate(PAPER, seed, (12, 9)) for seed in (1, 2))
    path = tmp_path / "network.json"
    one.save(path)
    two.save(path)
    assert starbreak.CrackNetwork.from_file(path) == two
    for theirs in ("mine", '{"schema": "starbreak.provenance/2"}'):
        path.write_text(theirs)
        with pytest.raises(FileExistsError, match="replace=True") as raised:
            one.save(path)
        assert (raised.value.errno, raised.value.filename) == (17, str(path))
        assert path.read_text() == theirs
    one.save(path, replace=True)
    assert starbreak.CrackNetwork.from_file(path) == one


def test_a_folder_is_no_file(tmp_path):
    network = starbreak.simulate(PAPER, 1, (12, 9))
    for call in (starbreak.Recipe.from_file, starbreak.CrackNetwork.from_file, network.save):
        with pytest.raises(IsADirectoryError) as raised:
            call(tmp_path)
        assert (raised.value.errno, raised.value.filename) == (21, str(tmp_path))


@pytest.mark.skipif(sys.platform != "linux", reason="another system has other limits")
def test_what_the_system_says_of_a_file_is_said_alone(tmp_path):
    network = starbreak.simulate(PAPER, 1, (12, 9))
    with pytest.raises(OSError) as raised:
        network.save(tmp_path / ("a" * 300))
    assert (raised.value.errno, raised.value.strerror) == (36, os.strerror(36))
    with pytest.raises(FileNotFoundError) as raised:
        network.save("/proc/network.json")
    assert raised.value.filename == "/proc/network.json"


def test_a_network_is_json_whatever_was_there(tmp_path):
    network = starbreak.simulate(PAPER, 1, (12, 9))
    for name in ("a.svg", "a.SVG"):
        with pytest.raises(ValueError, match=r"save writes JSON.*to_svg\(\)"):
            network.save(tmp_path / name)
    assert os.listdir(tmp_path) == []


@pytest.mark.skipif(sys.platform == "win32", reason="modes and links of files")
def test_a_saved_network_is_a_new_file(tmp_path):
    network = starbreak.simulate(PAPER, 1, (12, 9))
    (tmp_path / "target.json").write_text("here")
    (tmp_path / "link.json").symlink_to(tmp_path / "target.json")
    (tmp_path / "private.json").touch(0o600)
    (tmp_path / "plain.json").touch()
    for name in ("link.json", "private.json"):
        network.save(tmp_path / name, replace=True)
        assert not (tmp_path / name).is_symlink()
        assert stat.S_IMODE((tmp_path / name).stat().st_mode) == stat.S_IMODE((tmp_path / "plain.json").stat().st_mode)
    assert (tmp_path / "target.json").read_text() == "here"


@pytest.mark.parametrize(
    ("output", "says"), [({"format": "jpeg"}, 'set output.format = "same"'), ({"maps": True}, "set output.maps = false")]
)
def test_crack_file_refuses_the_outputs_that_generate_refuses(command, tmp_path, output, says):
    recipe = starbreak.Recipe.from_dict({"output": output})
    with pytest.raises(ValueError) as raised:
        starbreak.crack_file(b"", "a.png", recipe)
    assert says in str(raised.value)
    (tmp_path / "recipe.toml").write_text(recipe.to_toml())
    said = command("generate", f"folder:{tmp_path}", "-o", tmp_path / "out", "--recipe", tmp_path / "recipe.toml", ok=False)
    assert said.stderr == f"error: {raised.value}\n"


def test_bytes_are_those_of_any_buffer(small):
    with pytest.raises(OSError) as raised:
        starbreak.crack_file(b"no image", "a.png", small)
    for data in (bytearray(b"no image"), memoryview(b"no image"), memoryview(b"nXoX XiXmXaXgXeX")[::2]):
        with pytest.raises(OSError) as again:
            starbreak.crack_file(data, "a.png", small)
        assert str(again.value) == str(raised.value)


def test_another_bank_in_the_place_of_a_pickled_one_is_refused(command, tmp_path):
    words = ("patterns", "-n", 2, "--size", "128x96", "--set", "fracture.mesh=fast")
    command(*words, "-o", tmp_path / "bank", "--seed", 1)
    bank = starbreak.PatternBank(tmp_path / "bank")
    assert [network.seed for network in bank] == [bank[0].seed, bank[1].seed]
    both = pickle.dumps(bank), pickle.dumps(bank.pattern(1, (128, 96)))
    for pickled in both:
        pickle.loads(pickled)
    assert pickle.loads(both[0]).sha256 == bank.sha256
    del bank
    shutil.rmtree(tmp_path / "bank")
    command(*words, "-o", tmp_path / "bank", "--seed", 2)
    for pickled in both:
        with pytest.raises(ValueError, match="holds another bank than the one that was pickled"):
            pickle.loads(pickled)
