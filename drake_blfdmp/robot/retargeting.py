"""From the person's six points to the arms: palm poses, palm twists and swivel angles.

The person's torso frame is moved and scaled about the shoulders' midpoint; the distance between the hands is not
scaled with it, so that a box keeps its width. Arms in the order left, right. World frame W: x to the right, y forward,
z up.
"""

from dataclasses import dataclass

import numpy as np

from drake_blfdmp.quaternions import multiply
from drake_blfdmp.robot.swivel import swivel_angle, swivel_rate, wrap
from drake_blfdmp.skeleton import ELBOWS, SHOULDERS, WRISTS
from drake_blfdmp.vectors import cross, dot

FADING = np.deg2rad(120.0)
OUTWARD = np.array([1.0, -1.0])  # The sign of the swivel angle with which each arm's elbow swings away from the body.


@dataclass(frozen=True)
class Retarget:
    """The map from the person to the arms.

    Attributes:
        scale: of every position relative to `person`, except the distance between the hands.
        person: (3,) the point of the torso frame that is mapped to `world`: the shoulders' mean midpoint, m.
        world: (3,) where it goes, m.
        rolls: (2,) rotation of each palm about its normal, rad, constant; 0 has the palm's x axis up.
        level: keep the line between the palms horizontal, so that the box does not roll with the hands.
        elbow_up: mirror the elbows in the horizontal plane through shoulder and wrist: the robot's elbow swings out as
            far from "straight up" as the person's from "straight down". An arm that stands on its base has no posture
            with the elbow below that line (docs/redundancy.md measures it).
        swing_out: up to the first angle (rad) the elbow swings out as far as the person's; beyond it less and less,
            never past the second. swing_in: the same towards the other arm, where the robot's elbows would meet.
        yaw: the same for the yaw of the line between the hands, either way.
        yaw_share: of the person's yaw, taken before it is limited.
        hands_scale: of the distance between the hands; other than 1 only where they hold nothing.
        pitch: as `yaw`, of the turn of what is held about the line between the hands. It takes joint 7 alone, which has
            2.9 rad to either side of where the grasp leaves it; other motion needs its share of them.
    """

    scale: float
    person: np.ndarray
    world: np.ndarray
    rolls: np.ndarray
    level: bool = True
    elbow_up: bool = True
    swing_out: tuple[float, float] = (np.deg2rad(45.0), np.deg2rad(70.0))
    swing_in: tuple[float, float] = (np.deg2rad(10.0), np.deg2rad(25.0))
    yaw: tuple[float, float] = (np.deg2rad(30.0), np.deg2rad(45.0))
    hands_scale: float = 1.0
    pitch: tuple[float, float] = (np.deg2rad(60.0), np.deg2rad(80.0))
    yaw_share: float = 1.0

    def point(self, x):
        """A position (..., 3) of the torso frame in W."""
        return self.world + self.scale * (x - self.person)


def palm_offsets(rolls) -> np.ndarray:
    """The palms' orientations relative to the line frame (x from the left palm to the right one, z up): (2, 4).

    The normal (palm z) of the left palm is +x, that of the right one -x.
    """
    half = np.sqrt(0.5)
    # R_y(+-90 deg) takes z to +-x; the palm's x axis then points down or up.
    turn = np.array([[half, 0.0, half, 0.0], [half, 0.0, -half, 0.0]])
    offset = np.array([np.pi, 0.0])
    a = 0.5 * (np.asarray(rolls, dtype=float) + offset)
    spin = np.stack([np.cos(a), 0 * a, 0 * a, np.sin(a)], axis=-1)
    return multiply(turn, spin)


def softly_limited(angle, limits):
    """An angle (...) as it is up to limits[0], then approaching limits[1]; and its derivative, which is continuous."""
    start, end = limits
    beyond = np.tanh(np.maximum(np.abs(angle) - start, 0.0) / (end - start))
    return np.sign(angle) * (np.minimum(np.abs(angle), start) + (end - start) * beyond), 1.0 - beyond**2


