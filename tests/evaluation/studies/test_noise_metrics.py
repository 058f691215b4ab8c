"""The measures of a sensor's noise on series made by hand, whose answers are known, and on files made for it."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect, record_hold_and_place
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.evaluation.studies.noise_metrics import (
    JUMP_M,
    bone_spreads,
    distinct_frames,
    error_statistics,
    jitter,
    seen_points,
    spread,
    survey_folder,
    survey_recording,
)

N = 400
T = np.arange(N) / 30.0


def skeleton(n=N):
    """A person at rest with bones of 0.25 m (N, 6, 3), hands 0.3 m apart, m."""
    x = np.zeros((n, 6, 3))
    for first, side in ((0, -1.0), (3, 1.0)):
        x[:, first] = [0.15 * side, 0.0, 1.4]
        x[:, first + 1] = [0.15 * side, 0.0, 1.15]
        x[:, first + 2] = [0.15 * side, 0.25, 1.15]
    return x


def recording(x, t=None, name="made"):
    t = T[: len(x)] if t is None else t
    return Recording(t=t, x=x, source=name, format="made", frames=np.arange(len(t)))


def test_sizes_are_of_the_errors_norm():
    errors = np.zeros((5, 2, 3))
    errors[0, 0] = [0.03, 0.04, 0.0]
    found = error_statistics(errors)
    assert found.rms_m == pytest.approx(0.05 / np.sqrt(10.0))
    assert found.median_m == 0.0
    assert found.largest_m == pytest.approx(0.05)
    np.testing.assert_allclose(found.axis_rms_m, np.array([0.03, 0.04, 0.0]) / np.sqrt(10.0))


def test_the_95th_percentile_is_of_all_samples():
    errors = np.zeros((101, 1, 3))
    errors[:, 0, 2] = np.linspace(0.0, -1.0, 101)
    assert error_statistics(errors).p95_m == pytest.approx(0.95)


def test_a_jump_is_a_step_and_counts_when_it_comes_and_when_it_goes():
    errors = np.full((11, 1, 3), 0.05)  # Constant errors, however large, are no jumps.
    assert error_statistics(errors).jump_share == 0.0
    errors[4:7, 0, 0] += 1.01 * JUMP_M
    assert error_statistics(errors).jump_share == pytest.approx(0.2)
    errors[4:7, 0, 0] -= 0.02 * JUMP_M
    assert error_statistics(errors).jump_share == 0.0


def test_takes_padded_with_nan_count_what_they_hold():
    errors = np.full((2, 6, 1, 3), np.nan)
    errors[0] = 0.0
    errors[1, :3] = [0.0, 0.1, 0.0]
    found = error_statistics(errors)
    assert found.rms_m == pytest.approx(0.1 / np.sqrt(3.0))
    assert found.jump_share == 0.0  # From one take to the next there is no step.


def test_spread_ignores_what_is_missing_and_refuses_nothing_at_all():
    found = spread(np.array([0.2, np.nan, 0.3, 0.25]))
    assert (found.samples, found.min_m, found.max_m) == (3, 0.2, 0.3)
    assert found.mean_m == pytest.approx(0.25)
    assert found.std_m == pytest.approx(np.sqrt(0.005 / 3.0))
    with pytest.raises(RecordingError, match="no sample shows both ends"):
        spread(np.full(4, np.nan))


def test_unequal_arms_that_do_not_vary_have_no_spread():
    x = skeleton()
    x[:, 4] = x[:, 3] + [0.0, 0.0, -0.27]  # The right upper arm is longer, the forearm follows.
    x[:, 5] = x[:, 4] + [0.0, 0.25, 0.0]
    found = bone_spreads(x)
    assert found["upper_arm"].std_m == pytest.approx(0.0, abs=1e-12)
    assert found["upper_arm"].mean_m == pytest.approx(0.26)
    assert (found["upper_arm"].min_m, found["upper_arm"].max_m) == (pytest.approx(0.25), pytest.approx(0.27))
    assert found["upper_arm"].samples == 2 * N


def test_a_hand_that_slides_along_its_forearm_spreads_the_forearm_alone():
    x = skeleton()
    x[:, 2, 1] += 0.02 * np.sign(np.sin(np.arange(N) * np.pi / 2 + 0.1))
    found = bone_spreads(x)
    assert found["upper_arm"].std_m == pytest.approx(0.0, abs=1e-12)
    assert found["forearm"].std_m == pytest.approx(0.02 / np.sqrt(2.0), rel=1e-6)  # One arm of two.


def test_jitter_finds_white_noise_of_each_kind_of_point():
    rng = np.random.default_rng(3)
    sigma = np.array([0.001, 0.003, 0.006])
    x = skeleton(3000) + np.tile(sigma, 2)[:, None] * rng.standard_normal((3000, 6, 3))
    np.testing.assert_allclose(jitter(np.arange(3000) / 30.0, x), sigma, rtol=0.06)


def test_jitter_does_not_take_motion_for_noise():
    """A reach of 0.3 m amplitude at 0.5 Hz, with 2 mm of noise: without it nothing can be told, with it 2 mm."""
    rng = np.random.default_rng(4)
    t = np.arange(3000) / 30.0
    moving = skeleton(3000)
    moving[..., 0] += 0.3 * np.sin(np.pi * t)[:, None]
    moving[..., 1] += 0.3 * np.cos(np.pi * t)[:, None]
    moving[..., 2] += 0.3 * np.sin(np.pi * t + 1.0)[:, None]
    assert np.all(np.isnan(jitter(t, moving)) | (jitter(t, moving) < 1e-4))
    np.testing.assert_allclose(jitter(t, moving + 0.002 * rng.standard_normal(moving.shape)), 0.002, rtol=0.1)


def test_jitter_ignores_slow_drift_jumps_and_missing_points():
    rng = np.random.default_rng(5)
    x = skeleton() + 0.004 * rng.standard_normal((N, 6, 3))
    x += 0.05 * np.sin(0.5 * T)[:, None, None]
    x[100:103, 2] += 0.5
    x[200:210, 5] = np.nan
    np.testing.assert_allclose(jitter(T, x), 0.004, rtol=0.15)


@pytest.mark.parametrize("rate", [5.0, 15.0])
def test_jitter_is_not_told_below_twenty_frames_a_second(rate):
    x = skeleton() + 0.004 * np.random.default_rng(6).standard_normal((N, 6, 3))
    assert np.isnan(jitter(np.arange(N) / rate, x)).all()


def test_jitter_takes_only_stretches_of_even_steps():
    """Every third frame is missing: no four frames in a row are even."""
    t = np.delete(T, np.arange(2, N, 3))
    x = np.random.default_rng(7).standard_normal((len(t), 6, 3))
    assert np.isnan(jitter(t, x)).all()
    assert np.isnan(jitter(T[:5], skeleton(5))).all()


def test_repeated_frames_count_once_and_unseen_joints_not_at_all():
    x = skeleton(4)
    x[2, 2] = 0.0
    one = recording(x, t=np.array([0.0, 0.1, 0.1, 0.2]))
    np.testing.assert_array_equal(distinct_frames(one), [0, 1, 3])
    assert np.isnan(seen_points(one)[2, 2]).all()
    assert np.isfinite(np.delete(seen_points(one).reshape(24, 3), 14, axis=0)).all()


def test_the_virtual_kinects_white_noise_is_found_in_its_recording():
    """Errors that are known: 7 mm of white noise and nothing else."""
    silent = dict(shoulder_drift_m=0, elbow_drift_m=0, wrist_drift_m=0, occlusion_drift_m=0, occlusion_pull_m=0)
    sensor = VirtualKinect(**silent, white_m=0.007, jump_rate_hz=0, shortening=0.0)
    film, truth = record_hold_and_place(sensor=sensor, seed=1)
    found = survey_recording("film", film)
    np.testing.assert_allclose(found.jitter_m, 0.007, rtol=0.12)
    assert found.spreads["hands"].mean_m == pytest.approx(0.30, abs=0.01)
    assert found.rate_hz == pytest.approx(30.0) and found.refused == found.not_held == ""
    assert error_statistics(film.x - truth).rms_m == pytest.approx(0.007 * np.sqrt(3.0), rel=0.05)


def test_a_recording_without_a_held_box_still_tells_of_its_bones():
    x = skeleton() + 0.003 * np.random.default_rng(8).standard_normal((N, 6, 3))
    found = survey_recording("rest", recording(x))
    assert set(found.spreads) == {"upper_arm", "forearm"}
    assert "hands" in found.not_held and "made" not in found.not_held
    np.testing.assert_allclose(found.jitter_m, 0.003, rtol=0.15)


@pytest.mark.parametrize(
    ("x", "reason"),
    [
        (skeleton(1), "1 frame only"),
        (np.full((20, 6, 3), np.nan), "no sample shows both ends"),
        (1000.0 * skeleton(20), "the upper arm measures 250 m on average"),
    ],
)
def test_a_useless_recording_says_why(x, reason):
    assert reason in survey_recording("bad", recording(x)).refused


def write_csv(path, x):
    names = ("ShoulderLeft", "ElbowLeft", "WristLeft", "ShoulderRight", "ElbowRight", "WristRight")
    header = ",".join(["Timestamp", *(f"{name}{axis}" for name in names for axis in "XYZ")])
    rows = np.column_stack([T[: len(x)], x.reshape(len(x), 18)])
    np.savetxt(path, rows, delimiter=",", header=header, comments="")


def test_a_folder_is_walked_in_order_and_nothing_is_skipped_silently(tmp_path):
    (tmp_path / "b").mkdir()
    write_csv(tmp_path / "b" / "rest.csv", skeleton(60) + 0.003 * np.random.default_rng(9).standard_normal((60, 6, 3)))
    (tmp_path / "b" / "empty.csv").write_text("")
    (tmp_path / "a.txt").write_text("no recording\n")
    told = []
    found = survey_folder(tmp_path, lambda what, share: told.append((what, share)))
    assert [one.name for one in found] == ["a.txt", "b/empty.csv", "b/rest.csv"]
    assert found[0].refused.startswith("text of no known format")
    assert found[1].refused.startswith("is empty")
    assert found[2].refused == "" and found[2].samples == 60
    assert found[2].spreads["upper_arm"].mean_m == pytest.approx(0.25, abs=0.002)
    assert [share for _, share in told] == pytest.approx([0.0, 1 / 3, 2 / 3])
    assert str(tmp_path) not in " ".join(one.refused + one.not_held for one in found)


def test_a_folder_that_is_none_or_empty_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="is no folder"):
        survey_folder(tmp_path / "missing")
    with pytest.raises(RecordingError, match="holds no file"):
        survey_folder(tmp_path)


def test_real_recordings_that_are_read_have_the_links_of_people(recordings):
    found = survey_folder(recordings / "kinect_v1_kinder_gator")
    assert [one.refused for one in found] == [""]
    assert 0.2 < found[0].spreads["forearm"].mean_m < 0.35
    assert np.all(np.diff(found[0].jitter_m) > 0)  # Shoulders, elbows, hands.
