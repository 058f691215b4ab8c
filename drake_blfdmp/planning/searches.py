"""How places for the arms are looked for at a given scale, the quickest way first."""

from collections.abc import Mapping
from typing import Any, Literal

from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.robot.reach import CALM

Search = Literal["near", "wide", "led"]
NEAR: Search = "near"
WIDE: Search = "wide"
LED: Search = "led"

SEARCHES: Mapping[Search, Mapping[str, Any]] = {
    NEAR: {"calms": CALM[-1:]},
    WIDE: {"calms": CALM[-1:], "wide": True},
    LED: {"calms": CALM[-1:], "led": True},
}
"""Options of `FindReach`: near by, farther around, and with elbows that are led another way than the person's."""


def MayBe(search: Search, scenario: Scenario) -> bool:
    """Whether a scenario leaves a search its freedom: the place, or elbows held up and hands that need not turn."""
    if search == WIDE:
        return scenario.retarget.world is None
    if search == LED:
        return scenario.retarget.elbow_up and scenario.task.place_rotation[2] == 0.0
    return True
