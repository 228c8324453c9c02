"""Worker processes: forked or spawned, any number of them, the same pictures, one thread each."""

import hashlib
import multiprocessing
import os
import sys
import threading

import pytest
import starbreak
from conftest import SMALL, picture

N_ITEMS = 12

#: Set before workers fork, as a data set in a loader is.
STATE = {}


def digest(k):
    """What item k becomes, and how many threads the process has then."""
    recipes = STATE or {"paper": starbreak.Recipe("paper", set=SMALL), "physics": starbreak.Recipe(set={"fracture.mesh": "fast"})}
    bytes_of_all = b"".join(
        starbreak.crack(picture(seed=k), recipe, 5, name=f"{k}.png").tobytes() for recipe in recipes.values()
    )
    return hashlib.sha256(bytes_of_all).hexdigest(), n_threads()


def n_threads():
    return len(os.listdir("/proc/self/task")) if sys.platform == "linux" else 1


@pytest.fixture(scope="module")
def expected():
    return [digest(k)[0] for k in range(N_ITEMS)]


@pytest.mark.parametrize("method", ["fork", "spawn"])
@pytest.mark.parametrize("n_workers", [1, 2, 4])
def test_workers_make_what_one_process_makes(method, n_workers, expected):
    if method not in multiprocessing.get_all_start_methods():
        pytest.skip(f"this system cannot {method}")
    with multiprocessing.get_context(method).Pool(n_workers) as pool:
        made = pool.map(digest, range(N_ITEMS), chunksize=1)
    assert [bytes_of_item for bytes_of_item, _ in made] == expected


@pytest.mark.skipif(sys.platform != "linux", reason="threads are counted in /proc")
def test_no_thread_is_started():
    before = n_threads()
    starbreak.crack(picture(), "windshield-star", 1, full=True)
    starbreak.simulate("tempered-cover", 1)
    assert n_threads() == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system cannot fork")
def test_a_child_of_a_busy_process_is_not_stuck():
    """Fork while other threads are inside the library: the child waits for none of their locks."""
    stop = threading.Event()
    # That of the child, and so many others that none of what is kept stays for long.
    recipes = [starbreak.Recipe(set={"fracture.mesh": "fast", "glass.thickness_mm": 2.1 + 0.1 * k}) for k in range(6)]

    def work():
        while not stop.is_set():
            for recipe in recipes:
                starbreak.crack(picture(), recipe, 1)

    threads = [threading.Thread(target=work) for _ in range(3)]
    for thread in threads:
        thread.start()
    expected = digest(3)[0]
    try:
        for _ in range(5):
            context = multiprocessing.get_context("fork")
            queue = context.SimpleQueue()
            child = context.Process(target=lambda: queue.put(digest(3)[0]))
            child.start()
            child.join(60)
            assert child.exitcode == 0
            assert queue.get() == expected
    finally:
        stop.set()
        for thread in threads:
            thread.join()


def test_a_bank_is_read_by_forked_and_spawned_workers(command, tmp_path):
    command("patterns", "-n", 5, "-o", tmp_path, "--size", "128x96", "--set", "fracture.mesh=fast")
    bank = starbreak.PatternBank(tmp_path)
    seeds = range(20)
    expected = [bank.crack(picture(), seed).tobytes() for seed in seeds]
    for method in multiprocessing.get_all_start_methods():
        with multiprocessing.get_context(method).Pool(2) as pool:
            made = pool.starmap(from_bank, [(bank, seed) for seed in seeds], chunksize=1)
        assert made == expected, method


def from_bank(bank, seed):
    return bank.crack(picture(), seed).tobytes()
