"""Sliders and buttons beside a Meshcat scene, by which someone who looks on takes part in a run."""

# pyright: reportArgumentType=false, reportCallIssue=false
# (Drake's own type stubs state array types that no array has.)

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Box, Meshcat, Rgba
from pydrake.math import RigidTransform, RollPitchYaw

PAUSE, CONTINUE = "Pause", "Continue"
"""One button, with either of these labels."""

KEY = "KeyP"
"""The key that clicks it, as browsers call it."""

SPEED = "speed (0: full)"
"""The label of the slider for simulated time a second of wall time; a longer one would be cut off."""

SPEEDS = (0.0, 2.0, 0.5)
"""Lowest, highest and step of that slider; 0 waits for nothing."""

_PLACE = "/live/place"
_PLACE_COLOR, _PLACE_THICKNESS = Rgba(0.0, 0.62, 0.45, 0.65), 0.002  # m


@dataclass(frozen=True)
class Place:
    """Where something is put down, for the mark that shows it.

    Attributes:
        middle: (3,) of its lower face in W, m.
        yaw: rad.
        size: (2,) along its x and y, m.
    """

    middle: np.ndarray
    yaw: float
    size: tuple[float, float]


def goal_slider(axis: str) -> str:
    """The label of the slider for an axis of the goal."""
    return f"goal {axis} (m)"


class LiveControls:
    """The controls of one run; all of them are read, none calls back.

    Each slider of the goal shows a coordinate in W; until it is moved, that of the multiple of its step nearest to the
    planned one.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        *,
        goal: Mapping[str, tuple[float, float, float]],
        step: float,
        pushes: Sequence[str],
        place: Place | None = None,
    ):
        """Add the controls.

        Args:
            meshcat: the viewer.
            goal: axis of W -> the planned coordinate, m, and how far it may be lowered (<= 0) and raised (>= 0), m. An
                axis that may be moved by less than a step gets no slider.
            step: of the goal's sliders, m.
            pushes: labels of the buttons that push.
            place: marked on its table, where the goal's x and y are moved to.
        """
        self._meshcat, self._place = meshcat, place
        self._clicks = dict.fromkeys(pushes, 0)
        self._planned: dict[str, tuple[float, float]] = {}  # In the plan, and as the slider shows it.
        for axis, (value, lowest, highest) in goal.items():
            # The browser's slider knows the multiples of its step alone.
            near = round(value / step)
            least = min(near, math.ceil((value + lowest) / step))
            most = max(near, math.floor((value + highest) / step))
            if most > least:
                shown = meshcat.AddSlider(goal_slider(axis), step * least, step * most, step, step * near)
                self._planned[axis] = value, shown
        self._offset = np.zeros(3)
        meshcat.AddSlider(SPEED, *SPEEDS, 0.0)
        for label in self._clicks:
            meshcat.AddButton(label)
        # The last one, so that the others stay where they are when its label changes.
        meshcat.AddButton(PAUSE, KEY)
        self._paused = False
        if place is not None and self._planned:
            meshcat.SetObject(_PLACE, Box(*place.size, _PLACE_THICKNESS), _PLACE_COLOR)
            self._show_place()

    @property
    def movable(self) -> bool:
        """Whether the goal has sliders."""
        return bool(self._planned)

    def goal_offset(self) -> np.ndarray:
        """How far the goal is wanted from where it was planned: (3,), m along W's axes; moves the mark with it."""
        for axis, (planned, shown) in self._planned.items():
            value = self._meshcat.GetSliderValue(goal_slider(axis))
            self._offset["xyz".index(axis)] = 0.0 if value == shown else value - planned
        if self._planned:
            self._show_place()
        return self._offset.copy()

    def delete_goal(self, offset: np.ndarray) -> None:
        """Take the goal's sliders away, as it cannot be moved any more, and leave the mark at its offset (3,), m."""
        for axis in self._planned:
            self._meshcat.DeleteSlider(goal_slider(axis))
        self._planned = {}
        self._offset = np.array(offset)
        self._show_place()

    def pushed(self) -> list[str]:
        """The labels of the buttons clicked since this was asked last."""
        clicks = {label: self._meshcat.GetButtonClicks(label) for label in self._clicks}
        clicked = [label for label, count in clicks.items() if count > self._clicks[label]]
        self._clicks = clicks
        return clicked

    def paused(self) -> bool:
        """Whether the run shall stand still; several clicks on one label count as one."""
        if self._meshcat.GetButtonClicks(CONTINUE if self._paused else PAUSE):
            self._meshcat.DeleteButton(CONTINUE if self._paused else PAUSE)
            self._paused = not self._paused
            self._meshcat.AddButton(CONTINUE if self._paused else PAUSE, KEY)
        return self._paused

    def speed(self) -> float:
        """The wanted simulated time a second of wall time; 0 for as much as there can be."""
        return self._meshcat.GetSliderValue(SPEED)

    def delete(self) -> None:
        """Take all controls and the mark away."""
        self._meshcat.DeleteAddedControls()
        self._meshcat.Delete("/live")

    def _show_place(self) -> None:
        if self._place is None:
            return
        middle = np.asarray(self._place.middle) + self._offset + [0.0, 0.0, 0.5 * _PLACE_THICKNESS]
        self._meshcat.SetTransform(_PLACE, RigidTransform(RollPitchYaw(0.0, 0.0, self._place.yaw), middle))
