"""The made-up world of run_commands.py: whatever a page reads, by the name that the page gives it.

Its scenes are a road with red cars, and its detectors find red cars: a filter of the size of a car, which
gives as much as what it sees is red. So detections match labels, and broken glass loses some of them.
Each name is made when a command first needs it.
"""

from __future__ import annotations

import json
import math
import pathlib
import re
import subprocess

import numpy as np
from PIL import Image, ImageDraw

WIDTH_PX, HEIGHT_PX = 320, 192
CAR_PX = (64, 48)
CLIP_FPS, N_CLIP_FRAMES = 10, 40
N_CLASSES = 80  # those of MS-COCO
CAR = 2  # the number of the class in their list, from 0
CAR_ID = 3  # its id


def scene(seed: int, shift_px: int = 0) -> tuple[Image.Image, list[list[int]]]:
    """A road with two cars, moved to the right, and the boxes of the cars (x, y, width, height)."""
    random = np.random.default_rng(seed)
    rows, columns = np.mgrid[0:HEIGHT_PX, 0:WIDTH_PX]
    gray = np.where(rows < 70, 200 - rows / 2, 60 + rows / 3 + 8 * np.sin(columns / 9))
    pixels = gray[..., None] + random.integers(0, 12, (HEIGHT_PX, WIDTH_PX, 3))
    image = Image.fromarray(pixels.clip(0, 255).astype(np.uint8))
    draw = ImageDraw.Draw(image)
    boxes = []
    width, height = CAR_PX
    for first, last in [(3, 5), (11, 13)]:
        x = 16 * int(random.integers(first, last)) + 8 - width // 2 + shift_px
        y = 16 * int(random.integers(6, 9)) + 8 - height // 2
        draw.rectangle((x, y, x + width - 1, y + height - 1), fill=(200, 30, 30))
        draw.rectangle((x + 16, y + 5, x + 47, y + 13), fill=(90, 70, 70))
        boxes.append([x, y, width, height])
    return image, boxes


def glass(seed: int) -> Image.Image:
    """A photograph of broken glass on black."""
    random = np.random.default_rng(seed)
    image = Image.new("RGB", (WIDTH_PX, HEIGHT_PX))
    draw = ImageDraw.Draw(image)
    center = (int(random.integers(80, 240)), int(random.integers(50, 140)))
    for angle in np.sort(random.uniform(0, 2 * math.pi, 14)):
        end = (center[0] + 400 * math.cos(angle), center[1] + 400 * math.sin(angle))
        draw.line([center, end], fill=(int(random.integers(120, 255)),) * 3, width=2)
    for radius in (15, 30, 52):
        draw.ellipse([center[0] - radius, center[1] - radius, center[0] + radius, center[1] + radius], outline=(170,) * 3)
    return image


DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 320 192" width="320" height="192">
<g fill="none" stroke="black">
<circle id="impact" cx="160" cy="90" r="2"/>
<path class="radial" d="M160 90 L60 20 M160 90 L290 60 M160 90 L200 180 M160 90 L40 150"/>
<path class="ring" d="M110 55 L225 75 L177 128 L100 120 Z"/>
</g></svg>
"""


def coco(folder: pathlib.Path, n: int) -> None:
    """A set in the form of MS-COCO: JPEG files and one file of instances."""
    (folder / "val2017").mkdir(parents=True)
    (folder / "annotations").mkdir()
    images, annotations = [], []
    for k in range(n):
        image, boxes = scene(k)
        image.save(folder / f"val2017/{k:03}.jpg", quality=95)
        images.append({"id": k + 1, "file_name": f"{k:03}.jpg", "width": WIDTH_PX, "height": HEIGHT_PX})
        annotations += [instance(2 * k + at, k + 1, box) for at, box in enumerate(boxes, 1)]
    categories = [{"id": CAR_ID, "name": "car", "supercategory": "vehicle"}]
    labels = {"images": images, "annotations": annotations, "categories": categories}
    (folder / "annotations/instances_val2017.json").write_text(json.dumps(labels))


def instance(number: int, image: int, box: list[int], **more: int) -> dict:
    """An annotation of MS-COCO."""
    size = {"bbox": box, "area": box[2] * box[3], "iscrowd": 0}
    return {"id": number, "image_id": image, "category_id": CAR_ID, **size, **more}


def kitti(folder: pathlib.Path, n: int) -> None:
    """A set in the form of KITTI's object detection."""
    part = folder / "object/training"
    for name in ("image_2", "label_2", "calib"):
        (part / name).mkdir(parents=True)
    for k in range(n):
        image, boxes = scene(100 + k)
        image.save(part / f"image_2/{k:06}.png")
        rows = [f"Car 0.00 0 -1.57 {x}.00 {y}.00 {x + w}.00 {y + h}.00 1.5 1.6 3.9 1.0 1.6 15.0 -1.5" for x, y, w, h in boxes]
        (part / f"label_2/{k:06}.txt").write_text("\n".join(rows) + "\n")
        (part / f"calib/{k:06}.txt").write_text("P2: 700 0 160 0 0 700 96 0 0 0 1 0\n")


