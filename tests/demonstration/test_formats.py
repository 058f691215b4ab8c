import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_carry import SHARED, carry

from drake_blfdmp.demonstration.formats import FORMATS, read_recording
from drake_blfdmp.demonstration.formats.kinect_v1_rows import JOINTS
from drake_blfdmp.demonstration.formats.point_names import guess
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

KINECT = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")
SNAKE = POINTS
SHORT = ("LShoulder", "LElbow", "LWrist", "RShoulder", "RElbow", "RWrist")
TURKISH = ("solOmuz", "solDirsek", "solBilek", "sagOmuz", "sagDirsek", "sagBilek")
T, X = carry(duration=2.0)


def number(value):
    return "" if np.isnan(value) else f"{value:.9f}"


def write_csv(path, names=KINECT, axis="{}X", time="time_s", scale=1.0, order=None, trailing=False, t=T, x=X, extra=()):
    suffix = [axis.replace("X", a) if axis.isupper() or "X" in axis else axis.replace("x", a.lower()) for a in "XYZ"]
    header = [time, *(s.format(n) for n in names for s in suffix), *(name for name, _ in extra)]
    rows = [
        [repr(float(a)), *(number(v * scale) for v in b.ravel()), *(v for _, v in extra)]
        for a, b in zip(t, x, strict=True)
    ]
    order = order if order is not None else list(range(len(header)))
    end = "," if trailing else ""
    path.write_text("".join(",".join(row[i] for i in order) + end + "\n" for row in [header, *rows]))
    return path


def write_trc(path, names=TURKISH, header=False, unit="mm", scale=1000.0, x=X):
    lines = []
    if header:
        lines += ["PathFileType\t4\t(X/Y/Z)\tcarry.trc"]
        lines += ["DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames"]
        lines += [f"30\t30\t{len(T)}\t6\t{unit}\t30\t1\t{len(T)}"]
    lines += [
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t",
        "\t\t" + "\t".join(f"{a}{i}" for i in range(6) for a in "XYZ"),
    ]
    lines += [""] if header else []
    for i, (t, sample) in enumerate(zip(T, x, strict=True)):
        lines.append(f"{i + 1}\t{t:.9f}\t" + "\t".join(number(v * scale) for v in sample.ravel()))
    path.write_text("\n".join(lines) + "\n")
    return path


def write_rows(path, frames, x=X):
    with path.open("w") as file:
        for frame, sample in zip(frames, x, strict=True):
            joints = np.full((20, 3), 0.5)
            joints[[JOINTS.index(name) for name in KINECT]] = sample
            file.write(f"{frame}  " + " ".join(f"{v:.9f}" for v in joints.ravel()) + " \n")
    return path


@pytest.mark.parametrize("names", [KINECT, SNAKE, SHORT, ("LSHO", "LELB", "LWRA", "RSHO", "RELB", "RWRA")])
@pytest.mark.parametrize("axis", ["{}X", "{}_x", "{}.x", "x_{}", "{} X (m)"])
def test_wide_csv_spellings(tmp_path, names, axis):
    recording = read_recording(write_csv(tmp_path / "a.csv", names, axis))
    assert recording.format == "wide_csv"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-12)
    np.testing.assert_array_equal(recording.frames, np.arange(len(T)))


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(order=st.permutations(range(21)))
def test_wide_csv_any_column_order_and_extra_columns(tmp_path, order):
    path = write_csv(tmp_path / "a.csv", order=order, trailing=True, extra=[("User-ID", "93"), ("Action", "lift")])
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)


@pytest.mark.parametrize(
    ("time", "factor"),
    [
        ("Timestamp", 1e3),
        ("Timestamp ms", 1e3),
        ("t", 1.0),
        ("time_s", 1.0),
        ("TimeMs", 1e3),
        ("time [us]", 1e6),
        ("Timestamp", 1e7),
    ],
)
def test_wide_csv_time_units(tmp_path, time, factor):
    recording = read_recording(write_csv(tmp_path / "a.csv", time=time, t=T * factor))
    np.testing.assert_allclose(recording.t, T, atol=1e-9)


