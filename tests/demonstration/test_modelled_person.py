import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drake_blfdmp.demonstration.modelled_person import (
    MIN_ELBOW_ANGLE,
    REACH_LIMIT,
    ModelledPerson,
    elbow_position,
    held_interval,
    hold_and_place,
    minimum_jerk,
)
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import HANDS, LINKS


def link_lengths(x):
    return np.stack([np.linalg.norm(x[:, link.b] - x[:, link.a], axis=-1) for link in LINKS], axis=-1)


def check_truth(person, t, x):
    """What every modelled motion promises."""
    lengths = link_lengths(x)
    np.testing.assert_allclose(lengths[:, [0, 4]], person.upper_arm, atol=1e-12)
    np.testing.assert_allclose(lengths[:, [1, 3]], person.forearm, atol=1e-12)
    start, end = held_interval(t[-1])
    held = (t >= start) & (t <= end)
    np.testing.assert_allclose(lengths[held, HANDS], person.box_width, atol=1e-12)
    reach = np.linalg.norm(x[:, [2, 5]] - x[:, [0, 3]], axis=-1)
    upper, fore = person.upper_arm, person.forearm
    assert reach.max() <= REACH_LIMIT * (upper + fore) + 1e-12
    assert reach.min() >= np.sqrt(upper**2 + fore**2 - 2 * upper * fore * np.cos(MIN_ELBOW_ANGLE)) - 1e-12


def test_default_motion_is_exact():
    t, x = hold_and_place()
    assert t[0] == 0.0
    assert t[-1] == pytest.approx(8.0)
    assert len(t) == 241
    check_truth(ModelledPerson(), t, x)


def test_box_is_lifted_carried_and_put_down_at_the_same_height():
    t, x = hold_and_place(rate_hz=100.0)
    start, end = held_interval()
    middle = x[:, [2, 5]].mean(axis=1)[(t >= start) & (t <= end)]
    assert np.ptp(middle[:, 2]) >= 0.25
    assert 0.25 <= middle[-1, 0] - middle[0, 0] <= 0.30
    assert middle[-1, 2] == pytest.approx(middle[0, 2], abs=1e-9)
    # Nothing slides over the table: sideways motion only well above it.
    sideways = np.gradient(middle[:, 0], 0.01)
    assert np.abs(sideways[middle[:, 2] < middle[0, 2] + 0.02]).max() < 1e-3


def test_hands_are_level_and_the_box_hardly_yaws():
    t, x = hold_and_place()
    np.testing.assert_allclose(x[:, 2, 2], x[:, 5, 2], atol=1e-12)
    start, end = held_interval()
    line = (x[:, 5] - x[:, 2])[(t >= start) & (t <= end)]
    yaw = np.arctan2(line[:, 1], line[:, 0])
    assert np.abs(yaw).max() <= np.deg2rad(10.0)
    assert np.ptp(yaw) > np.deg2rad(5.0)


def test_starts_and_ends_at_rest_with_short_pauses_at_the_box():
    t, x = hold_and_place(rate_hz=200.0)
    speed = np.linalg.norm(np.gradient(x[:, [2, 5]], t, axis=0), axis=-1).max(axis=1)
    assert speed[0] < 1e-6
    assert speed[-1] < 1e-6
    start, end = held_interval()
    for pause in (start, end - 0.35):
        inside = (t >= pause + 0.02) & (t <= pause + 0.33)
        assert speed[inside].max() < 0.005
    np.testing.assert_allclose(x[0, [2, 5]], x[-1, [2, 5]], atol=1e-9)


def test_acceleration_is_continuous():
    # A step in acceleration would not shrink with the sampling time; a bounded jerk makes it shrink in proportion.
    steps = []
    for rate in (250.0, 500.0):
        _, x = hold_and_place(rate_hz=rate)
        acceleration = np.diff(x, 2, axis=0) * rate**2
        assert np.abs(acceleration).max() < 5.0
        steps.append(np.abs(np.diff(acceleration, axis=0)).max())
    assert steps[1] < 0.6 * steps[0]
    assert steps[1] * 500.0 < 30.0


def test_torso_sways_but_not_further_than_asked():
    person = ModelledPerson(sway=0.02)
    _, x = hold_and_place(person)
    still = np.array([-person.shoulder_width / 2, 0.0, person.shoulder_height])
    moved = np.linalg.norm(x[:, 0] - still, axis=-1)
    assert 0.01 < moved.max() <= 0.02
    np.testing.assert_allclose(x[:, 3] - x[:, 0], [[person.shoulder_width, 0.0, 0.0]] * len(x), atol=1e-12)


def test_elbows_hang_outward():
    _, x = hold_and_place()
    for side, (s, e, w) in ((-1.0, (0, 1, 2)), (1.0, (3, 4, 5))):
        middle = (x[:, s] + x[:, w]) / 2
        assert (x[:, e, 2] < middle[:, 2]).all()
        normal = np.cross([0.0, -0.3, -1.0], x[:, w] - x[:, s])  # The swivel's zero plane.
        outward = np.sum((x[:, e] - x[:, s]) * normal, axis=-1) * np.sign(normal[:, 0])
        assert (side * outward > 0).all()


