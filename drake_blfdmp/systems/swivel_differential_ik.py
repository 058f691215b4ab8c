"""Differential inverse kinematics of both arms with the swivel angle in the null space; (18), (19)."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.errors import ScenarioError, TaskError
from drake_blfdmp.robot.differential_ik import DEFAULT_GAINS, IkGains
from drake_blfdmp.robot.kinematics import DualArmKinematics
from drake_blfdmp.robot.pair_clearance import NEAR_SIZE
from drake_blfdmp.robot.plant import JointLimits
from drake_blfdmp.robot.tempo import next_tempo
from drake_blfdmp.robot.tracking import DualArmTracker


class SwivelDifferentialIk(LeafSystem):
    """Joint positions and velocities that follow palm poses and, beneath them, swivel angles (`robot.tracking`).

    .. pydrake_system::

        name: SwivelDifferentialIk
        input_ports:
        - palm_poses
        - palm_twists
        - swivel
        - swivel_rate
        - measured_position (optional)
        output_ports:
        - position
        - velocity
        - desired_state_left
        - desired_state_right
        - task_scale
        - swivel_now
        - task_deviation
        - tempo
        - clearance
        - commanded_palms

    Discrete state: q (14), v (14), task_scale (2), swivel (2), task_deviation (2), tempo (1), clearance (1),
    commanded_palms (6) and, with `clearance`, a record of the near pairs of links. The inputs are those of
    Retargeting. No output is direct-feedthrough. Joint positions, velocities and accelerations stay within their
    limits whatever the inputs are; what that costs the palms is an output:

    `task_scale` (2) is the share of each palm's commanded twist that the limits let through, `task_deviation` (2) the
    speed, m/s, of what it does beside that share (`robot.tracking.Tracked`). `tempo` (1), in [tempo_floor, 1], is how
    fast the phase may run so that the palms stay on their way (`robot.tempo`), meant for CanonicalSystem's input of
    that name: the loop goes through two states and closes no algebraic loop. `clearance` (1), m, is the least distance
    of the arms at the last update, inf where none is near or `clearance` was not asked for. `commanded_palms` (6), m in
    W, is where q has the left and the right palm.

    `measured_position` (14), where connected, is where the kinematics are evaluated; the command still integrates
    from the commanded q. `desired_state_left/right` (14) are q, v of one arm, for the plant's PD.
    """

    def __init__(
        self,
        *,
        kinematics: DualArmKinematics,
        limits: JointLimits,
        initial_position: np.ndarray,
        time_step: float,
        hold_until: float = 0.0,
        gains: IkGains = DEFAULT_GAINS,
        redundancy: str = "swivel",
        mirrored: bool = True,
        clearance: float | None = None,
    ):
        """Build the system.

        Args:
            kinematics: of both arms; the system keeps and uses it.
            limits: of their joints.
            initial_position: (14,) rad.
            time_step: period of the discrete update, s, positive.
            hold_until: the arms stay at `initial_position` until this time, s, while the skill's initial errors vanish.
            gains: of the closed loop; a step must not overshoot, so none of them times `time_step` may exceed 1.
            redundancy: what fills the null space: the swivel, nothing, or (18) as printed (`robot.redundancy`).
            mirrored: the arms hold their elbows up (`Retarget.elbow_up`); (18) as printed alone needs to know.
            clearance: m, that the arms keep from themselves and each other (`robot.tracking`); None: not looked at.

        Raises:
            ScenarioError: `time_step` is not positive, or too large for the gains, or there is no such redundancy, or
                `clearance` is not > 0.
            TaskError: `initial_position` is not 14 finite angles.
        """
        super().__init__()
        initial_position = np.asarray(initial_position, dtype=float)
        if initial_position.shape != (14,) or not np.all(np.isfinite(initial_position)):
            raise TaskError(f"initial_position of shape {initial_position.shape} must be 14 finite joint angles")
        fastest = max(gains.pose, gains.swivel, gains.limit_gain)
        if not 0 < time_step <= 1.0 / fastest:
            raise ScenarioError(
                f"time_step of the differential inverse kinematics is {time_step:g} s; choose it above 0 and at most "
                f"{1.0 / fastest:g} s, or lower its largest gain, {fastest:g} 1/s"
            )
        self._tracker = DualArmTracker(kinematics, limits, gains, redundancy, mirrored, clearance)
        self._tempo_constants = gains.tempo_fall, gains.tempo_rise, gains.tempo_floor
        self._time_step, self._hold_until = time_step, hold_until
        self._inputs = [
            self.DeclareVectorInputPort(name, size)
            for name, size in (("palm_poses", 14), ("palm_twists", 12), ("swivel", 2), ("swivel_rate", 2))
        ]
        self._measured = self.DeclareVectorInputPort("measured_position", 14)
        q = self.DeclareDiscreteState(initial_position)
        v = self.DeclareDiscreteState(np.zeros(14))
        scale = self.DeclareDiscreteState(np.ones(2))
        initial = kinematics.evaluate(initial_position)
        swivel = self.DeclareDiscreteState(np.array([state.swivel for state in initial]))
        deviation = self.DeclareDiscreteState(np.zeros(2))
        tempo = self.DeclareDiscreteState(np.ones(1))
        nearest = self.DeclareDiscreteState(np.full(1, np.inf))
        palms = self.DeclareDiscreteState(np.concatenate([state.position for state in initial]))
        self._near = None if clearance is None else self.DeclareDiscreteState(np.full(NEAR_SIZE, np.inf))
        self.DeclareStateOutputPort("position", q)
        self.DeclareStateOutputPort("velocity", v)
        for arm, name in enumerate(("left", "right")):
            self.DeclareVectorOutputPort(
                f"desired_state_{name}",
                14,
                lambda context, output, first=7 * arm: self._calc_desired_state(context, output, first),
                {self.xd_ticket()},
            )
        self.DeclareStateOutputPort("task_scale", scale)
        self.DeclareStateOutputPort("swivel_now", swivel)
        self.DeclareStateOutputPort("task_deviation", deviation)
        self.DeclareStateOutputPort("tempo", tempo)
        self.DeclareStateOutputPort("clearance", nearest)
        self.DeclareStateOutputPort("commanded_palms", palms)
        self.DeclarePeriodicDiscreteUpdateEvent(time_step, 0.0, self._update)

    def _calc_desired_state(self, context, output, first):
        q, v = (context.get_discrete_state(i).value()[first : first + 7] for i in range(2))
        output.SetFromVector(np.concatenate([q, v]))

    def _update(self, context, discrete_state):
        if context.get_time() < self._hold_until - 0.5 * self._time_step:
            return  # The states keep their values: still, at the initial position.
        pose, twist, swivel, swivel_rate = (self._finite(port, context) for port in self._inputs)
        q, v = (context.get_discrete_state(i).CopyToVector() for i in range(2))
        measured = self._measured.HasValue(context)
        tracked = self._tracker.velocity(
            self._finite(self._measured, context) if measured else q,
            pose.reshape(2, 7),
            twist.reshape(2, 6),
            swivel,
            swivel_rate,
            v,
            self._time_step,
            # A blocked arm must not wind the command past its limits.
            commanded=q if measured else None,
            near=None if self._near is None else context.get_discrete_state(self._near).value(),
        )
        tempo = context.get_discrete_state(5).value()
        tempo = next_tempo(tempo, tracked.scale.min(), self._time_step, *self._tempo_constants)
        values = (
            q + self._time_step * tracked.velocity,
            tracked.velocity,
            tracked.scale,
            tracked.swivel,
            tracked.deviation,
            tempo,
            [tracked.clearance],
            tracked.palms.ravel(),
            *(() if self._near is None else (tracked.near,)),
        )
        for index, value in enumerate(values):
            discrete_state.get_mutable_vector(index).SetFromVector(value)

    def _finite(self, port, context) -> np.ndarray:
        value = port.Eval(context)
        if not np.isfinite(value).all():
            raise TaskError(
                f"input port '{port.get_name()}' of system '{self.GetSystemPathname()}' is not finite at "
                f"t = {context.get_time():g} s: {np.array2string(value, precision=3)}; check what is connected to it"
            )
        return value
