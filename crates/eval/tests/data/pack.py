"""Packs reference cases into reference.zz: `python pack.py FOLDER`, with coco/, kitti/ and kl_ref.json in it.

The cases are random labels and detections of a generator of this project; what belongs to them was made by
pycocotools 2.0.11 (coco/*/ref), confirmed by the compiled development kit of KITTI (kitti/ref.json), or made by
NumPy and SciPy (kl_ref.json). The archive is zlib over one entry after another: the length of the path as u32,
that of the content as u32, both little endian, then path and content.
"""

import struct
import sys
import zlib
from pathlib import Path

root = Path(sys.argv[1])
files = [path for part in ("coco", "kitti") for path in sorted((root / part).rglob("*")) if path.is_file()]
entries = b""
for path in [*files, root / "kl_ref.json"]:
    if path.name == "matches.json":  # read by no test
        continue
    name, content = path.relative_to(root).as_posix().encode(), path.read_bytes()
    entries += struct.pack("<II", len(name), len(content)) + name + content
Path(__file__).with_name("reference.zz").write_bytes(zlib.compress(entries, 9))
