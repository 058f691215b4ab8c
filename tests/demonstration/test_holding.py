import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import gaussian_filter1d
from synthetic_carry import BOX, SHARED, carry, turn

from drake_blfdmp.demonstration.bones import estimate_bone_lengths
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
from drake_blfdmp.demonstration.demonstration import Demonstration
from drake_blfdmp.demonstration.formats import read_recording
from drake_blfdmp.demonstration.holding import find_holding, fit_distance
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, held_interval, hold_and_place, minimum_jerk
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.errors import RecordingError


def demonstration(t, x, **more):
    return Demonstration(t, x, "test", **more)


def real(name, **options):
    paths = sorted(SHARED.glob(name)) if SHARED.is_dir() else []
    if not paths:
        pytest.skip(f"{SHARED / name} is not here")
    return clean(read_recording(paths[0], **options))


@settings(max_examples=20, deadline=None)
@given(
    start=st.floats(0.9, 2.0), length=st.floats(2.5, 4.0), heading=st.floats(-3, 3), rate=st.sampled_from([30.0, 120.0])
)
def test_the_hold_is_found(start, length, heading, rate):
    t, x = carry(duration=start + length + 1.2, rate=rate, held=(start, start + length))
    holding = find_holding(demonstration(t, turn(x, heading) + 0.3 * t[:, None, None] * [1.0, 0.5, 0.0]))
    assert holding.start_s == pytest.approx(start, abs=0.3)
    assert holding.end_s == pytest.approx(start + length, abs=0.3)
    assert holding.hand_distance == pytest.approx(BOX, abs=0.005)


@pytest.mark.parametrize("seed", range(5))
def test_kinect_wobble(seed):
    t, x = carry(duration=7.0, held=(1.5, 5.5), opening=0.35)
    wobble = gaussian_filter1d(np.random.default_rng(seed).normal(size=x.shape), 6.0, axis=0)  # Slow: 0.2 s.
    x = x + 0.015 * wobble / np.std(wobble)
    holding = find_holding(demonstration(t, x))
    assert holding.start_s == pytest.approx(1.5, abs=0.6)
    assert holding.end_s == pytest.approx(5.5, abs=0.6)
    assert holding.hand_distance == pytest.approx(BOX, abs=0.05)


@pytest.fixture(scope="module")
def filmed():
    """Default virtual Kinect recordings of seeds 0 to 19, in the world frame."""
    return [clean(record_hold_and_place(seed=seed)[0]) for seed in range(20)]


def test_virtual_kinect_in_both_frames(filmed):
    truth = np.array(held_interval())
    for demonstrated in (filmed, [to_torso_frame(world) for world in filmed]):
        found = [find_holding(d) for d in demonstrated]
        error = np.abs(np.array([(h.start_s, h.end_s) for h in found]) - truth).max(axis=1)
        assert error.max() <= 0.45
        assert np.mean(error <= 0.25) >= 0.95
        assert np.median([h.hand_distance for h in found]) == pytest.approx(0.3, abs=0.03)


def test_the_lift_is_inside(filmed):
    for world in filmed:
        holding = find_holding(world)
        height = smooth(world.t, world.x)[:, [2, 5], 2].mean(axis=1)
        held = (world.t >= holding.start_s) & (world.t <= holding.end_s)
        start, end = height[held][[0, -1]]
        assert abs(end - start) <= 0.12  # Noise of both: 0.05 m; the lift is 0.32 m.
        assert height[held].max() - max(start, end) >= 0.15


@pytest.mark.parametrize(("duration", "tolerance"), [(5.0, 0.2), (8.0, 0.07), (12.0, 0.25)])
def test_exact_motions_fast_and_slow(duration, tolerance):
    holding = find_holding(demonstration(*hold_and_place(duration_s=duration)))
    assert (holding.start_s, holding.end_s) == pytest.approx(held_interval(duration), abs=tolerance)
    assert holding.hand_distance == pytest.approx(0.3, abs=0.002)


def test_a_clean_sensor_needs_no_lift():
    holding = find_holding(demonstration(*hold_and_place(ModelledPerson(lift=0.0))))
    assert (holding.start_s, holding.end_s) == pytest.approx(held_interval(), abs=0.3)