def bdd(folder: pathlib.Path, n: int) -> None:
    """A set in the form of BDD100K."""
    (folder / "labels/det_20").mkdir(parents=True)
    (folder / "images/100k/val").mkdir(parents=True)
    frames = []
    for k in range(n):
        image, boxes = scene(200 + k)
        image.save(folder / f"images/100k/val/{k:03}.jpg", quality=95)
        corners = [{"x1": x, "y1": y, "x2": x + w - 1, "y2": y + h - 1} for x, y, w, h in boxes]
        labels = [{"id": str(at), "category": "car", "box2d": box} for at, box in enumerate(corners)]
        frames.append({"name": f"{k:03}.jpg", "labels": labels})
    (folder / "labels/det_20/det_val.json").write_text(json.dumps(frames))


def yolo(folder: pathlib.Path, n: int) -> None:
    """A set in the form of YOLO."""
    for name in ("images/train", "labels/train"):
        (folder / name).mkdir(parents=True)
    for k in range(n):
        image, boxes = scene(300 + k)
        image.save(folder / f"images/train/{k:03}.png")
        rows = [
            f"0 {(x + w / 2) / WIDTH_PX:.6f} {(y + h / 2) / HEIGHT_PX:.6f} {w / WIDTH_PX:.6f} {h / HEIGHT_PX:.6f}"
            for x, y, w, h in boxes
        ]
        (folder / f"labels/train/{k:03}.txt").write_text("\n".join(rows) + "\n")
    (folder / "data.yaml").write_text("train: images/train\nval: images/train\nnames:\n  0: car\n")


def pictures(folder: pathlib.Path, n: int, first_seed: int) -> None:
    """A folder of scenes, and a list of them."""
    folder.mkdir()
    for k in range(n):
        scene(first_seed + k)[0].save(folder / f"{k:03}.png")
    (folder / "images.txt").write_text("".join(f"{k:03}.png\n" for k in range(n)))


def photographs(folder: pathlib.Path, n: int) -> None:
    """A folder of photographs of broken glass, and a list of them."""
    folder.mkdir()
    for k in range(n):
        glass(k).save(folder / f"{k:03}.png")
    (folder / "images.txt").write_text("".join(f"{k:03}.png\n" for k in range(n)))


def clip_frames(folder: pathlib.Path, n: int = N_CLIP_FRAMES) -> None:
    """Frames of a clip: the cars move to the right."""
    folder.mkdir()
    for k in range(n):
        scene(7, shift_px=k)[0].save(folder / f"{k:06}.png")


def clip_labels(path: pathlib.Path) -> None:
    """The cars of the clip `clean`, as MS-COCO with tracks."""
    images, annotations = [], []
    for k in range(N_CLIP_FRAMES):
        frame = {"id": k + 1, "file_name": f"clean/{k:06}.png", "width": WIDTH_PX, "height": HEIGHT_PX}
        images.append({**frame, "video_id": 1, "frame_index": k})
        for track, box in enumerate(scene(7, shift_px=k)[1], 1):
            annotations.append(instance(2 * k + track, k + 1, box, track_id=track))
    labels = {"videos": [{"id": 1, "name": "clean"}], "images": images, "annotations": annotations}
    path.write_text(json.dumps({**labels, "categories": [{"id": CAR_ID, "name": "car"}]}))


def numbers(path: pathlib.Path) -> None:
    """Feature vectors, or histograms, for `divergence`."""
    if path.suffix == ".npy":
        np.save(path, np.random.default_rng(ord(path.stem)).normal(size=(40, 3)))
    else:
        path.write_text(json.dumps([{"p": [4, 2, 1], "q": [1, 2, 4], "alpha": 0.5}]))


