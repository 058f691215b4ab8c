"""The ROS 2 messages this package writes: their definitions as text, and their layout in CDR.

Definitions are those of ROS 2 Humble to Rolling (unchanged between them), comments left out, in the `ros2msg` form that
MCAP embeds: the message, then every type it uses, each behind a line of 80 `=` (https://mcap.dev/spec/registry).
"""

from collections.abc import Sequence
from typing import NamedTuple

from drake_blfdmp.ros2.cdr import CdrTemplate, CdrWriter

STRING = "std_msgs/msg/String"
LOG = "rcl_interfaces/msg/Log"
JOINT_STATE = "sensor_msgs/msg/JointState"
TF = "tf2_msgs/msg/TFMessage"
WRENCH = "geometry_msgs/msg/WrenchStamped"
MARKERS = "visualization_msgs/msg/MarkerArray"

INFO = 20  # rcl_interfaces/msg/Log.INFO
SPHERE, LINE_LIST, ADD = 2, 5, 0  # visualization_msgs/msg/Marker: types and action.

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
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec\n",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z\n",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v\n",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data\n",
    "visualization_msgs/Marker": (
        "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\n"
        "int32 CUBE_LIST=6\nint32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n"
        "int32 TRIANGLE_LIST=11\nint32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n"
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\ngeometry_msgs/Pose pose\n"
        "geometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nvisualization_msgs/MeshFile mesh_file\nbool mesh_use_embedded_materials\n"
    ),
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
    MARKERS: _definition(
        "visualization_msgs/Marker[] markers\n",
        "visualization_msgs/Marker",
        "std_msgs/Header",
        "builtin_interfaces/Time",
        "geometry_msgs/Pose",
        "geometry_msgs/Point",
        "geometry_msgs/Quaternion",
        "geometry_msgs/Vector3",
        "std_msgs/ColorRGBA",
        "builtin_interfaces/Duration",
        "sensor_msgs/CompressedImage",
        "visualization_msgs/UVCoordinate",
        "visualization_msgs/MeshFile",
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


class Sphere(NamedTuple):
    """What of a sphere stays from one message to the next: name, id, diameter (m) and colour (red to alpha, 0 to 1).

    And whether it has an orientation of its own that changes.
    """

    name: str
    id: int
    diameter: float
    rgba: tuple[float, float, float, float]
    turns: bool = False


def spheres_template(frame_id: str, spheres: Sequence[Sphere], *, lifetime_ns: int = 0) -> CdrTemplate:
    """A visualization_msgs/msg/MarkerArray; values are x y z (m) of each sphere's centre, then qx qy qz qw if it turns.

    Args:
        frame_id: frame of the centres.
        spheres: the name is written as namespace, `ns`.
        lifetime_ns: after which a viewer drops the spheres; 0 for never.
    """
    return markers_template(frame_id, spheres, (), lifetime_ns=lifetime_ns)


class Lines(NamedTuple):
    """What of a list of lines stays: name, id, width (m), and how many lines there are."""

    name: str
    id: int
    width: float
    count: int


def markers_template(
    frame_id: str, spheres: Sequence[Sphere], lines: Sequence[Lines], *, lifetime_ns: int = 0
) -> CdrTemplate:
    """A visualization_msgs/msg/MarkerArray of spheres, then of lists of lines.

    Its values are those of `spheres_template`, then x y z (m) of every line's two ends; its singles red, green, blue
    and alpha of every line's two ends.

    Args:
        frame_id: frame of all points.
        spheres, lines: names are written as namespace, `ns`.
        lifetime_ns: after which a viewer drops the markers; 0 for never.
    """
    writer = CdrWriter()
    writer.uint32(len(spheres) + len(lines))
    for sphere in spheres:
        _header(writer, frame_id)
        _what(writer, sphere.name, sphere.id, SPHERE)
        writer.float64s(7 if sphere.turns else 3)
        still = () if sphere.turns else _UPRIGHT
        for number in (*still, *3 * (sphere.diameter,)):  # Orientation, scale.
            writer.float64(number)
        for number in sphere.rgba:
            writer.float32(number)
        _rest(writer, lifetime_ns, 0)
    for some in lines:
        _header(writer, frame_id)
        _what(writer, some.name, some.id, LINE_LIST)
        for number in (0.0, 0.0, 0.0, *_UPRIGHT, some.width, 0.0, 0.0):  # Pose, scale: x alone is the width.
            writer.float64(number)
        for number in (1.0, 1.0, 1.0, 1.0):
            writer.float32(number)
        _rest(writer, lifetime_ns, 2 * some.count)
    return CdrTemplate(writer)


_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def _what(writer: CdrWriter, name: str, number: int, kind: int) -> None:
    """Namespace, id, type and action of a marker."""
    writer.string(name)
    for value in (number, kind, ADD):
        writer.int32(value)


def _rest(writer: CdrWriter, lifetime_ns: int, points: int) -> None:
    """What of a marker stands behind its colour: among it its points and their colours, open."""
    writer.int32(lifetime_ns // 1_000_000_000)
    writer.uint32(lifetime_ns % 1_000_000_000)
    writer.uint8(0)  # frame_locked
    writer.uint32(points)
    writer.float64s(3 * points)
    writer.uint32(points)  # colors
    writer.float32s(4 * points)
    writer.string("")  # texture_resource
    _no_image(writer)
    writer.uint32(0)  # uv_coordinates
    for _ in range(3):  # text, mesh_resource, mesh_file.filename
        writer.string("")
    writer.uint32(0)  # mesh_file.data
    writer.uint8(0)  # mesh_use_embedded_materials


def _no_image(writer: CdrWriter) -> None:
    """An empty sensor_msgs/msg/CompressedImage: stamp, frame, format, data."""
    for _ in range(2):
        writer.uint32(0)
    for _ in range(2):
        writer.string("")
    writer.uint32(0)
