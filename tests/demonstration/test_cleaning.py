from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from synthetic_carry import carry, recording

from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import KnownDimensions, Recording
from drake_blfdmp.errors import RecordingError

T, X = carry()
DEFAULT = CleaningOptions()


def rms(a, b):
    return float(np.sqrt(np.mean(np.sum((a - b) ** 2, axis=-1))))


def check_refused(said, t, x, options=DEFAULT, **more):
    with pytest.raises(RecordingError) as caught:
        clean(recording(t, x, **more), options)
    message = str(caught.value)
    assert said in message
    assert message.startswith("test.csv: ")
    assert "\n" not in message


def test_a_clean_recording_stays_as_it_is():
    demonstration = clean(recording(T + 7.0, X))
    np.testing.assert_array_equal(demonstration.x, X)
    np.testing.assert_allclose(demonstration.t, T, atol=1e-9)
    assert set(demonstration.repairs.values()) == {0}


def test_known_dimensions_and_origin_are_handed_on():
    known = KnownDimensions(box_width=0.3)
    given_recording = Recording(T, X, "made", "test", np.arange(len(T)), synthetic=True, known=known)
    demonstration = clean(given_recording)
    assert (demonstration.source, demonstration.synthetic, demonstration.known) == ("made", True, known)


@settings(max_examples=25, deadline=None)
@given(
    gaps=st.lists(st.tuples(st.integers(5, 150), st.integers(1, 8), st.integers(0, 5)), max_size=4),
    jumps=st.lists(st.tuples(st.integers(3, 176), st.integers(0, 5)), max_size=6, unique_by=lambda jump: jump[0]),
    seed=st.integers(0, 1000),
)
@example(gaps=[(87, 8, 4)], jumps=[(3, 0), (4, 0), (95, 4)], seed=900)
def test_injected_gaps_and_jumps_are_repaired(gaps, jumps, seed):
    rng = np.random.default_rng(seed)
    x = X.copy()
    spoiled = np.zeros(x.shape[:2], dtype=bool)
    for frame, point in jumps:
        direction = rng.normal(size=3)
        x[frame, point] += rng.uniform(0.4, 0.9) * direction / np.linalg.norm(direction)
        spoiled[frame, point] = True
    for frame, length, point in gaps:
        x[frame : frame + length, point] = np.nan
        spoiled[frame : frame + length, point] = True
    demonstration = clean(recording(T, x))
    missing = np.isnan(x).any(axis=-1)
    assert demonstration.repairs["missing_samples_filled"] == missing.sum()
    assert demonstration.repairs["jumps_removed"] >= (spoiled & ~missing).sum()
    assert np.abs(demonstration.x - X).max() < 0.03
    assert rms(demonstration.x, X) < 0.004


def test_a_run_of_swapped_markers_is_removed():
    x = X.copy()
    x[60:70, [2, 5]] = x[60:70, [5, 2]] + [0.0, 0.3, 0.0]
    demonstration = clean(recording(T, x))
    assert demonstration.repairs["jumps_removed"] >= 20
    assert np.abs(demonstration.x - X).max() < 0.03


@settings(max_examples=20, deadline=None)
@given(
    doubled=st.sets(st.integers(1, 180), min_size=1, max_size=8),
    frozen=st.sets(st.integers(3, 177).map(lambda i: i - i % 3), max_size=6),
)
def test_repeated_frames(doubled, frozen):
    x = X.copy()
    for frame in frozen:
        x[frame] = x[frame - 1]
    order = np.sort(np.r_[np.arange(len(T)), sorted(doubled)])
    second = np.r_[False, np.diff(order) == 0]
    x = x[order] + np.where(second, 0.02, 0.0)[:, None, None]
    demonstration = clean(recording(T[order], x))
    assert demonstration.repairs["repeated_frames"] == len(doubled) + len(frozen)
    assert demonstration.repairs["resampled_frames"] == len(frozen)
    assert np.abs(demonstration.x - X).max() < 0.005


@settings(max_examples=20, deadline=None)
@given(late=st.sets(st.integers(2, 170).map(lambda i: i - i % 5), min_size=1, max_size=8))
def test_frames_out_of_order(late):
    order = np.arange(len(T))
    for frame in late:
        order[[frame, frame + 1]] = order[[frame + 1, frame]]
    demonstration = clean(recording(T[order], X[order]))
    assert demonstration.repairs["out_of_order_frames"] == len(late)
    np.testing.assert_array_equal(demonstration.x, X)


