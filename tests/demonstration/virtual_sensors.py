"""A virtual Kinect without errors, and which of the links are bones."""

from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect

BONES = [0, 1, 3, 4]
PERFECT = VirtualKinect(
    shoulder_drift_m=0,
    elbow_drift_m=0,
    wrist_drift_m=0,
    shortening=0,
    white_m=0,
    occlusion_drift_m=0,
    occlusion_pull_m=0,
    jump_rate_hz=0,
    drop_probability=0,
    repeat_probability=0,
)
