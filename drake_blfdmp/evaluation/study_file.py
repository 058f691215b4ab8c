"""A study's file, `study.mcap`: what the study found and all that its figures are drawn from.

Equal scenarios give equal files, byte for byte. What the clock of the machine has a say in (`Claim.timed`,
`Table.timed`) is therefore left out. docs/study_files.md says what stands where.
"""

import csv
import hashlib
import heapq
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from drake_blfdmp.evaluation.study import Claim, Study, Table
from drake_blfdmp.evaluation.summary import versions
from drake_blfdmp.planning.scenario import DumpScenario, Scenario
from drake_blfdmp.recording.mcap_file import McapFile
from drake_blfdmp.recording.plain_data import json_bytes
from drake_blfdmp.ros2.messages import JOINT_STATE, joint_state_template
from drake_blfdmp.viewing.redrawing import RECORD

FILE = "study.mcap"
TIME = "time_s"
"""A table whose first column has this name is a topic, too."""

_LATEST_S = 2.0**31
"""The seconds of a ROS 2 time stamp end there."""


def csv_text(table: Table) -> str:
    """A table as CSV with one line of names above; numbers with every digit they have."""
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(table.rows())
    return stream.getvalue()


def write_study(path: Path, study: Study, scenario: Scenario, about: Mapping[str, Any]) -> None:
    """Write a study's file.

    Args:
        path: must not exist.
        scenario: what was studied.
        about: further entries of the metadata record, as name, description and whether the study was quick.

    Raises:
        RecorderError: the file exists, or cannot be written.
        PlainDataError: a figure is to be drawn from something that cannot be kept; says from what.
    """
    text = DumpScenario(scenario).encode()
    # All of it is made before the file is begun: a drawing that cannot be kept leaves none.
    tables = {stem: _timeless(table) for stem, table in study.tables.items()}
    attachments = {"scenario.yaml": (text, "application/yaml"), "study.json": (_document(study), "application/json")}
    for stem, table in tables.items():
        if table is not None:
            attachments[f"tables/{stem}.csv"] = (csv_text(table).encode(), "text/csv")
    for stem, drawing in study.figures.items():
        attachments |= drawing.attachments(stem)
    file = McapFile(path)
    try:
        file.add_metadata(
            RECORD,
            {
                **about,
                "seed": scenario.seed,
                "law": scenario.law,
                "synthetic": scenario.recording.file is None,
                "recording": scenario.recording.file or "",
                "scenario_sha256": hashlib.sha256(text).hexdigest(),
                **{f"version_{name}": value for name, value in versions().items()},
            },
        )
        _write_series(file, tables)
        for name, (data, media_type) in attachments.items():
            file.add_attachment(name, data, media_type)
    finally:
        file.close()


def _document(study: Study) -> bytes:
    """Claims, captions and notes."""

    def told(claim: Claim) -> dict:
        found = {} if claim.timed else {"measured": claim.measured, "holds": claim.holds, "why": claim.why}
        return {"paper": claim.paper, **found, "timed": claim.timed}

    return json_bytes(
        {
            "claims": [told(claim) for claim in study.claims],
            "captions": dict(study.captions),
            "notes": list(study.notes),
            "shown": list(study.shown),
            "timed": {stem: list(table.timed) for stem, table in study.tables.items() if table.timed},
        }
    )


def _timeless(table: Table) -> Table | None:
    """The table without its columns of times that were taken; None where it has no others."""
    columns = {name: column for name, column in table.columns.items() if name not in table.timed}
    return Table(columns) if columns else None


def _write_series(file: McapFile, tables: Mapping[str, Table | None]) -> None:
    """Every table over time as a topic of its own: a JointState a row, elements named as the columns."""
    topics = [
        _samples(i, file, stem, table)
        for i, (stem, table) in enumerate(tables.items())
        if table is not None and _is_series(table)
    ]
    for t_ns, _, channel, message in heapq.merge(*topics, key=lambda sample: sample[:2]):
        file.write(channel, t_ns, message)


def _is_series(table: Table) -> bool:
    """Whether the first column is a clock, that is not negative and does not go backwards, and there is more."""
    names = list(table.columns)
    if names[0] != TIME or not _numbers(table):
        return False
    t = np.asarray(table.columns[TIME], dtype=float)
    return bool(np.all((t >= 0.0) & (t < _LATEST_S)) and np.all(np.diff(t) >= 0.0))


def _numbers(table: Table) -> dict[str, np.ndarray]:
    """The columns of numbers beside the time."""
    columns = {name: np.asarray(column) for name, column in table.columns.items() if name != TIME}
    return {name: column for name, column in columns.items() if column.dtype.kind in "biuf"}


def _samples(rank: int, file: McapFile, stem: str, table: Table) -> Iterator[tuple[int, int, int, bytes]]:
    """Time in ns, `rank`, channel and message of every row."""
    columns = _numbers(table)
    template = joint_state_template(list(columns), velocity=False, effort=False)
    channel = file.add_channel(f"/{stem.replace('-', '_')}", JOINT_STATE, {"unit": "in the names"})
    rows = np.stack([column.astype(float) for column in columns.values()], axis=-1)
    for t, row in zip(np.asarray(table.columns[TIME], dtype=float), rows, strict=True):
        t_ns = round(t * 1e9)
        yield t_ns, rank, channel, template.encode(t_ns, row)
