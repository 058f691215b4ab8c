"""People as frames of /tf."""

import numpy as np
import pytest
import ros_samples as samples
from ros_samples import LATE, stamps, transform
from scipy.spatial.transform import Rotation
from synthetic_carry import carry

from drake_blfdmp.demonstration.formats.ros.rosbag1 import RosBag1
from drake_blfdmp.demonstration.formats.ros.rosbag2 import RosBag2
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.ros2.messages import TF
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=1.0)
TURN = Rotation.from_euler("xyz", [0.3, -0.7, 1.9])
AT = np.array([0.5, -0.2, 1.1])


def write(path, moving, static=None, **options):
    """`moving(types)` gives [(log time, [transforms])], `static(types)` the transforms of /tf_static."""

    def message(types, transforms):
        return types[TF](list(transforms))

    topics = {"/tf": (TF, lambda types: [(a, message(types, some)) for a, some in moving(types)])}
    if static:
        topics["/tf_static"] = (TF, lambda types: [(LATE, message(types, static(types)))])
    return samples.write_bag1(path, topics, **options)


def flat(types, shift=0.0, suffix="", parent="world"):
    return [
        (
            LATE + k,
            [transform(types, ns, parent, point + suffix, p + shift) for point, p in zip(POINTS, x, strict=True)],
        )
        for k, (ns, x) in enumerate(zip(stamps(T), X, strict=True))
    ]


def check(raw, body="0", x=X):
    np.testing.assert_allclose(raw.bodies[body].x, x, atol=1e-12)
    np.testing.assert_allclose(raw.bodies[body].t, T, atol=1e-9)
    assert (raw.unit, raw.time_unit) == ("m", "s")


def test_frames_in_one_root(tmp_path):
    raw = RosBag1().read(write(tmp_path / "a.bag", flat), None)
    check(raw)
    assert raw.up == "z"


def test_ros2(tmp_path):
    topics = {"/tf": (TF, lambda types: [(a, types[TF](some)) for a, some in flat(types)])}
    check(RosBag2().read(samples.write_bag2(tmp_path / "bag", topics), None))


def test_chains_are_resolved_through_static_and_moving_frames(tmp_path):
    """world <- (static) camera <- (moving) torso <- shoulder <- elbow <- wrist, each turned in its parent."""
    torso = Rotation.from_euler("z", np.linspace(0.0, 0.8, len(T))[:, None])

    def moving(types):
        for k, ns in enumerate(stamps(T)):
            made = [transform(types, ns, "/camera", "torso", (0, 0.1 * k, 0), torso[k].as_quat())]
            in_torso = torso[k].inv().apply(TURN.inv().apply(X[k] - AT) - (0, 0.1 * k, 0))
            for arm in (0, 3):
                parent, p, turned = "torso", np.zeros(3), Rotation.identity()
                for j in range(arm, arm + 3):
                    made.append(
                        transform(types, ns, parent, POINTS[j], turned.inv().apply(in_torso[j] - p), TURN.as_quat())
                    )
                    parent, p, turned = POINTS[j], in_torso[j], turned * TURN
            yield LATE + k, made

    def static(types):
        return [transform(types, 1, "world", "camera", AT, TURN.as_quat())]

    raw = RosBag1().read(write(tmp_path / "a.bag", moving, static), None)
    check(raw)
    assert raw.up == "z"


def test_a_parent_between_its_own_samples_is_interpolated(tmp_path):
    def moving(types):
        for k, ns in enumerate(stamps(T)):
            yield LATE + 2 * k, [transform(types, ns - 10_000_000, "world", "camera", (0.01 * k, 0, 0))]
            yield LATE + 2 * k + 1, [transform(types, ns, "camera", n, p) for n, p in zip(POINTS, X[k], strict=True)]

    # Time 0 comes after the camera's -0.01 s, which no ROS 1 stamp can hold: leave it out.
    def later(types):
        return list(moving(types))[2:]

    x = RosBag1().read(write(tmp_path / "a.bag", later), None).bodies["0"].x
    k = np.arange(1, len(T))
    shift = np.minimum(0.01 * k + 0.01 * 0.01 * 30, 0.01 * k[-1])  # Held after the last.
    np.testing.assert_allclose(x, X[1:] + shift[:, None, None] * np.array([1, 0, 0]), atol=1e-6)


