import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.bands import make_bands
from drake_blfdmp.skill.laws import LAWS
from drake_blfdmp.skill.laws.gams import GamsGains
from drake_blfdmp.skill.laws.primitive import Primitive
from drake_blfdmp.skill.profiles import ConstantDistance
from drake_blfdmp.systems.point_coupler import PointCoupler

PRIMITIVE = Primitive(4.0, 40.0)
INPUTS = ("position", "velocity", "nominal_acceleration")
BANDS = make_bands(0.22, 0.28, ConstantDistance(0.3)).evaluate(0.5)


def fixed(name, time_step, gains=None):
    system = PointCoupler(law=LAWS[name], primitive=PRIMITIVE, gains=gains, time_step=time_step)
    context = system.CreateDefaultContext()
    values = [np.random.default_rng(i).normal(size=(6, 3)) for i in range(3)]
    for port, value in zip(INPUTS, values, strict=True):
        system.GetInputPort(port).FixValue(context, value.reshape(18))
    system.GetInputPort("bands").FixValue(context, BANDS.reshape(30))
    return system, context, values


@pytest.mark.parametrize("name", [name for name in LAWS if name != "published_lagged"])
@pytest.mark.parametrize("time_step", [0.0, 0.004])
def test_the_output_is_the_law(name, time_step):
    system, context, values = fixed(name, time_step)
    expected = LAWS[name](*values, np.zeros((6, 3)), BANDS, PRIMITIVE)
    np.testing.assert_array_equal(system.get_output_port().Eval(context).reshape(6, 3), expected)


def test_gains_are_passed_on():
    system, context, values = fixed("gams", 0.0, GamsGains(7.0, 3.0))
    expected = LAWS["gams"](*values, np.zeros((6, 3)), BANDS, PRIMITIVE, GamsGains(7.0, 3.0))
    np.testing.assert_array_equal(system.get_output_port().Eval(context).reshape(6, 3), expected)


def test_the_lagged_law_remembers_the_acceleration_it_took():
    system, context, values = fixed("published_lagged", 0.1)
    simulator = Simulator(system, context)
    simulator.Initialize()
    previous, law = np.zeros((6, 3)), LAWS["published_lagged"]
    for k in range(4):
        if k:
            simulator.AdvanceTo(0.1 * k - 0.05)  # Past the update at 0.1 (k - 1).
        coupling = law(*values, previous, BANDS, PRIMITIVE)
        np.testing.assert_allclose(system.get_output_port().Eval(context).reshape(6, 3), coupling, rtol=1e-12)
        previous = values[2] + coupling


def test_the_lagged_law_needs_samples():
    with pytest.raises(ScenarioError, match="published_lagged lives on samples; give the skill a time step above 0"):
        PointCoupler(law=LAWS["published_lagged"], primitive=PRIMITIVE)
