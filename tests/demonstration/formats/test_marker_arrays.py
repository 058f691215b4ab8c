"""Whose joints the markers of a topic are, and what they tell."""

import numpy as np
import pytest
import ros_samples as samples
from ros_samples import BLUE, GREEN, KINECT, MARKER, MARKERS, SPHERE_LIST, TEXT, array, marker, stamps
from synthetic_carry import carry

from drake_blfdmp.demonstration.formats.ros import ros_fields
from drake_blfdmp.demonstration.formats.ros.body_names import named_bodies, named_point
from drake_blfdmp.demonstration.formats.ros.marker_bodies import sort_markers
from drake_blfdmp.demonstration.formats.ros.marker_tracks import MarkerKey, Track
from drake_blfdmp.demonstration.formats.ros.mcap_bag import McapBag
from drake_blfdmp.demonstration.formats.ros.rosbag1 import RosBag1
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V1, KINECT_V2, MEDIAPIPE_POSE
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=1.0)
CAMERA = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # From z up to x right, y down, z forward.


def read(path, make, topic="/people", kind=MARKERS, joints=None):
    """`make(types, ns, k)` gives the markers of message k."""

    def messages(types):
        return [(samples.LATE + k, array(types, make(types, ns, k))) for k, ns in enumerate(stamps(T))]

    return RosBag1().read(samples.write_bag1(path / "a.bag", {topic: (kind, messages)}), joints)


def test_azure_kinect_numbers_people_and_confidence(tmp_path):
    camera = X @ CAMERA.T

    def make(types, ns, k):
        guessed = (samples.JOINTS[2],) if k % 3 == 0 else ()
        one = samples.azure(types, ns, camera[k], body=9, guessed=guessed) if k != 4 else []
        two = samples.azure(types, ns, camera[k] + 1.0, body=12) if 10 <= k < 20 else []
        return [*two, *one]

    raw = read(tmp_path, make)
    assert (raw.unit, raw.time_unit, raw.up, raw.empty_frames) == ("m", "s", "-y", 1)
    assert "joints: 32 of Azure Kinect by marker id (person * 100 + joint)" in raw.notes
    assert set(raw.bodies) == {"9", "12"}
    first, second = raw.bodies["9"], raw.bodies["12"]
    kept = np.delete(np.arange(len(T)), 4)
    np.testing.assert_array_equal(first.frames, kept)
    np.testing.assert_array_equal(first.x, camera[kept])
    np.testing.assert_allclose(first.t, T[kept], atol=1e-9)
    np.testing.assert_array_equal(second.frames, np.arange(10, 20))
    np.testing.assert_array_equal(second.x, camera[10:20] + 1.0)
    expected = np.ones((len(kept), 6))
    expected[kept % 3 == 0, 2] = 0.5
    np.testing.assert_array_equal(first.confidence, expected)
    np.testing.assert_array_equal(second.confidence, np.ones((10, 6)))


@pytest.mark.parametrize(("frame", "up"), [("camera", "-y"), ("world", "z"), ("a_optical_frame", "-y")])
def test_azure_kinect_frames(tmp_path, frame, up):
    assert read(tmp_path, lambda types, ns, k: samples.azure(types, ns, X[k], frame=frame)).up == up


def test_colours_of_people_are_no_confidence(tmp_path):
    def make(types, ns, k):
        guessed = range(32) if k >= 0 else ()
        return [*samples.azure(types, ns, X[k], 1), *samples.azure(types, ns, X[k] + 1.0, 2, guessed)]

    assert all(body.confidence is None for body in read(tmp_path, make).bodies.values())


@pytest.mark.parametrize("names", [AZURE_KINECT, KINECT_V2, KINECT_V1, MEDIAPIPE_POSE], ids=len)
@pytest.mark.parametrize("stride", [100, 1000, None])
@pytest.mark.parametrize("people", [1, 3])
def test_numbers_in_the_order_of_a_sensors_joints(tmp_path, names, stride, people):
    def make(types, ns, k):
        at = np.full((len(names), 3), 9.0)
        at[[names.index(name) for name in KINECT]] = X[k]
        return [
            marker(types, ns, p + body, number=body * (stride or len(names)) + joint)
            for body in range(people)
            for joint, p in enumerate(at)
        ]

    raw = read(tmp_path, make)
    # A thousand a person is ten hundreds.
    name = "{}0" if stride == 1000 else "{}"
    assert set(raw.bodies) == {name.format(body).lstrip("0") or "0" for body in range(people)}
    for body in range(people):
        np.testing.assert_array_equal(raw.bodies[name.format(body).lstrip("0") or "0"].x, X + body)


def test_a_sensors_joint_named_by_the_user(tmp_path):
    at = np.arange(96.0).reshape(32, 3)

    def make(types, ns, k):
        return [marker(types, ns, p + k, number=joint) for joint, p in enumerate(at)]

    raw = read(tmp_path, make, joints={"left_wrist": "HandLeft"})
    np.testing.assert_array_equal(raw.bodies["0"].x[3, 2], at[AZURE_KINECT.index("HandLeft")] + 3)
    with pytest.raises(RecordingError, match="no joint 'Paw' for left_wrist; the file has Pelvis"):
        read(tmp_path, make, joints={"left_wrist": "Paw"})


