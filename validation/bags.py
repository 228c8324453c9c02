"""Time and memory of `starbreak bag` against decoding and rewriting alone.

bags.py STARBREAK RECODE_BAG [ROUNDS] [N_THREADS]

Makes bags of three cameras of 1280 x 720 px, ten images a second: JPEG, and raw images in chunks of zstd, lz4 and
without compression, a short one and one ten times as long of each. Floor and bag alternate; the table has the fastest of the rounds
in seconds of wall clock and of CPU, and the peak memory.
"""

import io
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np
from mcap_ros2.writer import CompressionType, Writer
from PIL import Image, ImageFilter

HEADER = (
    "{0}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "{0}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
).format("=" * 80)
IMAGE = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
) + HEADER
COMPRESSED = "std_msgs/Header header\nstring format\nuint8[] data\n" + HEADER
TOPICS = ("/front", "/left", "/right")
WIDTH, HEIGHT = 1280, 720


def scene(seed):
    """A picture with sky, road and something like texture."""
    random = np.random.default_rng(seed)
    noise = Image.fromarray(random.integers(0, 256, (HEIGHT // 4, WIDTH // 4, 3), np.uint8))
    texture = np.asarray(noise.filter(ImageFilter.GaussianBlur(2)).resize((WIDTH, HEIGHT)), np.float32)
    base = np.linspace(190, 80, HEIGHT, dtype=np.float32)[:, None, None]
    grain = random.normal(0, 2, (HEIGHT, WIDTH, 3))
    return (base + 0.6 * (texture - 128) + grain).clip(0, 255).astype(np.uint8)


def write(path, kind, n):
    scenes = [scene(seed) for seed in range(6)]
    compression = {"zstd": CompressionType.ZSTD, "lz4": CompressionType.LZ4}.get(kind, CompressionType.NONE)
    files = []
    for pixels in scenes:
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "jpeg", quality=90)
        files.append(file.getvalue())
    with open(path, "wb") as out:
        writer = Writer(out, chunk_size=4 << 20, compression=compression)
        name, fields = ("CompressedImage", COMPRESSED) if kind == "jpeg" else ("Image", IMAGE)
        schema = writer.register_msgdef(f"sensor_msgs/msg/{name}", fields)
        for k in range(n):
            stamp = {"sec": 1000 + k // 10, "nanosec": k % 10 * 100_000_000}
            for c, topic in enumerate(TOPICS):
                message = {"header": {"stamp": stamp, "frame_id": topic}}
                at = (k + c) % len(scenes)
                if kind == "jpeg":
                    message |= {"format": "jpeg", "data": files[at]}
                else:
                    size = {"height": HEIGHT, "width": WIDTH, "encoding": "rgb8", "is_bigendian": 0, "step": 3 * WIDTH}
                    message |= {**size, "data": scenes[at].tobytes()}
                writer.write_message(topic, schema, message, k, k, k)
        writer.finish()


def run(words):
    """Wall-clock seconds, CPU seconds and peak memory (MiB)."""
    started = time.perf_counter()
    child = subprocess.Popen(words, stdout=subprocess.DEVNULL)
    peak_kib, pid = 0, 0
    while pid == 0:
        # The peak that the system tells at the end is also that of this program, before it became the other.
        status = pathlib.Path(f"/proc/{child.pid}/status").read_text()
        found = re.search(r"VmHWM:\s*(\d+)", status)
        peak_kib = int(found.group(1)) if found else peak_kib
        time.sleep(0.01)
        pid, code, usage = os.wait4(child.pid, os.WNOHANG)
    assert code == 0, words
    return time.perf_counter() - started, usage.ru_utime + usage.ru_stime, peak_kib / 1024


def main():
    starbreak, recode, *more = sys.argv[1:]
    rounds, threads = int(more[0]) if more else 3, more[1] if len(more) > 1 else "2"
    print(f"{'bag':>5} {'images':>7} {'MB':>6} {'floor s':>8} {'bag s':>7} {'ratio':>6} {'CPU s':>13} {'ratio':>6} {'MiB':>9}")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for kind in ("jpeg", "none", "lz4", "zstd"):
            for n in (20, 200):
                path, out = folder / f"{kind}.mcap", folder / "out.mcap"
                write(path, kind, n)
                results = {"floor": [], "bag": []}
                for _ in range(rounds):
                    results["floor"].append(run([recode, threads, path, out]))
                    out.unlink()
                    results["bag"].append(run([starbreak, "bag", path, "-o", out, "--threads", threads, "--quiet"]))
                    out.unlink()
                least = {key: np.min(values, axis=0) for key, values in results.items()}
                (floor_s, floor_cpu_s, floor_mib), (bag_s, bag_cpu_s, bag_mib) = least["floor"], least["bag"]
                size_mb = path.stat().st_size / 1e6
                print(
                    f"{kind:>5} {3 * n:7} {size_mb:6.0f} {floor_s:8.2f} {bag_s:7.2f} {bag_s / floor_s:6.2f} "
                    f"{floor_cpu_s:6.2f} {bag_cpu_s:6.2f} {bag_cpu_s / floor_cpu_s:6.2f} {floor_mib:4.0f} {bag_mib:4.0f}",
                    flush=True,
                )
                path.unlink()


if __name__ == "__main__":
    main()
