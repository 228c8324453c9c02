"""Banks of 10,000 patterns with both models: time, memory and size.

Takes ten minutes on two idle cores and 2.5 GB of disk at a time.
Usage: banks.py STARBREAK
"""

import os
import subprocess
import sys
import tempfile
import time


def bank(starbreak: str, preset: str, n: int) -> None:
    with tempfile.TemporaryDirectory() as folder:
        command = [starbreak, "patterns", "--preset", preset, "-n", str(n), "--quiet", "-o", f"{folder}/bank"]
        begin = time.monotonic()
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.monotonic() - begin
        if status != 0:
            sys.exit(f"starbreak patterns --preset {preset} ended with {status}")
        size = os.path.getsize(f"{folder}/bank/patterns.bank")
        cpu = usage.ru_utime + usage.ru_stime
        print(
            f"{preset:16} | {n} | {seconds:6.0f} s | {cpu:6.0f} s | {1e3 * cpu / n:6.1f} ms |"
            f" {usage.ru_maxrss / 1024:5.0f} MiB | {size / 1e9:.2f} GB"
        )


if __name__ == "__main__":
    print("preset           | patterns | wall | CPU | CPU each | peak RSS | size on disk")
    for preset in ("paper", "windshield-star"):
        bank(sys.argv[1], preset, 10_000)
