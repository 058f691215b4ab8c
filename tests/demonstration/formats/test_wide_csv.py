import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_carry import carry
from text_samples import KINECT, SHORT, numbers, save, write_wide_csv

from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS

T, X = carry(duration=2.0)


def write(path, *args, **options):
    return write_wide_csv(path, T, X, *args, **options)


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("names", [KINECT, POINTS, SHORT, ("LSHO", "LELB", "LWRA", "RSHO", "RELB", "RWRA")])
@pytest.mark.parametrize("axis", ["{}X", "{}_x", "{}.x", "x_{}", "{} X (m)", "{}_pos_x", "{}[x]"])
def test_spellings(tmp_path, names, axis):
    recording = read_recording(write(tmp_path / "a.csv", names, axis))
    assert recording.format == "wide_csv"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-12)
    np.testing.assert_array_equal(recording.frames, np.arange(len(T)))


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(order=st.permutations(range(21)), separator=st.sampled_from(",;\t"), end=st.sampled_from(["", "end", "ends"]))
def test_any_order_separator_and_extra_columns(tmp_path, order, separator, end):
    end = {"": "", "end": separator, "ends": 3 * separator}[end]
    extra = [("User-ID", "93"), ("Action", '"lift, then put"')]
    path = write(tmp_path / "a.csv", order=order, separator=separator, end=end, extra=extra)
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)


def test_blanks_comments_and_decimal_commas(tmp_path):
    path = write(tmp_path / "a.txt", SHORT, "{}_x", "t", separator=" ")
    path.write_text("# made by hand, on a Monday\n# second line: 1 2 3\n" + path.read_text())
    np.testing.assert_allclose(read_recording(path).x, X, atol=1e-8)
    path.write_text("# " + write(tmp_path / "b.txt", SHORT, "{}_x", "t").read_text().replace(",", " "))
    assert read_recording(path).format == "wide_csv"  # As numpy.savetxt writes a header.
    path = write(tmp_path / "c.csv", separator=";")
    header, rows = path.read_text().split("\n", 1)
    path.write_text("% Kinect\n" + header + "\n" + rows.replace(".", ",").replace("\n", "\n# a remark\n", 1))
    recording = read_recording(path)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=1e-12)


@pytest.mark.parametrize(
    ("time", "factor", "said"),
    [
        ("Timestamp", 1e3, "clock: ms, for its median step"),
        ("Timestamp ms", 1e3, "clock: ms, as the file"),
        ("t", 1.0, "clock: s, for"),
        ("time_s", 1.0, "clock: s, as the file"),
        ("TimeMs", 1e3, "clock: ms, as the file"),
        ("time [us]", 1e6, "clock: us, as the file"),
        ("time (µs)", 1e6, "clock: us, as the file"),
        ("device_timestamp_usec", 1e6, "clock: us, as the file"),
        ("Timestamp", 1e7, "clock: units of 100 ns, for"),
        ("%time", 1e9, "clock: ns, for"),
    ],
)
def test_time_units(tmp_path, time, factor, said):
    recording = read_recording(write_wide_csv(tmp_path / "a.csv", T * factor, X, time=time))
    np.testing.assert_allclose(recording.t, T, atol=1e-9)
    assert any(sentence.startswith(said) for sentence in recording.evidence)


@pytest.mark.parametrize("form", ["2020-02-29 12:00:{:09.6f}", "2020-02-29T12:00:{:09.6f}Z", "12:00:{:09.6f}"])
def test_times_of_day(tmp_path, form):
    lines = write(tmp_path / "a.csv", time="when", extra=[("Timestamp", "")]).read_text().splitlines()
    lines = [lines[0], *(line + form.format(t) for line, t in zip(lines[1:], T, strict=True))]
    recording = read_recording(save(tmp_path / "b.csv", lines))
    np.testing.assert_allclose(recording.t - recording.t[0], T, atol=2e-6)
    lines[5] += "?"
    check_error("line 6, column Timestamp: '", save(tmp_path / "c.csv", lines))