@settings(max_examples=20, deadline=None)
@given(
    first=st.integers(10, 30),
    length=st.integers(20, 40),
    level=st.floats(0.1, 0.6),
    before=st.floats(0.05, 0.5),
    after=st.floats(0.05, 0.5),
)
def test_the_fit_is_exact_on_its_own_model(first, length, level, before, after):
    t = np.arange(90) / 15.0
    closing, opening = 1 - minimum_jerk((t - t[first]) / 0.7 + 1), minimum_jerk((t - t[first + length]) / 0.7)
    fits = fit_distance(t, level + before * closing + after * opening, 0.02)
    best = np.argmin(fits.misfit)
    assert (fits.first[best], fits.last[best]) == (first, first + length)
    assert fits.opening[best] == pytest.approx([before, after], abs=1e-4)
    assert np.partition(fits.misfit, 1)[1] > fits.misfit[best] + 1e-3


def test_a_recording_held_from_first_to_last():
    t, x = carry(duration=8.0, held=(1.0, 7.0))
    inside = (t >= 1.3) & (t <= 6.7)
    t, x = t[inside] - t[inside][0], x[inside]
    holding = find_holding(demonstration(t, x))
    assert (holding.start_s, holding.end_s) == (0.0, t[-1])


def test_walking_with_hanging_arms_is_no_hold():
    t, x = carry(duration=10.0, held=(6.0, 9.0))
    walk = np.minimum(t, 5.0)[:, None, None] * [0.0, 0.8, 0.0]
    assert find_holding(demonstration(t, x + walk)).start_s == pytest.approx(6.0, abs=0.3)


def test_one_hand_that_carries_is_refused():
    t, x = carry()
    x[:, 3:6] = x[0, 3:6]
    x[:, 0:3] += 0.5 * np.sin(t)[:, None, None] * [-0.3, 0.5, 0.6]
    with pytest.raises(RecordingError, match=r"one hand carries.*distance .* varies by .* and 4 samples") as caught:
        find_holding(demonstration(t, x, repairs={"jumps_removed": 4}))
    assert "\n" not in str(caught.value)


def test_hands_that_rest_are_refused():
    t, x = carry()
    with pytest.raises(RecordingError, match="nothing is carried"):
        find_holding(demonstration(t, np.repeat(x[:1], len(t), axis=0)))


@pytest.mark.parametrize(
    ("name", "start", "end", "distance", "bones"),
    [
        ("omomo_largebox/*.csv", 0.90, 5.37, 0.383, (0.292, 0.294)),
        ("vicon_box_lift/yerden_alma_hatasiz.trc", 2.93, 5.58, 0.31, (0.321, 0.249)),
    ],
)
def test_real_lifts(name, start, end, distance, bones):
    world = real(name)
    for demonstrated in (world, to_torso_frame(world)):
        holding = find_holding(demonstrated)
        assert holding.start_s == pytest.approx(start, abs=0.15)
        assert holding.end_s == pytest.approx(end, abs=0.15)
        assert holding.hand_distance == pytest.approx(distance, abs=0.005)
    assert estimate_bone_lengths(world.x) == pytest.approx(bones, abs=0.01)


@pytest.mark.parametrize(
    ("name", "carry_frames"),
    [("s01_e01", (1016, 1242)), ("s02_e01", (1424, 1780)), ("s05_e02", (1266, 1540)), ("s08_e01", (1228, 1588))],
)
def test_real_kinect_carries_are_held_throughout(name, carry_frames):
    world = real(f"kinect_v1_utkinect/joints_{name}.txt", frames=carry_frames)
    assert world.rate_hz == pytest.approx(30.0)
    for demonstrated in (world, to_torso_frame(world)):
        holding = find_holding(demonstrated)
        assert (holding.start_s, holding.end_s) == (0.0, world.t[-1])
        assert 0.05 < holding.hand_distance < 0.35


def test_real_one_handed_carry_is_refused():
    world = real("vicon_box_lift/yantasima2.trc")
    for demonstrated in (world, to_torso_frame(world)):
        with pytest.raises(RecordingError, match="one hand carries"):
            find_holding(demonstrated)


@pytest.mark.parametrize("seed", range(4))
def test_the_hold_is_found_as_well_when_the_bones_have_been_restored(seed):
    recording, _ = record_hold_and_place(seed=seed)
    before, after = (find_holding(clean(recording, CleaningOptions(restore_bones=restored))) for restored in (0, 1))
    assert (after.start_s, after.end_s) == pytest.approx((before.start_s, before.end_s), abs=0.3)
    assert after.hand_distance == pytest.approx(before.hand_distance, abs=0.05)
