"""Files whose joints tell which way is up although the arms, held over the head, say the opposite."""

import numpy as np
import pytest
from file_samples import write_keypoint_json
from synthetic_carry import carry
from text_samples import write_wide_csv

from drake_blfdmp.demonstration.cleaning import clean
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.sensor_joints import KINECT_V1
from drake_blfdmp.demonstration.upright import rotation_to_z_up
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=2.0)


def arms_up(x):
    """Elbows and wrists mirrored to above the shoulders."""
    raised = x.copy()
    for shoulder in (0, 3):
        raised[:, shoulder + 1 : shoulder + 3, 2] = 2 * x[:, shoulder, None, 2] - x[:, shoulder + 1 : shoulder + 3, 2]
    return raised


def test_a_table_with_all_joints_of_a_kinect_is_y_up(tmp_path):
    y_up = arms_up(X) @ rotation_to_z_up("y")  # Rows: the inverse turns z up into y up.
    others = [name for name in KINECT_V1 if not name.startswith(("Shoulder", "Elbow", "Wrist")) or "Center" in name]
    extra = [(f"{name}{axis}", "0.5") for name in others for axis in "XYZ"]
    whole = read_recording(write_wide_csv(tmp_path / "a.csv", T, y_up, extra=extra))
    assert whole.up == "y"
    np.testing.assert_allclose(clean(whole).x[:, :, 2], arms_up(X)[:, :, 2], atol=1e-6)
    arms = read_recording(write_wide_csv(tmp_path / "b.csv", T, y_up))
    assert arms.up is None


@pytest.mark.parametrize("up", ["y", "-y", "z", "-z"])
def test_key_points_of_the_head_tell_up(tmp_path, up):
    head = X[:, [0, 3]].mean(axis=1) + np.array([0.0, 0.1, 0.25])
    x = np.concatenate([arms_up(X), head[:, None]], axis=1) @ rotation_to_z_up(up)
    recording = read_recording(write_keypoint_json(tmp_path / "a.json", T, x, names=(*POINTS, "nose")))
    assert recording.up == up
    assert any(sentence.startswith(f"up: {up}") for sentence in recording.evidence)
    np.testing.assert_allclose(clean(recording).x[:, :, 2], arms_up(X)[:, :, 2], atol=1e-6)
