"""Tables with a header: one row a sample, three columns a joint, in any order and with any other columns between.

Columns are a joint's name and an axis: `WristLeftX`, `left_wrist_x`, `LWrist.x`, `x_LWrist`, optionally with
a unit, `WristLeftX (mm)`; or a header of two rows, joints above axes. Columns for time, frame number, person,
confidence (`WristLeft_state`) and the wrists' or hands' orientations (`WristLeftQw` to `Qz`, `HandLeft_qw`) are used
where they are there. Vicon's and Qualisys' text tables are such tables.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_numbers
from drake_blfdmp.demonstration.formats.point_names import guess, listed, normalise, resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.sensor_joints import joints_by_number, sensor_by_names
from drake_blfdmp.demonstration.formats.tables.table_header import Header, columns_of_words, find_header, first_rows
from drake_blfdmp.demonstration.formats.tables.table_names import (
    JointColumns,
    body_column,
    confidence_columns,
    frame_column,
    joints_of,
    quaternions_of,
    time_column,
)
from drake_blfdmp.demonstration.formats.tables.table_rows import (
    clock_values,
    confidence_values,
    frame_values,
    split_people,
)
from drake_blfdmp.demonstration.formats.tables.tables import Columns, count_frames, read_columns
from drake_blfdmp.demonstration.formats.text import head_lines, numbered_lines
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.skeleton import POINTS, WRISTS


class WideCsv:
    """Reader of tables (comma, semicolon, tab, blanks) with a header; `joints` names stems or columns, "time" one."""

    name = "wide_csv"

    def sniff(self, head: bytes) -> bool:
        """Whether some line names joints' axes, or stands as a line of words right above a row of numbers."""
        return _find_header(enumerate(head_lines(head), 1)) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file.

        Raises:
            RecordingError: no header, a joint that is not there, a row with other columns than the header has, or a
                cell that is no number.
        """
        header = _find_header(numbered_lines(path))
        if header is None:
            raise RecordingError(
                f"{path}: no line names columns x, y and z of joints; add a header or give another format"
            )
        names = header.names
        points = _find_points(path, names, joints)
        time, time_unit = time_column(str(path), names, joints)
        frame, person = frame_column(names), body_column(names)
        nameless = not names[0] and time is None and frame is None
        if nameless:
            time = 0  # An index, as of pandas.
        dialect, rows = first_rows(numbered_lines(path, header.line + 1), len(names))
        turns = [column for columns in points.orientations for column in columns or ()]
        optional = {c for c in (time, frame, *points.confidence, *turns) if c is not None}
        words = columns_of_words(rows, optional) | ({person} - {None})
        numbers = dict.fromkeys([*points.columns, *(optional - words)])
        table = read_columns(
            path, dialect, len(names), list(numbers), list(words), first_line=header.line + 1, names=names
        )
        x = np.stack([table.numbers[column] for column in points.columns], axis=-1).reshape(-1, len(POINTS), 3)
        t, written_unit = clock_values(path, table, time, names[time] if time is not None else "")
        frames = frame_values(path, table, frame, names[frame] if frame is not None else "")
        if nameless and t is not None and count_frames(t):
            t, frames = None, t.astype(int)
        confidence, said = confidence_of_numbers(confidence_values(table, points.confidence), x)
        orientations = _orientations(table, points.orientations, len(x))
        bodies, empty = split_people(
            table.words[person] if person is not None else None, x, t, frames, confidence, orientations
        )
        return RawRecording(
            bodies,
            unit=points.unit or header.unit,
            time_unit=written_unit or time_unit,
            clock_hz=header.rate_hz,
            up=points.up,
            empty_frames=empty,
            notes=tuple(note for note in (points.note, said) if note),
        )


class _Points(NamedTuple):
    """The 18 columns of the points, those of their confidence and of the hands' orientations, and what names tell."""

    columns: list[int]
    confidence: list[int | None]
    orientations: list[tuple[int, int, int, int] | None]
    unit: str | None
    up: str | None
    note: str


def _find_header(lines: Iterable[tuple[int, str]]) -> Header | None:
    return find_header(lines, lambda names: bool(joints_of(names)), any_names=True)


def _find_points(path: Path, names: Sequence[str], joints: Joints | None) -> _Points:
    stems = joints_of(names)
    said = confidence_columns(names)
    stems, said, up, note = _named_by_number(stems, said)
    chosen = resolve(str(path), list(stems), joints)
    columns: list[int] = []
    confidence: list[int | None] = []
    units: set[str | None] = set()
    for point in POINTS:
        name = chosen[point]
        if isinstance(name, str):
            columns += stems[name].columns
            units.add(stems[name].unit)
            confidence.append(said.get(normalise(name)))
            continue
        absent = [column for column in name if column not in names]
        if len(name) != 3 or absent:
            raise RecordingError(
                f"{path}: {point} needs three columns, x, y and z, got {listed(list(name))}; "
                f"the file has {listed(names)}"
            )
        columns += [list(names).index(column) for column in name]
        confidence.append(None)
    units.discard(None)
    if len(units) > 1:
        raise RecordingError(f"{path}: columns in different units ({', '.join(sorted(map(str, units)))}); give unit")
    return _Points(columns, confidence, _quaternions(names, chosen), next(iter(units), None), up, note)


def _quaternions(
    names: Sequence[str], chosen: Mapping[str, str | Sequence[str]]
) -> list[tuple[int, int, int, int] | None]:
    """The columns of left and right hand's orientation: the wrist's, or else those of a joint called hand."""
    found = quaternions_of(names)
    columns = []
    for wrist in WRISTS:
        side = POINTS[wrist].split("_")[0]
        name = chosen[POINTS[wrist]]
        stems = [normalise(name)] if isinstance(name, str) else []
        stems += [stem for stem in guess(found).values() if guess([stem]).get(POINTS[wrist])]
        stems += [f"hand{side}", f"{side}hand"]
        columns.append(next((found[stem] for stem in stems if stem in found), None))
    return columns


def _orientations(table: Columns, columns: Sequence[Sequence[int] | None], count: int) -> np.ndarray | None:
    """The hands' orientations (N, 2, 4); None where no column has any."""
    if not any(columns):
        return None
    q = np.full((count, 2, 4), np.nan)
    for hand, own in enumerate(columns):
        if own is not None and all(column in table.numbers for column in own):
            q[:, hand] = np.stack([table.numbers[column] for column in own], axis=-1)
    return q


def _named_by_number(
    stems: dict[str, JointColumns], said: dict[str, int]
) -> tuple[dict[str, JointColumns], dict[str, int], str | None, str]:
    """Columns such as `joint12_x` under the names of the sensor that numbers its joints so; its up axis, and a note."""
    if guess(stems):
        sensor = sensor_by_names(stems)
        return (stems, said, None, "") if sensor is None else (stems, said, sensor[1], f"joints: all of a {sensor[0]}")
    numbered = {int(match[1]): stem for stem in stems if (match := re.fullmatch(r"\D*(\d{1,3})\D*", stem))}
    known = joints_by_number(numbered)
    if known is None or len(numbered) < len(stems):
        return stems, said, None, ""
    renamed = {known.names[number]: stems[stem] for number, stem in numbered.items()}
    confidence = {
        normalise(known.names[number]): said[normalise(stem)]
        for number, stem in numbered.items()
        if normalise(stem) in said
    }
    return renamed, confidence, known.up, f"joints: numbered as by {known.sensor}"
