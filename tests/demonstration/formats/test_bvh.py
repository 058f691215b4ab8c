import numpy as np
import pytest
from file_samples import write_bvh
from synthetic_carry import carry

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.bone_names import guess_bones
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=2.0, rate=60.0)

SMALL = """HIERARCHY
ROOT Hips
{{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftArm
  {{
    OFFSET 20 40 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftForeArm
    {{
      OFFSET 30 0 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      JOINT LeftHand {{ OFFSET 25 0 0 CHANNELS 0 End Site {{ OFFSET 8 0 0 }} }}
    }}
  }}
  JOINT RightArm
  {{
    OFFSET -20 40 0
    JOINT RightForeArm {{ OFFSET -30 0 0 JOINT RightHand {{ OFFSET -25 0 0 End Site {{ OFFSET -8 0 0 }} }} }}
  }}
}}
MOTION
Frames: 2
Frame Time: 0.025
{}
{}
"""


def said(recording):
    return " | ".join(recording.evidence)


def check_error(text, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert text in str(caught.value)
    assert "\n" not in str(caught.value)


def small(path, first="1 2 3 0 0 0 0 0 0 0 0 0", second="0 0 0 90 0 0 0 90 0 0 0 -90", text=SMALL):
    path.write_text(text.format(first, second))
    return path


def test_poses_worked_out_by_hand(tmp_path):
    recording = read_recording(small(tmp_path / "a"))
    left = np.array([[20, 40, 0], [50, 40, 0], [75, 40, 0]])
    np.testing.assert_allclose(recording.x[0, :3] * 100.0, left + np.array([1, 2, 3]))
    np.testing.assert_allclose(recording.x[0, 3:] * 100.0, left * [-1, 1, 1] + np.array([1, 2, 3]))
    # Hips turn by 90 degrees about z: x goes to y, y to -x. The arm turns about its x, which leaves it; the forearm
    # turns by -90 degrees about its y, which the arm's turn has brought onto the hips' z and so the world's z: y to x.
    np.testing.assert_allclose(recording.x[1, :3] * 100.0, [[-40, 20, 0], [-40, 50, 0], [-15, 50, 0]], atol=1e-9)
    np.testing.assert_allclose(recording.x[1, 3:] * 100.0, [[-40, -20, 0], [-40, -50, 0], [-40, -75, 0]], atol=1e-9)
    np.testing.assert_allclose(recording.t, [0.0, 0.025])
    assert "unit: cm, for upper arms measure 30" in said(recording)
    assert "frame numbers at 40 a second" in said(recording)


@pytest.mark.parametrize("order", ["ZXY", "XYZ", "YXZ"])
@pytest.mark.parametrize("constant", [False, True])
def test_round_trip(tmp_path, order, constant):
    recording = read_recording(write_bvh(tmp_path / "a", T, X, order=order, constant=constant))
    assert (recording.format, recording.up) == ("bvh", "z")
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-6)


def test_up_is_where_the_shoulders_are(tmp_path):
    y_up = X @ np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]]).T
    path = write_bvh(tmp_path / "a", T, X, constant=True)
    assert read_recording(path).up == "z"
    turned = small(tmp_path / "b", second="1 2 3 0 0 0 0 0 0 0 0 0")
    assert read_recording(turned).up == "y"
    assert y_up[0, 0, 1] == X[0, 0, 2]


@pytest.mark.parametrize(
    ("scale", "unit"), [(1.0, "unit: m"), (1000.0, "unit: mm"), (0.45 / 0.0254, "1/0.45 inch, as in the CMU set")]
)
def test_units(tmp_path, scale, unit):
    recording = read_recording(write_bvh(tmp_path / "a", T, X, scale=scale))
    np.testing.assert_allclose(recording.x, X, atol=1e-7)
    assert unit in said(recording)


def test_position_channels_that_add_to_the_offset(tmp_path):
    text = SMALL.replace(
        "OFFSET 30 0 0\n      CHANNELS 3 Zrotation Xrotation Yrotation",
        "OFFSET 30 0 0\n      CHANNELS 3 Xposition Yposition Zposition",
    )
    added = read_recording(small(tmp_path / "a", "0 0 0 0 0 0 0 0 0 1 0 2", "0 0 0 0 0 0 0 0 0 0 0 0", text))
    np.testing.assert_allclose(added.x[:, 1] * 100.0, [[51, 40, 2], [50, 40, 0]])
    placed = read_recording(small(tmp_path / "b", "0 0 0 0 0 0 0 0 0 31 0 2", "0 0 0 0 0 0 0 0 0 30 0 0", text))
    np.testing.assert_allclose(placed.x[:, 1] * 100.0, [[51, 40, 2], [50, 40, 0]])


def test_text_as_tools_write_it(tmp_path):
    text = small(tmp_path / "a").read_text()
    expected = read_recording(tmp_path / "a").x
    for name, changed in {
        "crlf": text.replace("\n", "\r\n"),
        "tabs": text.replace("0 0 90 0", "0\t0  90 0 ").replace("  ", "\t"),
        "blank lines": text.replace("MOTION\n", "\nMOTION\n\n") + "\n\n",
        "prefix": text.replace("ROOT ", "ROOT mixamorig:").replace("JOINT ", "JOINT mixamorig:"),
        "blanks in names": text.replace("Left", "Bip01 L ").replace("Right", "Bip01 R ").replace(" Arm", " UpperArm"),
        "no blanks": text.replace("Frame Time: ", "Frame Time:").replace("Frames: ", "frames:"),
        "more frames promised": text.replace("Frames: 2", "Frames: 4000000000"),
    }.items():
        path = tmp_path / name
        path.write_bytes(b"\xef\xbb\xbf" * (name == "crlf") + changed.encode())
        recording = read_recording(path)
        np.testing.assert_allclose(recording.x, expected, err_msg=name)
    assert "promises 4000000000 frames, the file holds 2" in said(recording)


