"""Whether two versions of the command give the same pixels: `python same_pixels.py OLD NEW [N]`.

N (200) random recipes with fixed seeds: a preset, a severity, a camera, a frame size, a hit and some optics each;
`crack` by both, and image, region and crack mask compared byte by byte. Ends with 1 if any differs.
"""

import hashlib
import random
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

PRESETS = [
    "windshield-star", "windshield-bullseye", "windshield-combination", "windshield-long-crack",
    "windshield-spiderweb", "windshield-gravel", "windshield-hail", "tempered-cover", "lens-cover-star",
    "lens-cover-shattered", "paper",
]
SIZES = [(320, 180), (401, 233), (640, 192), (200, 300)]


def ppm(path, size, draw):
    """A picture of sky, ground and noise, as PNG by the standard library."""
    import struct
    import zlib

    width, height = size
    rows = bytearray()
    for y in range(height):
        rows.append(0)
        sky = y < height * 0.45
        for _ in range(width):
            base = (150, 170, 200) if sky else (90, 88, 85)
            rows += bytes(max(0, min(255, channel + draw.randint(-12, 12))) for channel in base)

    def chunk(kind, data):
        body = kind + data
        return struct.pack(">I", len(data)) + body + struct.pack(">I", zlib.crc32(body))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    content = chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 1)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + content)


def arguments(draw):
    preset = draw.choice(PRESETS)
    words = ["--preset", preset, "--severity", str(draw.randint(1, 5)), "--seed", str(draw.randrange(1 << 32))]
    sets = [f"impact.position=[{draw.uniform(0.2, 0.8):.3f}, {draw.uniform(0.2, 0.8):.3f}]"]
    if preset == "paper":
        sets.append(f"fracture.particles={draw.randint(500, 4000)}")
    else:
        sets.append("fracture.mesh=fast")
        if draw.random() < 0.3:
            sets.append(f"camera.f_number={draw.choice([1.8, 2.8, 8])}")
        if draw.random() < 0.3:
            sets.append(f"glass.rake_deg={draw.choice([0, 20, 50])}")
    for assignment in sets:
        words += ["--set", assignment]
    return words


def digest(folder):
    parts = [hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.png"))]
    return " ".join(parts)


def main():
    old, new = (str(Path(program).resolve()) for program in sys.argv[1:3])
    n = int(sys.argv[3]) if len(sys.argv) > 3 else 200
    with tempfile.TemporaryDirectory() as temporary:
        root = Path(temporary)

        def one(k):
            draw = random.Random(k)
            image = root / f"{k}.png"
            ppm(image, draw.choice(SIZES), draw)
            words = arguments(draw)
            results = []
            for name, program in (("old", old), ("new", new)):
                out = root / f"{k}-{name}"
                done = subprocess.run(
                    [program, "crack", str(image), "-o", str(out), "--threads", "1", "--quiet", *words],
                    capture_output=True, text=True, check=False,
                )
                results.append((done.returncode, done.stderr if done.returncode else "", digest(out)))
            return k, words, results

        with ThreadPoolExecutor(2) as pool:
            outcomes = list(pool.map(one, range(n)))
    n_images = sum(results[0][0] == 0 for _, _, results in outcomes)
    wrong = [(k, words) for k, words, results in outcomes if results[0] != results[1]]
    for k, words in wrong:
        print(f"recipe {k} differs: {' '.join(words)}")
    print(f"{n} recipes: {n_images} pictures, {n - n_images} refused alike, {len(wrong)} differ")
    return 1 if wrong or n_images < n // 2 else 0


sys.exit(main())
