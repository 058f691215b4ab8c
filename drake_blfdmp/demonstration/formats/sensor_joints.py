"""The joint orders of depth sensors, for files that number joints instead of naming them."""

from collections.abc import Collection
from typing import NamedTuple

from drake_blfdmp.demonstration.formats.point_names import normalise

KINECT_V1 = (
    "HipCenter", "Spine", "ShoulderCenter", "Head",
    "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft",
    "ShoulderRight", "ElbowRight", "WristRight", "HandRight",
    "HipLeft", "KneeLeft", "AnkleLeft", "FootLeft",
    "HipRight", "KneeRight", "AnkleRight", "FootRight",
)  # fmt: skip
"""NUI_SKELETON_POSITION_INDEX of the Kinect for Windows SDK 1.8; metres, y up, 30 Hz."""

KINECT_V2 = (
    "SpineBase", "SpineMid", "Neck", "Head",
    "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft",
    "ShoulderRight", "ElbowRight", "WristRight", "HandRight",
    "HipLeft", "KneeLeft", "AnkleLeft", "FootLeft",
    "HipRight", "KneeRight", "AnkleRight", "FootRight",
    "SpineShoulder", "HandTipLeft", "ThumbLeft", "HandTipRight", "ThumbRight",
)  # fmt: skip
"""JointType of the Kinect for Windows SDK 2.0; metres, y up, 30 Hz."""

AZURE_KINECT = (
    "Pelvis", "SpineNavel", "SpineChest", "Neck",
    "ClavicleLeft", "ShoulderLeft", "ElbowLeft", "WristLeft", "HandLeft", "HandTipLeft", "ThumbLeft",
    "ClavicleRight", "ShoulderRight", "ElbowRight", "WristRight", "HandRight", "HandTipRight", "ThumbRight",
    "HipLeft", "KneeLeft", "AnkleLeft", "FootLeft",
    "HipRight", "KneeRight", "AnkleRight", "FootRight",
    "Head", "Nose", "EyeLeft", "EarLeft", "EyeRight", "EarRight",
)  # fmt: skip
"""k4abt_joint_id_t of the Azure Kinect body tracking SDK; millimetres, in ROS metres, y down, 5, 15 or 30 Hz."""

MEDIAPIPE_POSE = (
    "Nose", "EyeInnerLeft", "EyeLeft", "EyeOuterLeft", "EyeInnerRight", "EyeRight", "EyeOuterRight",
    "EarLeft", "EarRight", "MouthLeft", "MouthRight",
    "ShoulderLeft", "ShoulderRight", "ElbowLeft", "ElbowRight", "WristLeft", "WristRight",
    "PinkyLeft", "PinkyRight", "IndexLeft", "IndexRight", "ThumbLeft", "ThumbRight",
    "HipLeft", "HipRight", "KneeLeft", "KneeRight", "AnkleLeft", "AnkleRight",
    "HeelLeft", "HeelRight", "FootIndexLeft", "FootIndexRight",
)  # fmt: skip
"""PoseLandmark of MediaPipe; world landmarks are in metres, y down."""


class NumberedJoints(NamedTuple):
    """What a file's joint numbers mean: number -> name, the sensor, and the axis that points up for it."""

    names: dict[int, str]
    sensor: str
    up: str


_SENSORS = (
    ("Kinect v1", KINECT_V1, "y"),
    ("Kinect v2", KINECT_V2, "y"),
    ("Azure Kinect", AZURE_KINECT, "-y"),
    ("MediaPipe", MEDIAPIPE_POSE, "-y"),
)


def joints_by_number(numbers: Collection[int]) -> NumberedJoints | None:
    """The sensor whose joints carry just these numbers, from 0 or from 1, or whose arms do; None where none fits.

    Kinect v1 and v2 give both arms the same numbers.
    """
    given = set(numbers)
    for sensor, order, up in _SENSORS:
        for first in (0, 1):
            if given == set(range(first, first + len(order))):
                return NumberedJoints(dict(enumerate(order, first)), sensor, up)
    for sensor, order, up in _SENSORS:
        arms = {number: name for number, name in enumerate(order) if name.startswith(("Shoulder", "Elbow", "Wrist"))}
        arms = {number: name for number, name in arms.items() if name != "ShoulderCenter"}
        if given == set(arms):
            return NumberedJoints(arms, sensor, up)
    return None


def sensor_by_names(names: Collection[str]) -> tuple[str, str] | None:
    """The sensor all of whose joints are among the names, and the axis that points up for it; None where none fits."""
    given = {normalise(name) for name in names}
    for sensor, order, up in _SENSORS:
        if given.issuperset(map(normalise, order)):
            return sensor, up
    return None
