"""Settles with a running CARLA what cannot be tested without it; prints one JSON object.

    python carla_check.py --host 127.0.0.1 --port 2000 --frames 300

It spawns a vehicle with two cameras on its roof, one plain and one behind glass, in synchronous mode, and measures

- `n_lost`, `n_doubled`: frames that came to the callback never, or twice;
- `same_frames`: whether both cameras gave the same frames;
- `kept_valid`: whether images are the same after their callback has returned, and 100 frames later;
- `threads`: from how many threads the simulator calls;
- `latency_ms`: from the simulator's call to ours, and the frames per second with and without the glass;
- `sun_zero_deg`, `sun_sense`: for `starbreak.carla.sun_before`: the yaw at which a sun of azimuth 0 is ahead, and
  whether azimuths count clockwise. A camera looks around itself for the brightest direction, under two suns.

Needs a CARLA server and its Python client, and starbreak beside it. Everything spawned is destroyed again.
"""

import argparse
import hashlib
import json
import queue
import threading
import time

import numpy as np
from starbreak.carla import listen

#: Camera: that of KITTI.
SIZE, FOV_DEG = (1242, 375), 81.0

#: How long to wait for a frame, s.
PATIENCE_S = 20.0


def camera_at(carla, world, transform, parent, size=SIZE):
    """A camera, with the depth of field of the simulator off: the glass has its own."""
    blueprint = world.get_blueprint_library().find("sensor.camera.rgb")
    for name, value in [("image_size_x", size[0]), ("image_size_y", size[1]), ("fov", FOV_DEG), ("fstop", 32.0)]:
        if blueprint.has_attribute(name):
            blueprint.set_attribute(name, str(value))
    return world.spawn_actor(blueprint, transform, attach_to=parent)


def digest(image):
    """What identifies the pixels of an image."""
    return hashlib.sha256(image.raw_data).hexdigest()


def ticked(world, frames, n):
    """So many ticks, and the images of each: (number of the tick, image)."""
    got = []
    for _ in range(n):
        number = world.tick()
        image = frames.get(timeout=PATIENCE_S)
        got.append((number, image))
    return got


def follow(carla, world, vehicle, n_frames):
    """Frames of a plain camera and of one behind glass, and what became of them."""
    place = carla.Transform(carla.Location(x=0.5, z=1.7))
    plain, glass = camera_at(carla, world, place, vehicle), camera_at(carla, world, place, vehicle)
    report, plain_frames, glass_frames, threads = {}, queue.Queue(), queue.Queue(), set()
    try:
        plain.listen(lambda image: plain_frames.put(image.frame))
        began_s = time.perf_counter()
        for _ in range(n_frames // 3):
            world.tick()
            plain_frames.get(timeout=PATIENCE_S)
        report["plain_per_s"] = n_frames // 3 / (time.perf_counter() - began_s)

        digests = {}

        def on_glass(image):
            threads.add(threading.get_ident())
            digests[image.frame] = digest(image)
            glass_frames.put(image)

        listening = listen(glass, on_glass, "windshield-star", seed=7)
        began_s = time.perf_counter()
        got, plain_got = [], []
        for number, image in ticked(world, glass_frames, n_frames):
            got.append((number, image))
            plain_got.append(plain_frames.get(timeout=PATIENCE_S))
        report["glass_per_s"] = n_frames / (time.perf_counter() - began_s)
        numbers = [image.frame for _, image in got]
        report["n_frames"] = len(numbers)
        report["n_lost"] = len({number for number, _ in got} - set(numbers))
        report["n_doubled"] = len(numbers) - len(set(numbers))
        report["same_frames"] = numbers == plain_got
        report["kept_valid"] = all(digest(image) == digests[image.frame] for _, image in got)
        report["threads"] = len(threads)
        report["latency_ms"] = {f"p{percent}": listening.latency_ms(percent) for percent in (50, 99, 100)}
    finally:
        for sensor in (plain, glass):
            sensor.stop()
            sensor.destroy()
    return report


def brightest_yaw(carla, world, place, step_deg=15):
    """The yaw at which a level camera sees the most light."""
    brightness = []
    for yaw in range(0, 360, step_deg):
        pose = carla.Transform(place, carla.Rotation(yaw=float(yaw), pitch=15.0))
        camera, frames = camera_at(carla, world, pose, None, (320, 240)), queue.Queue()
        try:
            camera.listen(lambda image, frames=frames: frames.put(np.frombuffer(image.raw_data, np.uint8).mean()))
            # The first frames are still exposed for another view.
            for _ in range(5):
                world.tick()
                mean = frames.get(timeout=PATIENCE_S)
            brightness.append((float(mean), float(yaw)))
        finally:
            camera.stop()
            camera.destroy()
    return max(brightness)[1]


def look_for_the_sun(carla, world, place):
    """Where a sun of azimuth 0 is, and in which sense azimuths count."""
    before = world.get_weather()
    found = []
    try:
        for azimuth_deg in (0.0, 90.0):
            weather = world.get_weather()
            weather.cloudiness, weather.sun_altitude_angle = 0.0, 10.0
            weather.sun_azimuth_angle = azimuth_deg
            world.set_weather(weather)
            found.append(brightest_yaw(carla, world, place))
    finally:
        world.set_weather(before)
    turn = (found[1] - found[0] + 180.0) % 360.0 - 180.0
    return {"sun_zero_deg": found[0], "sun_sense": 1 if turn > 0 else -1, "sun_turn_deg": turn}


def check(carla, host="127.0.0.1", port=2000, n_frames=300):
    """All of it."""
    client = carla.Client(host, port)
    client.set_timeout(PATIENCE_S)
    world = client.get_world()
    before = world.get_settings()
    settings = world.get_settings()
    settings.synchronous_mode, settings.fixed_delta_seconds = True, 1 / 30
    world.apply_settings(settings)
    vehicle = None
    try:
        blueprint = world.get_blueprint_library().filter("vehicle.*")[0]
        start = world.get_map().get_spawn_points()[0]
        vehicle = world.spawn_actor(blueprint, start)
        report = follow(carla, world, vehicle, n_frames)
        above = carla.Location(x=start.location.x, y=start.location.y, z=start.location.z + 30.0)
        report.update(look_for_the_sun(carla, world, above))
    finally:
        if vehicle is not None:
            vehicle.destroy()
        world.apply_settings(before)
    return report


def main():
    """The command."""
    import carla

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, default=2000)
    parser.add_argument("--frames", type=int, default=300)
    given = parser.parse_args()
    print(json.dumps(check(carla, given.host, given.port, given.frames), indent=2))


if __name__ == "__main__":
    main()
