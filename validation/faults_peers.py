#!/usr/bin/env python3
"""Camera faults of the field's libraries beside the presets: time, meaning of severities, seeds.

usage: faults_peers.py STARBREAK FAULTS_SPEED [PYTHON_IMAGE_FAILURES]

STARBREAK is the command, FAULTS_SPEED the example of the crate `starbreak` of that name, whose times are its
own. Peers: imagecorruptions, AlbumentationsX, kornia on the CPU; NRTK's drops; and, where the last argument is
a checkout of github.com/francescosecci/Python_Image_Failures, the scripts of Secci and Ceccarelli. Those have
no license: none of their code is here. They are run as they are, but that they get the frame instead of their
own picture and plot nothing. First all are timed, in turns and on the same frame; then what a setting does is
measured on charts, for all by the same measure. One thread. Needs requirements-faults.txt.
"""
import contextlib
import functools
import importlib.metadata
import io
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
import types
import typing
import unittest.mock
import warnings

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
    os.environ[variable] = "1"
os.environ["ALBUMENTATIONS_NO_TELEMETRY"] = "1"
warnings.simplefilter("ignore")

import albumentations as A
import cv2
import imagecorruptions
import kornia
import numpy as np
import PIL.ImageEnhance
import PIL.ImageFilter
import skimage.filters
import torch
from nrtk.impls.perturb_image.environment import WaterDropletPerturber
from PIL import Image

cv2.setNumThreads(1)
torch.set_num_threads(1)

SIZES = ((1242, 375), (1280, 720))
RUNS = 15
# A call that takes longer is timed once; one that does not end within the limit is given up.
ONCE_MS = 10_000
LIMIT_S = 240
# Codes of sRGB next to 3, 18 and 50 % of white.
GRAYS = {3: 49, 18: 118, 50: 188}
SECCI = "Python_Image_Failures"


def light(codes):
    share = np.arange(256) / 255
    return np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)[codes]


# Adapters: each call takes a frame and a seed, None for a next frame without one, and returns a frame.


class Row(typing.NamedTuple):
    library: str
    name: str
    setting: str
    calls: dict
    seed: str


def imagecorruptions_row(name, severities=range(1, 6)):
    def call(severity, image, seed):
        if seed is not None:
            np.random.seed(seed)
        return imagecorruptions.corrupt(image, severity=severity, corruption_name=name.split(",")[0])

    return Row("imagecorruptions", name, "severity", {str(k): functools.partial(call, k) for k in severities}, "numpy.random.seed")


def albumentations_row(name, settings):
    def pipeline(words, seed):
        return A.Compose([getattr(A, name.split(",")[0])(p=1.0, **words)], seed=seed)

    def call(words, going_on, image, seed):
        return (going_on if seed is None else pipeline(words, seed))(image=image)["image"]

    calls = {key: functools.partial(call, words, pipeline(words, None)) for key, words in settings.items()}
    setting = next(iter(next(iter(settings.values()))), "")
    return Row("AlbumentationsX", name, setting, calls, "Compose(seed=)")


def same(key, *values):
    """Settings that fix a range to its low, middle and high end."""
    return {f"{value:g}": {key: (value, value)} for value in values}


def kornia_row(name, setting, augmentations):
    def call(augment, image, seed):
        if seed is not None:
            torch.manual_seed(seed)
        with torch.inference_mode():
            planes = torch.from_numpy(image).permute(2, 0, 1)[None].float() / 255
            made = (augment(planes)[0].clamp(0, 1) * 255).round().byte()
            return made.permute(1, 2, 0).numpy()

    calls = {key: functools.partial(call, augment) for key, augment in augmentations.items()}
    return Row("kornia", name, setting, calls, "torch.manual_seed")


def nrtk_row(*counts):
    """Drops of other numbers; what numba compiles it compiles here."""
    def call(count, going_on, image, seed):
        return (going_on if seed is None else WaterDropletPerturber(num_drops=count, seed=seed))(image=image)[0]

    WaterDropletPerturber(seed=0)(image=np.zeros((64, 96, 3), np.uint8))
    calls = {str(n): functools.partial(call, n, WaterDropletPerturber(num_drops=n, seed=0)) for n in counts}
    return Row("NRTK", "WaterDropletPerturber", "num_drops", calls, "seed=")