def faded_at_half_a_turn(angle):
    """A factor (...) that is 1 up to 120 degrees and 0 at 180, and its derivative.

    An elbow straight above the shoulder-wrist line has swung neither out nor in, and crossed hands have turned neither
    way; without the factor what is kept of the angle would jump from one side to the other there.
    """
    u = np.clip((np.abs(angle) - FADING) / (np.pi - FADING), 0.0, 1.0)
    return 0.5 * (1.0 + np.cos(np.pi * u)), -0.5 * np.pi * np.sin(np.pi * u) * np.sign(angle) / (np.pi - FADING)


def hand_line(x, velocity, retarget: Retarget):
    """The line between the hands in W.

    Returns:
        middle (..., 3), m; its velocity (..., 3); the palms' distance (...) and its rate; yaw and pitch (...) of the
        line, left to right, and their rates, rad and rad/s. Pitch is positive when the right hand is higher, 0 when
        levelled.
    """
    r, r_dot = x[..., 5, :] - x[..., 2, :], velocity[..., 5, :] - velocity[..., 2, :]
    middle = retarget.point(0.5 * (x[..., 5, :] + x[..., 2, :]))
    middle_velocity = 0.5 * retarget.scale * (velocity[..., 5, :] + velocity[..., 2, :])
    distance = np.sqrt(dot(r, r))
    rate = dot(r, r_dot) / distance
    flat2 = r[..., 0] ** 2 + r[..., 1] ** 2
    flat = np.sqrt(flat2)
    yaw = np.arctan2(r[..., 1], r[..., 0])
    fade, fade_slope = faded_at_half_a_turn(yaw)
    kept, slope = softly_limited(retarget.yaw_share * yaw, retarget.yaw)
    yaw, slope = fade * kept, retarget.yaw_share * fade * slope + fade_slope * kept
    yaw_rate = slope * (r[..., 0] * r_dot[..., 1] - r[..., 1] * r_dot[..., 0]) / flat2
    apart, apart_rate = retarget.hands_scale * distance, retarget.hands_scale * rate
    if retarget.level:
        return middle, middle_velocity, apart, apart_rate, yaw, yaw_rate, 0.0 * yaw, 0.0 * yaw
    pitch = np.arctan2(r[..., 2], flat)
    flat_rate = (r[..., 0] * r_dot[..., 0] + r[..., 1] * r_dot[..., 1]) / flat
    pitch_rate = (flat * r_dot[..., 2] - r[..., 2] * flat_rate) / distance**2
    return middle, middle_velocity, apart, apart_rate, yaw, yaw_rate, pitch, pitch_rate


def line_frame(yaw, pitch):
    """Quaternion (..., 4) of the line frame and its axes x, y (each (..., 3)): R_z(yaw) R_y(-pitch)."""
    cy, sy, cp, sp = np.cos(0.5 * yaw), np.sin(0.5 * yaw), np.cos(0.5 * pitch), np.sin(0.5 * pitch)
    q = np.stack([cy * cp, sy * sp, -cy * sp, sy * cp], axis=-1)
    c, s, k = np.cos(yaw), np.sin(yaw), np.cos(pitch)
    return q, np.stack([k * c, k * s, np.sin(pitch)], axis=-1), np.stack([-s, c, 0.0 * s], axis=-1)


def common_roll(turn, turn_rate, retarget: Retarget):
    """How far both palms roll together about the line between them, and how fast.

    A turn r of what is held is one about the line times one of the line itself (swing and twist); the hands' points
    tell the second, so only the first is taken from r.

    Args:
        turn: (..., 4) unit quaternions in the line frame.
        turn_rate: (..., 3) angular velocity in the line frame, rad/s.

    Returns:
        The angle (...), rad, 0 where r leaves the line's own x axis unrolled, and its rate (...), rad/s.
    """
    w, x, y, z = (turn[..., i] for i in range(4))
    rate = np.asarray(turn_rate)
    along = w * w + x * x
    # r' = omega r / 2; the angle is 2 atan2(x, w).
    x_dot = 0.5 * (rate[..., 0] * w + rate[..., 1] * z - rate[..., 2] * y)
    w_dot = -0.5 * (rate[..., 0] * x + rate[..., 1] * y + rate[..., 2] * z)
    # Where r turns the line round, its twist has no direction; it is none then.
    angle_rate = 2.0 * (w * x_dot - x * w_dot) / np.maximum(along, 1e-9)
    angle, slope = softly_limited(wrap(2.0 * np.arctan2(x, w)), retarget.pitch)
    return angle, slope * angle_rate


