"""`synthetic.sensor`: who films the modelled person."""

from dataclasses import replace

import numpy as np
import pytest

from drake_blfdmp.demonstration.sensors import SENSORS
from drake_blfdmp.demonstration.virtual_kinect import record_hold_and_place
from drake_blfdmp.planning.scenario import Scenario, SyntheticConfig
from drake_blfdmp.planning.scenario_sections import SENSOR_NAMES
from drake_blfdmp.planning.sources import ReadRecordings


@pytest.mark.parametrize("name", SENSOR_NAMES)
def test_the_sensor_of_that_name_films_every_take(name):
    found = ReadRecordings(replace(Scenario(seed=3), synthetic=SyntheticConfig(sensor=name, takes=2)))
    for k, recording in enumerate(found):
        expected, _ = record_hold_and_place(sensor=SENSORS.get(name), seed=3 + k)
        np.testing.assert_array_equal(recording.x, expected.x)
        np.testing.assert_array_equal(recording.t, expected.t)


def test_the_default_is_the_steady_one_and_every_other_errs_otherwise():
    assert Scenario().synthetic.sensor == "steady" and "steady" not in SENSORS
    steady = ReadRecordings(Scenario())[0]
    for name in SENSORS:
        other = ReadRecordings(replace(Scenario(), synthetic=SyntheticConfig(sensor=name)))[0]
        assert other.x.shape != steady.x.shape or np.nanmax(np.abs(other.x - steady.x)) > 0.01
