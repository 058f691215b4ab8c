"""The box around everything that is drawn, from which floor and camera follow."""

import numpy as np


class Bounds:
    """Grows with every point it is told of, m."""

    def __init__(self):
        self.low, self.high = np.full(3, np.inf), np.full(3, -np.inf)

    def include(self, points, radius: float = 0.0) -> None:
        """Points (..., 3) with `radius` around each."""
        points = np.asarray(points, dtype=float).reshape(-1, 3)
        points = points[np.isfinite(points).all(axis=-1)]
        if len(points):
            self.low = np.minimum(self.low, points.min(axis=0) - radius)
            self.high = np.maximum(self.high, points.max(axis=0) + radius)

    @property
    def empty(self) -> bool:
        """Whether it has been told of nothing."""
        return not np.isfinite(self.low).all()

    @property
    def middle(self) -> np.ndarray:
        """(3,) m."""
        return np.zeros(3) if self.empty else (self.low + self.high) / 2

    @property
    def radius(self) -> float:
        """Of the ball around the box, m."""
        return 1.0 if self.empty else max(float(np.linalg.norm(self.high - self.low)) / 2, 0.1)

    def corners(self) -> np.ndarray:
        """(8, 3) m."""
        ends = np.stack([self.low, self.high])
        return np.array([[ends[i, 0], ends[j, 1], ends[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
