import re
from pathlib import Path

import numpy as np
import pytest
from synthetic_carry import carry

from drake_blfdmp.demonstration.formats.interpretation import ReadOptions, interpret
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording, one_body
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=2.0)
PATH = Path("a.dat")


def read(raw, **options):
    return interpret(PATH, "test", raw, ReadOptions(**options))


def test_numbers_become_metres_and_seconds_with_their_evidence():
    recording = read(one_body(1000.0 * X, 5 + np.arange(len(T)), 1e7 * T, up="-y", notes=("a note",)))
    np.testing.assert_allclose(recording.x, X, atol=1e-12)
    np.testing.assert_allclose(recording.t, T, atol=1e-12)
    assert (recording.format, recording.source, recording.up) == ("test", "a.dat", "-y")
    assert [sentence.split(":")[0] for sentence in recording.evidence] == ["unit", "clock", "a note"]
    assert "mm" in recording.evidence[0] and "100 ns" in recording.evidence[1]


def test_a_range_of_frames_takes_everything_with_it_and_leaves_the_clock_alone():
    confidence = np.tile(np.linspace(0.0, 1.0, len(T))[:, None], 6)
    frames = 100 + np.arange(len(T))
    recording = read(one_body(X, frames, T, confidence), frames=(110, 119))
    np.testing.assert_array_equal(recording.frames, np.arange(110, 120))
    np.testing.assert_array_equal(recording.x, X[10:20])
    np.testing.assert_array_equal(recording.confidence, confidence[10:20])
    np.testing.assert_allclose(recording.t, T[10:20])
    # Two frames of a 30 Hz clock in ms would read as anything; the whole file tells.
    few = read(one_body(X, frames, 1000.0 * T), frames=(110, 111))
    np.testing.assert_allclose(few.t, T[10:12])


def test_absurd_numbers_are_missing_and_counted():
    x = X.copy()
    x[3, 2, 0], x[4, 1, 1], x[5, 0, 2] = np.inf, 1e300, np.nan
    recording = read(one_body(x, t=T))
    assert np.isnan(recording.x[[3, 4, 5], [2, 1, 0], [0, 1, 2]]).all()
    assert np.isfinite(recording.x).sum() == x.size - 3
    assert any(sentence.startswith("2 numbers are infinite or too large") for sentence in recording.evidence)


def test_frames_without_anybody_are_said():
    raw = RawRecording({"3": Body(X, np.arange(len(X)), T)}, empty_frames=12)
    assert "12 frames hold no person" in read(raw).evidence


@pytest.mark.parametrize(
    ("raw", "options", "message"),
    [
        (RawRecording({}), {}, "holds no person"),
        (one_body(X[:0]), {}, "holds a header but no samples"),
        (one_body(X, t=np.where(T > 1.0, np.nan, T)), {}, "frame 31 has no time; repair or remove it"),
        (one_body(X, t=T), {"frames": (900, 950)}, "no frame lies in 900:950; the file has frames 0 to 60"),
        (one_body(X, t=T), {"unit": "ell"}, "unknown unit 'ell'; give one of m, cm, mm"),
        (one_body(X, t=T), {"time_unit": "min"}, "unknown unit of time 'min'"),
        (one_body(X, t=T), {"rate_hz": -1.0}, "a rate of -1 frames a second; give a positive number"),
        (one_body(X, t=T), {"body": "4"}, "holds no person '4'; it has 0"),
    ],
)
def test_what_cannot_be_understood_is_refused(raw, options, message):
    with pytest.raises(RecordingError, match=f"^a.dat: .*{re.escape(message)}"):
        read(raw, **options)
