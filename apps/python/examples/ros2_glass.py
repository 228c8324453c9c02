"""A ROS 2 node that puts broken glass before a camera: it republishes images, in place, and their calibration.

    python ros2_glass.py --ros-args -r image:=/camera/image_raw -r camera_info:=/camera/camera_info -p recipe:=windshield-star

Topics: `image` and `camera_info` are read, `glass/image` and `glass/camera_info` written, each with the
stamp and frame of what came. Parameters: `recipe` (a preset), `seed`, `name` (give each camera its own) and
`impact_after_s`: until so long after the first image the images pass as they are.

Needs ROS 2 with rclpy and sensor_msgs. A service or a recorded bag may deliver images late: the summary at
the end counts what was damaged and how long that took.
"""

import time

import numpy as np
import rclpy
import starbreak
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image

#: Encodings that can be damaged, with their samples per pixel and the order of these.
ENCODINGS = {"mono8": (1, "gray"), "rgb8": (3, "rgb"), "bgr8": (3, "bgr"), "rgba8": (4, "rgba"), "bgra8": (4, "bgra")}


def stamp_s(header):
    """The time of a header, s."""
    return header.stamp.sec + 1e-9 * header.stamp.nanosec


def pixels_of(message):
    """The pixels of an image as an array over the message's own memory, rows `step` bytes apart."""
    n_samples, _ = ENCODINGS[message.encoding]
    shape = (message.height, message.width, n_samples)
    strides = (message.step, n_samples, 1)
    if message.step < message.width * n_samples or len(message.data) < message.height * message.step:
        raise ValueError(
            f"the image has {len(message.data)} bytes, step {message.step}; expected {message.height} rows of at "
            f"least {message.width * n_samples}"
        )
    pixels = np.ndarray(shape, np.uint8, buffer=message.data, strides=strides)
    return pixels[..., 0] if n_samples == 1 else pixels


class Glass(Node):
    """The node."""

    def __init__(self):
        super().__init__("glass")
        said = {"recipe": "windshield-spiderweb", "seed": 0, "name": "camera", "impact_after_s": 0.0}
        self.said = {name: self.declare_parameter(name, value).value for name, value in said.items()}
        self.crack = None
        self.light = starbreak.LightFilter()
        self.first_s = self.last_s = None
        self.focal_px = None
        self.latencies_s = []
        self.n_refused = 0
        self.images = self.create_publisher(Image, "glass/image", qos_profile_sensor_data)
        self.infos = self.create_publisher(CameraInfo, "glass/camera_info", qos_profile_sensor_data)
        self.create_subscription(CameraInfo, "camera_info", self.on_info, qos_profile_sensor_data)
        self.create_subscription(Image, "image", self.on_image, qos_profile_sensor_data)

    def on_info(self, info):
        """A calibration: the glass does not change it."""
        # K is row by row; 0 where the camera is not calibrated.
        self.focal_px = info.k[0] or None
        self.infos.publish(info)

    def on_image(self, image):
        """An image: damaged where it lies and sent on."""
        began_s = time.perf_counter()
        if image.encoding not in ENCODINGS:
            self.n_refused += 1
            said = f"encoding {image.encoding} is not damaged and not sent on; expected one of {', '.join(ENCODINGS)}"
            self.get_logger().error(said, once=True)
            return
        _, channels = ENCODINGS[image.encoding]
        pixels = pixels_of(image)
        now_s = stamp_s(image.header)
        if self.first_s is None:
            self.first_s = now_s
        if now_s - self.first_s >= self.said["impact_after_s"]:
            self.damage(pixels, channels, now_s)
        self.images.publish(image)
        self.latencies_s.append(time.perf_counter() - began_s)

    def damage(self, pixels, channels, now_s):
        """Puts the glass over the pixels of an image."""
        size = (pixels.shape[1], pixels.shape[0])
        if self.crack is None or self.crack.size != size:
            recipe = starbreak.Recipe(self.said["recipe"], set={"camera.f_px": self.focal_px} if self.focal_px else None)
            seed = starbreak.item_seed(self.said["seed"], self.said["name"])
            self.crack = starbreak.ReadyCrack(recipe, seed, size)
        own = self.crack.estimate_environment(pixels, channels=channels)
        if own is not None:
            elapsed_s = 0.0 if self.last_s is None else max(0.0, now_s - self.last_s)
            self.crack.set_environment(self.light.next(own, elapsed_s))
        self.last_s = now_s
        seed = starbreak.item_seed(self.said["seed"], self.said["name"], len(self.latencies_s))
        self.crack.over(pixels, seed, out=pixels, channels=channels)

    def summary(self):
        """What was done, in a line."""
        if not self.latencies_s:
            return f"no image was damaged, {self.n_refused} were refused"
        p50, p99 = 1e3 * np.percentile(self.latencies_s, [50, 99])
        return f"{len(self.latencies_s)} images, {self.n_refused} refused; {p50:.2f} ms p50, {p99:.2f} ms p99"


def main():
    """Runs the node until it is stopped."""
    rclpy.init()
    glass = Glass()
    try:
        rclpy.spin(glass)
    except KeyboardInterrupt:
        pass
    print(glass.summary())
    glass.destroy_node()


if __name__ == "__main__":
    main()
