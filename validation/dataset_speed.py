"""Images per second of `starbreak generate` against decoding and encoding alone.

    cargo build --release -p starbreak-cli && cargo build --release -p starbreak --example recode
    python3 validation/dataset_speed.py [N] [THREADS]

Sets: a synthetic KITTI-like one of N PNG frames (1242x375, made here from a street that a formula
draws, with noise), and coco96, the BDD frames (JPEG, 1280x720) and the KITTI frames of ../shared/data,
100 copies of each frame, where they are. In turns: recode (the floor; it hashes what it reads, as
`generate` does) and `generate` from a bank with all frame sizes of the set; after a round that does
not count the least of twenty rounds, of three where there are more than 500 images, and the ratio of
the medians of images/s. Then fresh physics, the lesser of two. CPU seconds are user and system time of
the process. The folder of temporary files decides whether it is a disk or memory (TMPDIR=/dev/shm)
that is written to. On a disk that takes some 30 GB, as nothing is deleted before the end.
"""
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
STARBREAK = TARGET / "starbreak"
RECODE = TARGET / "examples" / "recode"
SHARED = ROOT.parent / "shared" / "data"
N_COPIES = 100
IN_MEMORY = tempfile.gettempdir().startswith("/dev/shm")


def street(k, rng):
    """A frame with the statistics of a street: sky, facades, road, boxes, and sensor noise."""
    import numpy as np

    h, w = 375, 1242
    y, x = np.mgrid[0:h, 0:w].astype(np.float32)
    sky = 200 - 0.25 * y + 8 * np.sin(x / 90 + k)
    road = 70 + 0.12 * y + 6 * np.sin(x / 7.0 + y / 3.0)
    facade = 110 + 40 * (np.sin(x / 11 + k) > 0.3) * (np.sin(y / 9) > 0.1)
    lum = np.where(y < 140, np.where(np.sin(x / 160 + k) > 0, sky, facade), road)
    image = np.stack([lum * 0.98, lum, lum * 1.03], axis=2)
    for _ in range(12):
        bw, bh = int(rng.integers(20, 160)), int(rng.integers(20, 90))
        x0, y0 = int(rng.integers(0, w - bw)), int(rng.integers(120, h - bh))
        image[y0:y0 + bh, x0:x0 + bw] = rng.integers(20, 230, 3)
    image += rng.normal(0, 2.5, image.shape)
    return np.clip(image, 0, 255).astype(np.uint8)


def make_kitti(root, n):
    import numpy as np
    from PIL import Image

    rng = np.random.default_rng(1)
    for sub in ("image_2", "label_2", "calib"):
        (root / sub).mkdir(parents=True)
    for k in range(n):
        Image.fromarray(street(k, rng)).save(root / f"image_2/{k:06}.png", compress_level=1)
        labels = "".join(
            f"Car 0.00 0 -1.5 {100 + 90 * j}.00 170.00 {170 + 90 * j}.00 220.00 1.5 1.6 3.9 -0.6 1.7 {20 + j}.0 -1.6\n"
            for j in range(6)
        )
        (root / f"label_2/{k:06}.txt").write_text(labels)
        (root / f"calib/{k:06}.txt").write_text("P2: 721.5 0 609.6 44.9 0 721.5 172.9 0.2 0 0 1 0\n")


def timed(command):
    # Nobody pays for what the one before has left to be written.
    os.sync()
    started = time.perf_counter()
    child = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{command} ended with {status}")
    return time.perf_counter() - started, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    if sys.argv[1:2] == ["--make"]:
        make_kitti(pathlib.Path(sys.argv[2]), int(sys.argv[3]))
        return
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    threads = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    work = pathlib.Path(tempfile.mkdtemp(prefix="starbreak-speed-"))
    try:
        run(work, n, threads)
    finally:
        shutil.rmtree(work)


