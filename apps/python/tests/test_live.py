"""Simulators and robots, each by a stub: what a binding hands over, and in which order."""

import array
import pathlib
import runpy
import sys
import types

import numpy as np
import pytest
import starbreak
import starbreak.carla
from conftest import picture

EXAMPLES = pathlib.Path(__file__).parents[1] / "examples"

#: As KITTI's.
SIZE, FOV_DEG = (1242, 375), 81.0


class StubImage:
    """As `carla.Image`: a read-only view of memory that is the simulator's again once the callback has returned."""

    def __init__(self, frame, pixels):
        self.frame, self.timestamp = frame, frame / 30
        self.transform = f"transform of {frame}"
        self.width, self.height, self.fov = pixels.shape[1], pixels.shape[0], FOV_DEG
        self._memory = bytearray(pixels.tobytes())
        self.raw_data = memoryview(self._memory).toreadonly()

    def end(self):
        """The memory is used for something else."""
        self._memory[:] = bytes(len(self._memory))


class StubSensor:
    """As a `carla.Sensor` of the type `sensor.camera.rgb`."""

    def __init__(self, size, attributes=True):
        self.size = size
        width, height = size
        said = {"image_size_x": str(width), "image_size_y": str(height), "fov": str(FOV_DEG)}
        self.attributes = said if attributes else {}
        self.callback = None

    def get_transform(self):
        return types.SimpleNamespace(rotation=types.SimpleNamespace(yaw=350.0))

    def listen(self, callback):
        self.callback = callback

    def send(self, frame, pixels):
        image = StubImage(frame, pixels)
        self.callback(image)
        image.end()


def bgra(seed, size):
    image = picture(size[1], size[0], seed)
    return np.dstack([image[..., ::-1], np.full(image.shape[:2], 255, np.uint8)])


def test_a_thousand_images_of_carla_arrive_in_their_order_none_lost_or_doubled(capsys):
    sensor, got = StubSensor(SIZE), []
    listening = starbreak.carla.listen(sensor, got.append, "windshield-star", seed=7)
    assert listening.crack.size == SIZE
    pictures = [bgra(seed, SIZE) for seed in range(4)]
    for k in range(1000):
        sensor.send(100 + k, pictures[k % 4])
        if k >= 20:
            # Whoever keeps images keeps their memory.
            got[k - 20] = (got[k - 20].frame, got[k - 20].array[200, ::100].copy())
    numbers = [image[0] if isinstance(image, tuple) else image.frame for image in got]
    assert numbers == [*range(100, 1100)]
    assert listening.n_frames == 1000
    with capsys.disabled():
        p50, p99, most = (listening.latency_ms(percent) for percent in (50, 99, 100))
        print(f"\nCARLA stub, 1242 x 375, 1000 images: {p50:.2f} ms p50, {p99:.2f} ms p99, {most:.2f} ms maximum")
    last = got[-1]
    assert (last.transform, last.timestamp) == ("transform of 1099", 1099 / 30)
    assert (last.width, last.height, last.fov, len(last)) == (*SIZE, FOV_DEG, SIZE[0] * SIZE[1])
    assert last.raw_data.readonly and bytes(last.raw_data) == last.array.tobytes()
    assert (last.array[..., :3] != pictures[3][..., :3]).any() and (last.array[..., 3] == 255).all()


@pytest.mark.parametrize("light", ["own", "first"])
def test_an_image_of_carla_has_the_codes_of_over(light):
    size, got = (320, 200), []
    recipe = {"fracture": {"mesh": "fast"}, "noise": {"read_e": 40.0}}
    sensor = StubSensor(size, attributes=False)
    listening = starbreak.carla.listen(sensor, got.append, recipe, seed=3, name="front", light=light)
    assert listening.crack is None
    first, second = bgra(1, size), bgra(2, size) // 2
    sensor.send(8, first)
    sensor.send(9, second)
    whole = starbreak.carla.recipe_for(recipe, 320, FOV_DEG)
    crack = starbreak.ReadyCrack(whole, starbreak.item_seed(3, "front"), size)
    if light == "first":
        crack.set_environment(crack.estimate_environment(first, channels="bgra"))
    for image, pixels in zip(got, (first, second)):
        expected = crack.over(pixels, starbreak.item_seed(3, "front", image.frame), channels="bgra")
        np.testing.assert_array_equal(image.array, expected)


