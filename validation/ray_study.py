#!/usr/bin/env python3
"""A study on a local Ray with one and with two workers, and on one machine; and what a shard costs of many images.

usage: ray_study.py SOURCE MODEL... [ROUNDS]
needs ray[data], Pillow and the package starbreak; ends with 1 if files differ.
"""
import json
import pathlib
import resource
import shutil
import subprocess
import sys
import tempfile
import time

import ray
import starbreak
import starbreak.ray
from PIL import Image

STUDY = {"presets": ["windshield-star"], "severities": [3, 5], "limit": 32, "replicates": 100, "divergence": "off", "worst": 1}


def files_in(folder):
    return {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def on_ray(n_workers, source, models, folder):
    """Seconds of the steps and of joining and reporting, and the files; starting Ray is not counted."""
    ray.init(num_cpus=n_workers, include_dashboard=False, logging_level="ERROR", log_to_driver=False)
    joining = []
    call = starbreak.ray.call

    def timed(*words):
        begin = time.perf_counter()
        found = call(*words)
        joining.append(time.perf_counter() - begin)
        return found

    starbreak.ray.call = timed
    begin = time.perf_counter()
    starbreak.ray.study(source, models, folder / "study", n_shards=4, **STUDY)
    seconds = time.perf_counter() - begin
    starbreak.ray.call = call
    ray.shutdown()
    return seconds - joining[0], joining[0], files_in(folder / "study")


def alone(n_threads, source, models, folder):
    """The same in this process."""
    begin = time.perf_counter()
    starbreak.study(source, models, folder / "study", threads=n_threads, **STUDY)
    return time.perf_counter() - begin, files_in(folder / "study")


def many_images(model, n_images):
    """Seconds and peak MiB of a dry run over so many small images with seven labels each: what each task begins with."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        (root / "val2017").mkdir()
        (root / "annotations").mkdir()
        first = root / "val2017" / f"{1:012}.png"
        Image.new("RGB", (64, 48), (90, 80, 70)).save(first)
        images, annotations = [], []
        for k in range(1, n_images + 1):
            path = root / "val2017" / f"{k:012}.png"
            if k > 1:
                # File systems give one file some 60,000 names.
                path.hardlink_to(first) if k % 50_000 else shutil.copy(first, path)
                first = path if k % 50_000 == 0 else first
            images.append({"id": k, "file_name": path.name, "width": 64, "height": 48})
            box = {"bbox": [10.5, 8.25, 20.5, 15.75], "area": 322.9, "iscrowd": 0, "category_id": 1}
            annotations += [{"id": 7 * k + j, "image_id": k, **box} for j in range(7)]
        labels = {"images": images, "annotations": annotations, "categories": [{"id": 1, "name": "person"}]}
        (root / "annotations/instances_val2017.json").write_text(json.dumps(labels))
        words = f"import starbreak; starbreak.study('coco:{root}', {model!r}, '{root}-out', dry_run=True)"
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", words], check=True)
        return time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024


def main():
    *words, last = sys.argv[1:]
    n_rounds, words = (int(last), words) if last.isdigit() else (3, [*words, last])
    source, models = words[0], words[1:]
    print(f"ray {ray.__version__}, {len(models)} detectors, 32 images, two conditions, 4 shards; seconds: the steps, joining and report")
    for n_images in (10_000, 100_000):
        seconds, mib = many_images(models[0], n_images)
        print(f"a task begins after {seconds:.1f} s with {mib:.0f} MiB, of {n_images} images with 7 labels each")
    best, files = {}, {}
    for _ in range(n_rounds):
        for name in ("Ray, 1 worker", "Ray, 2 workers", "1 thread", "2 threads"):
            n = int("".join(filter(str.isdigit, name)))
            with tempfile.TemporaryDirectory() as folder:
                if name.startswith("Ray"):
                    steps, joining, found = on_ray(n, source, models, pathlib.Path(folder))
                    row = (steps + joining, f"{steps:6.1f} {joining:6.1f}")
                else:
                    seconds, found = alone(n, source, models, pathlib.Path(folder))
                    row = (seconds, f"{seconds:6.1f}")
            best[name] = min(best.get(name, row), row)
            # The folder is named in the report.
            files[name] = {str(path): data for path, data in found.items() if path.parts[0] in ("sets", "detections")}
    for name, (_, text) in best.items():
        print(f"{name:16} {text}")
    one, two = (float(best[f"Ray, {n}"][1].split()[0]) for n in ("1 worker", "2 workers"))
    print(f"steps of two workers: {one / two:.2f} times as fast as one")
    same = all(found == files["1 thread"] for found in files.values())
    print(f"{len(files['1 thread'])} files of sets and detections: {'the same bytes' if same else 'DIFFERENT'}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
