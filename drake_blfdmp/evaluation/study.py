"""What a study is given and what it hands back: claims, figures and tables, checked as they are made.

A study is a script with a function `study(StudyContext) -> Study` and a scenario beside it; `study_runner` runs it and
`report` shows what came out.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.viewing.drawing import Drawing


@dataclass(frozen=True)
class Claim:
    """One sentence of the paper, or a target of the project's own, held against what was measured.

    Args:
        paper: what the paper, or the project's target, says.
        measured: what was measured, figures and units in words.
        holds: None where it cannot be judged.
        why: needed where `holds` is not True.
        timed: what was measured is time, so it differs from run to run; `study.mcap` does not hold it.

    Raises:
        BlfDmpError: a text is missing, or `holds` is none of the three.
    """

    paper: str
    measured: str
    holds: bool | None
    why: str = ""
    timed: bool = False

    def __post_init__(self):
        if isinstance(self.holds, np.bool_):
            object.__setattr__(self, "holds", bool(self.holds))
        if not self.paper.strip() or not self.measured.strip():
            raise BlfDmpError(f"claim '{self.paper}': needs what the paper says and what was measured")
        if not (self.holds is None or isinstance(self.holds, bool)):
            raise BlfDmpError(f"claim '{self.paper}': holds is {self.holds!r}; use True, False or None")
        if self.holds is not True and not self.why.strip():
            verdict = "cannot be judged" if self.holds is None else "does not hold"
            raise BlfDmpError(f"claim '{self.paper}': {verdict}, so say why")


@dataclass(frozen=True)
class Table:
    """Columns of one length: name with unit, for example "time_s", to (N,) numbers or strings.

    Args:
        timed: columns of times that a computation took; `study.mcap` does not hold them.

    Raises:
        BlfDmpError: no column, a column that is not one-dimensional, columns of different lengths, or `timed` names
            none.
    """

    columns: Mapping[str, Sequence | np.ndarray]
    timed: Sequence[str] = ()

    def __post_init__(self):
        shapes = {name: _shape(column) for name, column in self.columns.items()}
        flat = all(len(shape) == 1 for shape in shapes.values())
        if not shapes or not flat or len(set(shapes.values())) > 1:
            told = ", ".join(f"{name} {shape}" for name, shape in shapes.items()) or "none"
            raise BlfDmpError(f"table: columns must be one-dimensional and of one length, but there are: {told}")
        for name in self.timed:
            if name not in self.columns:
                raise BlfDmpError(f"table: timed names '{name}', which is no column; columns: {_listed(self.columns)}")

    def rows(self) -> list[tuple]:
        """The rows, as tuples of Python's own numbers and strings, columns in their order."""
        plain = (
            [value.item() if isinstance(value, np.generic) else value for value in c] for c in self.columns.values()
        )
        return list(zip(*plain, strict=True))


@dataclass(frozen=True)
class Study:
    """What a study hands back.

    Args:
        claims: in the order in which the report shows them.
        figures: file stem to drawing: what draws the figure, and from what. It is drawn from `study.mcap` alone.
        captions: the same stems to one sentence each.
        tables: file stem to table; each is written as a CSV file.
        notes: sentences, among them what stands in for data the paper never published.
        shown: stems of the small tables that the report prints in full.

    Raises:
        BlfDmpError: a part of another type, a figure without a caption or a caption without a figure, `shown` names no
            table, or a stem is not a plain file name.
    """

    claims: Sequence[Claim]
    figures: Mapping[str, Drawing]
    captions: Mapping[str, str]
    tables: Mapping[str, Table]
    notes: Sequence[str] = ()
    shown: Sequence[str] = ()

    def __post_init__(self):
        for name, parts, kind in (
            ("claims", self.claims, Claim),
            ("figures", self.figures.values(), Drawing),
            ("tables", self.tables.values(), Table),
            ("notes", [self.notes], list | tuple),
        ):
            for part in parts:
                if not isinstance(part, kind):
                    wanted = getattr(kind, "__name__", "list")
                    raise BlfDmpError(f"study: {name} holds a {type(part).__name__}; use {wanted}")
        for stem in (*self.figures, *self.tables):
            if not stem.replace("_", "").replace("-", "").isalnum() or not stem.isascii():
                raise BlfDmpError(f"study: '{stem}' is no file stem; use letters, digits, - and _")
        for stem in self.figures:
            if not self.captions.get(stem, "").strip():
                raise BlfDmpError(f"study: figure '{stem}' has no caption")
        for stem in self.captions:
            if stem not in self.figures:
                raise BlfDmpError(f"study: caption '{stem}' belongs to no figure; figures: {_listed(self.figures)}")
        for stem in self.shown:
            if stem not in self.tables:
                raise BlfDmpError(f"study: shown names '{stem}', which is no table; tables: {_listed(self.tables)}")


@dataclass(frozen=True)
class StudyContext:
    """What a study is given.

    Args:
        scenario: from the study's YAML file, with the command line's changes; `scenario.seed` seeds all that is random.
        quick: a version that takes seconds and runs the same code.
        progress: called with what is being done and the share of it done, 0 to 1.
        recordings: a folder of real recordings, or None.
        workers: processes that a heavy study may use.
        folder: the study's own, for files that it writes while it runs; None where it has none.
    """

    scenario: Scenario
    quick: bool
    progress: Callable[[str, float], None]
    recordings: Path | None
    workers: int = 2
    folder: Path | None = None


@dataclass(frozen=True)
class FigureFile:
    """A figure that stands as `<stem>.png` and `<stem>.svg` in its study's folder; `width` in inches."""

    caption: str
    width: float


@dataclass(frozen=True)
class StudyResult:
    """What is kept of one study that was to run; the report shows it.

    Args:
        state: "done", "failed", "interrupted" or "not run".
        command: repeats this study.
        seconds: taken; None where the study did not end.
        figures: stem to file, in the study's order.
        shown: stem to table, those printed in full.
        files: names in the study's folder, `<report's folder>/<name>`.
        error: why it failed, one line.
    """

    name: str
    description: str
    command: str
    state: str = "not run"
    seconds: float | None = None
    seed: int | None = None
    claims: Sequence[Claim] = ()
    figures: Mapping[str, FigureFile] = field(default_factory=dict)
    shown: Mapping[str, Table] = field(default_factory=dict)
    notes: Sequence[str] = ()
    files: Sequence[str] = ()
    error: str = ""

    def count(self, holds: bool | None) -> int:
        """How many claims have this verdict."""
        return sum(claim.holds is holds for claim in self.claims)


def _listed(names) -> str:
    return ", ".join(names) or "none"


def _shape(column) -> tuple[int, ...]:
    """The shape of a column; that of a ragged list, which has none, counts as two-dimensional."""
    try:
        return np.shape(column)
    except ValueError:
        return (len(column), -1)