def test_wide_csv_units_and_missing_cells(tmp_path):
    holes = X.copy()
    holes[5, 2] = np.nan
    np.testing.assert_allclose(read_recording(write_csv(tmp_path / "a.csv", scale=1000.0), unit="mm").x, X, atol=1e-8)
    path = write_csv(tmp_path / "b.csv", SNAKE, "{}_x_cm", scale=100.0, x=holes)
    np.testing.assert_allclose(read_recording(path).x, holes, atol=1e-8)


def test_joints_map_stems_and_columns(tmp_path):
    path = write_csv(tmp_path / "a.csv", ("A", "B", "C", "D", "E", "F"))
    joints = dict(zip(POINTS, ("A", "B", "C", "D", "E", ("FX", "FY", "FZ")), strict=True))
    np.testing.assert_allclose(read_recording(path, joints=joints).x, X, atol=1e-8)
    swapped = {"left_wrist": "WristRight", "right_wrist": "wristleft"}
    swapped_x = read_recording(write_csv(tmp_path / "b.csv"), joints=swapped).x
    np.testing.assert_allclose(swapped_x[:, [2, 5]], X[:, [5, 2]], atol=1e-8)


@pytest.mark.parametrize("header", [False, True])
@pytest.mark.parametrize("names", [TURKISH, SHORT, SNAKE])
def test_trc(tmp_path, header, names):
    holes = X.copy()
    holes[3:9, 4] = np.nan
    holes[20, 5] = np.nan
    recording = read_recording(write_trc(tmp_path / "a.trc", names, header, x=holes))
    assert recording.format == "trc"
    np.testing.assert_allclose(recording.x, holes, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-8)
    np.testing.assert_array_equal(recording.frames, np.arange(1, len(T) + 1))


def test_trc_units_and_lost_last_cells(tmp_path):
    np.testing.assert_allclose(
        read_recording(write_trc(tmp_path / "a", header=True, unit="m", scale=1.0)).x, X, atol=1e-8
    )
    path = write_trc(tmp_path / "b.trc")
    lines = path.read_text().splitlines()
    lines[4] = "\t".join(lines[4].split("\t")[:-3])
    path.write_text("\n".join(lines))
    assert np.isnan(read_recording(path).x[2, 5]).all()


def test_kinect_rows_frames_are_the_files_own_numbers(tmp_path):
    numbers = 100 + 4 * np.arange(len(T))
    path = write_rows(tmp_path / "a.txt", numbers)
    recording = read_recording(path, frames=(104, 140))
    assert recording.format == "kinect_v1_rows"
    np.testing.assert_array_equal(recording.frames, np.arange(104, 141, 4))
    np.testing.assert_allclose(recording.t, recording.frames / 30.0)
    np.testing.assert_allclose(recording.x, X[1:11], atol=1e-8)
    hands = read_recording(path, joints={"left_wrist": "HandLeft"})
    np.testing.assert_allclose(hands.x[:, 2], 0.5)


@pytest.mark.parametrize(
    ("content", "options", "said"),
    [
        (b"", {}, "is empty"),
        (b"\x00\x01\x02\xff" * 100, {}, "binary data"),
        (b"caf\xe9 au lait\n" * 50, {}, "not UTF-8"),
        (b"once upon a time\nthere was\n", {}, "known formats are trc, kinect_v1_rows, wide_csv"),
        (b"1,2\n", {"format": "avi"}, "unknown format 'avi'; known are trc"),
        (b"1 2 3\n", {"format": "kinect_v1_rows"}, "line 1 has 3 columns, expected 61"),
        (b"a b c\n", {"format": "trc"}, "no line begins with Frame# and Time"),
        (b"x" * (3 << 20), {"format": "wide_csv"}, "longer than 1 MB"),
    ],
)
def test_files_that_are_no_recordings(tmp_path, content, options, said):
    path = tmp_path / "a.bin"
    path.write_bytes(content)
    check_error(said, path, **options)


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert said in message
    assert "\n" not in message
    assert str(path) in message


def test_paths_that_are_no_files(tmp_path):
    check_error("no such file", tmp_path / "none.csv")
    check_error("is a directory", tmp_path)
    os.mkfifo(tmp_path / "pipe")
    check_error("no regular file", tmp_path / "pipe")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"joints": {"left_wrist": "Paw"}}, "no joint 'Paw' for left_wrist; the file has ShoulderLeft, ElbowLeft"),
        ({"joints": {"tail": "WristLeft"}}, "unknown point 'tail'; the points are left_shoulder"),
        ({"joints": {"left_wrist": ("a", "b", "c")}}, "three columns"),
        ({"joints": {"time": "when"}}, "no column 'when' for time"),
        ({"frames": (500, 600)}, "no frame lies in 500:600; the file has frames 0 to 60"),
        ({"unit": "ft"}, "unknown unit 'ft'"),
    ],
)
def test_csv_options_refused(tmp_path, options, said):
    check_error(said, write_csv(tmp_path / "a.csv"), **options)


