"""Hand orientations in files: written, read, told from a place that is always filled alike, and cut with the frames."""

import json

import numpy as np
import pytest
import ros_samples as samples
from file_samples import BONES, write_azure_json, write_bvh, write_omomo_pt
from ros_samples import LATE, stamps, transform
from scipy.spatial.transform import Rotation
from synthetic_carry import carry
from text_samples import write_ntu_skeleton

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.ros.rosbag1 import RosBag1
from drake_blfdmp.demonstration.formats.sensor_joints import AZURE_KINECT, KINECT_V2
from drake_blfdmp.demonstration.formats.tables.table_names import joints_of, quaternions_of
from drake_blfdmp.demonstration.formats.writing import WRITERS, write_recording
from drake_blfdmp.demonstration.hand_orientation import turn_since
from drake_blfdmp.demonstration.holding import find_holding
from drake_blfdmp.quaternions import angle_between, from_rotation_vector
from drake_blfdmp.ros2.messages import TF
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=1.0)
RNG = np.random.default_rng(3)
TURNS = from_rotation_vector(np.sin(2.0 * T[:, None, None] + RNG.uniform(0.0, 6.0, (2, 3))))


def scalar_last(q):
    return np.roll(q, -1, axis=-1)


def recording(orientations=TURNS, x=X, confidence=None):
    frames = np.arange(len(T)) + 7
    return Recording(T, x, "a.trc", "trc", frames, confidence=confidence, orientations=orientations, up="z")


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("told", [False, True])
def test_what_is_written_is_read(tmp_path, suffix, told):
    q = TURNS.copy()
    q[3, 0] = q[5:8, 1] = q[9] = np.nan
    x = X.copy()
    x[11, 3] = np.nan
    confidence = np.where(np.isfinite(x).all(axis=-1), 0.5, 0.0) if told else None
    path = tmp_path / f"a{suffix}"
    write_recording(path, recording(q, x, confidence))
    back = read_recording(path)
    np.testing.assert_allclose(back.orientations, q, atol=1e-15)
    np.testing.assert_array_equal(back.x, x)
    np.testing.assert_array_equal(back.frames, np.arange(len(T)) + 7)
    assert (back.confidence is not None) == told
    assert "hand orientations: left in 94 %, right in 87 % of the frames" in back.evidence


