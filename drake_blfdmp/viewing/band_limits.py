"""The band of the hands' distance in Meshcat: where each hand may be, as a translucent sleeve round their line."""

# pyright: reportArgumentType=false, reportCallIssue=false
# (Drake's own type stubs state array types that no array has.)

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from drake_blfdmp.viewing.looks import BAND_COLOUR, BAND_OPACITY, BAND_RADIUS

_SIDES = (("left", -1.0), ("right", 1.0))
_SHORTEST = 1e-4  # m


class HandsBand:
    """Two sleeves, one at each hand.

    They reach from half the lower to half the upper limit, counted from the middle of both hands. So either hand is
    inside its sleeve if and only if the distance is inside its band.
    """

    def __init__(self, meshcat: Meshcat, path: str = "/hands_band"):
        """Makes both sleeves, unseen until drawn; call it before `meshcat.StartRecording`."""
        self._meshcat, self._path = meshcat, path.rstrip("/")
        red, green, blue = (int(BAND_COLOUR[i : i + 2], 16) / 255 for i in (1, 3, 5))
        for side, _ in _SIDES:
            sleeve = f"{self._path}/{side}/sleeve"
            meshcat.SetObject(sleeve, Cylinder(BAND_RADIUS, 1.0), Rgba(red, green, blue, BAND_OPACITY))
        meshcat.SetProperty(self._path, "visible", False)

    def draw(self, left: np.ndarray, right: np.ndarray, lower: float, upper: float, time: float | None = None) -> None:
        """Moves the sleeves.

        Args:
            left, right: (3,) the hands in W, m.
            lower, upper: limits of their distance, m.
            time: s; with it, what is drawn enters a running recording.
        """
        along = right - left
        if np.linalg.norm(along) < _SHORTEST or not np.isfinite([lower, upper]).all():
            return
        X_WM = RigidTransform(RotationMatrix.MakeFromOneVector(along, 2), (left + right) / 2)
        self._meshcat.SetTransform(self._path, X_WM, time)
        self._meshcat.SetProperty(self._path, "visible", True, time)
        for side, sign in _SIDES:
            middle = RigidTransform([0.0, 0.0, sign * (lower + upper) / 4])
            self._meshcat.SetTransform(f"{self._path}/{side}", middle, time)
            length = max((upper - lower) / 2, _SHORTEST)
            self._meshcat.SetProperty(f"{self._path}/{side}/sleeve", "scale", [1.0, 1.0, length], time)
