import os

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_carry import SHARED, carry
from text_samples import SAMPLES

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.formats.point_names import guess
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=1.0)
ONCE = {"deadline": None, "suppress_health_check": [HealthCheck.function_scoped_fixture]}


def check_error(said, path, **options):
    with pytest.raises(RecordingError) as caught:
        read_recording(path, **options)
    message = str(caught.value)
    assert said in message
    assert "\n" not in message
    assert str(path) in message


@pytest.mark.parametrize("name", SAMPLES)
def test_a_text_sample_is_found_and_comes_back(tmp_path, name):
    path = SAMPLES[name](tmp_path / "a.bin", T, X)
    recording = read_recording(path)
    assert recording.format == name
    np.testing.assert_allclose(recording.x, X, atol=1e-8)
    np.testing.assert_allclose(recording.t, T, atol=2e-6)
    evidence = " ".join(recording.evidence)
    assert "unit: " in evidence and "clock: " in evidence
    np.testing.assert_array_equal(read_recording(path, format=name).x, recording.x)


@pytest.mark.parametrize("name", SAMPLES)
@pytest.mark.parametrize("change", ["crlf", "bom", "cr", "no last end", "blank lines"])
def test_line_ends_and_marks_do_not_matter(tmp_path, name, change):
    path = SAMPLES[name](tmp_path / "a.txt", T, X)
    content = path.read_bytes().replace(b"\r\n", b"\n")
    path.write_bytes(
        {
            "crlf": content.replace(b"\n", b"\r\n"),
            "bom": b"\xef\xbb\xbf" + content,
            "cr": content.replace(b"\n", b"\r"),
            "no last end": content.rstrip(b"\n"),
            "blank lines": content + b"\n \n\t\n",
        }[change]
    )
    recording = read_recording(path)
    assert recording.format == name
    np.testing.assert_allclose(recording.x, X, atol=1e-8)


@pytest.mark.parametrize("name", SAMPLES)
def test_files_longer_than_a_block(tmp_path, monkeypatch, name):
    path = SAMPLES[name](tmp_path / "a.txt", T, X)
    lines = path.read_text().splitlines()
    if name != "ntu_skeleton":
        lines.insert(-3, "# a remark")
        lines.insert(-7, "")
    path.write_text("\n".join(lines) + "\n")
    whole = read_recording(path)
    monkeypatch.setattr("drake_blfdmp.demonstration.formats.text._BLOCK_BYTES", 1500)
    in_blocks = read_recording(path)
    np.testing.assert_array_equal(in_blocks.x, whole.x)
    np.testing.assert_array_equal(in_blocks.t, whole.t)
    damaged = path.read_text().rsplit("\n", 3)
    path.write_text("\n".join([*damaged[:-2], "1;2;3"]))
    check_error(f"line {len(lines)}", path)


@pytest.mark.parametrize(
    ("content", "options", "said"),
    [
        (b"", {}, "is empty"),
        (b"\x00\x01\x02\xff" * 100, {}, "binary data"),
        (b"caf\xe9 au lait\n" * 50, {}, "not UTF-8"),
        (b"once upon a time\nthere was\n", {}, "text of no known format; known formats are "),
        (b"1,2\n", {"format": "avi"}, "unknown format 'avi'; known are "),
        (b"1 2 3\n", {"format": "kinect_v1_rows"}, "line 1 has 3 columns, expected 20 joints"),
        (b"1 2 3\n", {"format": "points18"}, "line 1 has 3 columns, expected 18 numbers"),
        (b"a b c\n", {"format": "trc"}, "no line begins with Frame# and Time"),
        (b"a b c\n", {"format": "motive_csv"}, "no line begins with Frame below the lines Type and Name"),
        (b"a b c\n", {"format": "ntu_skeleton"}, "line 1: 3 cells, expected the number of frames"),
        (b"a b c\n", {"format": "long_csv"}, "no line names a column of joints"),
        (b"x" * (3 << 20), {"format": "wide_csv"}, "line 1 is longer than 1 MB"),
        (b'"' * 900_000 + b"\n", {"format": "points18"}, "line 1 has 0 columns"),
        (b"," * 900_000 + b"\n", {"format": "kinect_v2_rows"}, "line 1 has 900000 columns"),
    ],
)
def test_files_that_are_no_recordings(tmp_path, content, options, said):
    path = tmp_path / "a.bin"
    path.write_bytes(content)
    check_error(said, path, **options)


def test_paths_that_are_no_files(tmp_path):
    check_error("no such file", tmp_path / "none.csv")
    check_error("is a directory", tmp_path)
    os.mkfifo(tmp_path / "pipe")
    check_error("no regular file", tmp_path / "pipe")


@settings(max_examples=60, **ONCE)
@given(content=st.one_of(st.binary(max_size=300), st.text("0123456789.,\t\n aXYZ#Frme", max_size=300).map(str.encode)))
@pytest.mark.parametrize("name", [None, *SAMPLES])
def test_junk_never_raises_anything_else(tmp_path, name, content):
    path = tmp_path / "junk"
    path.write_bytes(content)
    with pytest.raises(RecordingError) as caught:
        read_recording(path, format=name)
    assert "\n" not in str(caught.value)