class Scripts:
    """The scripts of a checkout, each given a frame as the picture that it opens."""

    def __init__(self, folder):
        self.folder, self.image, self.shown = pathlib.Path(folder), None, []
        self.overlay = functools.cache(lambda path: Image.open(self.folder / path).copy())
        plot = types.SimpleNamespace(imshow=self.shown.append)
        for name in ("figure", "subplot", "title", "xticks", "yticks", "show"):
            setattr(plot, name, lambda *words, **options: None)
        library = types.SimpleNamespace(pyplot=plot, image=types.SimpleNamespace(imread=lambda path: self.image.copy()))
        pictures = types.SimpleNamespace(**{**vars(Image), "open": self.open, "ANTIALIAS": Image.LANCZOS})
        Image.init()
        pillow = types.SimpleNamespace(**{**vars(PIL), "Image": pictures})
        matrices = types.SimpleNamespace(**{**vars(cv2), "imread": lambda path: self.image[..., ::-1].copy()})
        self.modules = {"matplotlib": library, "matplotlib.pyplot": plot, "PIL": pillow, "cv2": matrices}

    def open(self, path):
        return Image.fromarray(self.image) if path in ("sim.jpg", "sim1.jpg") else self.overlay(path).copy()

    def row(self, name, changes=None, given=()):
        """CHANGES: what stands in the script to what a setting writes in its place; GIVEN: names it lacks."""
        source = (self.folder / name.split(",")[0]).read_text(encoding="utf-8")
        calls = {}
        for key, change in (changes or {"as it is": {}}).items():
            text = source
            for old, new in change.items():
                text, n = re.subn(old, new, text)
                assert n, (name, old)
            calls[key] = functools.partial(self.call, compile(text, name, "exec"), given)
        return Row(SECCI, name, "", calls, "numpy.random.seed")

    def call(self, code, given, image, seed):
        if seed is not None:
            np.random.seed(seed)
        self.image = image
        self.shown.clear()
        with unittest.mock.patch.dict(sys.modules, self.modules), contextlib.redirect_stdout(io.StringIO()):
            exec(code, {"__name__": "__main__", **{name: image.copy() for name in given}})
        return np.clip(np.asarray(self.shown[-1]), 0, 255).astype(np.uint8)


class Starbreak:
    """Presets through the command; their times are those of the example."""

    def __init__(self, command, example, folder):
        self.command, self.folder, self.n_frames = command, pathlib.Path(folder), 0
        listed = subprocess.run([command, "recipe", "--list"], check=True, capture_output=True, text=True).stdout
        self.presets = re.findall(r"^\S+", listed.split("\n\n")[0], re.MULTILINE)
        self.example, self.timed = example, {}

    def time(self):
        """Runs the example once more."""
        lines = subprocess.run([self.example], check=True, capture_output=True, text=True).stdout.splitlines()[1:]
        for name, *words in map(str.split, lines):
            self.timed.setdefault(name, []).append([float(word) for word in words])

    def times(self, preset):
        """Of a frame and until ready for the first one, for both sizes, ms: medians of the runs."""
        medians = np.median(self.timed.get(preset, [[np.nan] * 4]), axis=0)
        return medians[0::2], medians[1::2]

    def sets(self, preset):
        """What the severities set: keys and values of the recipe."""
        recipes = []
        for severity in "12345":
            words = [self.command, "recipe", "--preset", preset, "--severity", severity]
            recipe = tomllib.loads(subprocess.run(words, check=True, capture_output=True, text=True).stdout)
            tables = {key: value for key, value in recipe.items() if isinstance(value, dict)}
            recipes.append({f"{name}.{key}": value for name, table in tables.items() for key, value in table.items()})
        keys = [key for key in recipes[0] if any(recipe.get(key) != recipes[0][key] for recipe in recipes)]
        return "; ".join(f"{key} {' '.join(f'{recipe[key]:g}' for recipe in recipes)}" for key in keys)

    def crack(self, images, seed, words):
        for name, image in images.items():
            Image.fromarray(image).save(self.folder / name, compress_level=1)
        words = ["crack", *images, *words, "--seed", str(seed), "--threads", "1", "--quiet", "-o", "out"]
        subprocess.run([self.command, *words], check=True, capture_output=True, cwd=self.folder)
        return [np.asarray(Image.open(self.folder / "out" / name)) for name in images]

    def call(self, words, image, seed):
        self.n_frames += 1
        name = f"{self.n_frames}.png" if seed is None else "frame.png"
        return self.crack({name: image}, seed or 0, words)[0]

    def row(self, preset):
        words = {str(k): ["--preset", preset, "--severity", str(k)] for k in range(1, 6)}
        calls = {key: functools.partial(self.call, options) for key, options in words.items()}
        return Row("starbreak", preset, "severity", calls, "--seed")

    def is_of_sensor(self, preset, image):
        """Whether another sensor has it elsewhere."""
        words = ["--preset", preset, "--severity", "5", "--set"]
        first, second = (self.call([*words, f"sensor.number={number}"], image, 0) for number in (0, 1))
        return not np.array_equal(first, second)

    def many(self, call):
        return np.stack(self.crack({f"{k}.png": gray(18, 64, 48) for k in range(400)}, 0, call.args[0]))

    def black_percent(self, call):
        return 100 * (self.many(call).max(axis=(1, 2, 3)) == 0).mean()


