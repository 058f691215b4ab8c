import numpy as np
import pytest
from made_files import ARM

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.frames import FrameTree
from drake_blfdmp.viewing.playback.kinematics import link_poses
from drake_blfdmp.viewing.playback.poses import about, matrices, translation
from drake_blfdmp.viewing.playback.reading import read_played
from drake_blfdmp.viewing.playback.urdf import parse_urdf

STILL = [0.0, 0.0, 0.0, 1.0]


def test_joints_move_the_links_below_them_and_mimics_follow():
    q, d = np.array([0.0, 0.5, -1.0]), np.array([0.0, 0.1, 0.2])
    poses = link_poses(parse_urdf(ARM, ""), FrameTree(), {"shoulder": q, "rail": d})
    upper = translation([0.0, 0.0, 0.1]) @ about([0.0, 0.0, 1.0], q)
    assert np.allclose(poses["base"], np.eye(4))
    assert np.allclose(poses["upper"], upper)
    assert np.allclose(poses["slide"], upper @ translation(np.stack([0.4 + d, 0 * d, 0 * d], axis=-1)))
    finger = poses["tool"] @ translation(np.stack([0 * d, 0 * d, 0.1 - 0.5 * d], axis=-1))
    assert np.allclose(poses["finger"], finger)


def test_tf_counts_more_than_joints_and_carries_what_hangs_below():
    frames = FrameTree({"upper": ("world", np.array([[1.0, 2.0, 3.0, *STILL]]))})
    poses = link_poses(parse_urdf(ARM, ""), frames, {"shoulder": np.array([0.5, 0.6])})
    assert np.allclose(poses["upper"][0, :3, 3], [1, 2, 3])
    assert np.allclose(poses["slide"][0, :3, 3], [1.4, 2, 3]), "a joint without position is at 0"


def test_frames_are_chained_and_still_ones_stay_one():
    turn = np.array([[0, 0, 0, 0, 0, np.sin(a / 2), np.cos(a / 2)] for a in (0.0, 1.0)])
    tree = FrameTree({"b": ("a", np.array([[1.0, 0, 0, *STILL]])), "c": ("b", turn), "d": ("b", turn[:1])})
    assert tree.roots == {"a"} and "c" in tree and "a" not in tree
    assert np.allclose(tree.pose("c"), translation([1.0, 0, 0]) @ matrices(turn))
    assert tree.pose("d").shape == (1, 4, 4)
    assert np.allclose(tree.pose("a"), np.eye(4))


def test_a_ring_of_frames_or_links_is_refused():
    pose = np.array([[0.0, 0, 0, *STILL]])
    with pytest.raises(BlfDmpError, match=r"form a ring \(a -> b -> a\)"):
        FrameTree({"a": ("b", pose), "b": ("a", pose)}, "f").pose("a")
    ring = ARM.replace('<parent link="base"/>', '<parent link="finger"/>')
    with pytest.raises(BlfDmpError, match="links of the URDF form a ring"):
        link_poses(parse_urdf(ring, ""), FrameTree(), {})


def test_a_run_s_joint_states_put_every_link_where_its_tf_has_it(default_run):
    played = read_played(default_run.folder / "run.mcap", start=4.0, end=6.0)
    (model,) = played.models
    by_tf = link_poses(model.robot, model.frames, model.positions)
    box = FrameTree({"box": model.frames.edges["box"]})
    by_joints = link_poses(model.robot, box, model.positions)
    assert len(by_tf) > 20
    for link, X in by_tf.items():
        # The URDF's angles have six digits.
        assert np.abs(by_joints[link] - X).max() < 5e-5, link
