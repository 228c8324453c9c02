#!/usr/bin/env python3
"""A written dataset against its source, both loaded by public tools: same images, same labels, value for value.

usage: dataset_loaders.py SOURCE OUT {kitti,coco,bdd,yolo} [--subset]

With --subset OUT may have fewer images than SOURCE, but what it has is as in SOURCE.
needs requirements-loaders.txt, in an environment of its own, for scalabel 0.3.1 reads nothing with pydantic 2:
pycocotools for coco, scalabel for bdd, supervision for yolo (none of them brings torch). kitti is read by the fields of
the devkit's readme, and its label files are compared byte for byte.
"""
import pathlib
import sys

from PIL import Image

SUFFIXES = {".png", ".jpg", ".jpeg"}


def same(what, source, out, is_subset):
    """All keys of `out` are in `source` with equal values; without `is_subset` the reverse as well."""
    extra = sorted(map(str, set(out) - set(source)))[:3]
    missing = sorted(map(str, set(source) - set(out)))[:3]
    differ = [key for key in out if key in source and out[key] != source[key]][:3]
    if extra or differ or (missing and not is_subset):
        sys.exit(f"{what}: not in the source {extra}, missing {missing}, different {differ}")
    if not out:
        sys.exit(f"{what}: none")
    print(f"{what}: {len(out)} of {len(source)}")


def indexes(root, pattern):
    found = {str(path.relative_to(root)): path for path in sorted(root.glob(pattern))}
    return found or sys.exit(f"{root}: no {pattern}")


def coco(root):
    from pycocotools.coco import COCO

    tables = {"images": {}, "annotations": {}, "categories": {}, "annotations of images": {}}
    for name, path in indexes(root, "annotations/instances_*.json").items():
        data = COCO(str(path))
        tables["images"] |= {(name, key): value for key, value in data.imgs.items()}
        tables["annotations"] |= {(name, key): value for key, value in data.anns.items()}
        tables["categories"] |= {(name, key): value for key, value in data.cats.items()}
        tables["annotations of images"] |= {(name, key): data.getAnnIds(imgIds=[key]) for key in data.imgs}
        if len(data.anns) != len(data.dataset["annotations"]) or len(data.imgs) != len(data.dataset["images"]):
            sys.exit(f"{path}: ids occur twice")
    return tables


def bdd(root):
    from scalabel.label.io import load

    pattern = next(p for p in ("labels/det_20/*.json", "labels/*.json", "*.json") if any(root.glob(p)))
    frames, configs = {}, {}
    for name, path in indexes(root, pattern).items():
        data = load(str(path))
        frames |= {(name, frame.videoName, frame.name): frame.dict() for frame in data.frames}
        configs[name] = data.config and str(data.config)
    return {"frames": frames, "configs": configs}


def yolo(root):
    import supervision

    tables = {"classes": {}, "boxes": {}}
    for images in sorted({path.parent for path in root.rglob("*") if path.suffix.lower() in SUFFIXES and "images" in path.relative_to(root).parts}):
        parts = list(images.relative_to(root).parts)
        at = len(parts) - 1 - parts[::-1].index("images")
        labels = root.joinpath(*parts[:at], "labels", *parts[at + 1:])
        if not labels.is_dir():
            continue
        data = supervision.DetectionDataset.from_yolo(str(images), str(labels), str(root / "data.yaml"))
        tables["classes"][str(images.relative_to(root))] = data.classes
        for path, _, detections in data:
            name = str(pathlib.Path(path).relative_to(root))
            tables["boxes"][name] = (detections.xyxy.tolist(), detections.class_id.tolist())
    return tables


def kitti(root):
    types = {"Car", "Van", "Truck", "Pedestrian", "Person_sitting", "Cyclist", "Tram", "Misc", "DontCare"}
    tables = {"labels": {}, "objects": {}}
    for path in sorted(root.rglob("label_2/*.txt")):
        name = str(path.relative_to(root))
        tables["labels"][name] = path.read_bytes()
        for number, line in enumerate(path.read_text().splitlines()):
            kind, *numbers = line.split(" ")
            if kind not in types or len(numbers) not in (14, 15):
                sys.exit(f"{name}:{number + 1}: not a KITTI object")
            tables["objects"][name, number] = (kind, [float(text) for text in numbers])
        if not any(path.parent.parent.joinpath("image_2").glob(path.stem + ".*")):
            sys.exit(f"{name}: no image")
    return tables


def sizes(root, names=None):
    """Width and height of each image, decoded so that a broken one is found."""
    table = {}
    for path in sorted(root.rglob("*")):
        name = str(path.relative_to(root))
        if path.suffix.lower() in SUFFIXES and (names is None or name in names):
            with Image.open(path) as image:
                image.load()
                table[name] = image.size
    return table


def main():
    is_subset = "--subset" in sys.argv
    source, out, name = [arg for arg in sys.argv[1:] if arg != "--subset"]
    source, out = pathlib.Path(source), pathlib.Path(out)
    load = {"coco": coco, "bdd": bdd, "yolo": yolo, "kitti": kitti}[name]
    before, after = load(source), load(out)
    for what in before:
        same(what, before[what], after[what], is_subset)
    of_source = sizes(source)
    same("images", of_source, sizes(out, set(of_source)), is_subset)
    print("same")


if __name__ == "__main__":
    main()
