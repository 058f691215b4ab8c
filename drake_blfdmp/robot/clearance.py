"""The least distance between bodies that must not touch."""

from collections.abc import Sequence
from itertools import zip_longest

import numpy as np
from pydrake.geometry import CollisionFilterDeclaration, GeometrySet, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from drake_blfdmp.errors import TaskError
from drake_blfdmp.robot.box import AddBox, AddTable, BoxParameters, TableParameters
from drake_blfdmp.robot.capsules import CapsulePairs
from drake_blfdmp.robot.plant import AddDualPanda

SECOND_NEIGHBOURS = (
    *((f"panda_link{k}", f"panda_link{k + 2}") for k in range(6)),
    ("panda_link6", "palm"),
)


class ClearanceChecker:
    """Distances among both arms, their pedestals, the tables and, if given, the box.

    Not counted, because they touch by purpose: palms and box, box and tables. Not counted, because their distance says
    nothing: what is joined or stands still relative to each other, and links of one arm with one link between, which
    are always near and cannot touch within the joint limits. The box against the rest of the arms does count.

    Attributes:
        plant: the plant behind it, finalized; its positions are q (14), then the box's seven.
    """

    def __init__(
        self,
        supports: Sequence[TableParameters] = (),
        box: BoxParameters | None = None,
        max_distance: float = 0.2,
        among_arms: bool = True,
    ):
        """Builds the scene.

        Args:
            supports: the tables.
            box: the box, or None to leave it out.
            max_distance: m; farther pairs are not looked at, which is what makes a query cheap.
            among_arms: False counts no distances within an arm nor between the two.

        Raises:
            TaskError: `max_distance` is not > 0.
        """
        if not max_distance > 0:
            raise TaskError(f"clearance max_distance: {max_distance} must be > 0")
        self._max_distance = max_distance
        builder = DiagramBuilder()
        self.plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
        self._arms = AddDualPanda(self.plant)
        tables = [AddTable(self.plant, support) for support in supports]
        self._box = None if box is None else AddBox(self.plant, box)
        self.plant.Finalize()

        self._box_ids = set()
        if self._box is not None:
            self._box_ids = set(self._geometries([self._box]))
            touching = [self.plant.GetBodyByName("palm", arm) for arm in self._arms] + tables
            scene_graph.collision_filter_manager().Apply(
                CollisionFilterDeclaration().ExcludeBetween(
                    GeometrySet(list(self._box_ids)), GeometrySet(self._geometries(touching))
                )
            )
        self._exclude_second_neighbours(scene_graph)
        if not among_arms:
            links = GeometrySet([id for arm in self._arms for id in self._arm_ids(arm)])
            scene_graph.collision_filter_manager().Apply(CollisionFilterDeclaration().ExcludeWithin(links))
        inspector = scene_graph.model_inspector()
        self._capsules = CapsulePairs(self.plant, inspector)
        self._name = {}
        for id in inspector.GetAllGeometryIds():
            body = self.plant.GetBodyFromFrameId(inspector.GetFrameId(id))
            instance = self.plant.GetModelInstanceName(body.model_instance())
            self._name[id] = instance if instance == body.name() else f"{instance}::{body.name()}"

        self._arm_of = {
            id: k for k, arm in enumerate(self._arms) for id in self._arm_ids(arm) if "palm" not in self._name[id]
        }
        self._diagram = builder.Build()
        context = self._diagram.CreateDefaultContext()
        self._plant_context = self.plant.GetMyMutableContextFromRoot(context)
        self._scene_context = scene_graph.GetMyContextFromRoot(context)
        self._query_port = scene_graph.get_query_output_port()
        self._context = context

    def _geometries(self, bodies: Sequence[RigidBody]) -> list:
        return [id for body in bodies for id in self.plant.GetCollisionGeometriesForBody(body)]

    def _arm_ids(self, arm: ModelInstanceIndex) -> list:
        return self._geometries([self.plant.get_body(index) for index in self.plant.GetBodyIndices(arm)])

    def _exclude_second_neighbours(self, scene_graph: SceneGraph) -> None:
        manager = scene_graph.collision_filter_manager()
        for arm in self._arms:
            for pair in SECOND_NEIGHBOURS:
                a, b = (GeometrySet(self._geometries([self.plant.GetBodyByName(name, arm)])) for name in pair)
                manager.Apply(CollisionFilterDeclaration().ExcludeBetween(a, b))

    def min_clearance(self, q: np.ndarray, X_WB: RigidTransform | None = None) -> tuple[float, tuple[str, str]]:
        """The closest pair of bodies.

        Args:
            q: (14,) joint angles, left arm first, rad.
            X_WB: the box's pose; None leaves the box out of account.

        Returns:
            The signed distance, m (negative: overlap), and two names, as `left_arm::panda_link5` or `table`. When
            nothing is nearer than `max_distance`: `max_distance` and two empty names.

        Raises:
            TaskError: q has the wrong shape or is not finite, or X_WB is given to a checker without a box.
        """
        self._set(q, X_WB)
        if (deepest := self._capsules.deepest(self._plant_context)) is not None:
            distance, pair = deepest
            return distance, (self._name[pair[0]], self._name[pair[1]])
        query = self._query_port.Eval(self._scene_context)
        ignored = self._box_ids if X_WB is None else frozenset()
        closest, names = self._max_distance, ("", "")
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(self._max_distance):
            if pair.distance < closest and pair.id_A not in ignored and pair.id_B not in ignored:
                closest, names = pair.distance, (self._name[pair.id_A], self._name[pair.id_B])
        return float(closest), names

    def link_clearances(self, q: np.ndarray, X_WB: RigidTransform | None = None) -> np.ndarray:
        """The least distance (2,) of each arm's links, but for its palm, from what stands around, m.

        Of a checker with `among_arms` False; args and errors as of `min_clearance`.
        """
        self._set(q, X_WB)
        query = self._query_port.Eval(self._scene_context)
        ignored = self._box_ids if X_WB is None else frozenset()
        closest = np.full(2, self._max_distance)
        for pair in query.ComputeSignedDistancePairwiseClosestPoints(self._max_distance):
            for own, other in ((pair.id_A, pair.id_B), (pair.id_B, pair.id_A)):
                arm = self._arm_of.get(own)
                if arm is not None and other not in ignored:
                    closest[arm] = min(closest[arm], pair.distance)
        return closest

    def _set(self, q, X_WB: RigidTransform | None) -> None:
        q = np.asarray(q, dtype=float)
        if q.shape != (14,) or not np.all(np.isfinite(q)):
            raise TaskError(f"clearance: q of shape {q.shape} must be 14 finite joint angles")
        for arm, q_arm in zip(self._arms, (q[:7], q[7:]), strict=True):
            self.plant.SetPositions(self._plant_context, arm, q_arm)
        if X_WB is not None:
            if self._box is None:
                raise TaskError("clearance: a box pose was given to a checker built without a box; pass box=...")
            self.plant.SetFreeBodyPose(self._plant_context, self._box, X_WB)

    def overlapping(self, left, right, clearance: float = 0.0) -> np.ndarray:
        """In which pairs of n postures of the left arm and m of the right one capsules overlap, of one arm or of both.

        What has no capsules does not count: palms' rims, pedestals, tables and the box (`min_clearance`).

        Args:
            left: (n, 7) rad.
            right: (m, 7) rad.
            clearance: nearer than that, m, counts as overlapping.

        Returns:
            (n, m) booleans.
        """
        both = np.array([self._ends(*pair) for pair in zip_longest(left, right)])
        ends = both[: len(left)], both[: len(right)]
        return self._capsules.overlapping(*self._arms, *ends, clearance)

    def _ends(self, *postures) -> np.ndarray:
        """In a posture of either arm; None leaves one as it is."""
        for arm, q in zip(self._arms, postures, strict=True):
            if q is not None:
                self.plant.SetPositions(self._plant_context, arm, q)
        return self._capsules.ends(self._plant_context)
