"""Every real recording at hand: it loads by itself, and its figures are those published beside it."""

import numpy as np
import pytest

from drake_blfdmp.demonstration.bones import link_lengths
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.health import examine
from drake_blfdmp.skeleton import ELBOWS, HANDS, WRISTS

NO_RECORDINGS = ("LICENSE", "README.md", "actionLabel.txt")
UPPER_ARMS, FOREARMS = [0, 4], [1, 3]


def spread(x, links):
    """Mean and standard deviation of lengths over the samples and both arms, each arm about its own mean."""
    lengths = link_lengths(x)[:, links]
    return np.nanmean(lengths), np.sqrt(np.nanmean((lengths - np.nanmean(lengths, axis=0)) ** 2))


def test_every_file_loads_with_no_option_and_is_a_persons_arms(recordings):
    files = [path for path in sorted(recordings.rglob("*")) if path.is_file() and path.name not in NO_RECORDINGS]
    assert len(files) > 20
    for path in files:
        recording = read_recording(path)
        assert len(recording.evidence) >= 2, path
        lengths = np.nanmedian(link_lengths(recording.x), axis=0)
        assert ((lengths[UPPER_ARMS + FOREARMS] > 0.12) & (lengths[UPPER_ARMS + FOREARMS] < 0.40)).all(), (
            path,
            lengths,
        )
        examine(recording)


def test_the_azure_bag(recordings):
    recording = read_recording(recordings / "azure_kinect" / "body_tracking_data.bag")
    left = link_lengths(recording.x)[:, :2]  # The published figures are the left arm's, to the printed digits.
    assert left.mean(axis=0).round(3).tolist() == [0.261, 0.219]
    assert left.std(axis=0).round(3).tolist() == [0.010, 0.009]
    assert len(recording.t) == 933 - 60
    assert "60 frames hold no person" in recording.evidence
    low = (recording.confidence[:, WRISTS] < 0.75).mean(axis=0)
    assert ((low > 0.12) & (low < 0.18)).all()
    steps = np.linalg.norm(np.diff(recording.x[:, WRISTS], axis=0), axis=-1)
    assert np.nanmax(steps) == pytest.approx(0.49, abs=0.005)
    assert 1.0 / np.median(np.diff(recording.t)) == pytest.approx(15.0, abs=0.1)
    assert recording.up == "-y"


def test_the_body_model_fit(recordings):
    pt, csv = (
        read_recording(recordings / "omomo_largebox" / name)
        for name in ("sub3_largebox_003.pt", "sub3_largebox_003_extracted.csv")
    )
    np.testing.assert_allclose(pt.x, csv.x, atol=1e-5)
    np.testing.assert_allclose(pt.t, csv.t, atol=1e-5)
    assert spread(pt.x, UPPER_ARMS + FOREARMS)[1] < 1e-5
    examined = examine(pt)
    held = (pt.t >= examined.holding.start_s) & (pt.t <= examined.holding.end_s)
    hands = link_lengths(pt.x[held])[:, HANDS]
    assert (hands.mean().round(3), hands.std().round(3)) == (0.385, 0.008)


def test_the_marker_recordings(recordings):
    lift = read_recording(recordings / "vicon_box_lift" / "yerden_alma_hatasiz.trc")
    assert len(lift.t) == 939 and np.isfinite(lift.x).all(axis=(1, 2)).sum() == 418
    assert examine(lift).health.suitable
    alone = read_recording(recordings / "vicon_box_lift" / "yantasima2.trc")
    assert np.nanmax(link_lengths(alone.x)[:, FOREARMS]) == pytest.approx(0.72, abs=0.005)
    health = examine(alone).health
    assert not health.suitable
    assert "one hand carries" in health.reasons[0] and "jumped" in health.reasons[0]


def test_the_gesture_with_a_guessed_wrist(recordings):
    recording = read_recording(recordings / "kinect_v2" / "Ges06_chickenwing.csv")
    assert round(100 * (recording.confidence[:, WRISTS[0]] == 0.5).mean()) == 47
    assert (recording.confidence[:, ELBOWS] == 1.0).all()


def test_the_carries_of_kinect_v1(recordings):
    folder = recordings / "kinect_v1_utkinect"
    repeated = 0
    for path in sorted(folder.glob("joints_*.txt")):
        recording = read_recording(path)
        repeated += len(recording.t) - len(np.unique(recording.frames))
        assert 1.0 / np.median(np.diff(np.unique(recording.t))) < 8.0
    total = sum(len(read_recording(path).t) for path in folder.glob("joints_*.txt"))
    assert repeated / total == pytest.approx(0.02, abs=0.012)
    carry = read_recording(folder / "joints_s01_e01.txt", frames=(1016, 1242))
    lengths = link_lengths(carry.x)
    assert lengths[:, UPPER_ARMS].min() == pytest.approx(0.151, abs=5e-4)  # The least of the whole set.
    assert lengths[:, FOREARMS].min() == pytest.approx(0.152, abs=5e-4)


def test_key_points_and_their_cleaned_twin(recordings):
    folder = recordings / "rgbd_arm_keypoints"
    for path in sorted(folder.glob("*_Original.json")):
        raw, reference = read_recording(path), read_recording(str(path).replace("_Original", "_DepthProjection"))
        assert len(raw.t) == len(reference.t)
        assert raw.up == reference.up == "-z"
        assert spread(reference.x, FOREARMS)[1] < spread(raw.x, FOREARMS)[1]