def test_csv_content_refused(tmp_path):
    check_error(
        "nothing is named like left_wrist", write_csv(tmp_path / "a", ("LShoulder", "LElbow", "Paw", *SHORT[3:]))
    )
    check_error("no time column", write_csv(tmp_path / "b.csv", time="weather"))
    lines = write_csv(tmp_path / "c.csv").read_text().splitlines()
    for name, replacement, said in (
        ("short", lines[7].rsplit(",", 2)[0], "line 8 has 17 columns, the header 19"),
        ("long", lines[7] + ",1,2", "line 8 has 21 columns"),
        (
            "word",
            "0.1," + "cat" + lines[7][lines[7].index(",", 12) :],
            "line 8, column ShoulderLeftX: 'cat' is no number",
        ),
        ("clock", "later" + lines[7][lines[7].index(",") :], "line 8, column time_s: 'later' is no number"),
    ):
        path = tmp_path / name
        path.write_text("\n".join([*lines[:7], replacement, *lines[8:]]))
        check_error(said, path)
    path.write_text(lines[0] + "\n")
    check_error("no samples", path)
    path.write_bytes(("\n".join(lines) + "\n").encode() * 100 + b"\xff\xfe\n")
    check_error("is no number", path)


def test_trc_and_rows_content_refused(tmp_path):
    path = write_trc(tmp_path / "a.trc")
    check_error("no joint 'kol'", path, joints={"left_wrist": "kol"})
    check_error("frames 1 to 61", path, frames=(0, 0))
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines, lines[-1] + "\t7"]))
    check_error("line 64 has 21 columns, expected 20", path)
    path.write_text("\n".join([*lines, lines[-1].replace("\t", "\tx", 1)]))
    check_error("line 64 holds a cell that is no number", path)
    rows = write_rows(tmp_path / "a.txt", range(len(T)))
    check_error("frames 0 to 60", rows, frames=(70, 80))
    check_error("no joint 'Paw' for left_wrist; the file has HipCenter", rows, joints={"left_wrist": "Paw"})


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(content=st.one_of(st.binary(max_size=300), st.text("0123456789.,\t\n aXYZ#Frme", max_size=300).map(str.encode)))
@pytest.mark.parametrize("name", [None, *FORMATS])
def test_junk_never_raises_anything_else(tmp_path, name, content):
    path = tmp_path / "junk"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path, format=name)
    assert "\n" not in str(caught.value)


def test_names_prefer_the_plain_spelling():
    names = ["Anna:LWRB", "Anna:LWRA", "left_wrist", "HandLeft", "WristRight_pos", "JointType_ElbowLeft", "sağOmuz"]
    assert guess(names) == {
        "left_wrist": "left_wrist",
        "right_wrist": "WristRight_pos",
        "left_elbow": "JointType_ElbowLeft",
        "right_shoulder": "sağOmuz",
    }


@pytest.mark.parametrize(
    ("pattern", "format_name", "count"),
    [
        ("omomo_largebox/*.csv", "wide_csv", 196),
        ("kinect_v1_kinder_gator/*.csv", "wide_csv", 260),
        ("kinect_v1_utkinect/joints_s01_e01.txt", "kinect_v1_rows", 560),
        ("vicon_box_lift/yerden_alma_hatasiz.trc", "trc", 939),
    ],
)
def test_real_files(pattern, format_name, count):
    paths = sorted(SHARED.glob(pattern)) if SHARED.is_dir() else []
    if not paths:
        pytest.skip(f"{SHARED / pattern} is not here")
    recording = read_recording(paths[0])
    assert (recording.format, len(recording.t)) == (format_name, count)
    assert 0.1 < np.nanmedian(np.linalg.norm(recording.x[:, 0] - recording.x[:, 1], axis=-1)) < 0.6
    assert 0.9 / 120 < np.median(np.diff(recording.t)) < 0.2