def test_without_a_clock_frames_are_counted(tmp_path):
    recording = read_recording(write(tmp_path / "a.csv", time=None))
    np.testing.assert_allclose(recording.t, T)
    assert any("frame numbers at 30 a second, assumed" in sentence for sentence in recording.evidence)
    every_second = write_wide_csv(tmp_path / "b.csv", 100 + 2 * np.arange(len(T)), X, time="Frame")
    recording = read_recording(every_second, frames=(104, 110), rate_hz=60.0)
    np.testing.assert_array_equal(recording.frames, [104, 106, 108, 110])
    np.testing.assert_allclose(recording.t, recording.frames / 60.0)
    pandas = write_wide_csv(tmp_path / "c.csv", np.arange(len(T)), X, time="")
    np.testing.assert_allclose(read_recording(pandas).t, T)


def test_units_and_missing_cells(tmp_path):
    holes = X.copy()
    holes[5, 2] = np.nan
    np.testing.assert_allclose(read_recording(write(tmp_path / "a.csv", scale=1000.0), unit="mm").x, X, atol=1e-8)
    for word in ("", "NaN", "NA", "null", " "):
        path = write_wide_csv(tmp_path / "b.csv", T, holes, POINTS, "{}_x_cm", scale=100.0)
        path.write_text(path.read_text().replace(",,,", f",{word},{word},"))
        recording = read_recording(path)
        np.testing.assert_allclose(recording.x, holes, atol=1e-8)
        assert "unit: cm, the file" in recording.evidence[0]


@pytest.mark.parametrize(("scale", "most"), [((0.0, 1.0, 2.0), 2.0), ((0.0, 1.0, 3.0), 3.0), ((0.0, 0.5, 1.0), 1.0)])
def test_confidence(tmp_path, scale, most):
    states = np.full((len(T), 6), most)
    states[3, 2], states[4, 5] = scale[0], scale[1]
    recording = read_recording(write(tmp_path / "a.csv", states=states))
    expected = np.ones((len(T), 6))
    expected[3, 2], expected[4, 5] = 0.0, 0.5
    np.testing.assert_array_equal(recording.confidence, expected)
    words = write(tmp_path / "b.csv", extra=[("WristLeft state", "Inferred"), ("confidence_ElbowLeft", "NOT_TRACKED")])
    np.testing.assert_array_equal(read_recording(words).confidence, np.tile([1, 0, 0.5, 1, 1, 1], (len(T), 1)))
    words.write_text(words.read_text().replace("Inferred", "", 1))  # Said of nothing: what is there counts as tracked.
    np.testing.assert_array_equal(read_recording(words).confidence[:2, 2], [1.0, 0.5])


def test_confidence_on_no_known_scale_is_left_aside(tmp_path):
    recording = read_recording(write(tmp_path / "a.csv", states=np.full((len(T), 6), 87.0)))
    assert recording.confidence is None
    assert any(sentence.startswith("confidence: left aside") for sentence in recording.evidence)


def test_several_people(tmp_path):
    ids = ("72057594037930001", "72057594037930002")  # Beyond a float's whole numbers.
    lines = [write(tmp_path / "a.csv", extra=[("TrackingId", name)]).read_text().splitlines() for name in ids]
    small = write_wide_csv(tmp_path / "b.csv", T, 0.9 * X, extra=[("TrackingId", ids[1])]).read_text().splitlines()
    rows = [row for pair in zip(lines[0][1:], small[1:], strict=True) for row in pair]
    empty = "9.0" + "," * 18 + ","
    path = save(tmp_path / "c.csv", [lines[0][0], *rows, empty])
    recording = read_recording(path)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_array_equal(recording.frames, np.arange(len(T)))
    assert "1 frames hold no person" in recording.evidence
    np.testing.assert_allclose(read_recording(path, body=ids[1]).x, 0.9 * X, atol=1e-8)
    check_error("holds no person '7'", path, body="7")


