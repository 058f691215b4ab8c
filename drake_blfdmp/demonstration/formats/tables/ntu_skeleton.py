"""Skeletons of NTU RGB+D (`.skeleton`): Kinect v2, several people, one number or one joint a line.

The number of frames; per frame the number of people; per person a line of ten numbers that begins with the person's id,
the number of joints, and per joint a line of twelve: x, y, z (m, y up), depth and colour pixels, orientation, tracking
state. Source: Shahroudy, Liu, Ng, Wang, "NTU RGB+D: a large scale dataset for 3D human activity analysis", CVPR 2016.
"""

from operator import methodcaller
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import KINECT_V2
from drake_blfdmp.demonstration.formats.text import head_lines, kept_lines, text_blocks
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS, WRISTS

CLOCK_HZ = 30.0
_PERSON_NUMBERS, _JOINT_NUMBERS = 10, 12
_STATE = 11  # The column of a joint's tracking state: 0 not tracked, 1 inferred, 2 tracked.
_TURN = slice(7, 11)  # Those of its orientation, w x y z.
_MOST_SKELETONS = 1 << 20

_count_blanks = methodcaller("count", " ")


class NtuSkeleton:
    """Reader of NTU RGB+D's `.skeleton` files; `joints` may name any of `sensor_joints.KINECT_V2`."""

    name = "ntu_skeleton"

    def sniff(self, head: bytes) -> bool:
        """Whether single whole numbers are followed by a line of ten, the number of joints and a line of twelve."""
        rows = [line.split() for line in head_lines(head)]
        first = next((index for index, row in enumerate(rows) if len(row) > 1), None)
        if first is None:  # Nobody in any frame.
            counts = [row[0] for row in rows]
            return len(counts) > 1 and counts[0] == str(len(counts) - 1) and set(counts[1:]) == {"0"}
        counts = [row[0] for row in [*rows[:first], *rows[first + 1 : first + 2]]]
        return (
            first >= 2
            and all(count.isdecimal() for count in counts)
            and [len(row) for row in rows[first : first + 3]] == [_PERSON_NUMBERS, 1, _JOINT_NUMBERS]
        )

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; time is the frame's number from 0 at 30 Hz.

        Raises:
            RecordingError: a line of another kind than its place asks for, or fewer or more frames than promised.
        """
        chosen = resolve(str(path), KINECT_V2, joints)
        wanted: list[int] = []
        for point in POINTS:
            name = chosen[point]
            if not isinstance(name, str):
                raise RecordingError(
                    f"{path}: a joint has a line of its own in this format; give {point} one joint name"
                )
            wanted.append(KINECT_V2.index(name))
        lines = _Lines(path)
        frames: dict[str, list[int]] = {}
        rows: dict[str, list[list[float]]] = {}
        promised = lines.count("the number of frames")
        empty = read = 0
        for frame in range(promised):
            people = lines.count(f"the number of people in frame {frame} of {promised}")
            empty += people == 0
            for _ in range(people):
                person = lines.numbers(_PERSON_NUMBERS, "a person's ten numbers")[0]
                if lines.count("the number of joints") != len(KINECT_V2):
                    raise RecordingError(
                        f"{path}: line {lines.number}: a person of other than {len(KINECT_V2)} joints; repair it"
                    )
                frames.setdefault(person, []).append(frame)
                rows.setdefault(person, []).append(lines.joints(wanted, len(KINECT_V2)))
                read += 1
                if read > _MOST_SKELETONS:
                    raise RecordingError(f"{path}: more than {read} skeletons; cut the recording into shorter files")
        lines.require_end(promised)
        bodies: dict[str, Body] = {}
        for person, numbers in frames.items():
            values = np.array(rows[person]).reshape(-1, len(POINTS), 8)
            confidence = np.clip(np.nan_to_num(values[..., 3]), 0.0, 2.0) / 2.0
            turns = values[:, WRISTS, 4:]
            bodies[person] = Body(values[..., :3], np.array(numbers), confidence=confidence, orientations=turns)
        return RawRecording(bodies, unit="m", clock_hz=CLOCK_HZ, up="y", empty_frames=empty)


class _Lines:
    """The file's non-blank lines one after the other, with what is expected of each."""

    def __init__(self, path: Path):
        self._path = path
        self._blocks = text_blocks(path)
        self._numbers: list[int] = []
        self._lines: list[str] = []
        self._next = 0
        self.number = 0  # Of the line last taken.

    def count(self, what: str) -> int:
        """The next line's only number, whole and not negative."""
        (text,) = self.numbers(1, what)
        if not (text.isdecimal() and len(text) < 19):
            raise self._error(f"{text[:40]!r} is not {what}")
        return int(text)

    def numbers(self, how_many: int, what: str) -> list[str]:
        """The next line's cells."""
        (line,) = self._take(1, what)
        cells = line.split()
        if len(cells) != how_many:
            raise self._error(f"{len(cells)} cells, expected {what}")
        return cells

    def joints(self, wanted: list[int], how_many: int) -> list[float]:
        """x, y, z, tracking state and orientation w x y z of the `wanted` ones of the next lines, one joint each."""
        lines = self._take(how_many, f"the lines of {how_many} joints")
        first = self.number - how_many + 1
        if set(map(_count_blanks, lines)) != {_JOINT_NUMBERS - 1}:
            for number, line in enumerate(lines, first):
                if len(line.split()) != _JOINT_NUMBERS:
                    self.number = number
                    raise self._error(f"{len(line.split())} cells, expected a joint's {_JOINT_NUMBERS} numbers")
        values: list[float] = []
        for joint in wanted:
            cells = lines[joint].split()
            try:
                if len(cells) != _JOINT_NUMBERS:
                    raise ValueError
                values += map(float, (*cells[:3], cells[_STATE], *cells[_TURN]))
            except ValueError:
                self.number = first + joint
                raise self._error(f"not the {_JOINT_NUMBERS} numbers of {KINECT_V2[joint]}") from None
        return values

    def require_end(self, promised: int) -> None:
        """Raises where the file goes on."""
        self._fill(1)
        if self._next < len(self._lines):
            self.number = self._numbers[self._next]
            raise self._error(f"more lines follow the {promised} frames that the file promises")

    def _take(self, how_many: int, what: str) -> list[str]:
        self._fill(how_many)
        taken = self._lines[self._next : self._next + how_many]
        if len(taken) < how_many:
            last = self._numbers[-1] if self._numbers else 0
            raise RecordingError(f"{self._path}: ends after line {last}, expected {what}; copy the file again")
        self._next += how_many
        self.number = self._numbers[self._next - 1]
        return taken

    def _fill(self, how_many: int) -> None:
        while len(self._lines) - self._next < how_many:
            first, text = next(self._blocks, (0, ""))
            if not text:
                return
            numbers, lines = kept_lines(first, text)
            self._numbers = self._numbers[self._next :] + numbers
            self._lines = self._lines[self._next :] + lines
            self._next = 0

    def _error(self, what: str) -> RecordingError:
        return RecordingError(f"{self._path}: line {self.number}: {what}; repair it or copy the file again")