def run(work, n, threads):
    # In a process of its own: a child counts the most memory of its parent as its own.
    subprocess.run([sys.executable, __file__, "--make", work / "kitti", str(n)], check=True)
    sets = [(f"synthetic KITTI, {n}", f"kitti:{work / 'kitti'}", n)]
    if SHARED.exists():
        sets.append(("coco96", f"coco:{SHARED / 'coco96'}", 96))
        frames = sorted((SHARED / "bdd").glob("*.jpg"))
        (work / "bdd").mkdir()
        n_copied = N_COPIES * len(frames)
        for k in range(n_copied):
            shutil.copy(frames[k % len(frames)], work / f"bdd/{k:03}.jpg")
        sets.append((f"BDD frames, {len(frames)} as {n_copied}", f"folder:{work / 'bdd'}", n_copied))
        frames = sorted((SHARED / "kitti" / "image_2").glob("*.png"))
        n_copied = N_COPIES * len(frames)
        for sub, suffix in (("image_2", "png"), ("label_2", "txt"), ("calib", "txt")):
            (work / "kitti-frames" / sub).mkdir(parents=True)
            for k in range(n_copied):
                source = SHARED / "kitti" / sub / f"{frames[k % len(frames)].stem}.{suffix}"
                shutil.copy(source, work / f"kitti-frames/{sub}/{k:06}.{suffix}")
        sets.append((f"KITTI frames, {len(frames)} as {n_copied}", f"kitti:{work / 'kitti-frames'}", n_copied))
    else:
        print("SKIPPED coco96, BDD frames and KITTI frames: no ../shared/data")
    banks = []
    for name, source, _ in sets:
        bank = work / f"bank-{len(banks)}"
        subprocess.run([STARBREAK, "patterns", "-n", "200", "-o", bank, "--sizes-of", source, "--most-sizes", "64",
                        "--quiet"], check=True)
        banks.append(bank)
    # Memory does not depend on the number of images: the same run over fewer.
    for few in (500, n):
        _, _, rss = timed([STARBREAK, "generate", sets[0][1], "--bank", banks[0], "--limit", few, "--threads", threads,
                           "--quiet", "-o", work / f"few-{few}"])
        print(f"peak RSS of generate from a bank over {min(few, n)} images: {rss:.0f} MiB")
    print("set; run; images/s; CPU s; cores used; peak RSS MiB; images/s and CPU s over those of recode; medians of images/s")
    for (name, source, n_images), bank in zip(sets, banks):
        runs = {
            "recode": [RECODE, threads, source],
            "from a bank": [STARBREAK, "generate", source, "--bank", bank, "--threads", threads, "--quiet", "-o"],
        }
        if n_images <= 500 or "--fresh" in sys.argv:
            runs["fresh physics"] = [STARBREAK, "generate", source, "--threads", threads, "--quiet", "-o"]
        seen = {what: [] for what in runs}
        def measure(what):
            out = work / f"out-{len(list(work.iterdir()))}"
            seen[what].append(timed([*runs[what], out]))
            # On a disk all are kept to the end: one that has just deleted much is slow to create. In
            # memory none is: a virtual machine pays for each page that it has not used of late.
            if IN_MEMORY:
                shutil.rmtree(out)

        for round_ in range(4 if n_images > 500 else 21):
            # To and fro, so that each is as often the first to get what memory was left.
            for what in ["recode", "from a bank"][:: 1 if round_ % 2 == 0 else -1]:
                measure(what)
        for rows in seen.values():
            del rows[:1]
        for what in [what for what in runs if not seen[what]]:
            for _ in range(2):
                measure(what)
        least = {what: [min(column) for column in zip(*rows)] for what, rows in seen.items()}
        median = {what: statistics.median(row[0] for row in rows) for what, rows in seen.items()}
        for what, (wall, cpu, _) in least.items():
            rss = max(row[2] for row in seen[what])
            print(
                f"{name}; {what}; {n_images / wall:.1f}; {cpu:.2f}; {cpu / wall:.2f}; {rss:.0f}; "
                f"{least['recode'][0] / wall:.2f}; {cpu / least['recode'][1]:.2f}; "
                f"{median['recode'] / median[what]:.2f}",
                flush=True,
            )


main()
