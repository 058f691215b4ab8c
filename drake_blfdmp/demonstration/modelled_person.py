"""A modelled person who takes a box from a table with both hands, carries it aside and puts it down: exact truth.

The hands follow superposed minimum-jerk movements (Flash and Hogan, "The coordination of arm movements", J. Neurosci.
5, 1985), as people's hands do, so position, velocity and acceleration are continuous; the elbows follow from the bones'
lengths. Nothing here is measured: whatever is made of it has to be labelled synthetic.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import multiply

DURATION_S = 8.0
REACH_LIMIT = 0.95  # Of the straight arm: the elbow is never straight, so its swivel angle is always defined.
MIN_ELBOW_ANGLE = np.deg2rad(30.0)  # People's elbows do not fold further.
OPENING = 0.20  # How much wider than the box the open hands are, m.

# Start and end of each movement, s, in a motion of DURATION_S. The hands are still between squeeze and lift, and
# between lower and release; neighbours that overlap blend.
_TIMES = {
    "reach": (0.25, 1.35),
    "squeeze": (1.25, 1.95),
    "lift": (2.30, 3.50),
    "carry": (3.20, 4.90),
    "lower": (4.60, 5.75),
    "release": (6.10, 6.80),
    "retreat": (6.70, 7.75),
    "tip": (2.90, 4.10),
    "right": (4.10, 5.30),
}


# Left and right hand in the box's frame: z is x or -x of the box, x half up and half forward.
_FINGERS = np.sqrt(0.5) * np.array([0.0, 1.0, 1.0])
_ON_BOX = np.array(
    [
        np.roll(Rotation.from_matrix(np.stack([_FINGERS, np.cross(z, _FINGERS), z], axis=-1)).as_quat(), 1)
        for z in ([1.0, 0.0, 0.0], [-1.0, 0.0, 0.0])
    ]
)


@dataclass(frozen=True)
class ModelledPerson:
    """A standing person's measures, and where and how slowly the box is taken and put; metres, radians, seconds.

    The frame's origin lies on the floor below the shoulders' midpoint: x to the person's right, y forward, z up.

    Attributes:
        upper_arm: shoulder to elbow.
        forearm: elbow to wrist.
        shoulder_width: shoulder to shoulder.
        shoulder_height: above the floor.
        box_width: the distance between the wrists while the box is held.
        grasp_height: the wrists' height while the box stands on the table.
        grasp_forward: the wrists' midpoint in front of the body at the grasp.
        lift: how high the box is lifted.
        carry_right: how far it is carried to the right, half of it on either side of the body.
        carry_forward: how far it is carried forward.
        yaw: of the box: +yaw at the grasp, -yaw at the release (counter-clockwise from above), at most 10 degrees.
        box_pitch: how far the hands tip the box in the middle of the carry, about the line from the left hand to the
            right one; positive brings its top to the person. `hand_orientations` shows it, the points do not.
        swivel: elbows outward from hanging straight below the shoulder-wrist line.
        swivel_rise: added to `swivel` at the top of the lift.
        sway: bound on the torso's displacement.
        duration_s: length of the motion, s; all movements stretch with it.

    Raises:
        RecordingError: a measure is not finite or out of its range.
    """

    upper_arm: float = 0.22
    forearm: float = 0.28
    shoulder_width: float = 0.36
    shoulder_height: float = 1.40
    box_width: float = 0.30
    grasp_height: float = 1.08
    grasp_forward: float = 0.25
    lift: float = 0.32
    carry_right: float = 0.28
    carry_forward: float = -0.03
    yaw: float = np.deg2rad(5.0)
    box_pitch: float = 0.0
    swivel: float = 0.40
    swivel_rise: float = 0.25
    sway: float = 0.02
    duration_s: float = DURATION_S

    def __post_init__(self):
        for field in fields(self):
            if not np.isfinite(getattr(self, field.name)):
                raise RecordingError(f"ModelledPerson.{field.name} is not finite; give a number")
        for name in ("upper_arm", "forearm", "shoulder_width", "shoulder_height", "box_width"):
            if getattr(self, name) <= 0:
                raise RecordingError(f"ModelledPerson.{name} is {getattr(self, name)} m; give a positive length")
        for name in ("lift", "sway"):
            if getattr(self, name) < 0:
                raise RecordingError(f"ModelledPerson.{name} is {getattr(self, name)} m; give zero or more")
        if self.duration_s <= 0:
            raise RecordingError(f"ModelledPerson.duration_s is {self.duration_s} s; give a positive duration")
        if abs(self.yaw) > np.deg2rad(10.0) + 1e-9:
            raise RecordingError(f"ModelledPerson.yaw is {self.yaw:.3f} rad; keep it within 10 degrees (0.175 rad)")
        if abs(self.box_pitch) > np.deg2rad(90.0) + 1e-9:
            raise RecordingError(
                f"ModelledPerson.box_pitch is {self.box_pitch:.3f} rad; keep it within 90 degrees (1.571)"
            )


def held_interval(duration_s: float = DURATION_S) -> tuple[float, float]:
    """From the end of the squeeze to the start of the release, s: the hands are `box_width` apart throughout."""
    scale = duration_s / DURATION_S
    return _TIMES["squeeze"][1] * scale, _TIMES["release"][0] * scale


def hold_and_place(
    person: ModelledPerson | None = None, rate_hz: float = 30.0, duration_s: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The whole motion, from rest to rest: reach, squeeze, lift, carry, lower, release, retreat.

    Args:
        person: whose motion; the default person if None.
        rate_hz: samples a second.
        duration_s: length, s; the person's own if None.

    Returns:
        t: (N,) from 0, uniform, s.
        x: (N, 6, 3) positions in the order of `skeleton.POINTS`, m, in the frame of `ModelledPerson`.

    Raises:
        RecordingError: a hand cannot reach with a bent elbow, or the rate or duration is not positive.
    """
    person = person or ModelledPerson()
    duration_s = person.duration_s if duration_s is None else duration_s
    if not (0 < rate_hz < np.inf and 0 < duration_s < np.inf and rate_hz * duration_s >= 1):
        raise RecordingError(
            f"the modelled motion needs a positive rate and duration and two samples or more; got {rate_hz} Hz for "
            f"{duration_s} s"
        )
    t = np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    u = t * (DURATION_S / duration_s)
    middle, gap, yaw, raised = _hands(person, u)
    across = np.stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)], axis=-1)
    sway = _sway(person, u)
    swivel = person.swivel + person.swivel_rise * raised
    x = np.empty((len(t), 6, 3))
    for name, side, first in (("left", -1.0, 0), ("right", 1.0, 3)):
        shoulder = sway + np.array([side * person.shoulder_width / 2, 0.0, person.shoulder_height])
        wrist = middle + (side * gap / 2)[:, None] * across
        _check_reach(person, name, t, np.linalg.norm(wrist - shoulder, axis=-1))
        x[:, first] = shoulder
        x[:, first + 1] = elbow_position(shoulder, wrist, person.upper_arm, person.forearm, swivel, side)
        x[:, first + 2] = wrist
    return t, x