@pytest.mark.parametrize("suffix", WRITERS)
def test_a_file_without_is_the_file_it_was(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    write_recording(path, recording(None))
    back = read_recording(path)
    assert back.orientations is None
    assert not any("orientation" in sentence for sentence in back.evidence)
    if suffix == ".csv":
        assert "Q" not in path.read_text().splitlines()[0]


@pytest.mark.parametrize("suffix", WRITERS)
def test_one_that_never_changes_is_none(tmp_path, suffix):
    q = TURNS.copy()
    q[:, 0] = q[0, 0] * np.where(np.arange(len(T)) % 2, 1.0, -1.0)[:, None]
    path = tmp_path / f"a{suffix}"
    write_recording(path, recording(q))
    back = read_recording(path)
    assert np.isnan(back.orientations[:, 0]).all()
    np.testing.assert_allclose(back.orientations[:, 1], q[:, 1], atol=1e-15)
    still = tmp_path / f"b{suffix}"
    write_recording(still, recording(np.broadcast_to(q[:1], q.shape)))
    assert read_recording(still).orientations is None


def test_frames_cut_them_too(tmp_path):
    path = tmp_path / "a.csv"
    write_recording(path, recording())
    np.testing.assert_allclose(read_recording(path, frames=(10, 20)).orientations, TURNS[3:14], atol=1e-15)


def test_bvh_has_them_from_its_joints(tmp_path):
    back = read_recording(write_bvh(tmp_path / "a.bvh", T, X, order="XYZ"))
    rng = np.random.default_rng(3)  # As the writer turns its bones.
    made = {
        bone: Rotation.from_rotvec(np.sin(np.arange(len(T))[:, None] / 9.0 + rng.uniform(0, 6, 3))) for bone in BONES
    }
    for hand, bone in enumerate(("LeftHand", "RightHand")):
        expected = np.roll(made[bone].as_quat(), 1, axis=-1)
        assert angle_between(back.orientations[:, hand], expected).max() < 1e-7


def test_a_lost_angle_loses_the_orientation_alone(tmp_path):
    path = write_bvh(tmp_path / "a.bvh", T, X)
    lines = path.read_text().splitlines()
    cells = lines[-5].split()
    cells[-1] = "nan"
    lines[-5] = " ".join(cells)
    path.write_text("\n".join(lines) + "\n")
    back = read_recording(path)
    assert np.isfinite(back.x).all()
    assert np.isnan(back.orientations[-5, 1]).all()
    assert np.isfinite(np.delete(back.orientations, -5, axis=0)).all()


def test_tf_has_them_through_chains_of_frames(tmp_path):
    """world <- torso, turned <- wrists; the wrists' own turns on top."""
    torso = Rotation.from_euler("xz", [0.4, -1.1])

    def moving(types):
        for k, ns in enumerate(stamps(T)):
            made = [transform(types, ns, "world", "torso", (0.1, 0.0, 0.2), torso.as_quat())]
            for j, point in enumerate(POINTS):
                p = torso.inv().apply(X[k, j] - (0.1, 0.0, 0.2))
                q = scalar_last(TURNS[k, j // 3]) if point.endswith("wrist") else (0.0, 0.0, 0.0, 2.0)
                made.append(transform(types, ns, "torso", point, p, q))
            yield LATE + k, made

    topics = {"/tf": (TF, lambda types: [(a, types[TF](list(some))) for a, some in moving(types)])}
    body = RosBag1().read(samples.write_bag1(tmp_path / "a.bag", topics), None).bodies["0"]
    np.testing.assert_allclose(body.x, X, atol=1e-12)
    for hand in range(2):
        expected = (torso * Rotation.from_quat(scalar_last(TURNS[:, hand]))).as_matrix()
        found = Rotation.from_quat(scalar_last(body.orientations[:, hand])).as_matrix()
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_the_azure_kinects_json_has_them(tmp_path):
    path = write_azure_json(tmp_path / "a.json", T, X)
    assert read_recording(path).orientations is None  # All the same there.
    document = json.loads(path.read_text())
    wrists = [AZURE_KINECT.index(name) for name in ("WristLeft", "WristRight")]
    for frame, turns in zip(document["frames"], TURNS.tolist(), strict=True):
        for joint, turn in zip(wrists, turns, strict=True):
            frame["bodies"][0]["joint_orientations"][joint] = turn
    del document["frames"][4]["bodies"][0]["joint_orientations"]
    document["frames"][6]["bodies"][0]["joint_orientations"][wrists[1]] = [1.0, "none", None]
    path.write_text(json.dumps(document))
    expected = TURNS.copy()
    expected[4] = expected[6, 1] = np.nan
    back = read_recording(path)
    np.testing.assert_allclose(back.orientations, expected, atol=1e-12)
    np.testing.assert_allclose(back.x, X, atol=1e-8)


def test_ntu_has_them(tmp_path):
    path = write_ntu_skeleton(tmp_path / "a.skeleton", T, X)
    assert read_recording(path).orientations is None
    lines = path.read_text().splitlines()
    for k, turns in enumerate(TURNS):
        first = 2 + k * (len(KINECT_V2) + 3) + 2  # Of the frame's joints: below the counts and the person.
        for name, turn in zip(("WristLeft", "WristRight"), turns, strict=True):
            cells = lines[first + KINECT_V2.index(name)].split()
            cells[7:11] = [repr(float(value)) for value in turn]
            lines[first + KINECT_V2.index(name)] = " ".join(cells)
    path.write_text("\n".join(lines) + "\n")
    np.testing.assert_allclose(read_recording(path).orientations, TURNS, atol=1e-12)


def test_an_omomo_file_has_its_objects_for_both_hands(tmp_path):
    back = read_recording(write_omomo_pt(tmp_path / "a.pt", T, X, turns=TURNS[:, 0]))
    for hand in range(2):
        assert angle_between(back.orientations[:, hand], TURNS[:, 0]).max() < 1e-6
    assert "orientations: the object's, for both hands" in back.evidence
    assert read_recording(write_omomo_pt(tmp_path / "b.pt", T, X)).orientations is None


def test_the_box_of_a_real_carry_turns_with_it(recordings):
    """The person tips the box towards themselves, by what the tracked box says; it is put down as it stood."""
    demonstration = clean(read_recording(recordings / "omomo_largebox" / "sub3_largebox_003.pt"))
    holding = find_holding(demonstration)
    t = np.linspace(holding.start_s, holding.end_s, 50)
    turn = turn_since(demonstration, t, holding.start_s, 1.2)
    angle = np.rad2deg(2.0 * np.arctan2(turn[:, 1], turn[:, 0]))
    assert 15.0 < angle.max() < 22.0
    assert abs(angle[-1]) < 5.0


@pytest.mark.parametrize(
    "spelling",
    ["{}Q{}", "{}_q{}", "{}.quat.{}", "{}_orientation_{}", "{} Rotation ({})", "{}_{}_quat", "{}_ori_{}"],
)
@pytest.mark.parametrize("names", [("WristLeft", "WristRight"), ("hand_left", "hand_right")])
def test_columns_of_a_table(tmp_path, spelling, names):
    path = tmp_path / "a.csv"
    write_recording(path, recording())
    header, *rows = path.read_text().splitlines()
    assert "WristLeftQw" in header
    for side, name in zip(("Left", "Right"), names, strict=True):
        for axis in "wxyz":
            header = header.replace(f"Wrist{side}Q{axis}", spelling.format(name, axis))
    path.write_text("\n".join([header, *rows]) + "\n")
    np.testing.assert_allclose(read_recording(path).orientations, TURNS, atol=1e-15)


def test_columns_that_only_look_like_a_quaternion():
    names = ["time", "WristLeftX", "WristLeftY", "WristLeftZ", "HandLeftRotX", "HandLeftRotY", "HandLeftRotZ"]
    assert quaternions_of(names) == {}  # Angles: no w.
    assert "WristLeft" in joints_of(names)
    turned = [*names[:4], "WristLeftQw", "WristLeftQx", "WristLeftQy", "WristLeftQz"]
    assert list(joints_of(turned)) == ["WristLeft"]
    assert quaternions_of(turned) == {"wristleft": (4, 5, 6, 7)}
