"""Broken glass before the cameras of the simulator CARLA.

Nothing here imports `carla`: a sensor is whatever has `listen`, an image whatever has the attributes of
`carla.Image`. What was tested without the simulator, and what was not, stands in docs/live.md.
"""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from ._starbreak import LightFilter, ReadyCrack, Recipe, item_seed

_RecipeLike: TypeAlias = Recipe | str | dict[str, Any]

__all__ = ["Image", "Listening", "listen", "recipe_for", "sun_before"]

#: As many latencies are kept, of the last frames.
_N_LATENCIES = 10_000


@dataclass(frozen=True, eq=False)
class Image:
    """A camera's image behind broken glass, with the attributes of `carla.Image`.

    It keeps its own pixels and is valid for as long as it is referred to. It cannot be converted and
    saved as `carla.Image` can: `array` is for any library that takes arrays.
    """

    #: Number of the frame, as the simulator counts.
    frame: int
    #: Simulated time, s.
    timestamp: float
    #: The pose of the sensor when the image was taken, a `carla.Transform`.
    transform: Any
    #: Width, px.
    width: int
    #: Height, px.
    height: int
    #: Horizontal field of view, degrees.
    fov: float
    #: The pixels: uint8, H x W x 4, blue, green, red, alpha.
    array: npt.NDArray[np.uint8]

    @property
    def raw_data(self) -> memoryview:
        """The bytes of the pixels, BGRA row by row, read-only as those of `carla.Image`."""
        return memoryview(self.array).cast("B").toreadonly()

    def __len__(self) -> int:
        return self.width * self.height


class Listening:
    """What `listen` has begun: the crack, and counts of its frames."""

    def __init__(self, callback: Callable[[Image], object], light: Literal["follow", "first", "own"]) -> None:
        self._callback = callback
        self._light = light
        self._filter = LightFilter()
        self._last_s: float | None = None
        self._latencies_s: deque[float] = deque(maxlen=_N_LATENCIES)
        self._make: Callable[[Any], ReadyCrack]
        self._name = "carla"
        self._seed = 0
        #: The crack; None until the first image where the sensor does not say its size.
        self.crack: ReadyCrack | None = None
        #: Images that were handed on.
        self.n_frames = 0

    def latency_ms(self, percent: float) -> float:
        """Time from the simulator's call to ours that so many percent of the last frames did not exceed, ms."""
        return float(np.percentile(self._latencies_s, percent)) * 1e3 if self._latencies_s else math.nan

    def _on_image(self, image: Any) -> None:
        began_s = time.perf_counter()
        width, height = int(image.width), int(image.height)
        pixels = np.frombuffer(image.raw_data, np.uint8).reshape(height, width, 4)
        if self.crack is None:
            self.crack = self._make(image)
        crack = self.crack
        if self._light == "follow":
            elapsed_s = 0.0 if self._last_s is None else max(0.0, float(image.timestamp) - self._last_s)
            self._last_s = float(image.timestamp)
            own = crack.estimate_environment(pixels, channels="bgra")
            if own is not None:
                crack.set_environment(self._filter.next(own, elapsed_s))
        elif self.n_frames == 0:
            first = crack.estimate_environment(pixels, channels="bgra") if self._light == "first" else None
            crack.set_environment(first)
        # The simulator's view ends with the call, and is read-only: one pass to memory of the image's own.
        array = np.empty((height, width, 4), np.uint8)
        frame = int(image.frame)
        crack.over(pixels, item_seed(self._seed, self._name, frame), out=array, channels="bgra")
        array.flags.writeable = False
        cracked = Image(frame, float(image.timestamp), image.transform, width, height, float(image.fov), array)
        # Nothing of ours holds on to the simulator's memory, not even a traceback of the callback.
        del pixels
        self._latencies_s.append(time.perf_counter() - began_s)
        self.n_frames += 1
        self._callback(cracked)