def test_a_person_at_rest_is_no_repeated_frame():
    x = np.concatenate([np.repeat(X[:1], 30, axis=0), X])
    demonstration = clean(recording(np.arange(len(x)) / 30.0, x))
    assert demonstration.repairs["repeated_frames"] == 0
    np.testing.assert_array_equal(demonstration.x, x)


@pytest.mark.parametrize("interpolation", ["pchip", "linear"])
def test_kinect_rows_at_a_quarter_of_the_clock_come_back_at_30_hz(interpolation):
    keep = np.r_[np.arange(0, len(T), 4)]
    demonstration = clean(recording(T[keep], X[keep]), CleaningOptions(interpolation=interpolation))
    assert demonstration.rate_hz == pytest.approx(30.0)
    assert demonstration.repairs["resampled_frames"] == len(T) - len(keep)
    assert rms(demonstration.x, X) < 0.004


def test_rounded_stamps_and_an_asked_for_rate():
    t, x = carry(rate=120.0)
    demonstration = clean(recording(np.round(t, 6), x))
    np.testing.assert_array_equal(demonstration.x, x)
    assert clean(recording(t, x), CleaningOptions(rate_hz=60.0)).rate_hz == pytest.approx(60.0)


def test_ends_without_the_whole_person_are_trimmed():
    x = X.copy()
    x[:7] = np.nan
    x[-4:, 5] = 0.0  # A Kinect's joint that is not seen.
    demonstration = clean(recording(T, x))
    assert demonstration.repairs["trimmed_frames"] == 11
    np.testing.assert_array_equal(demonstration.x, X[7:-4])
    assert demonstration.t[0] == 0.0


@pytest.mark.parametrize("matrix", [[[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]]])
def test_y_up_and_y_down_become_z_up(matrix):
    demonstration = clean(recording(T, X @ np.array(matrix).T))
    np.testing.assert_allclose(demonstration.x, X, atol=1e-12)


def test_up_can_be_said():
    x_up = np.stack([X[..., 2], X[..., 1], -X[..., 0]], axis=-1)
    demonstration = clean(recording(T, x_up), CleaningOptions(up="x"))
    np.testing.assert_allclose(demonstration.x[..., 2], X[..., 2])
    check_refused("up is 'w'; give one of x, -x", T, X, CleaningOptions(up="w"))


def test_refusals():
    check_refused("a 2-frame recording", T[:2], X[:2])
    check_refused("lasts 0.50 s", T[:16], X[:16])
    check_refused("samples a second, at least 4", T[::15], X[::15])
    check_refused("every sample has the time 3 s", np.full_like(T, 3.0), X)
    check_refused("upper arm measures 290 m, expected 0.1 to 0.6 m; try --unit mm", T, X * 1000.0)
    check_refused("try --unit cm", T, X * 100.0)
    check_refused("upper arm measures 0.00029 m, expected 0.1 to 0.6 m; try --unit m", T, X / 1000.0)
    check_refused("check --unit and --joints", T, X * 5.0)
    check_refused("left and right are swapped; swap them with --joints", T, X[:, [3, 4, 5, 0, 1, 2]])
    check_refused("time runs backwards at frame 91", np.r_[T[:91], T[:90]], X)
    check_refused("nobody moves", T, X[:1] + 1e-4 * np.random.default_rng(0).normal(size=X.shape))
    check_refused("interpolation is 'cubic'", T, X, CleaningOptions(interpolation="cubic"))
    check_refused("max_gap_s is -1", T, X, CleaningOptions(max_gap_s=-1.0))


def test_refused_gaps_say_where():
    x = X.copy()
    x[40:100, 2] = np.nan
    frames = 1000 + np.arange(len(T))
    check_refused("left_wrist is missing between frames 1039 and 1100 (2.03 s, at most 1.5 s", T, x, frames=frames)
    assert clean(recording(T, x), CleaningOptions(max_gap_s=2.5)).repairs["missing_samples_filled"] == 60
    x[:, 2] = np.nan
    check_refused("left_wrist is missing in every frame", T, x)
    check_refused("left_shoulder is missing in every frame", T, np.full_like(X, np.nan))
    keep = np.r_[0:40, 100 : len(T)]
    check_refused("missing between frames 39 and 100", T[keep], X[keep], frames=keep)


def test_half_a_recording_without_left_or_right_confusion_passes_swapped_half_fails():
    x = X.copy()
    x[:40] = x[:40, [3, 4, 5, 0, 1, 2]]
    clean(recording(T, x), CleaningOptions(speed_limit=1000.0))
    x[:160] = X[:160, [3, 4, 5, 0, 1, 2]]
    check_refused("swapped", T, x, CleaningOptions(speed_limit=1000.0))