def test_numbers_of_no_sensor_need_the_user(tmp_path):
    def make(types, ns, k):
        return [marker(types, ns, p, number=40 + joint) for joint, p in enumerate(X[k])]

    with pytest.raises(RecordingError, match="left_shoulder.*name it with joints, the file has 40, 41"):
        read(tmp_path, make)
    joints = {point: str(40 + joint) for joint, point in enumerate(POINTS)}
    np.testing.assert_array_equal(read(tmp_path, make, joints=joints).bodies["0"].x, X)


def test_texts_on_markers_before_texts_beside_them(tmp_path):
    def make(types, ns, k):
        spheres = [marker(types, ns, p, number=j, text=POINTS[j]) for j, p in enumerate(X[k])]
        return [
            *spheres,
            *(marker(types, ns, p + 5, number=90 + j, kind=TEXT, text=POINTS[j]) for j, p in enumerate(X[k])),
        ]

    raw = read(tmp_path, make)
    assert "joints: named by the markers' texts" in raw.notes
    np.testing.assert_array_equal(raw.bodies["0"].x, X)


@pytest.mark.parametrize("kind", ["id", "name", "order", "counter"])
def test_people_with_the_same_names(tmp_path, kind):
    """Told apart by an id that all joints of one share, by the name, by the order in a message, or by counted ids."""

    def make(types, ns, k):
        return [
            marker(
                types,
                ns,
                X[k, j] + body,
                name=f"user_{body}/{point}" if kind == "name" else point,
                number={"id": 7 + body, "name": 0, "order": 0, "counter": 6 * body + j}[kind],
            )
            for body in range(2)
            for j, point in enumerate(POINTS)
        ]

    bodies = read(tmp_path, make).bodies
    names = {"id": ("7", "8"), "name": ("user 0", "user 1"), "order": ("0", "(2)"), "counter": ("0", "1")}[kind]
    assert set(bodies) == set(names)
    for body, name in enumerate(names):
        np.testing.assert_array_equal(bodies[name].x, X + body)


def test_lists_of_points_in_a_sensors_order(tmp_path):
    """In the marker's own frame, which stands somewhere and is turned by half a turn about z."""

    def make(types, ns, k):
        points = np.full((25, 3), 9.0)
        points[[KINECT_V2.index(name) for name in KINECT]] = (X[k] - 0.5) * (-1, -1, 1)
        made = marker(types, ns, (0.5, 0.5, 0.5), number=3, kind=SPHERE_LIST, points=points)
        made.pose.orientation.z, made.pose.orientation.w = 1.0, 0.0
        return [made]

    np.testing.assert_allclose(read(tmp_path, make).bodies["3"].x, X, atol=1e-12)


def test_single_markers_of_one_stamp_are_one_frame(tmp_path):
    def messages(types):
        return [
            (samples.LATE + 6 * k + j, marker(types, ns, X[k, j], name=point))
            for k, ns in enumerate(stamps(T))
            for j, point in enumerate(POINTS)
        ]

    raw = RosBag1().read(samples.write_bag1(tmp_path / "a.bag", {"/marker": (MARKER, messages)}), None)
    np.testing.assert_array_equal(raw.bodies["0"].x, X)
    np.testing.assert_allclose(raw.bodies["0"].t, T, atol=1e-9)


def test_missing_deleted_and_unset_markers(tmp_path):
    def make(types, ns, k):
        x = X[k].copy()
        x[1] = np.nan if k == 2 else x[1]
        x[4] = 0.0 if k == 3 else x[4]
        return [*samples.named(types, ns, x), marker(types, ns, (7, 7, 7), name="left_wrist", action=2)]

    expected = X.copy()
    expected[2, 1] = expected[3, 4] = np.nan
    np.testing.assert_array_equal(read(tmp_path, make).bodies["0"].x, expected)


def test_two_cameras_and_other_topics(tmp_path):
    def people(shift):
        return lambda types: [
            (a, array(types, samples.named(types, a, x + shift))) for a, x in zip(stamps(T), X, strict=True)
        ]

    def boxes(types):
        return [(5, array(types, [marker(types, 5, (1, 2, 3), name="box")]))]

    topics = {"/boxes": (MARKERS, boxes), "/a/people": (MARKERS, people(0)), "/b/people": (MARKERS, people(2))}
    bodies = RosBag1().read(samples.write_bag1(tmp_path / "a.bag", topics), None).bodies
    assert set(bodies) == {"/a/people 0", "/b/people 0"}
    np.testing.assert_array_equal(bodies["/b/people 0"].x, X + 2)
    only = samples.write_bag1(tmp_path / "b.bag", {"/boxes": (MARKERS, boxes)})
    with pytest.raises(RecordingError, match=r"b\.bag: /boxes: nothing is named like .*the file has box"):
        RosBag1().read(only, None)


