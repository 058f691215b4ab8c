import numpy as np
import pytest
from synthetic_carry import carry

from drake_blfdmp.demonstration.length_unit import METRES, find_length_unit
from drake_blfdmp.errors import RecordingError

_, X = carry(duration=2.0)
FRAMES = np.arange(len(X))


@pytest.mark.parametrize("size", [0.6, 1.0, 1.6])
@pytest.mark.parametrize("unit", list(METRES))
def test_the_arms_tell_the_unit(unit, size):
    found = find_length_unit("a", size * X / METRES[unit], FRAMES)
    assert found.unit == unit
    assert "upper arms measure" in found.evidence


def test_the_arms_overrule_a_file_that_is_wrong_and_say_so():
    found = find_length_unit("a", X, FRAMES, stated="mm")
    assert found.unit == "m"
    assert "although" in found.evidence and "mm" in found.evidence
    assert find_length_unit("a", X, FRAMES, stated="m").evidence.startswith("unit: m, the file or its format says")


def test_nothing_overrules_the_user():
    assert find_length_unit("a", X, FRAMES, stated="m", given="cm") == ("cm", "unit: cm, as set")


@pytest.mark.parametrize("x", [np.full_like(X, np.nan), np.zeros_like(X), 20.0 * X])
def test_arms_that_tell_nothing_leave_what_is_stated(x):
    assert find_length_unit("a", x, FRAMES, stated="cm").unit == "cm"
    assert find_length_unit("a", x, FRAMES).unit == "m"


def test_a_change_of_unit_is_refused_with_its_frame():
    x = X.copy()
    x[40:] *= 1000.0
    with pytest.raises(
        RecordingError, match=r"^a: the units are mixed: at frame 140 .* \(mm\), elsewhere they are in m"
    ):
        find_length_unit("a", x, 100 + FRAMES)


def test_a_jump_of_the_sensor_is_no_change_of_unit():
    x = X.copy()
    x[20:22] *= 100.0
    assert find_length_unit("a", x, FRAMES).unit == "m"