def rolled(q, angle):
    """Frames q (..., 4) turned by an angle (...), rad, about their own x axes."""
    zero = np.zeros_like(angle)
    return multiply(q, np.stack([np.cos(0.5 * angle), np.sin(0.5 * angle), zero, zero], axis=-1))


def retarget_motion(x, velocity, retarget: Retarget, offsets=None, turn=None, turn_rate=None):
    """Palm poses, palm twists, swivel angles and their rates.

    Args:
        x: (..., 6, 3) in the torso frame, m.
        velocity: (..., 6, 3), m/s.
        retarget: the map.
        offsets: `palm_offsets(retarget.rolls)` if at hand.
        turn: (..., 4) how what is held has turned since the grasp, in the line frame; None where nothing tells.
        turn_rate: (..., 3) its angular velocity, rad/s; None for a turn at rest.

    Returns:
        X_WP (..., 2, 7): qw qx qy qz x y z; V_WP (..., 2, 6): angular, then translational velocity in W;
        the swivel angles asked of the robot, psi (..., 2), rad, and psi' (..., 2), rad/s.
    """
    offsets = palm_offsets(retarget.rolls) if offsets is None else offsets
    middle, middle_velocity, distance, rate, yaw, yaw_rate, pitch, pitch_rate = hand_line(x, velocity, retarget)
    q, n, y_axis = line_frame(yaw, pitch)
    omega = -pitch_rate[..., None] * y_axis
    omega[..., 2] += yaw_rate
    n_dot = cross(omega, n)
    if turn is not None:
        angle, angle_rate = common_roll(turn, np.zeros(3) if turn_rate is None else turn_rate, retarget)
        q = rolled(q, angle)
        omega = omega + angle_rate[..., None] * n
    half = 0.5 * (distance[..., None] * n)
    half_dot = 0.5 * (rate[..., None] * n + distance[..., None] * n_dot)
    pose = np.empty((*x.shape[:-2], 2, 7))
    twist = np.empty((*x.shape[:-2], 2, 6))
    pose[..., :4] = multiply(q[..., None, :], offsets)
    for arm, sign in ((0, -1.0), (1, 1.0)):
        pose[..., arm, 4:] = middle + sign * half
        twist[..., arm, :3] = omega
        twist[..., arm, 3:] = middle_velocity + sign * half_dot
    s, e, w = (x[..., arms, :] for arms in (SHOULDERS, ELBOWS, WRISTS))
    rates = (velocity[..., arms, :] for arms in (SHOULDERS, ELBOWS, WRISTS))
    psi, psi_dot = swivel_angle(s, e, w), swivel_rate(s, e, w, *rates)
    outward = OUTWARD * psi > 0
    limits = [np.where(outward, out, inward) for out, inward in zip(retarget.swing_out, retarget.swing_in, strict=True)]
    swing, slope = softly_limited(psi, limits)
    fade, fade_slope = faded_at_half_a_turn(psi)
    swing, slope = fade * swing, fade * slope + fade_slope * swing
    if retarget.elbow_up:
        return pose, twist, wrap(np.pi - swing), -slope * psi_dot
    return pose, twist, swing, slope * psi_dot


def box_pose(x, retarget: Retarget, turn=None):
    """The pose the box has between the palms, (..., 7) as qw qx qy qz x y z: x axis along the line, left to right.

    Args:
        turn: (..., 4) as in `retarget_motion`.
    """
    middle, _, _, _, yaw, _, pitch, _ = hand_line(x, np.zeros_like(x), retarget)
    q = line_frame(yaw, pitch)[0]
    if turn is not None:
        q = rolled(q, common_roll(turn, np.zeros(3), retarget)[0])
    return np.concatenate([q, middle], axis=-1)


def up_axis(pose):
    """The z axis (..., 3) of poses (..., 7) qw qx qy qz x y z."""
    w, x, y, z = (np.asarray(pose)[..., i] for i in range(4))
    return np.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=-1)
