#!/usr/bin/env python3
"""The paper's three architectures with random weights: `detect` beside each framework's own pipeline.

architectures.py STARBREAK [Yolo | FasterRcnn | Retina ...], STARBREAK the command. Needs
requirements-torch.txt, requirements-architectures.txt and requirements-mmdeploy.txt.

- YOLOv8n by Ultralytics, Faster R-CNN (ResNet-50, FPN) by torchvision, RetinaNet-PVTv2-B0 by MMDetection, each
  from its configuration. Weights are drawn from a seed. Batch normalization takes its statistics from the
  pictures, and each channel of the heads' last layers is shifted and scaled over the pictures, so that scores
  spread over 0 to 1 and boxes differ. Such a network finds nothing real: this compares pixels, numbers and
  boxes, not how well a detector detects.
- They are exported by the commands of docs/detectors.md, which are read from that page. MMDeploy's package has
  no tools/deploy.py; the function that this calls is called here, with the settings of its
  detection_onnxruntime_dynamic.py. Torch 2 splits keys from values by an operator that opset 11 lacks and that
  freezes their number in a later one; for the export it is replaced by the split of torch 1, which MMDeploy was
  written for. MMDeploy's own rewriting stays as it is.
- The framework looks at the same PNG files by its own code: `predict` of Ultralytics and the model of torchvision
  in PyTorch, not at the exported file. MMDeploy changes what a model does (boxes are cut at the padded frame, not
  at the image), so its own pipeline of the exported file is what is compared with; how far MMDetection in PyTorch
  is from that is reported. MMCV comes without its compiled operators; the one that is needed, NMS, is torchvision's.
  torchvision's exported file multiplies by reciprocals in 32 bits to scale an image, PyTorch divides in 64: for some
  sizes, such as 640 x 425, the frames differ by a pixel, and with random weights all boxes do. These are compared
  with the exported file in ONNX Runtime only.

A box has a partner if the other side has one of its class with an IoU above 0.99 and a score within 0.01, each
used once. The share counts those with one among those of the side that has more. The least share that passes is
0.98: a box that just passes a threshold of score or overlap on one side and fails on the other takes one or two
with it, of some hundred per picture. Wrong colors and a wrong contract have to fall short of it: this shows that
the comparison sees them. Ends with 1 if a share or a contract is not as it should be.
"""
import contextlib
import functools
import io
import json
import logging
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import types
import warnings

import numpy as np
import PIL.Image
import PIL.ImageDraw

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs/detectors.md").read_text()
PHOTOS = ROOT.parent / "shared/data/coco96/val2017"
# Width and height, px: wide, upright, odd, smaller and larger than every frame.
SIZES = [(1242, 375), (640, 480), (333, 500), (97, 61), (1920, 1080)]
N_PHOTOS = 4
LEAST_IOU, MOST_SCORE, LEAST_SHARE = 0.99, 0.01, 0.98
# COCO's ids of categories that have no class.
GAPS = {12, 26, 29, 30, 45, 66, 68, 69, 71, 83}
COCO_IDS = [k for k in range(1, 91) if k not in GAPS]


