"""Bags of one motion as other tools write them, by an independent implementation (rosbags), and our own MCAP."""

import shutil
import tempfile
from pathlib import Path

import numpy as np
from rosbags.rosbag1 import Writer as Bag1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Bag2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT
from drake_blfdmp.demonstration.formats.writing import write_recording
from drake_blfdmp.ros2.messages import DEFINITIONS, TF
from drake_blfdmp.skeleton import POINTS

MARKERS, MARKER = "visualization_msgs/msg/MarkerArray", "visualization_msgs/msg/Marker"
KINECT = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")
JOINTS = [AZURE_KINECT.index(name) for name in KINECT]
LATE = 1_700_000_000_000_000_000  # ns, when the messages were recorded; their stamps are the motion's.
SPHERE, SPHERE_LIST, TEXT = 2, 7, 9
GREEN, BLUE, WHITE = (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0)


def typestore(store):
    found = get_typestore(store)
    if TF not in found.types:
        # Only what the store lacks: a header of ROS 1 has another layout.
        types = get_types_from_msg(DEFINITIONS[TF], TF)
        found.register({name: fields for name, fields in types.items() if name not in found.types})
    return found


def header(types, ns, frame="world"):
    stamp = types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
    fields = types["std_msgs/msg/Header"].__dataclass_fields__
    return types["std_msgs/msg/Header"](**({"seq": 7} if "seq" in fields else {}), stamp=stamp, frame_id=frame)


def marker(types, ns, at, *, name="", number=0, kind=SPHERE, text="", rgba=WHITE, frame="world", action=0, points=()):
    point, vector = types["geometry_msgs/msg/Point"], types["geometry_msgs/msg/Vector3"]
    fields = {
        "header": header(types, ns, frame),
        "ns": name,
        "id": number,
        "type": kind,
        "action": action,
        "pose": types["geometry_msgs/msg/Pose"](
            point(*map(float, at)), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
        ),
        "scale": vector(0.05, 0.05, 0.05),
        "color": types["std_msgs/msg/ColorRGBA"](*rgba),
        "lifetime": types["builtin_interfaces/msg/Duration"](0, 250_000_000),
        "frame_locked": False,
        "points": [point(*map(float, p)) for p in points],
        "colors": [],
        "text": text,
        "mesh_resource": "",
        "mesh_use_embedded_materials": False,
    }
    known = types[MARKER].__dataclass_fields__
    if "texture" in known:
        fields["texture_resource"] = ""
        fields["texture"] = types["sensor_msgs/msg/CompressedImage"](header(types, 0, ""), "", np.empty(0, np.uint8))
        fields["uv_coordinates"] = []
        fields["mesh_file"] = types["visualization_msgs/msg/MeshFile"]("", np.empty(0, np.uint8))
    return types[MARKER](**fields)


def array(types, markers):
    return types[MARKERS](list(markers))


def named(types, ns, x):
    """A marker a point, by namespace."""
    return [marker(types, ns, at, name=name) for name, at in zip(POINTS, x, strict=True) if np.isfinite(at).all()]


def azure(types, ns, x, body=9, guessed=(), frame="depth_camera_link"):
    """32 spheres as the Azure Kinect ROS driver numbers them; joints other than the six lie at (9, 9, 9)."""
    at = np.full((len(AZURE_KINECT), 3), 9.0)
    at[JOINTS] = x
    return [
        marker(types, ns, p, number=100 * body + k, rgba=BLUE if k in guessed else GREEN, frame=frame)
        for k, p in enumerate(at)
    ]


def transform(types, ns, parent, child, p, q=(0.0, 0.0, 0.0, 1.0)):
    return types["geometry_msgs/msg/TransformStamped"](
        header(types, ns, parent),
        child,
        types["geometry_msgs/msg/Transform"](
            types["geometry_msgs/msg/Vector3"](*map(float, p)), types["geometry_msgs/msg/Quaternion"](*map(float, q))
        ),
    )


def stamps(t):
    return [round(float(a) * 1e9) for a in t]


def write_bag1(path, topics, compression=None, store=Stores.ROS1_NOETIC):
    """Writes topic -> (type, function of types returning [(log time, message)]) as a ROS 1 bag."""
    types = typestore(store)
    path.unlink(missing_ok=True)
    bag = Bag1(path)
    if compression:
        bag.set_compression(Bag1.CompressionFormat[compression])
    bag.chunk_threshold = 1 << 16
    with bag:
        for topic, (kind, make) in topics.items():
            connection = bag.add_connection(topic, kind, typestore=types)
            for ns, message in make(types.types):
                bag.write(connection, ns, types.serialize_ros1(message, kind))
    return path


def write_bag2(path, topics, storage="sqlite3", store=Stores.ROS2_HUMBLE, compression=None):
    """The same as the directory of a ROS 2 bag."""
    types = typestore(store)
    shutil.rmtree(path, ignore_errors=True)
    bag = Bag2(path, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if compression:
        from rosbags.rosbag2.enums import CompressionFormat, CompressionMode

        bag.set_compression(CompressionMode[compression], CompressionFormat.ZSTD)
    with bag:
        for topic, (kind, make) in topics.items():
            connection = bag.add_connection(topic, kind, typestore=types)
            for ns, message in make(types.types):
                bag.write(connection, ns, types.serialize_cdr(message, kind))
    return path


def named_topics(t, x):
    def make(types):
        pairs = zip(stamps(t), x, strict=True)
        return [(LATE + k, array(types, named(types, ns, p))) for k, (ns, p) in enumerate(pairs)]

    return {"/people": (MARKERS, make)}


def write_rosbag1(path, t, x, **options):
    return write_bag1(path, named_topics(t, x), **options)


def write_rosbag2(path, t, x, **options):
    """The SQLite file of a ROS 2 bag alone."""
    with tempfile.TemporaryDirectory() as folder:
        whole = write_bag2(Path(folder) / "bag", named_topics(t, x), **options)
        shutil.copyfile(next(file for file in whole.iterdir() if file.suffix != ".yaml"), path)
    return path


def write_mcap(path, t, x, confidence=None, frames=None, up="z", synthetic=False):
    """Our own MCAP, whatever the suffix of `path`."""
    frames = np.arange(len(t)) if frames is None else frames
    recording = Recording(t, x, "sample.csv", "sample", frames, synthetic, confidence=confidence, up=up)
    with tempfile.TemporaryDirectory() as folder:
        write_recording(Path(folder) / "a.mcap", recording)
        shutil.copyfile(Path(folder) / "a.mcap", path)
    return path


SAMPLES = {"rosbag1": write_rosbag1, "rosbag2": write_rosbag2, "mcap": write_mcap}