# Charts and measures: each measure takes a row and returns lines.


def gray(percent, width=640, height=360):
    return np.full((height, width, 3), GRAYS[percent], np.uint8)


def picture(width, height):
    """Noise of all scales in all colors, codes 10 to 245."""
    rng = np.random.default_rng(0)
    total = 0.0
    for sigma in (0.7, 2, 6, 18, 54):
        layer = cv2.GaussianBlur(rng.normal(size=(height, width, 3)), (0, 0), sigma)
        total = total + layer / layer.std() * sigma**0.4
    low, high = np.quantile(total, (0.001, 0.999))
    return np.clip(10 + 235 * (total - low) / (high - low), 10, 245).astype(np.uint8)


def sawtooth(width, height):
    """The frame of the example."""
    x, y = np.meshgrid(np.arange(width), np.arange(height))
    return (np.stack([x, y, x + y], axis=-1) * 7 % 256).astype(np.uint8)


def each(row, measure, form="{:.3g}"):
    return " ".join(form.format(measure(call)) for call in row.calls.values())


def middle(row):
    return list(row.calls.values())[len(row.calls) // 2]


def give_up(*_):
    raise TimeoutError


def elapsed_ms(call, frame):
    """Infinite beyond the limit, nan where it fails."""
    signal.alarm(LIMIT_S)
    try:
        before = time.perf_counter()
        call(frame, None)
        return 1e3 * (time.perf_counter() - before)
    except TimeoutError:
        return np.inf
    except Exception:
        return np.nan
    finally:
        signal.alarm(0)


def interleaved(ours, rows):
    """Times by row and size: medians of rounds in which all take their turns, after a first one."""
    frames = [sawtooth(*size) for size in SIZES]
    times = {(id(row), size): [] for row in rows for size in SIZES}
    for turn in range(RUNS + 1):
        if turn % (RUNS // 2) == 0:
            ours.time()
        for row in rows:
            for size, frame in zip(SIZES, frames):
                found = times[id(row), size]
                if not found or found[0] < ONCE_MS:
                    found.append(elapsed_ms(middle(row), frame))
    return {key: np.median(found[1:] or found) for key, found in times.items()}


def patches(call):
    """Green of a chart of the three grays."""
    made = call(np.hstack([gray(percent, 320) for percent in GRAYS]), 1)[..., 1]
    return [made[20:-20, 320 * k + 20:320 * k + 300] for k in range(3)]


def snr(codes):
    noise = light(codes).std()
    return light(codes).mean() / noise if noise > 1e-9 else np.inf


def of_noise(row):
    def drift(call):
        return 100 * (light(call(gray(18), 1)[..., 1]).mean() / light(GRAYS[18]) - 1)

    uniform = each(row, lambda call: snr(call(gray(18), 1)[..., 1]))
    on_chart = each(row, lambda call: "/".join(f"{snr(codes):.2g}" for codes in patches(call)), "{}")
    return [f"{uniform}; mean light {each(row, drift, '{:+.0f}')} %", "on one chart of 3, 18 and 50 %: " + on_chart]


def of_exposure(row):
    def stops(codes, code):
        return np.log2(light(codes).mean() / light(code)) if codes.max() else np.nan

    def is_white(codes):
        return (codes == 255).mean() > 0.01

    made = [list(zip(patches(call), GRAYS.values())) for call in row.calls.values()]
    kept = [[stops(*patch) for patch in chart if patch[0].max() and not is_white(patch[0])] for chart in made]
    apart = max(np.ptp(values) for values in kept if values)
    text = [" ".join(f"{stops(*patch):+.2f}{'w' if is_white(patch[0]) else ''}" for patch in column) for column in zip(*made)]
    text = [line.replace("+nan", "black") for line in text]
    return [text[1], f"at 3 %: {text[0]}; at 50 %: {text[2]}; grays at most {apart:.2f} EV apart"]


def of_bands(row):
    def lines(call, axis=1):
        return light(call(gray(18, 1280, 720), 1)[..., 1]).mean(axis=axis)

    def depth(axis, call):
        return 100 * np.ptp(lines(call, axis)) / (lines(call, axis).max() + lines(call, axis).min())

    def period(call):
        rows, errors = lines(call), {}
        for length in np.geomspace(4, 2 * rows.size, 600):
            turn = 2 * np.pi * np.arange(rows.size) / length
            waves = np.stack([np.ones(rows.size), np.sin(turn), np.cos(turn)], axis=1)
            errors[length] = np.sum((rows - waves @ np.linalg.lstsq(waves, rows, rcond=None)[0]) ** 2)
        return min(errors, key=errors.get)

    rows, columns = (each(row, functools.partial(depth, axis)) for axis in (1, 0))
    return [f"{rows}; of columns {columns}", "period of the strongest sine, rows: " + each(row, period)]


def changed(call, chart):
    made = call(chart, 1)
    return (made != chart) if made.ndim == 2 else (made != chart).any(axis=-1)


def of_defects(row):
    chart = gray(18, 1280, 720)
    share = each(row, lambda call: 100 * changed(call, chart).mean()) + " %"
    # A gray image has no mosaic, so that a defect is one pixel.
    is_ours = row.library == "starbreak"
    count = each(row, lambda call: 1e6 * changed(call, chart[..., 1] if is_ours else chart).mean(), "{:,.0f}")
    return [count, "on a gray image; pixels that differ in colors, after the interpolation: " + share] if is_ours else [count]


def alone(metric, form="{:.3g}"):
    """A measure that is one number of each call."""
    return lambda row: [each(row, metric, form)]


def n_lines(call):
    made = changed(call, gray(18, 1280, 720)[..., 1])
    return (made.mean(axis=1) > 0.9).sum() + (made.mean(axis=0) > 0.9).sum()


def mosaic_rows(call):
    chart = picture(640, 360)
    made = call(chart, 1)
    if made.shape[:2] != chart.shape[:2]:
        return f"all, the frame {made.shape[1] / 640:g} x {made.shape[0] / 360:g} as large"
    made = np.broadcast_to(made.reshape(360, 640, -1), chart.shape)
    return f"{100 * ((made != chart).any(axis=-1).mean(axis=1) > 0.3).mean():.0f}"


def color_left(call):
    patches = [(160, 80, 60), (60, 140, 70), (60, 80, 170), (170, 160, 60), (150, 70, 150), (70, 150, 160)]
    chart = np.repeat(np.repeat(np.array([patches], np.uint8), 120, axis=0), 120, axis=1)

    def chroma(frame):
        if frame.ndim == 2 or frame.shape[2] < 3:
            return 0.0
        return np.ptp(light(frame).reshape(120, 6, 120, 3).mean(axis=(0, 2)), axis=1).mean()

    return 100 * chroma(call(chart, 1)) / chroma(chart)


def of_sharpness(row):
    def left(period, call):
        wave = 118 + 40 * np.cos(2 * np.pi * np.arange(640) / period + np.pi / 4)
        chart = np.repeat(np.broadcast_to(wave.round().astype(np.uint8), (360, 640))[..., None], 3, axis=-1)

        def contrast(frame):
            x = np.arange(160, 480)
            return (light(frame[180, 160:480, 1]) * np.exp(-2j * np.pi * x / period)).mean()

        return 100 * (contrast(call(chart, 1)) / contrast(chart)).real

    return [each(row, functools.partial(left, 4), "{:.0f}"), "of 16 px: " + each(row, functools.partial(left, 16), "{:.0f}")]


def cast(call):
    red, green, blue = light(call(gray(18), 1)).mean(axis=(0, 1))
    return f"{np.log2(red / green):+.2f}/{np.log2(blue / green):+.2f}"


def psnr(call):
    chart = picture(640, 360)
    return 10 * np.log10(255**2 / ((call(chart, 1).astype(float) - chart) ** 2).mean())


def bit_share(call):
    chart = picture(1280, 720)
    return np.unpackbits(call(chart, 1) ^ chart).mean()


def dimmed(call):
    made = light(call(gray(18, 1280, 720), 1)[..., 1]) / light(GRAYS[18])
    return f"{100 * (abs(made - 1) > 0.02).mean():.2g}/{made.min():.2f}"


def of_picture(ours, row):
    """What a setting does to a picture with lamps, whatever it is."""
    chart = picture(640, 360)
    for x in range(80, 640, 160):
        cv2.circle(chart, (x, 120), 4, (255, 255, 255), -1)

    def compared(call):
        made = call(chart, 1)
        before = chart[:made.shape[0], :made.shape[1]]
        apart = abs(made.astype(float) - before)
        error, drift = (apart**2).mean(), light(made).mean() / light(before).mean() - 1
        return 100 * (apart > 5).any(axis=-1).mean(), 10 * np.log10(255**2 / error) if error else np.inf, 100 * drift

    off, distances, drifts = zip(*map(compared, row.calls.values()))
    lines = [" ".join(f"{share:.3g}" for share in off)]
    lines += [f"PSNR, dB: {' '.join(f'{db:.1f}' for db in distances)}; mean light {' '.join(f'{d:+.0f}' for d in drifts)} %"]
    if row.library == "starbreak":
        once = ours.times(row.name)[1]
        ready = f"; once, before the first frame: {once[0]:.1f} and {once[1]:.1f} ms" if once.max() > 0.05 else ""
        lines.append(f"severities set {ours.sets(row.name)}{ready}")
    return lines


def of_frames(ours, row):
    if row.library == "starbreak":
        return [each(row, ours.black_percent) + " % black, of 400 pictures by themselves"]
    return ["100 %, of code " + each(row, lambda call: call(gray(18), 1).max(), "{}")]


def repeats(ours, row, chart):
    """Whether a seed brings the bytes back, and whether a next frame is new."""
    call = middle(row)
    a, b, c, d = call(chart, 7), call(chart, 7), call(chart, None), call(chart, None)
    equal, still = np.array_equal(a, b), np.array_equal(c, d)
    seed = row.seed
    if row.library == "starbreak" and still:
        # Some frames are only rarely hit.
        still = not np.ptp(ours.many(call), axis=0).any()
    if still and np.array_equal(a, c):
        if row.library != "starbreak" or not ours.is_of_sensor(row.name, chart):
            return "no chance in it", "same"
        seed = "sensor.number"
    return f"{seed}: {'same bytes' if equal else 'NOT THE SAME'}", "same" if still else "new"


def faults(ours, scripts):
    """Title, measure, our presets and the peers' rows of each fault."""
    i, a, k = imagecorruptions_row, albumentations_row, kornia_row
    K = kornia.augmentation
    s = scripts.row if scripts else lambda *words, **options: None

    def overlay(path, share):
        return {f"{pathlib.Path(path).name} at {share}": {r"broken1\.png": path, r"0\.35\)": f"{share})"}}

    def brightness(*values):
        return {f"{v:+g}": {"brightness_range": (v, v), "contrast_range": (0, 0)} for v in values}

    def each_of(kind, *values):
        return {f"{v:g}": kind(v) for v in values}

    def glass(title, presets, *rows):
        return f"{title}: pixels off by more than 5 codes, %", functools.partial(of_picture, ours), presets, rows

    found = [
        ("too much light: EV at 18 % gray", of_exposure, ["overexposed"], [
            i("brightness"), a("RandomBrightnessContrast", brightness(0.05, 0.1, 0.2)),
            a("RandomGamma", same("gamma_range", 95, 90, 80)),
            k("RandomBrightness, chosen", "brightness", each_of(lambda v: K.RandomBrightness((v, v)), 1.1, 1.25, 1.5)),
            s("brightness.py", {v: {r"factor = 3\.5\nimg2": f"factor = {v}\nimg2"} for v in ("1.5", "2.5", "3.5")})]),
        ("too little light: EV at 18 % gray", of_exposure, ["underexposed"], [
            a("RandomBrightnessContrast", brightness(-0.05, -0.1, -0.2)), a("RandomGamma", same("gamma_range", 105, 110, 120)),
            a("ExposureMatching, by the mean", same("target_mean_range", 0.5, 0.4, 0.3)),
            k("RandomBrightness, chosen", "brightness", each_of(lambda v: K.RandomBrightness((v, v)), 0.9, 0.75, 0.5))]),
        ("bands of lamps: depth, % of the light", of_bands, ["banding", "led-banding"], [
            s("overlay_images2.py", overlay("banding/banding.png", 0.02))]),
        ("noise: signal over noise of green at 18 % gray", of_noise, ["noise"], [
            i("gaussian_noise"), i("shot_noise"), i("speckle_noise"),
            a("GaussNoise", same("std_range", 0.2, 0.32, 0.44)),
            a("ISONoise", {f"{v:g}": {"intensity_range": (v, v), "color_shift_range": (v / 10, v / 10)} for v in (0.1, 0.3, 0.5)}),
            a("ShotNoise", same("scale_range", 0.1, 0.2, 0.3)),
            a("FilmGrain", {f"{n / 10:g}": {"intensity_range": (n / 10, n / 10), "grain_size_range": (n, n)} for n in (1, 2, 3)}),
            k("RandomGaussianNoise, default 1", "std", each_of(lambda v: K.RandomGaussianNoise(std=v, p=1.0), 0.02, 0.1, 1.0)),
            s("noise.py, given its `im`", given=("im",))]),
        ("defective pixels: per million", of_defects, ["pixels"], [
            i("impulse_noise"), a("PixelDropout", {"0.01": {"dropout_prob": 0.01}}),
            a("SaltAndPepper", same("amount_range", 0.01, 0.035, 0.06)),
            k("RandomSaltAndPepperNoise", "amount", each_of(lambda v: K.RandomSaltAndPepperNoise(amount=v, p=1.0), 0.01, 0.035, 0.06)),
            s("deadpixel-fixedposition.py"), s("deadpixel50-fixedposition.py"), s("deadpixel200-fixedposition.py")]),
        ("defective rows and columns: count", alone(n_lines), ["lines"], []),
        ("missing demosaicing: rows without it, %", alone(mosaic_rows, "{}"), ["no-demosaicing"], [
            k("color.rgb_to_raw", "", {"BG": lambda planes: kornia.color.rgb_to_raw(planes, kornia.color.CFA.BG)}), s("nodemos.py")]),
        ("missing color filters: color that is left, %", alone(color_left, "{:.0f}"), ["no-filters"], [
            a("ToGray", {"default": {}}), k("RandomGrayscale", "", {"default": K.RandomGrayscale(p=1.0)}),
            s("nobayesfilter-greyscale.py"), s("nobayesfilter-greyscale2.py")]),
        ("sharpness lost: contrast that is left of a grating of 4 px, %", of_sharpness, ["no-sharpening"], [
            i("gaussian_blur"), i("defocus_blur"), a("GaussianBlur", same("sigma_range", 0.5, 1.75, 3.0)),
            a("Defocus", {str(v): {"radius_range": (v, v), "alias_blur_range": (0.3, 0.3)} for v in (3, 6, 10)}),
            k("RandomGaussianBlur(3), example", "sigma", each_of(lambda v: K.RandomGaussianBlur((3, 3), (v, v), p=1.0), 0.1, 1.05, 2.0)),
            s("sharpness.py", {"factor -3.5": {}}), s("blurred.py", {"5 x 5": {}})]),
        ("white balance lost: red/blue over green, EV", alone(cast, "{}"), ["no-white-balance"], [
            # Its range cannot leave out 6000 K.
            Row("AlbumentationsX", "PlanckianJitter.apply", "kelvin", each_of(
                lambda v: lambda image, seed: A.PlanckianJitter().apply(image, v), 3000, 6000, 15000), ""),
            k("RandomPlanckianJitter", "select_from", each_of(lambda v: K.RandomPlanckianJitter(select_from=v, p=1.0), 0, 12, 24))]),
        ("compression: PSNR, dB", alone(psnr, "{:.1f}"), ["compression"], [
            i("jpeg_compression"), a("ImageCompression, default 99-100", same("quality_range", 99, 50, 20)),
            k("RandomJPEG, default 50", "jpeg_quality", each_of(lambda v: K.RandomJPEG(jpeg_quality=(v, v)), 99.0, 50.0, 20.0))]),
        ("bit errors: share of the bits", alone(bit_share, "{:.1e}"), ["bit-errors"], []),
        ("spots and dirt: pixels that differ by over 2 %, %, / least light that is left", alone(dimmed, "{}"), ["spots"], [
            i("spatter"), a("Spatter", {mode: {"mode": mode} for mode in ("rain", "mud")}),
            s("overlay_images2.py", overlay("dirtyonglass.png", 0.35))]),
        ("blank and frozen frames: share", functools.partial(of_frames, ours), ["blank-frames"], [s("black.py"), s("white.py")]),
        glass("rain on the pane", ["rain"], nrtk_row(5, 20, 80), i("spatter, mud from 4 on"), a("RandomRain, streaks in the air", {
            kind: {"rain_type": kind} for kind in ("drizzle", "default", "heavy", "torrential")}),
            a("Spatter", {"rain": {"mode": "rain"}}), k("RandomRain, streaks in the air", "", {"default": K.RandomRain(p=1.0)}),
            s("overlay_images2.py", overlay("rain/rain1.png", 0.35))),
        glass("mud", ["muddy"], i("spatter, mud from 4 on", (4, 5)), a("Spatter", {"mud": {"mode": "mud"}})),
        glass("dust and dirt", ["dusty"], s("overlay_images2.py", overlay("dirtyonglass.png", 0.35))),
        glass("dew and fog", ["fogged"], i("fog"), a("RandomFog, in the air", same("fog_coef_range", 0.3, 0.65, 1)),
            a("AtmosphericFog, in the air", same("density_range", 1, 2, 3)),
            s("overlay_images2.py", overlay("condensation/condensation1.png", 0.35))),
        glass("ice", ["frosted"], i("frost"), s("overlay_images2.py", overlay("ice/ice1.png", 0.2))),
        glass("grease", ["greasy"]),
        glass("scratches", ["scratched"]),
        glass("flares: ghosts, stars and veils", ["ghosts", "star-burst", "glare"],
            a("RandomSunFlare", {"overlay": {}}), a("RandomSunFlare", {"physics_based": {"method": "physics_based"}}),
            a("LensFlare", same("intensity_range", 0.3, 0.5, 0.7))),
        glass("distortion", ["distortion"], a("OpticalDistortion", same("distort_range", 0.0125, 0.025, 0.05))),
        glass("color fringes", ["fringes"], a("ChromaticAberration", {f"{v:g}": {
            "primary_distortion_range": (v, v), "secondary_distortion_range": (2.5 * v, 2.5 * v)} for v in (0.005, 0.01, 0.02)}),
            s("chromaticaberration.py")),
        glass("defocus", ["defocus"], i("defocus_blur"), a("Defocus", {
            str(v): {"radius_range": (v, v), "alias_blur_range": (0.3, 0.3)} for v in (3, 6, 10)}), s("blurred.py, as BGR", {"5 x 5": {}})),
        glass("shake", ["shake"], i("motion_blur"), a("MotionBlur", same("blur_range", 3, 5, 7)),
            k("RandomMotionBlur, example", "kernel_size", each_of(lambda v: K.RandomMotionBlur(v, 35.0, 0.5, p=1.0), 3))),
    ]
    return [(title, measure, presets, [row for row in rows if row]) for title, measure, presets, rows in found]


def print_row(ours, row, measure, times, chart):
    if np.inf in times:
        print(f"  {row.library:22}{row.name:32}{'':7}> {LIMIT_S} s: given up, and not measured")
        return
    try:
        lines = measure(row)
        seed, following = repeats(ours, row, chart)
    except Exception as error:
        print(f"  {row.library:22}{row.name:32} FAILS: {type(error).__name__}: {error}")
        return
    print(f"  {row.library:22}{row.name:32}{times[0]:>9.1f}{times[1]:>9.1f}  {seed:32} {following}")
    settings = " ".join(filter(None, [row.setting, *row.calls]))
    print(f"      {settings}  ->  {lines[0]}")
    for line in lines[1:]:
        print(f"      {line}")


LEGEND = f"""
ms: medians of {RUNS} frames on one thread, of the middle setting, from an array of 8 bits to another: with kornia's
conversion to floats and back, without reading and writing files, but for what a peer itself reads at each call.
All on the same frame and in rounds, in which all take their turns, after one that does not count. A call of more
than {ONCE_MS // 1000} s is timed once, one of more than {LIMIT_S} s given up. Of starbreak medians of 3 runs, before, amid and after
the rounds, of the example faults_speed: in Rust, in place; what lies on the glass is made once, before the first
frame. Those of NRTK are without numba's compilation.
Below each row its settings: severities 1 to 5; else low, middle and end of the default range (of one around
nothing a quarter, half and the end); other values where the name says `chosen`, `example` or what the default is.
After the arrow what they do, measured on charts, in linear light, for all by the same code, starbreak's through
the command. One draw each: a count is off by about its square root. w: more than 1 % of the patch is white. inf:
no noise at all, since that of ISONoise follows the spread of the picture.
same seed: how a seed is given, and whether it brings the same bytes back. numpy.random.seed and
torch.manual_seed are one state of the whole process; Compose(seed=) is one of a pipeline's calls, in order.
next: whether a second call on the same frame, without a new seed, draws anew; of starbreak, whether an image of
another name does.
Of glass and lens: on a picture of 640 x 360 with lamps. Severities set keys of the recipe, in the unit that is part
of the key. Peers know no physical unit but NRTK's indices of refraction and distances: they count drops, pixels and
grades, or mix shares of colors. Fog of imagecorruptions and AlbumentationsX is in the air. The frost of the former and
what the scripts lay over the frame are pictures. NRTK's drops refract the frame, and the rest is blurred.
Boxes: imagecorruptions and the scripts know none. AlbumentationsX and NRTK hand them on, OpticalDistortion moves them.
starbreak says how much of each box is damaged, and moves labels under distortion.
gaussian_blur, spatter and fog of imagecorruptions get new names of skimage and numpy, chromaticaberration.py one of
Pillow. deadpixel*.py paint red pixels.
"""


def main():
    command, example = (str(pathlib.Path(path).resolve()) for path in sys.argv[1:3])
    checkout = sys.argv[3] if len(sys.argv) > 3 else None
    # skimage has renamed an argument, and numpy a type, since imagecorruptions 1.1.2.
    imagecorruptions.corruptions.gaussian = lambda x, sigma, multichannel=False: skimage.filters.gaussian(
        x, sigma=sigma, channel_axis=-1 if multichannel else None)
    np.float_ = np.float64
    signal.signal(signal.SIGALRM, give_up)
    print(f"{'':56}{'ms':>9}{'ms':>9}")
    print(f"  {'library':22}{'call':32}{'1242x375':>9}{'1280x720':>9}  {'same seed':32} next")
    chart = picture(*SIZES[0])
    with tempfile.TemporaryDirectory() as folder:
        ours = Starbreak(command, example, folder)
        found = faults(ours, Scripts(checkout) if checkout else None)
        times = interleaved(ours, [row for *_, rows in found for row in rows])
        for title, measure, presets, rows in found:
            print(f"\n{title}")
            for preset in presets:
                if preset in ours.presets:
                    print_row(ours, ours.row(preset), measure, ours.times(preset)[0], chart)
                else:
                    print(f"  {'starbreak':22}{preset:32} not in this build")
            for row in rows:
                print_row(ours, row, measure, [times[id(row), size] for size in SIZES], chart)
            absent = [name for name in ("imagecorruptions", "AlbumentationsX", "kornia", SECCI)
                      if name not in {row.library for row in rows} and (checkout or name != SECCI)]
            if absent:
                print(f"  none in {', '.join(absent)}")
            sys.stdout.flush()
    print(LEGEND)
    print(subprocess.run([command, "--version"], check=True, capture_output=True, text=True).stdout.strip())
    packages = ("imagecorruptions", "albumentationsx", "kornia", "nrtk", "numba", "torch", "numpy", "scikit-image", "opencv-python")
    print(", ".join(f"{name} {importlib.metadata.version(name)}" for name in packages))
    head = ["git", "-C", checkout or ".", "rev-parse", "HEAD"]
    print(SECCI, subprocess.run(head, capture_output=True, text=True).stdout[:12] if checkout else "was not given")


if __name__ == "__main__":
    main()