def test_the_camera_and_the_sun_of_carla():
    weather = types.SimpleNamespace(sun_azimuth_angle=10.0, sun_altitude_angle=-5.0)
    sensor = StubSensor((320, 200))
    listening = starbreak.carla.listen(sensor, print, "windshield-star", weather=weather)
    recipe = starbreak.carla.recipe_for("windshield-star", 320, FOV_DEG, weather=weather, transform=sensor.get_transform())
    tables = recipe.to_dict()
    assert tables["camera"]["f_px"] == pytest.approx(160 / np.tan(np.radians(FOV_DEG / 2)))
    assert (tables["optics"]["sun_azimuth_deg"], tables["optics"]["sun_elevation_deg"]) == (20.0, -5.0)
    crack = starbreak.ReadyCrack(recipe, starbreak.item_seed(0, "carla"), (320, 200))
    assert crack.network == listening.crack.network
    # The paper's optics have another sun, of which CARLA says nothing.
    starbreak.carla.recipe_for("paper", 320, FOV_DEG, weather=weather, transform=sensor.get_transform())
    for azimuth, yaw, zero, sense, expected in [(0, 0, 0, 1, 0), (90, 0, 0, -1, -90), (350, 20, 0, 1, -30), (0, 0, 180, 1, -180)]:
        weather = types.SimpleNamespace(sun_azimuth_angle=azimuth, sun_altitude_angle=1)
        pose = types.SimpleNamespace(rotation=types.SimpleNamespace(yaw=yaw))
        assert starbreak.carla.sun_before(weather, pose, zero_deg=zero, sense=sense) == (expected, 1)
    with pytest.raises(ValueError, match="sense = 2; expected 1 or -1"):
        starbreak.carla.sun_before(weather, pose, sense=2)
    with pytest.raises(ValueError, match="fov_deg = 180; expected more than 0 and less than 180"):
        starbreak.carla.recipe_for(None, 320, 180)
    with pytest.raises(ValueError, match="light = 'sun'; expected"):
        starbreak.carla.listen(sensor, print, light="sun")


def test_a_ready_crack_is_taken_as_it_is_and_one_of_another_size_refused():
    crack = starbreak.ReadyCrack({"fracture": {"mesh": "fast"}}, 1, (320, 200))
    sensor, got = StubSensor((320, 200)), []
    assert starbreak.carla.listen(sensor, got.append, crack).crack is crack
    sensor.send(1, bgra(1, (320, 200)))
    with pytest.raises(ValueError, match="the image is 300 × 200 px"):
        sensor.send(2, bgra(1, (300, 200)))
    sensor.send(3, bgra(1, (320, 200)))
    assert [image.frame for image in got] == [1, 3]