def hand_orientations(person: ModelledPerson, t: np.ndarray) -> np.ndarray:
    """The hands' orientations (N, 2, 4) at times t (N,), s, w x y z: on the box while it is held, and as on it else.

    Fingers (x) up and forward, palms (z) on the box's sides.
    """
    u = np.asarray(t) * (DURATION_S / person.duration_s)
    yaw = 0.5 * _hands(person, u)[2]
    done = {name: minimum_jerk((u - start) / (end - start)) for name, (start, end) in _TIMES.items()}
    half = 0.5 * person.box_pitch * (done["tip"] - done["right"])
    zero = np.zeros_like(u)
    line = np.stack([np.cos(yaw), zero, zero, np.sin(yaw)], axis=-1)
    box = multiply(line, np.stack([np.cos(half), np.sin(half), zero, zero], axis=-1))
    return multiply(box[:, None], _ON_BOX)


def elbow_position(
    shoulder: np.ndarray, wrist: np.ndarray, upper_arm: float, forearm: float, swivel: np.ndarray | float, side: float
) -> np.ndarray:
    """Two-bone inverse kinematics: the elbow on the circle that the bones' lengths leave, at a given swivel.

    Args:
        shoulder: (*, 3) m.
        wrist: (*, 3) m; between |upper_arm - forearm| and upper_arm + forearm from the shoulder.
        upper_arm: m.
        forearm: m.
        swivel: (*) rad; 0 lets the elbow hang below the shoulder-wrist line, positive moves it outward.
        side: -1 for the left arm, +1 for the right.

    Returns:
        (*, 3) m.
    """
    reach = wrist - shoulder
    distance = np.linalg.norm(reach, axis=-1, keepdims=True)
    along = reach / distance
    foot = (upper_arm**2 - forearm**2 + distance**2) / (2 * distance)
    radius = np.sqrt(np.maximum(upper_arm**2 - foot**2, 0.0))
    # Down and a little back, not straight down: parallel to the arm only for a hand behind the body.
    hanging = np.array([0.0, -0.3, -1.0])
    down = hanging - np.sum(along * hanging, axis=-1, keepdims=True) * along
    down /= np.linalg.norm(down, axis=-1, keepdims=True)
    out = side * np.cross(down, along)
    angle = np.asarray(swivel)[..., None]
    return shoulder + foot * along + radius * (np.cos(angle) * down + np.sin(angle) * out)


