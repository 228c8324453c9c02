"""FastestDet and YOLOX-nano over coco96: outputs and detections beside ONNX Runtime, OpenCV and NumPy.

detectors.py EXAMPLE [STARBREAK]: EXAMPLE is examples/detector_outputs; with STARBREAK the AP of the
command is counted, too. Ends with an error if an output
is off by more than 1e-3, if a detection is off by more than 1e-3 px from the reference's
post-processing of the same outputs, or if more than one in a
thousand has no partner within 0.1 px and 1e-3 of score in the whole reference: an overlap or a score
just at its threshold falls to the other side there.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import cv2
import numpy as np
import onnxruntime
from pycocotools.coco import COCO
from pycocotools.cocoeval import COCOeval

ROOT = pathlib.Path(__file__).resolve().parent.parent
DATA = ROOT.parent / "shared" / "data"
TOLERANCE = 1e-3
# Boxes multiply what differs in an output by strides and exponentials.
REACH_PX = 0.1
# AP and AP50 in percent on all 128 images that the 96 were cut from.
WHOLE_SET = {"FastestDet": (18.65, 32.8), "yolox_nano": (34.24, 52.7)}


def f32(x):
    return np.asarray(x, np.float32)


def yolox_input(image):
    height, width = image.shape[:2]
    gain = min(416 / height, 416 / width)
    frame = np.full((416, 416, 3), 114, np.uint8)
    size = int(width * gain), int(height * gain)
    frame[: size[1], : size[0]] = cv2.resize(image, size, interpolation=cv2.INTER_LINEAR)
    return f32(frame.transpose(2, 0, 1))[None], gain


def yolox_boxes(raw, image):
    """Corners in px of the image, class, score: all classes above 0.001, suppressed per class at 0.65."""
    height, width = image.shape[:2]
    gain = min(416 / height, 416 / width)
    cells, strides = [], []
    for stride in (8, 16, 32):
        n = 416 // stride
        y, x = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")
        cells.append(np.stack((x, y), 2).reshape(-1, 2))
        strides.append(np.full((n * n, 1), stride))
    cells, strides = f32(np.concatenate(cells)), f32(np.concatenate(strides))
    raw = raw[0]
    center, size = (raw[:, :2] + cells) * strides, np.exp(raw[:, 2:4]) * strides
    corners = np.concatenate((center - size / 2, center + size / 2), 1)
    scores = raw[:, 4:5] * raw[:, 5:]
    place, label = np.nonzero(scores >= f32(0.001))
    return suppressed(corners[place], label, scores[place, label], 0.65, gain, gain)


def fastestdet_input(image):
    frame = cv2.resize(image, (352, 352), interpolation=cv2.INTER_AREA)
    return f32(frame.transpose(2, 0, 1))[None] / f32(255), None


def fastestdet_boxes(raw, image):
    """The best class of each cell, objectness^0.6 class^0.4 above 0.001, suppressed per class at 0.45."""
    height, width = image.shape[:2]
    raw = raw[0]
    _, rows, columns = raw.shape
    y, x = np.meshgrid(f32(np.arange(rows)), f32(np.arange(columns)), indexing="ij")
    sigmoid = lambda v: f32(1) / (f32(1) + np.exp(-v))
    center = (np.tanh(raw[1]) + x) / f32(columns), (np.tanh(raw[2]) + y) / f32(rows)
    size = sigmoid(raw[3]), sigmoid(raw[4])
    corners = np.stack(
        (center[0] - size[0] / 2, center[1] - size[1] / 2, center[0] + size[0] / 2, center[1] + size[1] / 2), 2
    ).reshape(-1, 4)
    label = raw[5:].argmax(0).reshape(-1)
    score = (raw[0] ** f32(0.6) * raw[5:].max(0) ** f32(0.4)).reshape(-1)
    keep = score >= f32(0.001)
    return suppressed(corners[keep], label[keep], score[keep], 0.45, 1 / width, 1 / height)


def suppressed(corners, labels, scores, iou, gain_x, gain_y):
    order = np.argsort(-scores, kind="stable")
    kept = {}
    out = []
    for i in order[:30000]:
        box = corners[i]
        area = (box[2] - box[0]) * (box[3] - box[1])
        rivals = kept.setdefault(int(labels[i]), [])
        if rivals:
            r = np.stack(rivals)
            w = np.maximum(np.minimum(r[:, 2], box[2]) - np.maximum(r[:, 0], box[0]), 0)
            h = np.maximum(np.minimum(r[:, 3], box[3]) - np.maximum(r[:, 1], box[1]), 0)
            both = w * h
            areas = (r[:, 2] - r[:, 0]) * (r[:, 3] - r[:, 1])
            if (both / (areas + area - both) > f32(iou)).any():
                continue
        rivals.append(box)
        x0, y0, x1, y1 = (float(v) for v in box)
        out.append((int(labels[i]), [x0 / gain_x, y0 / gain_y, x1 / gain_x, y1 / gain_y], float(scores[i])))
    return out[:300]


MODELS = {
    "FastestDet": (fastestdet_input, fastestdet_boxes),
    "yolox_nano": (yolox_input, yolox_boxes),
}


def differ(ours, theirs, reach_px):
    """Largest difference of boxes, px, and of scores over pairs, pairs whose boxes are off by more
    than 1e-3 px, and how many of either list have no partner within reach."""
    left = [(c, np.array(b), s) for c, b, s in theirs]
    worst_px = worst_score = 0.0
    n_off = lonely = 0
    for label, box, score in ours:
        near = [
            (max(np.abs(other - box).max(), abs(s - score)), k)
            for k, (c, other, s) in enumerate(left)
            if c == label and abs(s - score) <= TOLERANCE and np.abs(other - box).max() <= reach_px
        ]
        if not near:
            lonely += 1
            continue
        _, other, other_score = left.pop(min(near)[1])
        off_px = float(np.abs(other - box).max())
        n_off += off_px > TOLERANCE
        worst_px = max(worst_px, off_px)
        worst_score = max(worst_score, abs(other_score - score))
    return np.array([worst_px, worst_score]), np.array([n_off, lonely + len(left)])


def average_precision(truth, rows):
    results = truth.loadRes(rows)
    count = COCOeval(truth, results, "bbox")
    count.evaluate()
    count.accumulate()
    count.summarize()
    return count.stats[0] * 100, count.stats[1] * 100


def quietly(function, *args):
    import contextlib
    import io

    with contextlib.redirect_stdout(io.StringIO()):
        return function(*args)


def main():
    example = sys.argv[1]
    starbreak = sys.argv[2] if len(sys.argv) > 2 else None
    truth = quietly(COCO, str(next((DATA / "coco96" / "annotations").glob("instances_*.json"))))
    numbers = sorted(truth.getCatIds())
    ids = {pathlib.Path(i["file_name"]).stem: i["id"] for i in truth.dataset["images"]}
    library = next((pathlib.Path(onnxruntime.__file__).parent / "capi").glob("libonnxruntime.so*"), None)
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        images = {}
        # As PNG, so that both sides see the same pixels.
        for path in sorted((DATA / "coco96" / "val2017").iterdir()):
            images[path.stem] = cv2.imread(str(path))
            cv2.imwrite(str(folder / f"{path.stem}.png"), images[path.stem])
        pngs = [str(folder / f"{stem}.png") for stem in images]
        for name, (input_of, boxes_of) in MODELS.items():
            model = DATA / "onnx" / f"{name}.onnx"
            session = onnxruntime.InferenceSession(str(model), providers=["CPUExecutionProvider"])
            raw, theirs = {}, {}
            for stem, image in images.items():
                raw[stem] = session.run(None, {session.get_inputs()[0].name: input_of(image)[0]})[0]
                theirs[stem] = boxes_of(raw[stem], image)
            for backend in ("rten", "ONNX Runtime"):
                out = folder / f"{name}-{backend}"
                flags = ["--onnxruntime", str(library)] if backend != "rten" else []
                run = subprocess.run([example, str(model), str(out), *flags, *pngs], capture_output=True, text=True)
                if run.returncode:
                    print(f"{name} by {backend}: not run: {run.stderr.strip().splitlines()[-1]}")
                    failed = True
                    continue
                worst_raw, n, rows = 0.0, 0, []
                same = [np.zeros(2), np.zeros(2, int)]
                whole = [np.zeros(2), np.zeros(2, int)]
                for stem, image in images.items():
                    ours_raw = np.load(out / f"{stem}.0.npy")
                    ours = [tuple(row) for row in json.loads((out / f"{stem}.json").read_text())]
                    worst_raw = max(worst_raw, float(np.abs(ours_raw - raw[stem]).max()))
                    for total, other, reach_px in (
                        (same, boxes_of(ours_raw, image), TOLERANCE),
                        (whole, theirs[stem], REACH_PX),
                    ):
                        worst, counts = differ(ours, other, reach_px)
                        total[0] = np.maximum(total[0], worst)
                        total[1] += counts
                    n += len(ours)
                    rows += as_results(ours, ids[stem], numbers)
                ap = quietly(average_precision, truth, rows)
                is_bad = worst_raw > TOLERANCE or same[1][1] > 0 or whole[1][1] > n / 1000
                failed |= is_bad
                print(
                    f"{name} by {backend}, {len(images)} images: outputs differ from ONNX Runtime "
                    f"{onnxruntime.__version__} by {worst_raw:.1e} at most. {n} detections. From the reference's "
                    f"post-processing of the same outputs they differ by {same[0][0]:.1e} px and {same[0][1]:.1e} of "
                    f"score at most, {same[1][1]} have no partner. From the whole reference by {whole[0][0]:.1e} px "
                    f"({whole[1][0]} of them by more than {TOLERANCE} px) and {whole[0][1]:.1e} of score, "
                    f"{whole[1][1]} have no partner. AP {ap[0]:.2f} AP50 {ap[1]:.2f} {'FAIL' if is_bad else 'ok'}"
                )
            rows = [row for stem in images for row in as_results(theirs[stem], ids[stem], numbers)]
            ap = quietly(average_precision, truth, rows)
            print(f"{name} by the reference: AP {ap[0]:.2f} AP50 {ap[1]:.2f}")
            if starbreak:
                out = folder / f"{name}.json"
                command = [starbreak, "detect", "--quiet", "--model", str(model)]
                subprocess.run([*command, f"coco:{DATA / 'coco96'}", "-o", str(out)], check=True)
                ap = quietly(average_precision, truth, json.loads(out.read_text()))
                print(f"{name} by `starbreak detect` of the JPEG files: AP {ap[0]:.2f} AP50 {ap[1]:.2f}")
            whole = WHOLE_SET[name]
            print(f"{name} on the 128 images that these were cut from: AP {whole[0]} AP50 {whole[1]}")
    sys.exit(int(failed))


def as_results(detections, image_id, numbers):
    return [
        {
            "image_id": image_id,
            "category_id": numbers[label],
            "bbox": [box[0], box[1], box[2] - box[0], box[3] - box[1]],
            "score": score,
        }
        for label, box, score in detections
    ]


main()
