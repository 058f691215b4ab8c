import numpy as np
import pytest
from made_files import JOINT_STATE, STORE, TF, MadeFile, header

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.sampling import TopicSampler

SECOND = 1_000_000_000


def joints(names, values, velocity=()):
    kind = STORE.types[JOINT_STATE]
    made = kind(header(0), list(names), np.array(values, float), np.array(velocity, float), np.zeros(0))
    return bytes(STORE.serialize_cdr(made, JOINT_STATE))


def sampler(times, kind=JOINT_STATE):
    return TopicSampler("file: /topic", kind, np.round(np.asarray(times) * SECOND).astype(np.int64))


def test_values_lie_between_their_neighbours_and_are_held_outside():
    s = sampler([0.0, 0.15, 0.25, 0.4, 5.0])
    for t, x in ((0.1, 1.0), (0.2, 2.0), (0.3, 4.0)):
        s.add(round(t * SECOND), joints(["a", "b"], [x, -x]))
    series = s.finish()
    assert np.allclose(series[("a",)][:, 0], [1.0, 1.5, 3.0, 4.0, 4.0])
    assert np.allclose(series[("b",)], -series[("a",)])


def test_across_a_long_gap_the_earlier_value_is_held():
    s = sampler([0.0, 1.0, 2.999, 3.0])
    s.add(0, joints(["a"], [1.0]))
    s.add(3 * SECOND, joints(["a"], [4.0]))
    assert np.allclose(s.finish()[("a",)][:, 0], [1.0, 1.0, 1.0, 4.0])


def test_names_in_another_order_and_spread_over_messages_are_put_together():
    times = np.linspace(0.0, 1.0, 21)
    s = sampler(times)
    for k in range(101):
        t = k / 100
        at = k * SECOND // 100
        if k % 3 == 0:
            s.add(at, joints(["a", "b"], [t, 2 * t]))
        elif k % 3 == 1:
            s.add(at, joints(["b", "a"], [2 * t, t], velocity=[0.0, 0.0]))
        else:
            s.add(at, joints(["c"], [3 * t]))
    series = s.finish()
    for name, factor in (("a", 1), ("b", 2), ("c", 3)):
        assert np.allclose(series[(name,)][1:-1, 0], factor * times[1:-1], atol=1e-9)


def test_numbers_that_are_not_finite_count_as_not_there():
    s = sampler([0.0, 0.1, 0.2, 0.3])
    for k, x in enumerate([np.nan, 1.0, np.inf, 3.0]):
        s.add(k * SECOND // 10, joints(["a", "never"], [x, np.nan]))
    series = s.finish()
    assert np.allclose(series[("a",)][:, 0], [1.0, 1.0, 1.0, 3.0])
    assert ("never",) not in series


def test_messages_without_positions_are_passed_over():
    s = sampler([0.0, 1.0])
    s.add(0, joints(["a"], [], velocity=[1.0]))
    assert s.finish() == {}


def test_quaternions_turn_the_short_way(tmp_path):
    with MadeFile(tmp_path / "x.mcap") as file:
        made = []
        file.message = lambda topic, kind, t, message: made.append(bytes(STORE.serialize_cdr(message, TF)))
        file.transforms(0.0, [("/w", "/b", [0, 0, 0, 0, 0, 0, 1.0])])
        file.transforms(0.0, [("/w", "/b", [1, 0, 0, 0, 0, -np.sin(0.5), -np.cos(0.5)])])
    s = sampler([0.5], TF)
    s.add(0, made[0])
    s.add(SECOND, made[1])
    expected = [0.5, 0, 0, 0, 0, np.sin(0.25), np.cos(0.25)]
    assert np.allclose(s.finish()[("w", "b")], [expected]), "and slashes before frames are dropped"


def test_a_little_late_is_left_out_and_counted_and_time_that_goes_back_is_refused():
    s = sampler([0.0, 1.0])
    s.add(SECOND, joints(["a"], [1.0]))
    s.add(SECOND - 1000, joints(["a"], [7.0]))
    assert s.late == 1 and np.allclose(s.finish()[("a",)], 1.0)
    with pytest.raises(BlfDmpError, match=r"file: /topic: time goes back from 1.000 s to 0.100 s"):
        s.add(SECOND // 10, joints(["a"], [1.0]))


@pytest.mark.parametrize("message", [b"", b"\x00\x00\x00\x00", joints(["a"], [1.0])[:40], joints(["a"], [1.0]) * 2])
def test_bytes_that_are_no_such_message_are_refused_in_one_line(message):
    with pytest.raises(BlfDmpError, match="file: /topic: a message is no sensor_msgs") as error:
        sampler([0.0]).add(0, message)
    assert "\n" not in str(error.value)


def test_endless_new_names_are_refused():
    s = sampler([0.0, 1.0])
    with pytest.raises(BlfDmpError, match="different sets of names"):
        for k in range(1000):
            s.add(k, joints([f"a{k}"], [1.0]))
