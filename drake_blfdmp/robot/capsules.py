"""Distances of capsules, in closed form.

Drake's own query for overlapping capsules may never return (1.51 and 1.58, some configurations), so overlaps of the
arms' capsules are found here first.
"""

import numpy as np
from pydrake.geometry import Capsule, GeometryId, SceneGraphInspector
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Context

from drake_blfdmp.vectors import dot


def segment_distances(a, b, c, d):
    """Distances (...) of the segments from a to b and from c to d, each (..., 3), m."""
    u, v, w = b - a, d - c, a - c
    uu, uv, vv, uw, vw = dot(u, u), dot(u, v), dot(v, v), dot(u, w), dot(v, w)
    tiny = np.finfo(float).tiny
    denominator = uu * vv - uv * uv
    s = np.where(denominator > 1e-12 * uu * vv, (uv * vw - vv * uw) / np.maximum(denominator, tiny), 0.0).clip(0.0, 1.0)
    # The nearest point of the second line to that of the first, kept on its segment, and the first's to that again.
    t = ((uv * s + vw) / np.maximum(vv, tiny)).clip(0.0, 1.0)
    s = ((uv * t - uw) / np.maximum(uu, tiny)).clip(0.0, 1.0)
    between = w + s[..., None] * u - t[..., None] * v
    return np.sqrt(dot(between, between))


def _squares(one, other):
    """Squares of the distances of points (n, K, 3) and (m, K, 3): (K, n, m), m^2."""
    one, other = one.swapaxes(0, 1), other.swapaxes(0, 1)
    return dot(one, one)[:, :, None] + dot(other, other)[:, None] - 2.0 * (one @ other.swapaxes(1, 2))


BLOCK = 32
"""So many pairs of capsules are looked at at once, of many postures."""


class CapsulePairs:
    """The pairs of capsules of a plant that may collide."""

    def __init__(self, plant: MultibodyPlant, inspector: SceneGraphInspector):
        """As the inspector's collision filters have it."""
        self._plant = plant
        self.pairs: list[tuple[GeometryId, GeometryId]] = [
            pair
            for pair in sorted(inspector.GetCollisionCandidates(), key=lambda pair: [id.get_value() for id in pair])
            if all(isinstance(inspector.GetShape(id), Capsule) for id in pair)
        ]
        ids = sorted({id for pair in self.pairs for id in pair}, key=GeometryId.get_value)
        row = {id.get_value(): k for k, id in enumerate(ids)}
        carriers = [plant.GetBodyFromFrameId(inspector.GetFrameId(id)) for id in ids]
        indices = [int(body.index()) for body in carriers]
        bodies, self._carrier = np.unique(indices, return_inverse=True)
        self._bodies = [carriers[indices.index(index)] for index in bodies]
        self._instances = np.array([int(body.model_instance()) for body in carriers], dtype=int)
        self._ends, self._radii = np.empty((len(ids), 2, 3)), np.empty(len(ids))
        for k, id in enumerate(ids):
            shape, X_BG = inspector.GetShape(id), inspector.GetPoseInFrame(id)
            half = np.array([0.0, 0.0, 0.5 * shape.length()])
            self._ends[k] = X_BG @ -half, X_BG @ half
            self._radii[k] = shape.radius()
        self._first, self._second = (
            np.array([row[pair[i].get_value()] for pair in self.pairs], dtype=int) for i in range(2)
        )
        size = 0.5 * np.linalg.norm(self._ends[:, 1] - self._ends[:, 0], axis=1) + self._radii
        self._spheres = (size[self._first] + size[self._second]) ** 2  # Farther apart no pair overlaps.

    def distances(self, context: Context) -> np.ndarray:
        """Signed distances, m, of `pairs`, negative where they overlap."""
        return self._signed(self.ends(context), np.arange(len(self.pairs)))

    def deepest(self, context: Context) -> tuple[float, tuple[GeometryId, GeometryId]] | None:
        """The pair that overlaps most and its negative distance, m; None where no pair overlaps."""
        ends = self.ends(context)
        apart = (ends.sum(axis=1)[self._first] - ends.sum(axis=1)[self._second]) * 0.5
        near = np.flatnonzero(dot(apart, apart) <= self._spheres)
        signed = self._signed(ends, near)
        if not np.any(signed <= 0.0):
            return None
        return float(signed.min()), self.pairs[near[signed.argmin()]]

    def overlapping(
        self, one: ModelInstanceIndex, other: ModelInstanceIndex, ends_one, ends_other, clearance: float = 0.0
    ) -> np.ndarray:
        """Which of n postures of a model overlap which of m of another, or themselves: (n, m).

        Args:
            one: a model.
            other: another; the plant's capsules are theirs.
            ends_one: (n, G, 2, 3) `ends` in n postures of the one, m.
            ends_other: (m, G, 2, 3) in m postures of the other, m.
            clearance: nearer than that, m, counts as overlapping.
        """
        models = self._instances[self._first], self._instances[self._second]
        own = [
            self._any_overlap(ends, np.flatnonzero((models[0] == int(model)) & (models[1] == int(model))), clearance)
            for model, ends in ((one, ends_one), (other, ends_other))
        ]
        overlap = own[0][:, None] | own[1]
        across = np.flatnonzero(models[0] != models[1])
        swapped = models[0][across] != int(one)
        mine = np.where(swapped, self._second[across], self._first[across])
        its = np.where(swapped, self._first[across], self._second[across])
        radii = self._radii[mine] + self._radii[its] + clearance
        spheres = (np.sqrt(self._spheres[across]) + clearance) ** 2
        centres_one, centres_other = (0.5 * (ends[:, :, 0] + ends[:, :, 1]) for ends in (ends_one, ends_other))
        for block in np.split(np.arange(len(across)), range(BLOCK, len(across), BLOCK)):
            # What overlaps already need not be looked at again, so not all at once.
            squares = _squares(centres_one[:, mine[block]], centres_other[:, its[block]])
            k, i, j = np.nonzero((squares <= spheres[block, None, None]) & ~overlap)
            (a, b), (c, d) = ends_one[i, mine[block][k]].swapaxes(0, 1), ends_other[j, its[block][k]].swapaxes(0, 1)
            hit = segment_distances(a, b, c, d) <= radii[block][k]
            overlap[i[hit], j[hit]] = True
        return overlap

    def _any_overlap(self, ends: np.ndarray, chosen: np.ndarray, clearance: float) -> np.ndarray:
        """Whether any of the chosen pairs comes that near, in n postures with `ends` (n, G, 2, 3): (n,)."""
        first, second = self._first[chosen], self._second[chosen]
        a, b, c, d = (ends[:, rows, i] for rows in (first, second) for i in range(2))
        near = self._radii[first] + self._radii[second] + clearance
        return np.any(segment_distances(a, b, c, d) <= near, axis=1)

    def ends(self, context: Context) -> np.ndarray:
        """Where each of the G capsules' segments ends: (G, 2, 3), m in W."""
        poses = [self._plant.EvalBodyPoseInWorld(context, body) for body in self._bodies]
        turns = np.array([pose.rotation().matrix() for pose in poses])[self._carrier]
        origins = np.array([pose.translation() for pose in poses])[self._carrier]
        return origins[:, None] + self._ends @ turns.swapaxes(1, 2)

    def _signed(self, ends: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        first, second = self._first[chosen], self._second[chosen]
        a, b, c, d = (ends[rows, i] for rows in (first, second) for i in range(2))
        return segment_distances(a, b, c, d) - self._radii[first] - self._radii[second]