def test_ids_that_count_on_from_message_to_message_are_one_person(tmp_path):
    def make(types, ns, k):
        return [
            marker(types, ns, p, name=n, number=6 * k + j) for j, (n, p) in enumerate(zip(POINTS, X[k], strict=True))
        ]

    bodies = read(tmp_path, make).bodies
    assert set(bodies) == {"0"}
    np.testing.assert_array_equal(bodies["0"].x, X)


def test_a_sensors_joints_among_other_namespaces(tmp_path):
    def make(types, ns, k):
        people = [[*samples.azure(types, ns, X[k] + p, 0)] for p in range(2)]
        for p, markers in enumerate(people):
            for made in markers:
                made.ns = f"person_{p}"
        return [marker(types, ns, (1, 1, 1), name="centre", number=77), *people[0], *people[1]]

    bodies = read(tmp_path, make).bodies
    assert set(bodies) == {"person_0 0", "person_1 0"}
    np.testing.assert_array_equal(bodies["person_1 0"].x, X + 1)


def test_every_message_may_have_another_structure(tmp_path, monkeypatch):
    monkeypatch.setattr(ros_fields, "_MOST_STRUCTURES", 5)

    def make(types, ns, k):
        return [*samples.named(types, ns, X[k]), marker(types, ns, (0, 0, 1), number=1000 + k, name="clock")]

    np.testing.assert_array_equal(read(tmp_path, make).bodies["0"].x, X)


@pytest.mark.parametrize(
    ("name", "point", "rest"),
    [
        ("left_shoulder_1", "left_shoulder", "1"),
        ("K4ABT_JOINT_WRIST_LEFT", "left_wrist", "K 4 ABT"),
        ("user_2/right_hand", "right_wrist", "user 2"),
        ("human_0_left_upper_arm", "left_shoulder", "human 0"),
        ("RElbow", "right_elbow", ""),
        ("l_elbow_a4f3e", "left_elbow", "a 4 f 3 e"),
    ],
)
def test_names_of_frames(name, point, rest):
    assert named_point(name)[:2] == (point, rest)


@pytest.mark.parametrize("name", ["", "base_link", "left_gripper", "panda_link4", "hand_tip", "x" * 10_000, "a " * 500])
def test_names_that_are_no_points(name):
    assert named_point(name) is None


def test_wrists_come_before_hands_and_people_must_be_whole():
    names = ["left_hand", "left_wrist", "left_elbow", "left_shoulder", "right_elbow", "right_shoulder", "right_hand"]
    found = named_bodies([*names, *(f"{name}_2" for name in names[:5])])
    assert set(found) == {""}
    assert (found[""]["left_wrist"], found[""]["right_wrist"]) == ("left_wrist", "right_hand")


def test_nobody_says_what_there_is():
    track = Track(np.zeros(1, int), np.zeros(1, int), np.zeros((1, 3)), np.zeros((1, 4)), np.zeros((1, 4)))
    tracks = {MarkerKey("world", f"cone {k}", k, 2, "", 0, -1): track for k in range(3)}
    with pytest.raises(RecordingError, match="a: nothing is named like .*the file has cone 0, cone 1, cone 2"):
        sort_markers("a", tracks, None)
    with pytest.raises(RecordingError, match="one name for its three axes; give left_wrist one name"):
        sort_markers("a", tracks, {"left_wrist": ("a", "b", "c")})


def test_run_of_this_package(tmp_path):
    """The person's points stand in a JointState among those of the arms."""
    from drake_blfdmp.recording.mcap_file import McapFile
    from drake_blfdmp.ros2.messages import JOINT_STATE, joint_state_template

    elements = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
    file = McapFile(tmp_path / "run.mcap")
    file.add_metadata("run", {"synthetic": True})
    for topic, names, values in (("/joint_states", ["left_1", "left_2"], X[:, 0, :2]), ("/points", elements, X)):
        channel = file.add_channel(topic, JOINT_STATE)
        template = joint_state_template(names, velocity=False, effort=False)
        for ns, value in zip(stamps(T), values, strict=True):
            file.write(channel, ns, template.encode(ns, value))
    file.close()
    raw = McapBag().read(tmp_path / "run.mcap", None)
    np.testing.assert_array_equal(raw.bodies["0"].x, X)
    np.testing.assert_allclose(raw.bodies["0"].t, T, atol=1e-9)
    assert raw.up == "z"
    assert raw.synthetic


def test_colours_seen_on_one_marker_tell_confidence(tmp_path):
    def make(types, ns, k):
        red = (1.0, 0.0, 0.0, 1.0)
        return [
            marker(types, ns, p, name=point, rgba=(GREEN, BLUE, red)[k % 3] if j == 5 else GREEN)
            for j, (point, p) in enumerate(zip(POINTS, X[k], strict=True))
        ]

    confidence = read(tmp_path, make).bodies["0"].confidence
    np.testing.assert_array_equal(confidence[:6, 5], [1, 0.5, 0, 1, 0.5, 0])
    np.testing.assert_array_equal(confidence[:, :5], 1)
