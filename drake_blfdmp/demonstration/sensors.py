"""What a skeleton sensor does to the truth, and the sensors that people film with: Kinect v1, Kinect v2, Azure Kinect.

What a recording can tell of a preset's numbers was measured on real recordings of that sensor; `docs/virtual_kinect.md`
has the comparison, and says what no recording can tell.
"""

from dataclasses import dataclass, fields

import numpy as np

from drake_blfdmp.errors import RecordingError

_POSITIVE = ("rate_hz", "correlation_s", "misfit_duration_s")
_BELOW_ONE = ("drop_probability", "repeat_probability", "shortening", "absent_share")


@dataclass(frozen=True)
class VirtualKinect:
    """What the sensor does to the truth; standard deviations are per axis, in metres.

    The defaults film a person who stands and faces a Kinect v1: the bones' standard deviations are those of recordings
    of people who carry something (0.027 m for the upper arm, 0.035 m for the forearm, UTKinect-Action3D), the slow
    errors are smooth, no arm is lost, and the wrists' distance wobbles by some centimetres while the box is held.

    Attributes:
        rate_hz: frames a second.
        shoulder_drift_m: standard deviation of the shoulders' slow error, present from the first frame on.
        elbow_drift_m: what an elbow adds to its shoulder's.
        wrist_drift_m: what a wrist adds to its elbow's.
        correlation_s: integral time scale of the slow errors.
        shortening: fraction by which the fitted bones come out short.
        white_m: standard deviation of the frame-to-frame noise.
        occlusion_drift_m: standard deviation of both wrists' common further slow error while the box hides them.
        occlusion_pull_m: how far a hidden wrist is pulled towards the box's middle.
        jump_rate_hz: how often a wrist is inferred instead of seen (Poisson), each wrist.
        jump_m: standard deviation of the offset while it is inferred.
        jump_duration_s: mean length of such a spell (exponential).
        drop_probability: of a frame to be missing from the file (never the first).
        repeat_probability: of a frame to stand in the file twice, with the same time stamp.
        rough: slow errors without a velocity (Ornstein-Uhlenbeck), normally distributed, instead of smooth and bounded
            ones.
        white_grading: what `white_m` is multiplied by for shoulders, elbows and wrists.
        misfit_rate_hz: how often an arm is fitted in a wrong direction, bones kept (Poisson), each arm.
        misfit_angle: standard deviation of the largest angle of such a spell, about the shoulder, rad.
        misfit_duration_s: mean length of such a spell, from 0.5 to 1.5 times that.
        misfit_confidence: what the sensor says of elbow and wrist while the arm is turned by more than 0.3 rad; 0.5
            guessed, 1 tracked.
        rigid: a body model is fitted: bones keep their proportions, whatever the points' errors; only directions err.
        body_scale: relative standard deviation of the fitted body's size, slow, common to all bones.
        hand_turn: standard deviation per axis of the slow error of the hands' orientations, where they are filmed, rad;
            assumed, not measured.
        absent_share: share of the frames, at both ends of the recording, that hold no body.

    Raises:
        RecordingError: a number is out of its range.
    """

    rate_hz: float = 30.0
    shoulder_drift_m: float = 0.010
    elbow_drift_m: float = 0.025
    wrist_drift_m: float = 0.025
    correlation_s: float = 0.8
    shortening: float = 0.09
    white_m: float = 0.005
    occlusion_drift_m: float = 0.022
    occlusion_pull_m: float = 0.015
    jump_rate_hz: float = 0.15
    jump_m: float = 0.04
    jump_duration_s: float = 0.10
    drop_probability: float = 0.03
    repeat_probability: float = 0.02
    rough: bool = False
    white_grading: tuple[float, float, float] = (1.0, 1.0, 1.0)
    misfit_rate_hz: float = 0.0
    misfit_angle: float = 0.6
    misfit_duration_s: float = 1.5
    misfit_confidence: float = 0.5
    rigid: bool = False
    body_scale: float = 0.0
    absent_share: float = 0.0
    hand_turn: float = np.deg2rad(2.0)

    def __post_init__(self):
        if len(self.white_grading) != 3:
            raise RecordingError(
                f"VirtualKinect.white_grading has {len(self.white_grading)} numbers; give one for shoulders, elbows "
                "and wrists each"
            )
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if not np.isfinite(value).all() or np.less(value, 0).any() or (name in _POSITIVE and value == 0):
                wanted = "a positive number" if name in _POSITIVE else "zero or a positive number"
                raise RecordingError(f"VirtualKinect.{name} is {value}; give {wanted}")
            if name in _BELOW_ONE and value >= 1:
                raise RecordingError(f"VirtualKinect.{name} is {value}; give a number below 1")
        if self.misfit_confidence > 1:
            raise RecordingError(f"VirtualKinect.misfit_confidence is {self.misfit_confidence}; give 0 to 1")


KINECT_V1 = VirtualKinect(
    shoulder_drift_m=0.020,
    elbow_drift_m=0.0255,
    wrist_drift_m=0.026,
    correlation_s=0.9,
    rough=True,
    shortening=0.0,
    white_m=0.0045,
    white_grading=(0.4, 1.0, 1.5),
    misfit_rate_hz=0.55,
    misfit_angle=0.78,
    misfit_duration_s=1.8,
)
"""Kinect v1 and a person who walks with a box: UTKinect-Action3D, 19 carries."""

KINECT_V2 = VirtualKinect(
    shoulder_drift_m=0.010,
    elbow_drift_m=0.0145,
    wrist_drift_m=0.008,
    correlation_s=0.7,
    shortening=0.0,
    white_m=0.001,
    white_grading=(0.15, 0.8, 1.6),
    occlusion_drift_m=0.010,
    occlusion_pull_m=0.010,
    jump_rate_hz=0.9,
    jump_m=0.018,
    jump_duration_s=0.23,
    drop_probability=0.006,
    repeat_probability=0.0,
)
"""Kinect v2: two recordings of gestures."""

AZURE_KINECT = VirtualKinect(
    rate_hz=15.0,
    shoulder_drift_m=0.010,
    elbow_drift_m=0.010,
    wrist_drift_m=0.010,
    correlation_s=1.8,
    shortening=0.0,
    white_m=0.0012,
    white_grading=(0.8, 1.0, 1.2),
    occlusion_drift_m=0.010,
    occlusion_pull_m=0.010,
    jump_rate_hz=0.55,
    jump_m=0.020,
    jump_duration_s=0.25,
    drop_probability=0.0,
    repeat_probability=0.0,
    misfit_rate_hz=0.09,
    misfit_angle=1.4,
    misfit_duration_s=0.25,
    misfit_confidence=1.0,
    rigid=True,
    body_scale=0.04,
    absent_share=0.064,
)
"""Azure Kinect: one recording of a minute, at 15 Hz."""

SENSORS: dict[str, VirtualKinect] = {
    "kinect_v1": KINECT_V1,
    "kinect_v2": KINECT_V2,
    "azure_kinect": AZURE_KINECT,
}
"""The sensors by name."""