class Graph:
    """An ONNX graph whose image is blue, green, red, or red, green, blue."""

    def __init__(self, side_px: int, white: float) -> None:
        self.side_px, self.white = side_px, white
        self.nodes, self.weights = [], []

    def node(self, operator: str, inputs: list[str], **attributes) -> str:
        """Adds a node, and gives the name of its output."""
        from onnx import helper

        name = f"{operator.lower()}{len(self.nodes)}"
        self.nodes.append(helper.make_node(operator, inputs, [name], name=name, **attributes))
        return name

    def constant(self, values: np.ndarray) -> str:
        """Adds numbers, and gives their name."""
        from onnx import numpy_helper

        name = f"weights{len(self.weights)}"
        self.weights.append(numpy_helper.from_array(values, name))
        return name

    def map(self, weights: np.ndarray, biases: list[float], stride_px: int) -> str:
        """A convolution whose windows are around the centers of the cells of a grid."""
        pads = [(side - stride_px) // 2 for side in weights.shape[2:]] * 2
        inputs = ["images", self.constant(weights.astype(np.float32)), self.constant(np.array(biases, np.float32))]
        return self.node("Conv", inputs, strides=[stride_px, stride_px], dilations=[1, 1], pads=pads)

    def redness(self, car_px: tuple[int, int], stride_px: int) -> str:
        """How red a window of the size of a car is: 0.9 for one of our cars."""
        width, height = car_px
        weights = np.zeros((1, 3, height, width))
        weights[:, 2], weights[:, 0] = 1, -1
        weights *= 0.9 / (150 / 255 * self.white * width * height)
        return self.node("Relu", [self.map(weights, [0], stride_px)])

    def flat(self, biases: list[float], stride_px: int) -> str:
        """Numbers that are the same in each cell."""
        return self.map(np.zeros((len(biases), 3, stride_px, stride_px)), biases, stride_px)

    def save(self, path: pathlib.Path, output: str, shape: list[int]) -> None:
        """Writes it, with the sides of its input and of its output."""
        import onnx
        from onnx import TensorProto, helper

        self.nodes.append(helper.make_node("Identity", [output], ["output"], name="last"))
        sides = [1, 3, self.side_px, self.side_px]
        images = helper.make_tensor_value_info("images", TensorProto.FLOAT, sides)
        found = helper.make_tensor_value_info("output", TensorProto.FLOAT, shape)
        graph = helper.make_graph(self.nodes, "detector", [images], [found], self.weights)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
        onnx.save(model, path)


CLASS_SCORES = [1.0 if k == CAR else 0.0 for k in range(N_CLASSES)]


def yolox(path: pathlib.Path) -> None:
    """A detector in the form of YOLOX, on frames of 160 px: cars on the finest grid, and nothing else."""
    graph = Graph(160, white=255)
    n_numbers, places = 5 + N_CLASSES, []
    for stride_px in (8, 16, 32):
        if stride_px == 8:
            box = graph.flat([0.5, 0.5, math.log(4), math.log(3)], stride_px)
            parts = [box, graph.redness((32, 24), stride_px), graph.flat(CLASS_SCORES, stride_px)]
            grid = graph.node("Concat", parts, axis=1)
        else:
            # What `divergence --model` looks at; its objectness is 0.
            weights = np.random.default_rng(stride_px).normal(0, 1e-5, (n_numbers, 3, stride_px, stride_px))
            weights[4] = 0
            grid = graph.map(weights, [0.0] * n_numbers, stride_px)
        shape = graph.constant(np.array([1, n_numbers, -1]))
        places.append(graph.node("Transpose", [graph.node("Reshape", [grid, shape])], perm=[0, 2, 1]))
    graph.save(path, graph.node("Concat", places, axis=1), [1, 20**2 + 10**2 + 5**2, n_numbers])


def fastestdet(path: pathlib.Path) -> None:
    """A detector in the form of FastestDet, on frames of 176 px, to which images are stretched."""
    graph = Graph(176, white=1)
    share = (CAR_PX[0] / WIDTH_PX, CAR_PX[1] / HEIGHT_PX)
    box = [math.atanh(0.5), math.atanh(0.5), *(math.log(part / (1 - part)) for part in share)]
    parts = [graph.redness((36, 44), 16), graph.flat(box, 16), graph.flat(CLASS_SCORES, 16)]
    graph.save(path, graph.node("Concat", parts, axis=1), [1, 5 + N_CLASSES, 11, 11])


class World:
    """Inputs by name, each made when it is first asked for."""

    def __init__(self, folder: pathlib.Path, inputs: pathlib.Path | None, programs: pathlib.Path, environment: dict) -> None:
        import imageio_ffmpeg

        self.folder, self.inputs, self.environment = folder, inputs, environment
        folder.mkdir()
        (programs / "ffmpeg").symlink_to(imageio_ffmpeg.get_ffmpeg_exe())
        self.makers = {
            "photo.png": lambda path: scene(1)[0].save(path),
            "more.jpg": lambda path: scene(2)[0].save(path, quality=95),
            "glass.png": lambda path: glass(0).save(path),
            "traced.svg": lambda path: path.write_text(DRAWING),
            "mine.toml": lambda path: path.write_text(self.run("starbreak recipe")),
            "KITTI": lambda path: kitti(path, 10),
            "COCO": lambda path: coco(path, 10),
            "coco": lambda path: coco(path, 10),
            "coco96": lambda path: coco(path, 10),
            "BDD100K": lambda path: bdd(path, 4),
            "SET": lambda path: yolo(path, 4),
            "PHOTOS": lambda path: photographs(path, 10),
            "CATS": lambda path: pictures(path, 10, 400),
            "frames": lambda path: clip_frames(path, 15),
            "in.mp4": self.clip,
            "clip.mp4": self.clip,
            "clean.mp4": self.clip,
            "labels.json": clip_labels,
            "counts.json": numbers,
            "A.npy": numbers,
            "B.npy": numbers,
            # One small network for many: what matters is that a command gets one that it can read.
            **{f"{name}.onnx": yolox for name in ("yolo", "yolox_nano", "yolov8n", "pvt", "fasterrcnn")},
            "FastestDet.onnx": fastestdet,
            "clean.json": lambda path: self.detections("COCO", path),
            "cracked.json": lambda path: self.detections("COCO", path),
            "coco-cracked": lambda path: self.run(f"starbreak generate coco:{self['coco']} -o {path}"),
            "bank": lambda path: self.run(f"starbreak patterns -n 3 --size 320x192 -o {path}"),
            "PATTERNS": lambda path: self.run(f"starbreak patterns -n 10 --preset paper --size 320x192 -o {path}"),
            "run-a": lambda path: self.networks(path, "windshield-spiderweb"),
            "run-b": lambda path: self.networks(path, "windshield-hail"),
        }

    def __getitem__(self, name: str) -> pathlib.Path:
        """Where it is, made if need be; that of the user's own inputs where these have it."""
        if self.inputs and (self.inputs / name).exists():
            return self.inputs / name
        path = self.folder / name
        if not path.exists():
            self.makers[name](path)
        return path

    def link_into(self, scratch: pathlib.Path, command: str, outputs: list[str]) -> None:
        """Puts links into a scratch folder to what a command names, does not write, and has not there."""
        own = [path.name for path in self.inputs.iterdir()] if self.inputs else []
        for name in dict.fromkeys([*self.makers, *own]):
            is_named = re.search(rf"(?<![\w./-]){re.escape(name)}(?![\w.-])", command)
            if is_named and name not in outputs and not (scratch / name).exists():
                (scratch / name).symlink_to(self[name])

    def run(self, command: str) -> str:
        """Runs a command, and gives what it prints."""
        done = subprocess.run(command, shell=True, env=self.environment, capture_output=True, text=True, check=True)
        return done.stdout

    def clip(self, path: pathlib.Path) -> None:
        """A clip, by ffmpeg."""
        frames = self.folder / "clip-frames"
        if not frames.exists():
            clip_frames(frames)
        encode = f"-loglevel error -framerate {CLIP_FPS} -i {frames}/%06d.png -pix_fmt yuv420p"
        self.run(f"ffmpeg {encode} {path}")

    def detections(self, source: str, path: pathlib.Path) -> None:
        """What the detector finds in a set."""
        self.run(f"starbreak detect --model {self['yolo.onnx']} coco:{self[source]} -o {path}")

    def networks(self, folder: pathlib.Path, preset: str) -> None:
        """A folder of networks."""
        folder.mkdir()
        for seed in range(10):
            self.run(f"starbreak simulate --preset {preset} --seed {seed} -o {folder}/{seed}.json")