def test_two_people_in_one_file(tmp_path):
    one = SMALL.partition("MOTION")[0].removeprefix("HIERARCHY\n")
    text = "HIERARCHY\n" + one + one.replace("Hips", "Other") + "MOTION" + SMALL.partition("MOTION")[2]
    still = "5 0 0 0 0 0 0 0 0 0 0 0"
    path = small(tmp_path / "a", f"0 0 0 0 0 0 0 0 0 0 0 0 {still}", f"0 9 0 0 0 0 0 0 0 0 0 0 {still}", text)
    recording = read_recording(path)
    assert "person: Hips of 2" in said(recording)
    np.testing.assert_allclose(recording.x[1, 0] * 100.0, [20, 49, 0])
    np.testing.assert_allclose(read_recording(path, body="Other").x[:, 0] * 100.0, [[25, 40, 0]] * 2)


def test_lost_angles_lose_what_hangs_below(tmp_path):
    recording = read_recording(small(tmp_path / "a", second="0 0 0 0 0 0 nan 0 0 0 0 0"))
    assert np.isfinite(recording.x[0]).all()
    assert np.isnan(recording.x[1, 1:3]).all()
    assert np.isfinite(recording.x[1, [0, 3, 4, 5]]).all()


def test_joints_by_name(tmp_path):
    recording = read_recording(small(tmp_path / "a"), joints={"left_wrist": "LeftForeArm"})
    np.testing.assert_allclose(recording.x[:, 2], recording.x[:, 1])


@pytest.mark.parametrize(
    "pattern",
    ["{}Arm {}ForeArm {}Hand {}Shoulder", "{}UpArm {}LowArm {}Hand {}Collar", "{}Shoulder {}Elbow {}Wrist {}Hand",
     "{}UpperArm {}Forearm {}Hand {}Clavicle", "C_{}Arm C_{}ForeArm C_{}Hand C_{}Shoulder"],
)  # fmt: skip
def test_names_of_bones(pattern):
    names = [pattern.format(*[side] * 4).split() for side in ("Left", "Right")]
    assert guess_bones(["Hips", *names[0], *names[1]]) == dict(zip(POINTS, names[0][:3] + names[1][:3], strict=True))


@pytest.mark.parametrize(
    ("shoulder", "elbow", "wrist"),
    [("lShldr", "lForeArm", "lHand"), ("upperarm_l", "lowerarm_l", "hand_l"), ("lhumerus", "lradius", "lwrist"),
     ("DEF-upper_arm.L", "DEF-forearm.L", "DEF-hand.L"), ("Bip01 L UpperArm", "Bip01 L Forearm", "Bip01 L Hand"),
     ("J_Bip_L_UpperArm", "J_Bip_L_LowerArm", "J_Bip_L_Hand"), ("L_Shoulder", "L_Elbow", "L_Wrist")],
)  # fmt: skip
def test_names_of_left_bones(shoulder, elbow, wrist):
    found = guess_bones([shoulder, elbow, wrist, "lCollar", "L_Collar", "Bip01 L Finger0", "lHandTip"])
    assert found == {"left_shoulder": shoulder, "left_elbow": elbow, "left_wrist": wrist}


def test_refused(tmp_path):
    path = small(tmp_path / "a")
    text = path.read_text()
    for change, message in (
        (("90 0 0 0 90", "90 0 0 90"), "line 27"),
        (("90 0 0 0 90", "90 0 0 0 ninety"), "line 27"),
        (("OFFSET 20 40 0", "OFFSET 20 up 0"), "line 8: an OFFSET that is no three numbers"),
        (("OFFSET 20 40 0\n", ""), "joint LeftArm has no OFFSET"),
        (("CHANNELS 6", "CHANNELS 5"), "line 5: 5 channels, but 6 names"),
        (("JOINT LeftArm", "BONE LeftArm"), "line 6 is no part of a BVH hierarchy"),
        (("}\nMOTION", "\nMOTION"), "lacks 1 braces"),
        (("}\nMOTION", "}}\nMOTION"), "belongs to no joint"),
        (("MOTION", "MOVES"), "is cut off"),
        (("LeftHand", "LeftPaw"), "nothing is named like left_wrist"),
        ((text[text.index("MOTION") + 6 :], "\nFrames: 0\n"), "no samples"),
    ):
        path.write_text(text.replace(*change))
        check_error(message, path)
    path.write_bytes(text.replace("Hips", "H\xfcfte").encode("latin-1"))
    check_error("UTF-8", path)
    check_error("no joint 'Paw'", small(tmp_path / "b"), joints={"left_wrist": "Paw"})


def test_more_joints_in_a_row_than_a_person_has(tmp_path):
    chain = "ROOT a {{ OFFSET 0 0 0\n" + "JOINT a {{ OFFSET 0 1 0\n" * 200
    check_error("line 101: ", small(tmp_path / "a", text="HIERARCHY " + chain + "}}" * 201 + "\nMOTION\n{}\n{}\n"))


def test_bone_lengths_stay(tmp_path):
    lengths = link_lengths(read_recording(write_bvh(tmp_path / "a", T, X, constant=True)).x)
    np.testing.assert_allclose(np.ptp(lengths[:, [0, 1, 3, 4]], axis=0), 0.0, atol=1e-8)
