"""The ROS 2 messages a recording holds: their definitions as text, and their layout in CDR.

Definitions are those of ROS 2 Humble to Rolling (unchanged between them), comments left out, in the `ros2msg` form that
MCAP embeds: the message, then every type it uses, each behind a line of 80 `=` (https://mcap.dev/spec/registry).
"""

from collections.abc import Sequence

from drake_blfdmp.recording.cdr import CdrTemplate, CdrWriter

STRING = "std_msgs/msg/String"
LOG = "rcl_interfaces/msg/Log"
JOINT_STATE = "sensor_msgs/msg/JointState"
TF = "tf2_msgs/msg/TFMessage"
WRENCH = "geometry_msgs/msg/WrenchStamped"

INFO = 20  # rcl_interfaces/msg/Log.INFO

_TYPES = {
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec\n",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Quaternion": "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"
    ),
    "geometry_msgs/Wrench": "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque\n",
}


def _definition(text: str, *used: str) -> str:
    blocks = [text, *(f"MSG: {name}\n{_TYPES[name]}" for name in used)]
    return ("=" * 80 + "\n").join(blocks)


DEFINITIONS = {
    STRING: _definition("string data\n"),
    LOG: _definition(
        "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\n"
        "builtin_interfaces/Time stamp\nuint8 level\nstring name\nstring msg\n"
        "string file\nstring function\nuint32 line\n",
        "builtin_interfaces/Time",
    ),
    JOINT_STATE: _definition(
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort\n",
        "std_msgs/Header",
        "builtin_interfaces/Time",
    ),
    TF: _definition(
        "geometry_msgs/TransformStamped[] transforms\n",
        "geometry_msgs/TransformStamped",
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Transform",
        "geometry_msgs/Vector3",
        "geometry_msgs/Quaternion",
    ),
    WRENCH: _definition(
        "std_msgs/Header header\ngeometry_msgs/Wrench wrench\n",
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Wrench",
        "geometry_msgs/Vector3",
    ),
}


def string_message(text: str) -> bytes:
    """A std_msgs/msg/String."""
    writer = CdrWriter()
    writer.string(text)
    return writer.message()


def log_message(t_ns: int, name: str, text: str) -> bytes:
    """An rcl_interfaces/msg/Log of level INFO from the node `name`."""
    writer = CdrWriter()
    writer.stamp()
    writer.uint8(INFO)
    writer.string(name)
    writer.string(text)
    writer.string("")
    writer.string("")
    writer.uint32(0)
    return writer.message(t_ns)


def _header(writer: CdrWriter, frame_id: str) -> None:
    writer.stamp()
    writer.string(frame_id)


def joint_state_template(names: Sequence[str], *, velocity: bool = True, effort: bool = True) -> CdrTemplate:
    """A sensor_msgs/msg/JointState; values are positions, then velocities, then efforts, in the order of `names`."""
    writer = CdrWriter()
    _header(writer, "")
    writer.strings(names)
    writer.float64_sequence(len(names))
    writer.float64_sequence(len(names) if velocity else 0)
    writer.float64_sequence(len(names) if effort else 0)
    return CdrTemplate(writer)


def tf_template(parent: str, children: Sequence[str]) -> CdrTemplate:
    """A tf2_msgs/msg/TFMessage; values are x y z (m) qx qy qz qw of each child in the parent's frame."""
    writer = CdrWriter()
    writer.uint32(len(children))
    for child in children:
        _header(writer, parent)
        writer.string(child)
        writer.float64s(7)
    return CdrTemplate(writer)


def wrench_template(frame_id: str) -> CdrTemplate:
    """A geometry_msgs/msg/WrenchStamped; values are the force (3, N), then the torque (3, N m)."""
    writer = CdrWriter()
    _header(writer, frame_id)
    writer.float64s(6)
    return CdrTemplate(writer)