def test_swapped_markers_are_swapped_back():
    x = X.copy()
    x[60:70, [2, 5]] = x[60:70, [5, 2]]
    demonstration = clean(recording(T, x))
    np.testing.assert_array_equal(demonstration.x, X)
    assert demonstration.repairs["swaps_undone"] == 20
    assert demonstration.repairs["jumps_removed"] == 0
    assert any("left_wrist, right_wrist stood under each other's names in 10 frames" in n for n in demonstration.notes)
    assert clean(recording(T, x), CleaningOptions(undo_swaps=False)).repairs["jumps_removed"] >= 20


def test_confidence_decides_what_is_seen():
    x, confidence = X.copy(), np.ones((len(T), 6))
    x[50:60, 1] += 0.02
    x[90:96, 5] += 0.02
    confidence[50:60, 1], confidence[90:96, 5] = 0.5, 0.0
    doubted = replace(recording(T, x), confidence=confidence)
    counts = []
    for least, wrong in ((0.0, [1, 5]), (0.25, [1]), (0.75, [])):
        demonstration = clean(doubted, CleaningOptions(least_confidence=least))
        off = np.flatnonzero(np.abs(demonstration.x - X).max(axis=(0, 2)) > 0.015)
        np.testing.assert_array_equal(off, wrong)
        counts.append(demonstration.repairs["low_confidence_removed"])
    assert counts == [0, 6, 16]
    with pytest.raises(RecordingError, match=r"test.csv: confidence is \(3, 6\), points are \(181, 6\)"):
        clean(replace(doubted, confidence=confidence[:3]))


def test_frames_without_a_body_are_counted():
    x = X.copy()
    x[80:90] = np.nan
    demonstration = clean(recording(T, x))
    assert demonstration.repairs["empty_frames"] == 10
    assert demonstration.repairs["missing_samples_filled"] == 60
    assert rms(demonstration.x, X) < 0.004


def test_every_step_can_be_left_out():
    late = np.arange(len(T))
    late[[50, 51]] = 51, 50
    check_refused("frame 51 comes late", T[late], X[late], CleaningOptions(sort_frames=False))
    x = X.copy()
    x[100] = x[99]
    demonstration = clean(recording(T, x), CleaningOptions(drop_repeats=False))
    np.testing.assert_array_equal(demonstration.x, x)
    x = X.copy()
    x[60, 2, 0] += 0.5
    left = CleaningOptions(remove_jumps=False, undo_swaps=False)
    np.testing.assert_array_equal(clean(recording(T, x), left).x, x)


def test_options_out_of_range():
    check_refused("least_confidence is 2", T, X, CleaningOptions(least_confidence=2.0))
    check_refused("smoothing is 'sinc'; give one of auto, butterworth", T, X, CleaningOptions(smoothing="sinc"))
    check_refused("set restore_bones too", T, X, CleaningOptions(restore_hold=True))


def test_smoothing_by_the_data_is_counted_and_said():
    x = X + 0.01 * np.random.default_rng(0).normal(size=X.shape)
    raw, smoothed = clean(recording(T, x)), clean(recording(T, x), CleaningOptions(smoothing="auto"))
    assert rms(smoothed.x, X) < 0.5 * rms(raw.x, X)
    assert (raw.repairs["points_smoothed"], smoothed.repairs["points_smoothed"]) == (0, 6 * len(T))
    assert any(note.startswith("smoothing by the least estimated error") for note in smoothed.notes)
    np.testing.assert_array_equal(raw.uncertainty, smoothed.uncertainty)


def test_the_file_says_what_is_up():
    turned = X @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]).T
    for up, said in (("y", "as the file says"), (None, "as the arms hang")):
        demonstration = clean(replace(recording(T, turned), up=up))
        assert demonstration.notes[0] == f"up: the file's y axis, {said}"
    with pytest.raises(RecordingError, match="test.csv: the file's up axis is 'w'"):
        clean(replace(recording(T, turned), up="w"))


def test_numbers_that_are_no_measurements_name_frame_and_point():
    x, t = X.copy(), T.copy()
    x[7, 4, 1] = 1e200
    check_refused("at frame 7 right_elbow is at 1e+200 m; check --unit", T, x)
    t[9] = np.nan
    check_refused("frame 9 has the time nan s", t, X)
    check_refused("do not fit", T[:-1], X)
    close = T.copy()
    close[20] = close[19] + 1e-12
    check_refused("frames 19 and 20 are 1.0e-12 s apart", close, X)
    check_refused("is no clock for", np.r_[np.arange(150) * 1e-5, np.linspace(0.1, 3.1, 31)], X)
