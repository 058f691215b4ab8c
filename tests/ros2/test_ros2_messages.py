"""Definitions and bytes against an independent implementation (rosbags) and its copy of ROS 2 Humble's definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from drake_blfdmp.ros2 import messages
from drake_blfdmp.ros2.cdr import CdrReader

HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
NAMES = st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=12), max_size=8)
TIMES = st.integers(0, 2**31 * 10**9 - 1)
NUMBERS = st.floats(allow_nan=False)


def embedded_store(name: str):
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(messages.DEFINITIONS[name], name))
    return store


@pytest.mark.parametrize("name", messages.DEFINITIONS)
def test_definition_is_ros_2s(name):
    # The hash covers the fields' names, types and order, through all types used.
    assert embedded_store(name).hash_rihs01(name) == HUMBLE.hash_rihs01(name)


def stamp(t_ns):
    return HUMBLE.types["builtin_interfaces/msg/Time"](t_ns // 10**9, t_ns % 10**9)


def header(t_ns, frame):
    return HUMBLE.types["std_msgs/msg/Header"](stamp(t_ns), frame)


@given(NAMES, TIMES, st.booleans(), st.booleans(), st.data())
def test_joint_state_bytes(names, t_ns, velocity, effort, data):
    n = len(names)
    count = n * (1 + velocity + effort)
    values = np.array(data.draw(st.lists(NUMBERS, min_size=count, max_size=count)))
    fields = iter(values.reshape(-1, n)) if n else iter([np.empty(0)] * 3)
    expected = HUMBLE.types[messages.JOINT_STATE](
        header(t_ns, ""),
        names,
        next(fields),
        next(fields) if velocity else np.empty(0),
        next(fields) if effort else np.empty(0),
    )
    template = messages.joint_state_template(names, velocity=velocity, effort=effort)
    encoded = template.encode(t_ns, values)
    assert encoded == bytes(HUMBLE.serialize_cdr(expected, messages.JOINT_STATE))
    # A template used again holds nothing of the previous message.
    template.encode(0, np.full(count, np.nan))
    assert template.encode(t_ns, values) == encoded


@given(st.text("ab", max_size=9), NAMES, TIMES, st.data())
def test_tf_bytes(parent, children, t_ns, data):
    values = np.array(data.draw(st.lists(NUMBERS, min_size=7 * len(children), max_size=7 * len(children))))
    types = HUMBLE.types
    transforms = [
        types["geometry_msgs/msg/TransformStamped"](
            header(t_ns, parent),
            child,
            types["geometry_msgs/msg/Transform"](
                types["geometry_msgs/msg/Vector3"](*row[:3]), types["geometry_msgs/msg/Quaternion"](*row[3:])
            ),
        )
        for child, row in zip(children, values.reshape(-1, 7), strict=True)
    ]
    expected = HUMBLE.serialize_cdr(types[messages.TF](transforms), messages.TF)
    assert messages.tf_template(parent, children).encode(t_ns, values) == bytes(expected)


@given(st.text("ab", max_size=9), TIMES, st.lists(NUMBERS, min_size=6, max_size=6))
def test_wrench_bytes(frame, t_ns, values):
    vector = HUMBLE.types["geometry_msgs/msg/Vector3"]
    wrench = HUMBLE.types["geometry_msgs/msg/Wrench"](vector(*values[:3]), vector(*values[3:]))
    expected = HUMBLE.serialize_cdr(HUMBLE.types[messages.WRENCH](header(t_ns, frame), wrench), messages.WRENCH)
    assert messages.wrench_template(frame).encode(t_ns, np.array(values)) == bytes(expected)


@given(NAMES, TIMES, st.integers(0, 2**31 - 1), st.floats(0, 1, width=32), st.data())
def test_spheres_bytes(names, t_ns, lifetime_ns, alpha, data):
    values = np.array(data.draw(st.lists(NUMBERS, min_size=3 * len(names), max_size=3 * len(names))))
    ids = data.draw(st.lists(st.integers(-(2**31), 2**31 - 1), min_size=len(names), max_size=len(names)))
    types = HUMBLE.types
    vector = types["geometry_msgs/msg/Vector3"]
    markers = [
        types["visualization_msgs/msg/Marker"](
            header(t_ns, "world"),
            name,
            number,
            messages.SPHERE,
            messages.ADD,
            types["geometry_msgs/msg/Pose"](
                types["geometry_msgs/msg/Point"](*row), types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            ),
            vector(0.05, 0.05, 0.05),
            types["std_msgs/msg/ColorRGBA"](1.0, 0.5, 0.0, alpha),
            types["builtin_interfaces/msg/Duration"](lifetime_ns // 10**9, lifetime_ns % 10**9),
            False,
            [],
            [],
            "",
            types["sensor_msgs/msg/CompressedImage"](header(0, ""), "", np.empty(0, np.uint8)),
            [],
            "",
            "",
            types["visualization_msgs/msg/MeshFile"]("", np.empty(0, np.uint8)),
            False,
        )
        for name, number, row in zip(names, ids, values.reshape(-1, 3), strict=True)
    ]
    expected = HUMBLE.serialize_cdr(types[messages.MARKERS](markers), messages.MARKERS)
    spheres = [messages.Sphere(name, k, 0.05, (1.0, 0.5, 0.0, alpha)) for name, k in zip(names, ids, strict=True)]
    template = messages.spheres_template("world", spheres, lifetime_ns=lifetime_ns)
    assert template.encode(t_ns, values) == bytes(expected)


@given(st.text(st.characters(codec="utf-8", exclude_characters="\0")), TIMES)
def test_text_bytes(text, t_ns):
    string = HUMBLE.types[messages.STRING](text)
    assert messages.string_message(text) == bytes(HUMBLE.serialize_cdr(string, messages.STRING))
    log = HUMBLE.types[messages.LOG](stamp(t_ns), messages.INFO, "node", text, "", "", 0)
    assert messages.log_message(t_ns, "node", text) == bytes(HUMBLE.serialize_cdr(log, messages.LOG))


@given(NAMES)
def test_reader_refuses_every_truncation(names):
    message = messages.joint_state_template(names).encode(0, np.zeros(3 * len(names)))
    for end in range(len(message)):
        with pytest.raises(ValueError, match=r"encapsulation|ends within|utf-8"):
            reader = CdrReader(message[:end])
            reader.stamp()
            reader.string()
            reader.strings()
            for _ in range(3):
                reader.float64_sequence()
