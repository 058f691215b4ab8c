"""What a frame's name says about its axes, by REP 103 and REP 105."""

from collections.abc import Iterable

_UPRIGHT = {"world", "map", "odom", "earth", "base_link", "base_footprint"}


def up_of(frames: Iterable[str], *, azure_kinect: bool = False) -> str | None:
    """The axis that points up in all of these frames; None where their names do not tell.

    Args:
        frames: names of frames.
        azure_kinect: joints as the sensor's driver publishes them: in the depth camera's frame (x right, y down,
            z forward), whatever its name.
    """
    ups = {_up(frame.removeprefix("/").rsplit("/", 1)[-1].lower(), azure_kinect) for frame in frames}
    return ups.pop() if len(ups) == 1 else None


def _up(frame: str, azure_kinect: bool) -> str | None:
    if frame in _UPRIGHT:
        return "z"
    return "-y" if azure_kinect or frame.endswith("optical_frame") else None