class StubCarla:
    """So much of a simulator that the script that asks a real one has something to ask: a sun in a level world."""

    class Location:
        def __init__(self, x=0.0, y=0.0, z=0.0):
            self.x, self.y, self.z = x, y, z

    class Rotation:
        def __init__(self, pitch=0.0, yaw=0.0, roll=0.0):
            self.pitch, self.yaw, self.roll = pitch, yaw, roll

    class Transform:
        def __init__(self, location=None, rotation=None):
            self.location = location or StubCarla.Location()
            self.rotation = rotation or StubCarla.Rotation()

    class Blueprint:
        def __init__(self):
            self.attributes = {"image_size_x": "8", "image_size_y": "8", "fov": "90"}

        def has_attribute(self, name):
            return name in self.attributes

        def set_attribute(self, name, value):
            self.attributes[name] = value

    class Actor:
        def __init__(self, world, blueprint, transform):
            self.world, self.attributes, self.transform = world, dict(blueprint.attributes), transform
            self.callback, self.is_alive = None, True

        def get_transform(self):
            return self.transform

        def listen(self, callback):
            self.callback = callback

        def stop(self):
            self.callback = None

        def destroy(self):
            self.is_alive = False

    class World:
        def __init__(self):
            self.number, self.actors, self.settings, self.applied = 0, [], types.SimpleNamespace(synchronous_mode=False), []
            self.weather = types.SimpleNamespace(sun_azimuth_angle=0.0, sun_altitude_angle=45.0, cloudiness=50.0)

        def get_settings(self):
            return types.SimpleNamespace(**vars(self.settings))

        def apply_settings(self, settings):
            self.settings = settings
            self.applied.append(settings.synchronous_mode)

        def get_weather(self):
            return types.SimpleNamespace(**vars(self.weather))

        def set_weather(self, weather):
            self.weather = weather

        def get_blueprint_library(self):
            return types.SimpleNamespace(find=lambda _: StubCarla.Blueprint(), filter=lambda _: [StubCarla.Blueprint()])

        def get_map(self):
            return types.SimpleNamespace(get_spawn_points=lambda: [StubCarla.Transform()])

        def spawn_actor(self, blueprint, transform, attach_to=None):
            self.actors.append(StubCarla.Actor(self, blueprint, transform))
            return self.actors[-1]

        def tick(self):
            self.number += 1
            for actor in self.actors:
                if actor.callback is not None:
                    size = (int(actor.attributes["image_size_x"]), int(actor.attributes["image_size_y"]))
                    pixels = bgra(self.number % 3, size)
                    # The sun stands at yaw 90 for azimuth 0 and goes counterclockwise.
                    off = np.radians(90.0 - self.weather.sun_azimuth_angle - actor.transform.rotation.yaw)
                    pixels[: size[1] // 8, :, :3] = round(100 + 100 * np.cos(off))
                    image = StubImage(self.number, pixels)
                    actor.callback(image)
                    image.end()
            return self.number

    def __init__(self):
        self.world = self.World()

    def Client(self, host, port):  # noqa: N802
        return types.SimpleNamespace(set_timeout=lambda seconds: None, get_world=lambda: self.world)


def test_the_script_that_asks_a_running_carla():
    check = runpy.run_path(str(EXAMPLES / "carla_check.py"))["check"]
    carla = StubCarla()
    report = check(carla, n_frames=30)
    assert (report["n_frames"], report["n_lost"], report["n_doubled"]) == (30, 0, 0)
    assert report["same_frames"] and report["kept_valid"] and report["threads"] == 1
    assert (report["sun_zero_deg"], report["sun_sense"]) == (90.0, -1)
    assert report["latency_ms"]["p50"] <= report["latency_ms"]["p99"]
    assert not any(actor.is_alive for actor in carla.world.actors)
    assert carla.world.applied == [True, False] and carla.world.weather.cloudiness == 50.0


def stamped(k):
    return types.SimpleNamespace(stamp=types.SimpleNamespace(sec=k // 30, nanosec=k % 30 * 33_333_333), frame_id="camera")


class StubNode:
    """As much of `rclpy.node.Node` as a node that subscribes and publishes needs."""

    parameters: dict = {}

    def __init__(self, name):
        self.name, self.published, self.on, self.errors = name, {}, {}, []

    def declare_parameter(self, name, value):
        return types.SimpleNamespace(value=self.parameters.get(name, value))

    def create_publisher(self, kind, topic, qos):
        return types.SimpleNamespace(publish=self.published.setdefault(topic, []).append)

    def create_subscription(self, kind, topic, callback, qos):
        self.on[topic] = callback

    def get_logger(self):
        return types.SimpleNamespace(error=lambda said, once: self.errors.append(said))

    def destroy_node(self):
        self.is_destroyed = True


@pytest.fixture
def ros(monkeypatch):
    """The example, over stubs of rclpy and sensor_msgs."""
    stubs = {
        "rclpy": {"init": lambda: None, "spin": lambda node: None},
        "rclpy.node": {"Node": StubNode},
        "rclpy.qos": {"qos_profile_sensor_data": "sensor data"},
        "sensor_msgs": {},
        "sensor_msgs.msg": {"Image": object, "CameraInfo": object},
    }
    for name, values in stubs.items():
        module = types.ModuleType(name)
        vars(module).update(values)
        monkeypatch.setitem(sys.modules, name, module)
    return runpy.run_path(str(EXAMPLES / "ros2_glass.py"))


def ros_image(pixels, encoding, k=0, padding=0):
    height, width = pixels.shape[:2]
    rows = pixels.reshape(height, -1)
    data = np.pad(rows, ((0, 0), (0, padding)), constant_values=99)
    return types.SimpleNamespace(
        header=stamped(k), height=height, width=width, encoding=encoding, is_bigendian=0, step=data.shape[1],
        data=array.array("B", data.tobytes()),
    )


@pytest.mark.parametrize("encoding", ["rgb8", "bgr8", "rgba8", "bgra8", "mono8"])
def test_the_node_damages_images_where_they_lie_and_keeps_all_else(ros, monkeypatch, encoding):
    monkeypatch.setattr(StubNode, "parameters", {"recipe": "windshield-star", "seed": 4, "impact_after_s": 0.05})
    node = ros["Glass"]()
    info = types.SimpleNamespace(header=stamped(0), k=[200.0, 0.0, 160.0])
    node.on["camera_info"](info)
    assert node.published["glass/camera_info"] == [info]
    size = (320, 200)
    channels = ros["ENCODINGS"][encoding][1]
    whole = bgra(1, size)
    pixels = {"gray": whole[..., 1], "rgb": whole[..., 2::-1], "bgr": whole[..., :3], "rgba": whole[..., [2, 1, 0, 3]], "bgra": whole}[channels]
    pixels = np.ascontiguousarray(pixels)
    messages = [ros_image(pixels, encoding, k, padding=5) for k in range(4)]
    for message in messages:
        node.on["image"](message)
    assert node.published["glass/image"] == messages
    recipe = starbreak.Recipe("windshield-star", set={"camera.f_px": 200.0})
    crack = starbreak.ReadyCrack(recipe, starbreak.item_seed(4, "camera"), size)
    expected = crack.over(pixels, channels=channels)
    for k, message in enumerate(messages):
        rows = np.frombuffer(message.data, np.uint8).reshape(200, -1)
        found = rows[:, :-5].reshape(pixels.shape)
        # 0.05 s are frame 1.5.
        np.testing.assert_array_equal(found, expected if k >= 2 else pixels)
        assert (rows[:, -5:] == 99).all()
    assert (expected != pixels).any() and node.summary().startswith("4 images, 0 refused")


def test_the_node_refuses_what_it_cannot_damage(ros, monkeypatch):
    monkeypatch.setattr(StubNode, "parameters", {})
    node = ros["Glass"]()
    node.on["image"](ros_image(picture(), "bayer_rggb8"))
    assert node.published["glass/image"] == [] and "bayer_rggb8" in node.errors[0] and "mono8" in node.errors[0]
    short = ros_image(picture(), "rgb8")
    short.data = short.data[:-1]
    with pytest.raises(ValueError, match="expected 96 rows of at least 384"):
        node.on["image"](short)
    assert node.summary() == "no image was damaged, 1 were refused"
    ros["main"].__globals__["Glass"] = lambda: node
    ros["main"]()
    assert node.is_destroyed


def test_an_augmentation_of_replicator(monkeypatch):
    registered = {}

    class Augmentation:
        @staticmethod
        def from_function(function, **words):
            return function

    annotators = types.SimpleNamespace(
        Augmentation=Augmentation,
        get=lambda name, device: (name, device),
        augment_compose=lambda source_annotator, augmentations: (source_annotator, augmentations),
        register=lambda name, annotator: registered.update({name: annotator}),
    )
    for name in ("omni", "omni.replicator", "omni.replicator.core"):
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    sys.modules["omni.replicator.core"].annotators = annotators
    sys.modules["omni"].replicator = sys.modules["omni.replicator"]
    sys.modules["omni.replicator"].core = sys.modules["omni.replicator.core"]
    register = runpy.run_path(str(EXAMPLES / "isaac_replicator.py"))["register_glass"]
    glass = register("windshield-star", 7, (320, 200))
    source, [augment] = registered["rgb_glass"]
    assert source == ("rgb", "cpu")
    pixels = bgra(1, (320, 200))
    pixels.flags.writeable = False
    found = augment(pixels)
    crack = starbreak.ReadyCrack("windshield-star", 7, (320, 200))
    np.testing.assert_array_equal(found, crack.over(pixels, channels="rgba"))
    assert glass.n_frames == 1 and (found[..., 3] == 255).all()
