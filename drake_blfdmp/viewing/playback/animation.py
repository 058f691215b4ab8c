"""What changes in a scene, as Meshcat's viewer animates it: one clip a path, one track a property.

Keys are kept as arrays and packed in base64: as Meshcat's own list of {time, value} they would take ten times as much.
"""

import base64
from typing import Any

import numpy as np


def packed(numbers) -> str:
    """Numbers as little-endian float32 in base64."""
    return base64.b64encode(np.ascontiguousarray(numbers, dtype="<f4").tobytes()).decode("ascii")


class Tracks:
    """Collects tracks; times of one and the same array are stored once."""

    def __init__(self):
        self._times: dict[str, int] = {}
        self._clips: dict[str, list[dict[str, Any]]] = {}
        self.end = 0.0

    def add(self, path: str, name: str, kind: str, times: np.ndarray, values: np.ndarray) -> None:
        """A property (position, quaternion, scale) with values (F, n) at increasing times (F,), s.

        Between keys three.js interpolates: straight, and quaternions on the sphere.
        """
        self._clips.setdefault(path, []).append(
            {"name": name, "type": kind, "times": self._time(times), "values": packed(values)}
        )

    def add_switch(self, path: str, name: str, times: np.ndarray, values: np.ndarray) -> None:
        """A property that is true or false (F,) from each of the times (F,), s, on."""
        self._clips.setdefault(path, []).append(
            {"name": name, "type": "bool", "times": self._time(times), "values": [bool(value) for value in values]}
        )

    def __len__(self) -> int:
        return sum(map(len, self._clips.values()))

    def lower(self) -> dict[str, Any]:
        """Tracks as the page's script takes them: a list of times, and path -> tracks that refer to it."""
        return {"times": list(self._times), "clips": self._clips}

    def _time(self, times: np.ndarray) -> int:
        self.end = max(self.end, float(times[-1]))
        return self._times.setdefault(packed(times), len(self._times))
