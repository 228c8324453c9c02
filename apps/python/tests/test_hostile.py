"""Arguments that lie, programs that end, pickles that somebody made: an exception, never the end of the process."""

import collections.abc
import os
import pickle
import random
import signal
import subprocess
import sys
import textwrap
import threading

import numpy as np
import pytest
import starbreak
from conftest import picture


class Lying(collections.abc.Sequence):
    """A sequence that says that it is longer than any memory."""

    def __init__(self, entry, length=sys.maxsize, n=2):
        self.entry, self.length, self.n = entry, length, n

    def __len__(self):
        return self.length

    def __getitem__(self, k):
        if k >= self.n:
            raise IndexError(k)
        return self.entry


class Endless(list):
    """A list that goes on for ever."""

    def __iter__(self):
        while True:
            yield self[0]


@pytest.mark.parametrize("length", [2**40, sys.maxsize])
def test_a_length_is_not_believed(length, image, small):
    cracked = starbreak.crack(image, small, boxes=Lying([0, 0, 1, 1], length))
    assert len(cracked.damage) == 2
    for argument in ({"tau": Lying(0.1, length)}, {"max_dets": Lying(1, length)}, {"iou_thresholds": range(length)}):
        with pytest.raises((ValueError, TypeError, OSError)):
            starbreak.evaluate(clean="nowhere", ground_truth="nowhere", **argument)
    with pytest.raises(ValueError):
        starbreak.Recipe(set=Lying("camera.fnumber=2", length))
    with pytest.raises(TypeError):
        starbreak.Recipe(set=range(length))


def test_what_never_ends_is_ended(image, small):
    boxes = Endless([[0, 0, 1, 1]])
    assert len(starbreak.crack(image, small, boxes=boxes).damage) == 1
    for call in (
        lambda: starbreak.Recipe(set={"impact.position": Endless([0.5])}),
        lambda: starbreak.Recipe.from_dict({"impact": Endless([{"position": 1}])}),
        lambda: starbreak.Recipe(set=Endless(["camera.fnumber=2"])),
        lambda: starbreak.evaluate(clean="nowhere", ground_truth="nowhere", tau=Endless([7.0])),
    ):
        with pytest.raises((ValueError, OSError)):
            call()
    many = [1.0]
    for _ in range(12):
        many = [many] * 100
    with pytest.raises(ValueError, match="more than 100000 values"):
        starbreak.Recipe.from_dict({"impact": many})


def test_a_forged_pickle_is_an_exception(image, small):
    network = starbreak.simulate(small, 1, (128, 96))
    draw = random.Random(1)
    for thing in (small, network):
        whole = pickle.dumps(thing, 2)
        assert pickle.loads(whole) == thing
        for _ in range(500):
            forged = bytearray(whole)
            for _ in range(draw.randint(1, 3)):
                forged[draw.randrange(60, len(forged))] = draw.randrange(256)
            try:
                pickle.loads(bytes(forged))
            except Exception:  # noqa: S110 - any but a panic, which is no Exception
                pass
    for kind in (starbreak.CrackNetwork, starbreak.Cracked):
        with pytest.raises(TypeError):
            kind.__new__(kind)
    with pytest.raises(OSError):
        starbreak.PatternBank._reopen("/nowhere", "0")


def run(program, timeout=60):
    """What a program says that ends well."""
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program)], capture_output=True, text=True, timeout=timeout, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_interpreter_ends_while_threads_are_at_work():
    for _ in range(5):
        run(
            """
            import threading, time, numpy as np, starbreak
            image = np.zeros((96, 128, 3), np.uint8)
            def work():
                while True:
                    starbreak.crack(image, "paper", 1)
            for _ in range(4):
                threading.Thread(target=work, daemon=True).start()
            time.sleep(0.2)
            """
        )


def test_work_at_the_end_of_the_interpreter():
    said = run(
        """
        import atexit, numpy as np, starbreak
        image = np.zeros((9, 9, 3), np.uint8)
        class Kept:
            def __del__(self):
                print(starbreak.crack(image, "paper", 1).shape)
        kept = Kept()
        atexit.register(lambda: print(starbreak.crack(image, "paper", 1).shape))
        """
    )
    assert said == "(9, 9, 3)\n(9, 9, 3)\n"


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers")
def test_a_signal_is_heard_between_calls(image, small):
    def heard(*_):
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, heard)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(KeyboardInterrupt):
            while True:
                starbreak.crack(image, small, 1)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_an_array_that_changes_meanwhile_is_read_once(small):
    image = picture(300, 400)
    done = threading.Event()

    def change():
        while not done.is_set():
            image[:] = 255 - image
            try:
                image.resize((30, 40, 3), refcheck=False)
                image.resize((300, 400, 3), refcheck=False)
            except ValueError:
                pass

    thread = threading.Thread(target=change)
    thread.start()
    try:
        for _ in range(20):
            try:
                starbreak.crack(image, small, 1)
            except ValueError:
                pass
    finally:
        done.set()
        thread.join()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
def test_a_raw_fork_goes_on(image, small):
    expected = starbreak.crack(image, small, 1)
    child = os.fork()
    if child == 0:
        same = (starbreak.crack(image, small, 1) == expected).all()
        os._exit(0 if same else 1)
    assert os.waitpid(child, 0)[1] == 0


def test_strides_of_nothing_and_backwards(small):
    values = np.arange(5000, dtype=np.uint8)
    for shape, strides in (((20, 30, 3), (0, 0, 0)), ((20, 30, 3), (-3, 0, 1)), ((20, 30), (0, 1))):
        view = np.lib.stride_tricks.as_strided(values[2000:], shape, strides)
        np.testing.assert_array_equal(
            starbreak.crack(view, "paper", 1), starbreak.crack(view.copy(), "paper", 1), err_msg=str(strides)
        )