def minimum_jerk(u: np.ndarray) -> np.ndarray:
    """From 0 to 1 over u in [0, 1] and constant outside; velocity and acceleration vanish at both ends."""
    u = np.clip(u, 0.0, 1.0)
    return u**3 * (10 - 15 * u + 6 * u**2)


def _hands(person: ModelledPerson, u: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Wrists' midpoint (N, 3), distance (N,), yaw of their line (N,), and how much of the lift is done (N,)."""
    done = {name: minimum_jerk((u - start) / (end - start)) for name, (start, end) in _TIMES.items()}
    arm = person.upper_arm + person.forearm
    rest = np.array([0.0, 0.54 * arm, person.shoulder_height - 0.50 * arm])
    taken = np.array([-person.carry_right / 2, person.grasp_forward, person.grasp_height])
    carried = np.array([person.carry_right, person.carry_forward, 0.0])
    raised = done["lift"] - done["lower"]
    middle = (
        rest
        + done["reach"][:, None] * (taken - rest)
        + raised[:, None] * np.array([0.0, 0.0, person.lift])
        + done["carry"][:, None] * carried
        + done["retreat"][:, None] * (rest - taken - carried)
    )
    rest_gap = person.shoulder_width + 0.09
    open_gap = person.box_width + OPENING
    gap = (
        rest_gap
        + (done["reach"] - done["retreat"]) * (open_gap - rest_gap)
        + (done["squeeze"] - done["release"]) * (person.box_width - open_gap)
    )
    yaw = person.yaw * (done["reach"] - 2 * done["carry"] + done["retreat"])
    return middle, gap, yaw, raised


def _sway(person: ModelledPerson, u: np.ndarray) -> np.ndarray:
    """The torso's displacement, (N, 3) m, never longer than `person.sway`: no two axes at one frequency."""
    return person.sway * np.stack(
        [
            0.75 * np.sin(2 * np.pi * 0.13 * u - 1.0),
            0.60 * np.sin(2 * np.pi * 0.21 * u + 0.5),
            0.20 * np.sin(2 * np.pi * 0.25 * u),
        ],
        axis=-1,
    )


def _check_reach(person: ModelledPerson, name: str, t: np.ndarray, distance: np.ndarray) -> None:
    upper, fore = person.upper_arm, person.forearm
    farthest = REACH_LIMIT * (upper + fore)
    nearest = np.sqrt(upper**2 + fore**2 - 2 * upper * fore * np.cos(MIN_ELBOW_ANGLE))
    i = int(np.argmax(distance))
    if distance[i] > farthest:
        raise RecordingError(
            f"modelled person: at t = {t[i]:.2f} s the {name} wrist is {distance[i]:.3f} m from its shoulder, the arm "
            f"reaches {farthest:.3f} m; raise or pull in the grasp, carry less far, or lengthen the arm"
        )
    i = int(np.argmin(distance))
    if distance[i] < nearest:
        raise RecordingError(
            f"modelled person: at t = {t[i]:.2f} s the {name} wrist is {distance[i]:.3f} m from its shoulder, the "
            f"elbow folds to {nearest:.3f} m; lower the grasp or the lift, or move the grasp forward"
        )