def listen(
    sensor: Any,
    callback: Callable[[Image], object],
    glass: _RecipeLike | ReadyCrack | None = None,
    *,
    seed: int = 0,
    name: str = "carla",
    light: Literal["follow", "first", "own"] = "follow",
    weather: Any = None,
) -> Listening:
    """Listens to a camera of CARLA and hands each image on behind broken glass, in the order of the calls.

    sensor: a `carla.Sensor` of the type `sensor.camera.rgb`.
    callback: gets an `Image` for each `carla.Image`, in the simulator's thread.
    glass: a recipe, which gets the camera's focal length (`recipe_for`), or a `ReadyCrack` of the camera's
    size, which no other sensor may share, since its light is set; default `windshield-spiderweb`.
    seed, name: determine everything random; give each camera its own name.
    light: "follow": the mean light of about the last second of simulated time, without flicker
    (`LightFilter`); "first": that of the first image; "own": that of each image.
    weather: a `carla.WeatherParameters`, for the direction of the sun as the camera stands now
    (`sun_before`).

    The glass is broken here, before the first image, if the sensor says its size in `attributes`. Errors in
    the callback are the simulator's to tell.
    """
    if light not in ("follow", "first", "own"):
        raise ValueError(f'light = {light!r}; expected "follow", "first" or "own"')
    listening = Listening(callback, light)
    listening._name, listening._seed = name, seed
    if isinstance(glass, ReadyCrack):
        listening.crack = glass
    else:
        transform = sensor.get_transform() if weather is not None else None
        recipe = glass

        def make(width: int, height: int, fov_deg: float) -> ReadyCrack:
            whole = recipe_for(recipe, width, fov_deg, weather=weather, transform=transform)
            return ReadyCrack(whole, item_seed(seed, name), (width, height))

        listening._make = lambda image: make(int(image.width), int(image.height), float(image.fov))
        said: Mapping[str, str] = getattr(sensor, "attributes", {})
        if {"image_size_x", "image_size_y", "fov"} <= set(said):
            listening.crack = make(int(said["image_size_x"]), int(said["image_size_y"]), float(said["fov"]))
    sensor.listen(listening._on_image)
    return listening


def recipe_for(
    recipe: _RecipeLike | None,
    width: int,
    fov_deg: float,
    *,
    weather: Any = None,
    transform: Any = None,
) -> Recipe:
    """The recipe with the focal length of a camera, f = W / (2 tan(fov / 2)) px, and the direction of the sun.

    width: of the image, px. fov_deg: its horizontal field of view, degrees.
    weather, transform: a `carla.WeatherParameters` and the camera's `carla.Transform`; with them the recipe
    gets the sun's direction by `sun_before`, unless its optics are the paper's.

    >>> recipe = recipe_for("windshield-star", 1242, 81.0)
    >>> round(recipe.to_dict()["camera"]["f_px"], 1)
    727.1
    """
    if weather is not None and transform is None:
        raise ValueError("weather without transform; expected the camera's transform, for the sun stands in the world")
    if not 0.0 < fov_deg < 180.0:
        raise ValueError(f"fov_deg = {fov_deg}; expected more than 0 and less than 180 degrees")
    if isinstance(recipe, dict):
        recipe = Recipe.from_dict(recipe)
    elif not isinstance(recipe, Recipe):
        recipe = Recipe(recipe) if recipe is not None else Recipe()
    f_px = width / (2.0 * math.tan(math.radians(fov_deg) / 2.0))
    values: dict[str, float] = {"camera.f_px": f_px}
    if weather is not None and recipe.to_dict()["optics"]["model"] == "physical":
        azimuth_deg, elevation_deg = sun_before(weather, transform)
        values["optics.sun_azimuth_deg"] = azimuth_deg
        values["optics.sun_elevation_deg"] = elevation_deg
    return recipe.replace(values)


def sun_before(weather: Any, transform: Any, *, zero_deg: float = 0.0, sense: int = 1) -> tuple[float, float]:
    """Azimuth of the sun from the optical axis to the right, -180 to 180, and its elevation, degrees.

    weather: has `sun_azimuth_angle` (0 to 360, in the world) and `sun_altitude_angle` (-90 to 90).
    transform: has `rotation.yaw`, degrees, clockwise from above.
    zero_deg, sense: yaw at which a sun of azimuth 0 stands ahead, and 1 if azimuths count clockwise from
    above, else -1. Only a running simulator shows both: apps/python/examples/carla_check.py measures them.

    >>> from types import SimpleNamespace as Of
    >>> sun_before(Of(sun_azimuth_angle=10.0, sun_altitude_angle=45.0), Of(rotation=Of(yaw=350.0)))
    (20.0, 45.0)
    """
    if sense not in (1, -1):
        raise ValueError(f"sense = {sense}; expected 1 or -1")
    azimuth = zero_deg + sense * float(weather.sun_azimuth_angle) - float(transform.rotation.yaw)
    return (azimuth + 180.0) % 360.0 - 180.0, float(weather.sun_altitude_angle)
