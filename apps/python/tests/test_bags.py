"""`starbreak bag` as two other readers of MCAP and ROS 2 messages see it, and a writer that is not ours."""

import io
import json

import numpy as np
import pytest
import starbreak
from conftest import SMALL, picture
from PIL import Image

pytest.importorskip("mcap_ros2", reason="mcap-ros2-support is not installed; run `cargo xtask test`")
pytest.importorskip("rosbags", reason="rosbags is not installed; run `cargo xtask test`")

from mcap.reader import make_reader  # noqa: E402
from mcap_ros2.decoder import DecoderFactory  # noqa: E402
from mcap_ros2.writer import Writer  # noqa: E402
from rosbags.highlevel import AnyReader  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

FIRST_NS = 1_700_000_000_000_000_000
HEADER = (
    "{0}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
    "{0}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
).format("=" * 80)
IMAGE = (
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\nuint32 step\nuint8[] data\n"
) + HEADER
COMPRESSED = "std_msgs/Header header\nstring format\nuint8[] data\n" + HEADER
TOPICS = {
    "/front/image_raw": "bgr8",
    "/rear/image_raw": "mono8",
    "/left/compressed": "jpeg",
    "/right/compressed": "png",
}


def frame(topic, k):
    return picture(seed=10 * sorted(TOPICS).index(topic) + k)