def two_rows(separator, above, axes, units=None, names=SHORT):
    gap = 2 * separator
    lines = [*above, separator.join(["", ""]) + separator + (gap + separator).join(f"Anna:{n}" for n in names) + gap]
    lines += [separator.join(["Frame", "Sub Frame", *axes * 6])]
    lines += [separator.join(["", "", *[units] * 18])] if units else []
    return lines + [separator.join([str(i + 1), "0", *numbers(x, 1e3)]) for i, x in enumerate(X)]


def test_headers_of_two_rows(tmp_path):
    nexus = save(tmp_path / "a.csv", two_rows(",", ["Trajectories", "120"], "XYZ", "mm"), end="\r\n")
    recording = read_recording(nexus)
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, recording.frames / 120.0)
    assert "unit: mm, the file" in recording.evidence[0]
    names = [f"{name} {axis}" for name in SHORT for axis in "XYZ"]
    qualisys = [
        "NO_OF_FRAMES\t61",
        "FREQUENCY\t30",
        "MARKER_NAMES\t" + "\t".join(SHORT),
        "\t".join(["Frame", "Time", *names]),
    ]
    qualisys += [
        "\t".join([str(i + 1), f"{t:.5f}", *numbers(x, 1e3)]) for i, (t, x) in enumerate(zip(T, X, strict=True))
    ]
    recording = read_recording(save(tmp_path / "b.tsv", qualisys))
    assert recording.format == "wide_csv"
    np.testing.assert_allclose(recording.x, X, atol=1e-8)


def test_joints_by_number(tmp_path):
    names = [f"joint{number}" for number in range(32)]
    many = np.full((len(T), 32, 3), 0.5)
    many[:, [5, 6, 7, 12, 13, 14]] = X
    recording = read_recording(write_wide_csv(tmp_path / "a.csv", T, many, names, "{}_x"))
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    assert recording.up == "-y"
    assert "joints: numbered as by Azure Kinect" in recording.evidence


def test_joints_map_stems_and_columns(tmp_path):
    path = write(tmp_path / "a.csv", ("A", "B", "C", "D", "E", "F"))
    joints = dict(zip(POINTS, ("A", "B", "C", "D", "E", ("FX", "FY", "FZ")), strict=True))
    np.testing.assert_allclose(read_recording(path, joints=joints).x, X, atol=1e-8)
    swapped = {"left_wrist": "WristRight", "right_wrist": "wristleft"}
    swapped_x = read_recording(write(tmp_path / "b.csv"), joints=swapped).x
    np.testing.assert_allclose(swapped_x[:, [2, 5]], X[:, [5, 2]], atol=1e-8)


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
def test_options_refused(tmp_path, options, said):
    check_error(said, write(tmp_path / "a.csv"), **options)


def test_content_refused(tmp_path):
    check_error("nothing is named like left_wrist", write(tmp_path / "a", ("LShoulder", "LElbow", "Paw", *SHORT[3:])))
    lines = write(tmp_path / "c.csv").read_text().splitlines()
    for replacement, said in (
        (lines[7].rsplit(",", 2)[0], "line 8 has 17 columns, expected 19"),
        (lines[7] + ",1,2", "line 8 has 21 columns"),
        ("0.1,cat" + lines[7][lines[7].index(",", 12) :], "line 8, column ShoulderLeftX: 'cat' is no number"),
        ("0.1,1_0" + lines[7][lines[7].index(",", 12) :], "line 8, column ShoulderLeftX: '1_0' is no number"),
        ("later" + lines[7][lines[7].index(",") :], "line 8, column time_s: 'later' is no number"),
        ("nan" + lines[7][lines[7].index(",") :], "frame 6 has no time"),
    ):
        check_error(said, save(tmp_path / "a", [*lines[:7], replacement, *lines[8:]]))
    check_error("no samples", save(tmp_path / "a", lines[:1]))
    save(tmp_path / "a", lines * 100).write_bytes(("\n".join(lines) + "\n").encode() + b"\xff\xfe\n")
    check_error(f"line {len(lines) + 1} is not UTF-8 text", tmp_path / "a")
    check_error(f"line {len(lines) + 1}, column", save(tmp_path / "a", lines * 2))
