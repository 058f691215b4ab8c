"""Everything a run's metrics and figures are computed from, as plain arrays on one clock."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RunLog:
    """Signals of one simulated run, sampled on a uniform clock of N samples.

    Skill signals are in the person's torso frame, robot signals in the world frame W. Arms in the order left, right;
    joints 1-7 of the left arm, then of the right; links in the order of `skeleton.LINKS`.

    Attributes:
        t: (N,) s.
        clock: (N,) the skill's own clock, s: behind t where the tempo was below 1.
        phase: (N,).
        tempo: (N,) how fast that clock runs; 1 where nothing slows it.
        position: (N, 6, 3) coupled skill, m.
        uncoupled: (N, 6, 3) the same skill without coupling, m.
        demonstrated: (N, 6, 3) what the skill was learned from, on the run's clock, m.
        lower, upper: (N, 5) the links' bands, m.
        desired: (N, 5) the links' desired lengths, m.
        barrier: (N, 5) barrier values V.
        q, q_desired: (N, 14) joint angles, rad.
        v: (N, 14) joint velocities, rad/s.
        effort: (N, 14) actuation, N m.
        q_lower, q_upper, v_limit, effort_limit: (14,) limits.
        palm, palm_desired: (N, 2, 7) poses X_WP as qw qx qy qz x y z.
        swivel, swivel_desired: (N, 2) rad.
        hands: (N,) the palms' effective distance, in the skill's measure, m (`robot.palm_feedback`).
        palm_force: (N, 2) normal force of each palm on the box, N; 0 in a motion without a box.
        box: (N, 7) pose X_WB as qw qx qy qz x y z; None in a motion without a box.
        box_desired: (N, 7) where the plan has it; None without one.
        clearance: (N,) least distance between bodies that must not touch, m.
        events: (name, time in s): grasp, lift, lower, release and so on; start and end without a box.
        spread: (N, 6, 3) standard deviation over the recordings the skill was learned from, m; None of one recording.
        recognised: (name, time in s): the phases of the carry as measured (`robot.carry_phases`); empty without a box.
    """

    t: np.ndarray
    clock: np.ndarray
    phase: np.ndarray
    tempo: np.ndarray
    position: np.ndarray
    uncoupled: np.ndarray
    demonstrated: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    desired: np.ndarray
    barrier: np.ndarray
    q: np.ndarray
    q_desired: np.ndarray
    v: np.ndarray
    effort: np.ndarray
    q_lower: np.ndarray
    q_upper: np.ndarray
    v_limit: np.ndarray
    effort_limit: np.ndarray
    palm: np.ndarray
    palm_desired: np.ndarray
    swivel: np.ndarray
    swivel_desired: np.ndarray
    hands: np.ndarray
    palm_force: np.ndarray
    box: np.ndarray | None
    box_desired: np.ndarray | None
    clearance: np.ndarray
    events: tuple[tuple[str, float], ...] = ()
    spread: np.ndarray | None = None
    recognised: tuple[tuple[str, float], ...] = ()