def header(k):
    stamp_ns = FIRST_NS + k * 100_000_000
    return {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": "camera"}


def message(topic, k):
    pixels = frame(topic, k)
    kind = TOPICS[topic]
    if kind in ("jpeg", "png"):
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, kind)
        return {"header": header(k), "format": kind, "data": file.getvalue()}
    pixels = pixels[..., ::-1] if kind == "bgr8" else pixels[..., 0]
    height, width = pixels.shape[:2]
    size = {"height": height, "width": width, "encoding": kind, "is_bigendian": 0}
    return {"header": header(k), **size, "step": pixels.nbytes // height, "data": pixels.tobytes()}


@pytest.fixture(params=["none", "lz4", "zstd"])
def bag(request, tmp_path):
    """Four cameras and a topic of texts, three times each, by the writer of the MCAP project."""
    from mcap.writer import CompressionType

    path = tmp_path / "in.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=60_000, compression=CompressionType[request.param.upper()])
        schemas = {
            "image": writer.register_msgdef("sensor_msgs/msg/Image", IMAGE),
            "compressed": writer.register_msgdef("sensor_msgs/msg/CompressedImage", COMPRESSED),
            "text": writer.register_msgdef("std_msgs/msg/String", "string data\n"),
        }
        for k in range(3):
            time_ns = FIRST_NS + k * 100_000_000 + 5
            for topic, kind in TOPICS.items():
                schema = schemas["compressed" if kind in ("jpeg", "png") else "image"]
                writer.write_message(topic, schema, message(topic, k), time_ns, time_ns - 3, k)
            writer.write_message("/text", schemas["text"], {"data": f"text {k}"}, time_ns, time_ns, k)
        writer.finish()
    return path


def as_mcap_reads(path):
    """Channel, sequence, times, topic, bytes and message of each record, by the readers of the MCAP project."""
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [
            ((m.channel_id, m.sequence, m.log_time, m.publish_time), channel.topic, m.data, decoded)
            for _, channel, m, decoded in reader.iter_decoded_messages(log_time_order=False)
        ]


def as_rosbags_reads(path):
    """Topic, time, bytes and message, by rosbags."""
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        return [
            (connection.topic, time_ns, bytes(data), reader.deserialize(data, connection.msgtype))
            for connection, time_ns, data in reader.messages()
        ]


def pixels_of(topic, decoded):
    kind = TOPICS[topic]
    data = bytes(decoded.data)
    if kind in ("jpeg", "png"):
        image = Image.open(io.BytesIO(data))
        assert image.format.lower() == kind
        return np.asarray(image)
    shape = (decoded.height, decoded.width) if kind == "mono8" else (decoded.height, decoded.width, 3)
    pixels = np.frombuffer(data, np.uint8).reshape(shape)
    return pixels if kind == "mono8" else pixels[..., ::-1]


def flags():
    return [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]


def test_only_data_differ_and_the_pixels_are_those_of_crack(bag, command, tmp_path):
    out = tmp_path / "out.mcap"
    command("bag", bag, "-o", out, "--preset", "paper", *flags(), "--seed", 7, "--masks")
    before, after = as_mcap_reads(bag), as_mcap_reads(out)
    ours = [record for record in after if "/starbreak/" in record[1]]
    kept = [record for record in after if "/starbreak/" not in record[1]]
    assert [record[:2] for record in kept] == [record[:2] for record in before]
    recipe = starbreak.Recipe("paper", set=SMALL)
    count = dict.fromkeys(TOPICS, 0)
    for (_, topic, old_bytes, old), (_, _, new_bytes, new) in zip(before, kept, strict=True):
        if topic == "/text":
            assert new_bytes == old_bytes
            continue
        assert str(new.header) == str(old.header)
        for field in ("height", "width", "encoding", "is_bigendian", "step", "format"):
            assert getattr(new, field, None) == getattr(old, field, None)
        name = topic.strip("/").replace("/", ".")
        shown = pixels_of(topic, new)
        if TOPICS[topic] == "jpeg":
            folder = tmp_path / f"frame {count[topic]}"
            folder.mkdir()
            (folder / name).write_bytes(bytes(old.data))
            command("crack", folder / name, "-o", folder / "out", "--preset", "paper", *flags(), "--seed", 7)
            assert bytes(new.data) == next((folder / "out").glob("*.jpg")).read_bytes()
        else:
            expected = starbreak.crack(pixels_of(topic, old), recipe, 7, name=name)
            assert np.array_equal(shown, expected)
        assert not np.array_equal(shown, pixels_of(topic, old))
        count[topic] += 1
    assert set(count.values()) == {3}
    # A mask and a line of the track for each image.
    added = {f"{topic}/starbreak/{kind}" for topic in TOPICS for kind in ("region", "track")}
    assert {record[1] for record in ours} == added
    assert len(ours) == 2 * 12
    for _, topic, _, decoded in ours:
        if topic.endswith("/track"):
            assert json.loads(decoded.data)["state"] == "still"
        else:
            assert (decoded.encoding, decoded.header.frame_id) == ("mono8", "camera")
            assert 0 < np.mean(np.frombuffer(bytes(decoded.data), np.uint8) > 0) < 1


def test_another_reader_sees_the_same(bag, command, tmp_path):
    out = tmp_path / "out.mcap"
    command("bag", bag, "-o", out, "--preset", "paper", *flags(), "--masks", "--control")
    ours = sorted((topic, times[2], data) for times, topic, data, _ in as_mcap_reads(out))
    theirs = as_rosbags_reads(out)
    assert sorted((topic, time_ns, data) for topic, time_ns, data, _ in theirs) == ours
    topics = {topic for topic, *_ in theirs}
    assert {"/left/compressed/starbreak/control", "/front/image_raw/starbreak/region"} <= topics
    for topic, _, _, decoded in theirs:
        if topic in TOPICS:
            assert pixels_of(topic, decoded).shape[:2] == (96, 128)


def test_a_bag_with_a_hit_and_two_recipes(bag, command, tmp_path):
    out = tmp_path / "out.mcap"
    recipe = tmp_path / "front.toml"
    recipe.write_text(starbreak.Recipe("paper", set=SMALL).to_toml())
    words = ["--topic", f"/front/image_raw={recipe}", "--topic", "/left/compressed=dusty", "--impact-at", "0.15"]
    done = command("bag", bag, "-o", out, *words, "--json")
    cameras = {camera["topic"]: camera for camera in json.loads(done.stdout)["cameras"]}
    assert cameras["/front/image_raw"]["damage_onset"] == {"frame_idx": 2, "time_s": 0.2}
    assert cameras["/front/image_raw"]["n_altered"] == 1
    assert cameras["/left/compressed"]["n_altered"] == 3
    for (_, topic, old, _), (_, _, new, _) in zip(as_mcap_reads(bag), as_mcap_reads(out), strict=True):
        assert topic.startswith(("/front", "/left")) or new == old
    with out.open("rb") as file:
        record = next(record for record in make_reader(file).iter_metadata() if record.name == "starbreak")
    assert record.metadata["schema"] == "starbreak.bag/1"
    said = {camera["topic"]: camera for camera in json.loads(record.metadata["cameras"])}
    assert "[fracture]" in said["/front/image_raw"]["recipe"]