PIECES = [
    b"",
    b"nan",
    b"inf",
    b"-1e308",
    b"9" * 400,
    b"x",
    b'"',
    b"\xff",
    b"\0",
    b"\n",
    b",",
    b";",
    b"\t",
    b" ",
    b"-1",
    b"2147483648",
]


@settings(max_examples=80, **ONCE)
@given(data=st.data())
@pytest.mark.parametrize("name", SAMPLES)
def test_damaged_files_are_refused_or_read(tmp_path, name, data):
    content = bytearray(SAMPLES[name](tmp_path / "a.bin", T[:6], X[:6]).read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(content) - 1))
        end = data.draw(st.integers(start, min(start + 80, len(content))))
        kind = data.draw(st.sampled_from(["flip", "cut", "double", "replace", "end"]))
        if kind == "flip":
            content[start] ^= 1 << data.draw(st.integers(0, 7))
        elif kind == "double":
            content[start:start] = content[start:end]
        elif kind == "end":
            del content[max(start, 1) :]
        else:
            content[start:end] = data.draw(st.sampled_from(PIECES)) if kind == "replace" else b""
        content = content or bytearray(b"1")
    path = tmp_path / "damaged"
    path.write_bytes(content)
    for format_name in (None, name):
        try:
            recording = read_recording(path, format=format_name)
        except RecordingError as error:
            assert "\n" not in str(error)
            assert str(path) in str(error)
        else:
            assert recording.x.shape == (len(recording.t), 6, 3) == (len(recording.frames), 6, 3)
            assert not np.isinf(recording.x).any()


def test_names_prefer_the_plain_spelling():
    names = ["Anna:LWRB", "Anna:LWRA", "left_wrist", "HandLeft", "WristRight_pos", "JointType_ElbowLeft", "sağOmuz"]
    assert guess(names) == {
        "left_wrist": "left_wrist",
        "right_wrist": "WristRight_pos",
        "left_elbow": "JointType_ElbowLeft",
        "right_shoulder": "sağOmuz",
    }


def real(pattern):
    paths = sorted(SHARED.glob(pattern)) if SHARED.is_dir() else []
    if not paths:
        pytest.skip(f"{SHARED / pattern} is not here")
    return [read_recording(path) for path in paths]


@pytest.mark.parametrize(
    ("pattern", "format_name", "counts", "rate", "clock"),
    [
        ("omomo_largebox/*.csv", "wide_csv", [196], 30.0, "clock: s, as the file or its format says"),
        ("kinect_v1_kinder_gator/*.csv", "wide_csv", [260], 31.0, "clock: ms"),
        ("kinect_v1_utkinect/joints_*.txt", "kinect_v1_rows", [560, 597, 534, 626], None, "clock: frame numbers at 30"),
        ("kinect_v2/*.csv", "kinect_v2_rows", [160, 371], 30.0, "clock: units of 100 ns"),
        ("vicon_box_lift/*.trc", "trc", [780, 939], 120.0, "clock: s"),
        ("human_assembly/*.txt", "points18", [925], 30.0, "assumed"),
    ],
)
def test_real_files_load_without_options(pattern, format_name, counts, rate, clock):
    recordings = real(pattern)
    assert [len(recording.t) for recording in recordings] == counts
    for recording in recordings:
        assert recording.format == format_name
        assert clock in " ".join(recording.evidence)
        lengths = np.nanmedian(link_lengths(recording.x), axis=0)
        assert ((lengths[[0, 1, 3, 4]] > 0.18) & (lengths[[0, 1, 3, 4]] < 0.36)).all()
        if rate is not None:
            assert 1.0 / np.median(np.diff(recording.t)) == pytest.approx(rate, rel=0.02)


def test_real_figures():
    one_handed, lift = real("vicon_box_lift/*.trc")
    assert np.isfinite(lift.x).all(axis=(1, 2)).sum() == 418
    np.testing.assert_allclose(np.nanmedian(link_lengths(lift.x), axis=0)[[0, 1]], [0.318, 0.248], atol=1e-3)
    assert np.nanmax(link_lengths(one_handed.x)[:, 3]) == pytest.approx(0.724, abs=1e-3)
    kinect, _ = real("kinect_v2/*.csv")
    assert kinect.confidence is not None
    np.testing.assert_allclose((kinect.confidence == 0.5).mean(axis=0), [0, 0, 0.46875, 0, 0, 0.125])
    (body_model,) = real("omomo_largebox/*.csv")
    assert link_lengths(body_model.x)[:, [0, 1, 3, 4]].std(axis=0).max() < 1e-5
    (assembly,) = real("human_assembly/*.txt")
    assert link_lengths(assembly.x)[:, [0, 1, 3, 4]].std(axis=0).max() < 1e-9