def test_duration_stretches_the_motion():
    _, slow = hold_and_place(rate_hz=30.0, duration_s=8.0)
    t, fast = hold_and_place(rate_hz=60.0, duration_s=4.0)
    assert t[-1] == pytest.approx(4.0)
    np.testing.assert_allclose(fast, slow, atol=1e-12)


def test_the_duration_is_the_persons_unless_one_is_given():
    t, x = hold_and_place(ModelledPerson(duration_s=16.0))
    np.testing.assert_allclose(x[::2], hold_and_place()[1], atol=1e-12)
    assert t[-1] == pytest.approx(16.0)
    assert hold_and_place(ModelledPerson(duration_s=16.0), duration_s=4.0)[0][-1] == pytest.approx(4.0)


@settings(max_examples=60, deadline=None)
@given(
    person=st.builds(
        ModelledPerson,
        upper_arm=st.floats(0.15, 0.40),
        forearm=st.floats(0.15, 0.40),
        shoulder_width=st.floats(0.2, 0.6),
        shoulder_height=st.floats(1.2, 1.7),
        box_width=st.floats(0.1, 0.6),
        grasp_height=st.floats(0.9, 1.3),
        grasp_forward=st.floats(0.1, 0.5),
        lift=st.floats(0.0, 0.5),
        carry_right=st.floats(-0.4, 0.4),
        yaw=st.floats(-0.17, 0.17),
        swivel=st.floats(-0.5, 1.2),
    )
)
def test_any_person_reaches_with_a_bent_elbow_or_is_refused(person):
    try:
        t, x = hold_and_place(person)
    except RecordingError as error:
        assert "wrist is" in str(error)
        assert "\n" not in str(error)
        return
    check_truth(person, t, x)


@settings(max_examples=40, deadline=None)
@given(scale=st.floats(0.9, 1.8), lift=st.floats(0.25, 0.32))
def test_a_scaled_person_at_a_scaled_table_is_never_refused(scale, lift):
    # Not smaller: the opening of the hands and the sway do not scale.
    default = ModelledPerson()
    lengths = ("upper_arm", "forearm", "shoulder_width", "shoulder_height", "grasp_height", "grasp_forward")
    person = ModelledPerson(
        **{name: scale * getattr(default, name) for name in lengths},
        carry_right=scale * default.carry_right,
        box_width=scale * default.box_width,
        lift=scale * lift,
    )
    check_truth(person, *hold_and_place(person))


@given(
    upper=st.floats(0.1, 0.5), fore=st.floats(0.1, 0.5), share=st.floats(0.05, 0.95), swivel=st.floats(-np.pi, np.pi)
)
def test_elbow_keeps_both_bones_at_every_swivel(upper, fore, share, swivel):
    distance = abs(upper - fore) + share * (upper + fore - abs(upper - fore))
    wrist = distance * np.array([0.3, 0.8, -0.4]) / np.linalg.norm([0.3, 0.8, -0.4])
    elbow = elbow_position(np.zeros(3), wrist, upper, fore, swivel, 1.0)
    assert np.linalg.norm(elbow) == pytest.approx(upper, abs=1e-9)
    assert np.linalg.norm(wrist - elbow) == pytest.approx(fore, abs=1e-9)


def test_minimum_jerk_ends():
    u = np.array([-1.0, 0.0, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(minimum_jerk(u), [0.0, 0.0, 0.5, 1.0, 1.0])
    h = 1e-4
    ends = minimum_jerk(np.array([h, 1 - h])) - [0.0, 1.0]
    assert np.abs(ends).max() < 20 * h**3  # Neither velocity nor acceleration.


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"upper_arm": 0.0}, "upper_arm"),
        ({"box_width": -0.3}, "box_width"),
        ({"lift": -0.1}, "lift"),
        ({"yaw": 0.5}, "yaw"),
        ({"sway": np.nan}, "sway"),
        ({"forearm": np.inf}, "forearm"),
        ({"duration_s": 0.0}, "duration_s"),
    ],
)
def test_bad_person_is_named(arguments, word):
    with pytest.raises(RecordingError, match=word):
        ModelledPerson(**arguments)


def test_out_of_reach_says_when_and_which_hand():
    with pytest.raises(RecordingError, match=r"t = .* the (left|right) wrist .* reaches 0\.475 m"):
        hold_and_place(ModelledPerson(grasp_forward=0.6))


@pytest.mark.parametrize(("rate", "duration"), [(0.0, 8.0), (-30.0, 8.0), (30.0, 0.0), (30.0, np.inf), (1.0, 0.5)])
def test_bad_clock_is_refused(rate, duration):
    with pytest.raises(RecordingError, match="rate and duration"):
        hold_and_place(rate_hz=rate, duration_s=duration)