def test_openni_sends_one_frame_a_message_each_with_its_own_stamp(tmp_path):
    """Without wrists; a lost joint leaves a hole in its own row, not in the next."""
    names = [f"{point.replace('wrist', 'hand')}_2" for point in POINTS]

    def moving(types):
        for k, ns in enumerate(stamps(T)):
            for j, (name, p) in enumerate(zip(names, X[k], strict=True)):
                if (k, j) != (5, 0):
                    yield LATE + 10 * k + j, [transform(types, ns + 1 + 100_000 * j, "/openni_depth_frame", name, p)]

    raw = RosBag1().read(write(tmp_path / "a.bag", moving), None)
    expected = X.copy()
    expected[5, 0] = np.nan
    np.testing.assert_array_equal(raw.bodies["2"].x, expected)
    np.testing.assert_allclose(np.delete(raw.bodies["2"].t, 5), np.delete(T, 5), atol=1e-6)
    assert "wrists: left_hand_2, right_hand_2 stand for them" in raw.notes


def test_two_people(tmp_path):
    def both(types):
        return [
            (a, [*one, *two])
            for (a, one), (_, two) in zip(flat(types, suffix="_1"), flat(types, 1.0, "_2"), strict=True)
        ]

    raw = RosBag1().read(write(tmp_path / "a.bag", both), None)
    check(raw, "1")
    check(raw, "2", X + 1.0)


def test_frames_named_by_the_user(tmp_path):
    def moving(types):
        return [
            (a, [*some, transform(types, stamps(T)[k], "world", "glove", (k, 0, 0))])
            for k, (a, some) in enumerate(flat(types))
        ]

    raw = RosBag1().read(write(tmp_path / "a.bag", moving), {"left_wrist": "glove"})
    np.testing.assert_array_equal(raw.bodies["0"].x[:, 2, 0], np.arange(len(T)))


def test_stamps_that_tell_nothing(tmp_path):
    def moving(types):
        return [
            (ns, [transform(types, 0, "world", point, p) for point, p in zip(POINTS, x, strict=True)])
            for ns, x in zip(stamps(T), X, strict=True)
        ]

    check(RosBag1().read(write(tmp_path / "a.bag", moving), None))


@pytest.mark.parametrize(
    ("parents", "said"),
    [
        (["world"] * 5 + ["map"], r"different roots \(map, world\)"),
        (["world"] * 2 + ["left_wrist"] + ["world"] * 3, "frame left_wrist is its own ancestor"),
    ],
)
def test_trees_that_cannot_be_resolved(tmp_path, parents, said):
    def moving(types):
        return [
            (LATE + k, [transform(types, ns, parent, n, p) for parent, n, p in zip(parents, POINTS, X[k], strict=True)])
            for k, ns in enumerate(stamps(T))
        ]

    with pytest.raises(RecordingError, match=said):
        RosBag1().read(write(tmp_path / "a.bag", moving), None)


def test_robots_alone_are_nobody(tmp_path):
    def moving(types):
        return [(a, [transform(types, a, "base_link", "left_gripper", (0, 0, k))]) for k, a in enumerate(stamps(T))]

    with pytest.raises(RecordingError, match="nothing is named like left_shoulder.*the file has left_gripper"):
        RosBag1().read(write(tmp_path / "a.bag", moving), None)


def test_static_alone_moves_nobody(tmp_path):
    def static(types):
        return [transform(types, 1, "world", point, p) for point, p in zip(POINTS, X[0], strict=True)]

    with pytest.raises(RecordingError, match="static; record the topic /tf"):
        RosBag1().read(write(tmp_path / "a.bag", lambda types: [], static), None)


def test_a_rotation_that_is_none_is_a_missing_point(tmp_path):
    def moving(types):
        for k, ns in enumerate(stamps(T)):
            q = (0.0, 0.0, 0.0, 0.0) if k == 3 else (0.0, 0.0, 0.0, 1.0)
            made = [transform(types, ns, "world", "camera", (0, 0, 0), q)]
            yield LATE + k, [*made, *(transform(types, ns, "camera", n, p) for n, p in zip(POINTS, X[k], strict=True))]

    x = RosBag1().read(write(tmp_path / "a.bag", moving), None).bodies["0"].x
    assert np.isnan(x[3]).all()
    np.testing.assert_array_equal(np.delete(x, 3, axis=0), np.delete(X, 3, axis=0))
