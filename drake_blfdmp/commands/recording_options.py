"""The options that say how a recording is read, shared by every command that reads one."""

import argparse
from typing import Any

from drake_blfdmp.errors import ScenarioError

_PLAIN = ("format", "unit", "time_unit", "rate_hz", "body", "up")


def add_recording_options(parser: argparse.ArgumentParser) -> None:
    """Add them; each is for what the file's content does not tell, or tells wrongly."""
    group = parser.add_argument_group("reading the recording", "only for what its content does not tell")
    group.add_argument("--format", help="the file's format, see docs/recordings.md")
    group.add_argument("--frames", metavar="A:B", help="first and last frame, inclusive")
    group.add_argument(
        "--joints",
        nargs="+",
        default=[],
        metavar="NAME=COLUMN",
        help="left_wrist=HandL takes the columns of HandL; left_wrist=a,b,c three columns",
    )
    group.add_argument("--unit", choices=["m", "cm", "mm"], help="unit of length")
    group.add_argument("--time-unit", choices=["s", "ms", "us", "100ns", "ns", "frames"], help="unit of the clock")
    group.add_argument("--rate", type=float, dest="rate_hz", metavar="HZ", help="frames a second; frames are counted")
    group.add_argument("--body", metavar="ID", help="which person, where there are several")
    group.add_argument("--up", choices=["x", "-x", "y", "-y", "z", "-z"], help="the axis that points up")


def frame_range(options: argparse.Namespace) -> tuple[int, int] | None:
    """The `--frames` of a parsed command line.

    Raises:
        ScenarioError: not of the form FIRST:LAST.
    """
    if options.frames is None:
        return None
    first, colon, last = options.frames.partition(":")
    if not colon or not first.strip().isdigit() or not last.strip().isdigit():
        raise ScenarioError(f"--frames {options.frames}: write it as FIRST:LAST, for example 1016:1242")
    return int(first), int(last)


def joint_names(options: argparse.Namespace) -> dict[str, str | list[str]]:
    """The `--joints` of a parsed command line: point -> joint, or three columns.

    Raises:
        ScenarioError: not of the form NAME=COLUMN.
    """
    joints: dict[str, str | list[str]] = {}
    for joint in options.joints:
        name, equals, columns = joint.partition("=")
        if not equals or not columns:
            raise ScenarioError(f"--joints {joint}: write it as NAME=COLUMN, for example left_wrist=HandLeft")
        parts = columns.split(",")
        joints[name] = parts[0] if len(parts) == 1 else parts
    return joints


def reader_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """Keyword arguments of `read_recording`; raises as `frame_range` and `joint_names` do."""
    arguments = {name: getattr(options, name) for name in _PLAIN if name != "up"}
    return arguments | {"frames": frame_range(options), "joints": joint_names(options) or None}


def recording_settings(options: argparse.Namespace) -> list[str]:
    """The same options as settings of a scenario; raises as `frame_range` and `joint_names` do."""
    settings = []
    for name in _PLAIN:
        value = getattr(options, name)
        if value is not None:
            settings.append(f"recording.{name}={quoted(value) if isinstance(value, str) else value}")
    frames = frame_range(options)
    if frames is not None:
        settings.append(f"recording.frames=[{frames[0]}, {frames[1]}]")
    for name, columns in joint_names(options).items():
        listed = [columns] if isinstance(columns, str) else columns
        settings.append(f"recording.joints={{{name}: [{', '.join(map(quoted, listed))}]}}")
    return settings


def quoted(text: str) -> str:
    """A string as YAML."""
    return "'" + text.replace("'", "''") + "'"