def draw(folder):
    """Pictures of shapes over a gradient with noise, and photographs where there are some, as PNG."""
    folder.mkdir()
    for k, (width, height) in enumerate(SIZES):
        rng = np.random.default_rng(k)
        ramp = np.linspace(rng.integers(0, 256, 3), rng.integers(0, 256, 3), width)
        image = PIL.Image.fromarray(np.repeat(ramp[None], height, 0).astype(np.uint8))
        pen = PIL.ImageDraw.Draw(image)
        for _ in range(40):
            x, y = rng.integers(0, width), rng.integers(0, height)
            w, h = rng.integers(2, max(width // 3, 4)), rng.integers(2, max(height // 3, 4))
            shape = pen.rectangle if rng.random() < 0.5 else pen.ellipse
            shape((int(x), int(y), int(x + w), int(y + h)), fill=tuple(int(c) for c in rng.integers(0, 256, 3)))
        noisy = np.asarray(image, np.int16) + rng.integers(-3, 4, (height, width, 3))
        PIL.Image.fromarray(noisy.clip(0, 255).astype(np.uint8)).save(folder / f"drawn-{width}x{height}.png")
    for path in sorted(PHOTOS.glob("*.jpg"))[:N_PHOTOS]:
        image = PIL.Image.open(path).convert("RGB")
        image.save(folder / f"photo-{path.stem}-{image.width}x{image.height}.png")
    return sorted(folder.iterdir())


def command(start):
    """The command of docs/detectors.md that starts so."""
    return re.search(rf"`(?:pip install [^;`]*; )?({re.escape(start)}[^`]*)`", PAGE)[1]


def settle(model, look):
    """Batch normalization with the statistics of the pictures."""
    layers = [layer for layer in model.modules() if isinstance(layer, torch.nn.BatchNorm2d)]
    for layer in layers:
        layer.reset_running_stats()
        layer.momentum = None
        layer.train()
    look()
    for layer in layers:
        layer.eval()


def spread(look, *groups):
    """Last layers of heads, as (layers, spread, count): each channel with mean 0 and this spread over the pictures.
    With count = (threshold, n): then all alike scaled and shifted, so that n scores over all pictures pass the
    threshold and the best is 0.97."""
    layers = [layer for group in groups for layer in group[0]]
    seen = {layer: [] for layer in layers}
    hooks = [
        layer.register_forward_hook(lambda its, _, out: seen[its].append(out.movedim(1, -1).flatten(0, -2)))
        for layer in layers
    ]
    look()
    for hook in hooks:
        hook.remove()
    for layers, std, count in groups:
        best = []
        for layer in layers:
            outputs = torch.cat(seen.pop(layer))
            mean, scale = outputs.mean(0), std / outputs.std(0)
            layer.weight.data *= scale.reshape(-1, *[1] * (layer.weight.dim() - 1))
            layer.bias.data = (layer.bias.data - mean) * scale
            if count:
                outputs = ((outputs - mean) * scale).flatten()
                best.append(outputs.topk(min(count[1], len(outputs))).values)
        if count:
            best = torch.cat(best).sort(descending=True).values
            first, last = float(best[0]), float(best[count[1] - 1])
            logit = lambda p: np.log(p / (1 - p))
            scale = (logit(0.97) - logit(count[0])) / (first - last)
            for layer in layers:
                layer.weight.data *= scale
                layer.bias.data = layer.bias.data * scale + (logit(count[0]) - scale * last)


class Yolo:
    """YOLOv8n of Ultralytics."""

    name, contract, wrong, lacking = "YOLOv8n", "yolov8", "yolov5", "no operator"
    threshold = 0.01

    def __init__(self, folder, pictures):
        import ultralytics
        import ultralytics.utils.nms
        import yaml

        self.by = f"Ultralytics {ultralytics.__version__}"
        torch.manual_seed(0)
        model = ultralytics.YOLO("yolov8n.yaml")
        listed = pathlib.Path(ultralytics.__file__).parent / "cfg/datasets/coco.yaml"
        model.model.names = yaml.safe_load(listed.read_text())["names"]
        net, head = model.model.eval(), model.model.model[-1]
        images = [letterboxed(path) for path in pictures]
        look = lambda: [net(image) for image in images]
        settle(net, look)
        count = self.threshold, 1500 * len(images)
        spread(look, ([branch[-1] for branch in head.cv2], 1.5, None), ([branch[-1] for branch in head.cv3], 1, count))
        model.save(folder / "yolov8n.pt")
        words = command("yolo export model=yolo11n.pt format=onnx imgsz=640").replace("yolo11n", "yolov8n")
        run = subprocess.run(
            [pathlib.Path(sys.executable).with_name("yolo"), *words.split()[1:]], cwd=folder, capture_output=True
        )
        assert run.returncode == 0, run.stderr.decode()
        self.command = words
        self.onnx = folder / "yolov8n.onnx"
        # The weights as they are stored, with 16 bits.
        self.model = ultralytics.YOLO(folder / "yolov8n.pt")

    def look(self, path, one_label=False):
        """As `predict` looks, except that it takes a frame of 640 x 640 px, as the exported model has to, and
        every class of a place above the threshold, as `val` does."""
        from ultralytics.utils import nms

        own = nms.non_max_suppression
        nms.non_max_suppression = own if one_label else functools.partial(own, multi_label=True)
        words = {"conf": self.threshold, "iou": 0.7, "max_det": 300, "imgsz": 640, "rect": False, "verbose": False}
        found = self.model.predict(path, device="cpu", **words)[0].boxes
        nms.non_max_suppression = own
        return [
            (COCO_IDS[int(label)], corners, score)
            for label, corners, score in zip(found.cls.tolist(), found.xyxy.numpy(), found.conf.tolist())
        ]


def letterboxed(path):
    """A picture roughly as a YOLO sees it, for the statistics."""
    image = PIL.Image.open(path)
    gain = 640 / max(image.size)
    size = tuple(max(round(side * gain), 1) for side in image.size)
    frame = np.full((640, 640, 3), 114, np.uint8)
    frame[: size[1], : size[0]] = np.asarray(image.resize(size))
    return torch.from_numpy(frame).permute(2, 0, 1)[None] / 255


class FasterRcnn:
    """Faster R-CNN of torchvision."""

    name, contract, wrong, lacking = "Faster R-CNN R50-FPN", "torchvision-fasterrcnn", "mmdeploy", "NonMaxSuppression"
    session = None
    threshold = 0.05

    def __init__(self, folder, pictures):
        self.by = f"torchvision {torchvision.__version__}"
        torch.manual_seed(0)
        build = torchvision.models.detection.fasterrcnn_resnet50_fpn
        self.model = model = build(weights=None, weights_backbone=None).eval()
        images = [self.pixels(path) for path in pictures]
        frames = [model.transform([image])[0].tensors for image in images]
        settle(model.backbone, lambda: [model.backbone(frame) for frame in frames])
        look = lambda: [model([image]) for image in images]
        spread(look, ([model.rpn.head.bbox_pred], 0.3, None), ([model.rpn.head.cls_logits], 2.0, None))
        heads = model.roi_heads.box_predictor
        spread(look, ([heads.bbox_pred], 1.0, None), ([heads.cls_score], 1.5, None))
        # The export of the page, without the line that loads weights.
        export = re.search(r"^torch\.onnx\.export\(.*?\)\n```", PAGE, re.DOTALL | re.MULTILINE)[0][:-4]
        with contextlib.chdir(folder):
            exec(export, {"torch": torch, "model": model})
        self.command = "torch.onnx.export(model, … dynamo=False, opset_version=17, …)"
        self.onnx = folder / "fasterrcnn.onnx"

    @staticmethod
    def pixels(path):
        return torch.from_numpy(np.array(PIL.Image.open(path))).permute(2, 0, 1) / 255

    def look(self, path):
        """By torchvision in PyTorch; None where its frame is another than that of the exported file."""
        sides = np.array(PIL.Image.open(path).size, float)
        frame = np.floor(sides * min(800 / sides.min(), 1333 / sides.max()))
        sides, one = sides.astype(np.float32), np.float32(1)
        exported = np.floor(sides * min(800 * (one / sides.min()), 1333 * (one / sides.max())))
        if (frame != exported).any():
            return None
        return self.rows(self.model([self.pixels(path)])[0])

    def look_otherwise(self, path):
        """By the exported file in ONNX Runtime."""
        if self.session is None:
            self.session = onnxruntime.InferenceSession(str(self.onnx), providers=["CPUExecutionProvider"])
        names = [output.name for output in self.session.get_outputs()]
        return self.rows(dict(zip(names, self.session.run(names, {"image": self.pixels(path).numpy()}))))

    @staticmethod
    def rows(found):
        labels, boxes, scores = (np.asarray(found[key]) for key in ("labels", "boxes", "scores"))
        rows = zip(labels.tolist(), boxes, scores.tolist())
        return [row for row in rows if row[0] not in GAPS]


class Extension(types.ModuleType):
    """What MMCV would compile."""

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self.missing

    @staticmethod
    def missing(*_, **__):
        raise NotImplementedError("an operator that MMCV compiles")

    @staticmethod
    def nms(boxes, scores, iou_threshold, offset):
        assert offset == 0
        return torchvision.ops.nms(boxes, scores, iou_threshold)


def split_as_torch_1(query, key, value, weight, bias):
    """Queries, keys and values of an attention, with keys that are values."""
    assert key is value
    linear, n = torch.nn.functional.linear, query.size(-1)
    if query is key:
        return linear(query, weight, bias).chunk(3, -1)
    return linear(query, weight[:n], bias[:n]), *linear(key, weight[n:], bias[n:]).chunk(2, -1)


class Retina:
    """RetinaNet-PVTv2-B0 of MMDetection, through MMDeploy."""

    name, contract, wrong, lacking = "RetinaNet-PVTv2-B0", "mmdeploy", "torchvision-fasterrcnn", "NonMaxSuppression"
    threshold = 0.05

    def __init__(self, folder, pictures):
        import mmcv

        sys.modules["mmcv._ext"] = Extension("mmcv._ext")
        import mmcv.ops

        del sys.modules["mmcv._ext"]
        import mmdeploy
        import mmdet
        from mmdeploy.apis import torch2onnx
        from mmdet.apis import init_detector
        from mmengine.config import Config

        logging.disable(logging.WARNING)
        self.by = f"MMDetection {mmdet.__version__}, MMDeploy {mmdeploy.__version__}"
        settings = pathlib.Path(mmdet.__file__).parent / ".mim/configs/pvt/retinanet_pvtv2-b0_fpn_1x_coco.py"
        settings = Config.fromfile(settings)
        settings.model.backbone.init_cfg = None
        torch.manual_seed(0)
        self.model = init_detector(settings, None, device="cpu")
        look = lambda: [self.look_otherwise(path) for path in pictures]
        heads, count = self.model.bbox_head, (self.threshold, 400 * len(pictures))
        spread(look, ([heads.retina_reg], 0.3, None), ([heads.retina_cls], 1, count))
        torch.save({"state_dict": self.model.state_dict(), "meta": {}}, folder / "retina.pth")
        batch = {0: "batch", 1: "num_dets"}
        deploy = Config(
            {
                "onnx_config": {
                    "type": "onnx",
                    "export_params": True,
                    "keep_initializers_as_inputs": False,
                    "opset_version": 11,
                    "save_file": "end2end.onnx",
                    "input_names": ["input"],
                    "output_names": ["dets", "labels"],
                    "input_shape": None,
                    "optimize": True,
                    "dynamic_axes": {
                        "input": {0: "batch", 2: "height", 3: "width"},
                        "dets": batch,
                        "labels": batch,
                    },
                },
                "codebase_config": {
                    "type": "mmdet",
                    "task": "ObjectDetection",
                    "post_processing": {
                        "score_threshold": 0.05,
                        "confidence_threshold": 0.005,
                        "iou_threshold": 0.5,
                        "max_output_boxes_per_class": 200,
                        "pre_top_k": 5000,
                        "keep_top_k": 100,
                        "background_label_id": -1,
                    },
                },
                "backend_config": {"type": "onnxruntime"},
            }
        )
        own = torch.onnx.export, torch.nn.functional._in_projection_packed
        torch.onnx.export = functools.partial(own[0], dynamo=False)
        torch.nn.functional._in_projection_packed = split_as_torch_1
        torch2onnx(str(pictures[0]), str(folder), "end2end.onnx", deploy, settings, str(folder / "retina.pth"), "cpu")
        torch.onnx.export, torch.nn.functional._in_projection_packed = own
        self.command = "torch2onnx of MMDeploy, as its tools/deploy.py calls it"
        self.onnx = folder / "end2end.onnx"
        import mmdeploy.backend.onnxruntime.wrapper as wrapper
        from mmdeploy.apis.utils import build_task_processor

        # No operators of MMDeploy's own are needed.
        wrapper.get_ops_path = str
        self.task = build_task_processor(settings, deploy, "cpu")
        self.exported = self.task.build_backend_model([str(self.onnx)], self.task.update_data_preprocessor)

    def look(self, path):
        """By MMDeploy: the exported file in ONNX Runtime."""
        inputs, _ = self.task.create_input(str(path), None)
        return self.rows(self.exported.test_step(inputs)[0].pred_instances, path)

    def look_otherwise(self, path):
        """By MMDetection in PyTorch, before the export."""
        from mmdet.apis import inference_detector

        return self.rows(inference_detector(self.model, str(path)).pred_instances, path)

    @staticmethod
    def rows(found, path):
        width, height = PIL.Image.open(path).size
        corners = found.bboxes.numpy().clip(0, (width, height, width, height))
        rows = zip(found.labels.tolist(), corners, found.scores.tolist())
        return [(COCO_IDS[label], corners, score) for label, corners, score in rows]


def detect(program, network, folder, *flags):
    """What `starbreak detect` says, and its boxes of every picture; or what it refuses."""
    out = folder.parent / "boxes.json"
    # The default threads: as many as processors.
    line = [program, "detect", "--model", network.onnx, f"folder:{folder}", "-o", out, "--replace", "--json"]
    run = subprocess.run(
        [*line, "--score-threshold", str(network.threshold), *flags], capture_output=True, text=True
    )
    if run.returncode:
        return None, run.stderr.strip().splitlines()[-1].replace(str(folder.parent) + "/", "")
    names = sorted(path.name for path in folder.iterdir())
    boxes = {name: [] for name in names}
    for row in json.loads(out.read_text()):
        x, y, w, h = row["bbox"]
        found = row["category_id"], np.array([x, y, x + w, y + h]), row["score"]
        boxes[names[row["image_id"] - 1]].append(found)
    return json.loads(run.stdout), boxes


def compare(ours, theirs):
    """Pairs of partners: their differences of sides, px, and of scores."""
    left, pairs = list(theirs), []
    for label, box, score in sorted(ours, key=lambda row: -row[2]):
        near = [
            (overlap(box, other), k)
            for k, (c, other, s) in enumerate(left)
            if c == label and abs(s - score) <= MOST_SCORE
        ]
        if near and max(near)[0] > LEAST_IOU:
            _, other, other_score = left.pop(max(near)[1])
            pairs.append((float(np.abs(other - box).max()), abs(other_score - score)))
    return pairs


def overlap(a, b):
    sides = np.minimum(a[2:], b[2:]) - np.maximum(a[:2], b[:2])
    both = float(np.prod(sides.clip(0)))
    whole = float(np.prod(a[2:] - a[:2]) + np.prod(b[2:] - b[:2])) - both
    # Boxes that the border of the image cuts to nothing are equal if their sides are.
    return both / whole if whole > 0 else float(np.abs(a - b).max() < 0.01)


def share_of(boxes, truth):
    """The share of partners, over the pictures of the truth."""
    pairs = sum(len(compare(boxes[name], truth[name])) for name in truth)
    return pairs / max(sum(len(boxes[name]) for name in truth), sum(map(len, truth.values())), 1)


def report(boxes, truth):
    """A line per picture, and the share over all."""
    rows = []
    for name in truth:
        pairs = compare(boxes[name], truth[name])
        n = len(boxes[name]), len(truth[name])
        worst = np.max(pairs, 0) if pairs else (0, 0)
        rows.append((len(pairs), max(n), *worst))
        print(
            f"    {name[:-4]:32} {n[0]:3} boxes, {n[1]:3} by the framework, {len(pairs):3} partners, off by "
            f"{worst[0]:.1e} px and {worst[1]:.1e} of score at most"
        )
    rows = np.array(rows)
    share = share_of(boxes, truth)
    print(f"    all: {share:.4f} have a partner, off by {rows[:, 2].max():.1e} px and {rows[:, 3].max():.1e} of score")
    return share


def judge(program, network, folder, pictures):
    """Whether all is as it should be."""
    print(f"{network.name}, {network.by}, exported by: {network.command}")
    truth = {path.name: network.look(path) for path in pictures}
    unlike = [name for name in truth if truth[name] is None]
    truth = {name: rows for name, rows in truth.items() if rows is not None}
    if unlike:
        print(f"  left out, since the framework's frame is another than that of its exported file: {', '.join(unlike)}")
    scores = np.array([score for rows in truth.values() for _, _, score in rows])
    print(
        f"  {len(scores)} boxes by the framework from a score of {network.threshold} on; quartiles of their scores "
        + ", ".join(f"{q:.2f}" for q in np.quantile(scores, (0, 0.25, 0.5, 0.75, 1)))
    )
    fine, compared = True, None
    for backend in FLAGS:
        said, found = detect(program, network, folder, *FLAGS[backend])
        if not said and "none of the presets" in found:
            print(f"  FAIL: by {backend}, no contract is chosen: {found}")
            fine = False
            said, found = detect(program, network, folder, *FLAGS[backend], "--contract", network.contract)
        if not said:
            print(f"  by {backend}, not run: {found}")
            # The default backend lacks operators of some models, and says so.
            fine &= backend == "rten" and network.lacking in found
            continue
        is_it = said["contract"] == network.contract
        fine &= is_it
        print(f"  by {backend}, contract {said['contract']}, because {said['reason']} {'ok' if is_it else 'FAIL'}")
        share = report(found, truth)
        fine &= share >= LEAST_SHARE
        print(f"    {'ok' if share >= LEAST_SHARE else 'FAIL'}: at least {LEAST_SHARE} was asked for")
        compared = FLAGS[backend]
    if compared is None:
        print("  FAIL: no backend was compared")
        return False
    if isinstance(network, FasterRcnn):
        said, found = detect(program, network, folder, *compared)
        share = share_of(found, {path.name: network.look_otherwise(path) for path in pictures})
        fine &= share >= LEAST_SHARE
        print(
            f"  beside the exported file in ONNX Runtime, all pictures: {share:.4f} have a partner "
            f"{'ok' if share >= LEAST_SHARE else 'FAIL'}"
        )
    if isinstance(network, Retina):
        share = share_of({path.name: network.look_otherwise(path) for path in pictures}, truth)
        print(f"  what the export itself changes, beside MMDetection in PyTorch: {share:.4f} have a partner (info)")
    if isinstance(network, Yolo):
        own = folder.parent / "one-label.toml"
        own.write_text('schema = 1\npreset = "yolov8"\n[output]\nmulti_label = false\n')
        said, found = detect(program, network, folder, *compared, "--contract", str(own))
        share = share_of(found, {path.name: network.look(path, one_label=True) for path in pictures})
        fine &= share >= LEAST_SHARE
        print(
            f"  with multi_label = false, beside `predict` as it is: {share:.4f} have a partner "
            f"{'ok' if share >= LEAST_SHARE else 'FAIL'}"
        )
    bgr = folder.parent / "bgr.toml"
    bgr.write_text(f'schema = 1\npreset = "{network.contract}"\n[input]\ncolor = "bgr"\n')
    for what, contract in (("colors in the wrong order", str(bgr)), (f"--contract {network.wrong}", network.wrong)):
        said, found = detect(program, network, folder, *compared, "--contract", contract)
        share = share_of(found, truth) if said else 0
        fine &= share < LEAST_SHARE
        if said:
            found = f"of {sum(map(len, found.values()))} boxes {share:.4f} have a partner"
        print(f"  {what}: {found} {'ok: seen' if share < LEAST_SHARE else 'FAIL: not seen'}")
    return fine


def main():
    fine = True
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        os.environ.update(YOLO_CONFIG_DIR=str(folder), YOLO_AUTOINSTALL="false", YOLO_VERBOSE="false")
        pictures = draw(folder / "pictures")
        for kind in KINDS:
            work = folder / kind.__name__
            work.mkdir()
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
                network = kind(work, pictures)
            is_fine = judge(program, network, folder / "pictures", pictures)
            print(f"{network.name}: {'ok' if is_fine else 'FAIL'}\n", flush=True)
            fine &= is_fine
    return not fine


if __name__ == "__main__":
    warnings.filterwarnings("ignore")
    import onnxruntime
    import torch
    import torchvision

    torch.set_num_threads(2)
    torch.set_grad_enabled(False)
    library = next((pathlib.Path(onnxruntime.__file__).parent / "capi").glob("libonnxruntime.so*"))
    FLAGS = {"rten": (), "ONNX Runtime": ("--onnxruntime", str(library))}
    KINDS = [k for k in (Yolo, FasterRcnn, Retina) if not sys.argv[2:] or k.__name__ in sys.argv[2:]]
    sys.exit(main())
