"""MCAP files as other ROS 2 systems write them: messages by rosbags, not by this package."""

import numpy as np
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_HUMBLE)
JOINT_STATE, TF, STRING = "sensor_msgs/msg/JointState", "tf2_msgs/msg/TFMessage", "std_msgs/msg/String"
WRENCH, LOG = "geometry_msgs/msg/WrenchStamped", "rcl_interfaces/msg/Log"

ARM = """<robot name="arm">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry><material name="blue"/></visual></link>
  <link name="upper"><visual><origin xyz="0.2 0 0" rpy="0 1.5707963267948966 0"/>
    <geometry><cylinder radius="0.05" length="0.4"/></geometry>
    <material name="red"><color rgba="1 0 0 1"/></material></visual></link>
  <link name="slide"><visual><geometry><sphere radius="0.06"/></geometry><material name="red"/></visual></link>
  <link name="tool"><visual><geometry><capsule radius="0.02" length="0.1"/></geometry></visual></link>
  <link name="finger"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><origin xyz="0 0 0.1"/>
    <axis xyz="0 0 2"/></joint>
  <joint name="rail" type="prismatic"><parent link="upper"/><child link="slide"/><origin xyz="0.4 0 0"/>
    <axis xyz="1 0 0"/></joint>
  <joint name="flange" type="fixed"><parent link="slide"/><child link="tool"/>
    <origin rpy="0 0 1.5707963267948966"/></joint>
  <joint name="follower" type="prismatic"><parent link="tool"/><child link="finger"/><axis xyz="0 0 1"/>
    <mimic joint="rail" multiplier="-0.5" offset="0.1"/></joint>
  <material name="blue"><color rgba="0 0 1 0.5"/></material>
</robot>"""


def _type(name):
    return STORE.types[name]


def header(t_ns, frame=""):
    stamp = _type("builtin_interfaces/msg/Time")(sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    return _type("std_msgs/msg/Header")(stamp=stamp, frame_id=frame)


class MadeFile:
    """A file under construction; use it in a `with` block."""

    def __init__(self, path, *, profile="ros2", encoding="cdr", start_ns=0, **writer):
        self.path, self._encoding, self._start = path, encoding, start_ns
        self._stream = path.open("wb")
        self._writer = Writer(self._stream, **{"compression": CompressionType.NONE, "chunk_size": 4096, **writer})
        self._writer.start(profile=profile, library="made")
        self._schemas, self._channels = {}, {}

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._writer.finish()
        self._stream.close()

    def metadata(self, name, data):
        self._writer.add_metadata(name, data)

    def raw(self, topic, kind, t, data, schema=None):
        schema = kind if schema is None else schema
        if schema not in self._schemas:
            text = STORE.generate_msgdef(kind)[0] if kind in STORE.types else ""
            self._schemas[schema] = self._writer.register_schema(schema, "ros2msg", text.encode())
        if topic not in self._channels:
            self._channels[topic] = self._writer.register_channel(topic, self._encoding, self._schemas[schema])
        t_ns = self._start + round(t * 1e9)
        self._writer.add_message(self._channels[topic], t_ns, bytes(data), t_ns)

    def another_publisher(self, topic):
        """What comes next on the topic has a channel of its own."""
        self._channels.pop(topic, None)

    def message(self, topic, kind, t, message):
        self.raw(topic, kind, t, STORE.serialize_cdr(message, kind))

    def description(self, text=ARM, topic="/robot_description", t=0.0):
        self.message(topic, STRING, t, _type(STRING)(data=text))

    def joints(self, t, positions, topic="/joint_states", velocity=()):
        values = np.array(list(positions.values()), dtype=float)
        none, speed = np.zeros(0), np.array(velocity, dtype=float)
        made = _type(JOINT_STATE)(header(round(t * 1e9)), list(positions), values, speed, none)
        self.message(topic, JOINT_STATE, t, made)

    def transforms(self, t, edges, topic="/tf"):
        """Edges are (parent, child, x y z qx qy qz qw)."""
        vector, quaternion = _type("geometry_msgs/msg/Vector3"), _type("geometry_msgs/msg/Quaternion")
        stamped, transform = _type("geometry_msgs/msg/TransformStamped"), _type("geometry_msgs/msg/Transform")
        made = [
            stamped(header(round(t * 1e9), parent), child, transform(vector(*pose[:3]), quaternion(*pose[3:])))
            for parent, child, pose in edges
        ]
        self.message(topic, TF, t, _type(TF)(transforms=made))

    def wrench(self, t, topic, frame, force):
        vector = _type("geometry_msgs/msg/Vector3")
        wrench = _type("geometry_msgs/msg/Wrench")(force=vector(*force), torque=vector(0.0, 0.0, 0.0))
        self.message(topic, WRENCH, t, _type(WRENCH)(header=header(round(t * 1e9), frame), wrench=wrench))

    def event(self, t, text, topic="/events"):
        stamp = _type("builtin_interfaces/msg/Time")(sec=int(t), nanosec=0)
        self.message(topic, LOG, t, _type(LOG)(stamp, 20, "made", text, "", "", 0))


def poke(path, seconds=4.0, *, law="default", shift=0.0, events=True):
    """What a run writes: an arm that turns, a person whose hands part until their link leaves its band, a force."""
    from drake_blfdmp.skeleton import LINKS, POINTS

    with MadeFile(path) as file:
        file.metadata("run", {"law": law})
        file.description(ARM)
        still = [0.0, 0.0, 0.0, 1.0]
        file.transforms(0.0, [("world", "person", [1.2, 0.0, 0.0, *still])], "/tf_static")
        for k in range(round(seconds * 50) + 1):
            t, u = k / 50, k / 50 / seconds
            turn = np.array([0.0, 0.0, np.sin(0.5 * (u + shift)), np.cos(0.5 * (u + shift))])
            file.transforms(t, [("world", "base", [0.0, 0.0, 0.0, *still]), ("base", "upper", [0.0, 0.0, 0.1, *turn])])
            file.transforms(
                t, [("upper", "slide", [0.4 + 0.2 * u, 0.0, 0.0, *still]), ("slide", "tool", [0] * 3 + still)]
            )
            half = 0.10 + 0.20 * u
            left = np.array([[-0.18, 0.0, 1.3], [-0.32, 0.1, 1.1], [-half, 0.35, 1.0]])
            points = np.concatenate([left, left * [-1, 1, 1]])
            names = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
            file.joints(t, dict(zip(names, points.ravel(), strict=True)), "/points")
            margin = dict.fromkeys((link.name for link in LINKS), 0.7)
            file.joints(t, {**margin, "hands": 0.7 - u, "left_forearm": 0.1}, "/margin")
            lengths = {f"{link.name}{end}": 0.3 for link in LINKS for end in ("", "_lower", "_upper")}
            file.joints(t, {**lengths, "hands_lower": 0.16, "hands_upper": 0.36}, "/link_lengths")
            file.wrench(t, "/contact/tool", "tool", [0.0, 0.0, 40.0 * (u > 0.5)])
        if events:
            file.event(0.5, "contact")
            file.event(2.5, "let_go")
    return path
