"""The report of a row of studies: `report.html`, one file with its figures inside, and `report.md` beside the figures.

Both are made of the same blocks, so that they say the same. Nothing in them depends on the clock but the seconds taken.
"""

import base64
import html
import platform
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import matplotlib

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation.study import FigureFile, StudyResult
from drake_blfdmp.evaluation.summary import versions
from drake_blfdmp.viewing.style import BLUE, DARK, VERMILLION

VERDICTS: Mapping[bool | None, str] = {True: "✓ holds", False: "✗ does not hold", None: "? cannot be judged"}
LARGEST_SVG = 400_000
"""Bytes up to which a figure goes into the page as SVG; beyond, a PNG is smaller and quicker to show."""
_SCREEN = 1.3 * 96.0
"""Pixels of the page for an inch of a figure: its 7.5 point letters are made for paper."""


def write_report(folder: Path, results: Sequence[StudyResult], *, quick: bool, command: str) -> Path:
    """Writes `report.md` and `report.html` into `folder`, each whole or not at all; returns the latter.

    Args:
        results: in the order of the report, with those not run yet.
        quick: whether the studies ran in their quick version, which the report then says.
        command: the command line that ran them.

    Raises:
        BlfDmpError: a file cannot be written, or a figure's file is not there.
    """
    blocks = [*_opening(results, quick), *(block for result in results for block in _section(result))]
    blocks += _closing(results, command)
    page = folder / "report.html"
    try:
        for path, text in ((folder / "report.md", _markdown(blocks)), (page, _html(blocks, folder))):
            part = path.with_name(f"{path.name}.part")
            part.write_text(text, encoding="utf-8")
            part.replace(path)
    except OSError as error:
        raise BlfDmpError(f"report in {folder}: cannot be written ({error.strerror}: {error.filename})") from error
    return page


# What is said: blocks, without a thought for the format.


@dataclass(frozen=True)
class _Heading:
    level: int
    text: str
    anchor: str = ""


@dataclass(frozen=True)
class _Text:
    text: str
    kind: str = ""  # "", "warning" or "code"


@dataclass(frozen=True)
class _Link:
    text: str
    target: str


@dataclass(frozen=True)
class _Items:
    items: Sequence[str | _Link]


@dataclass(frozen=True)
class _Grid:
    kind: str  # "summary", "claims" or "data"
    header: Sequence[str]
    rows: Sequence[Sequence[str | _Link]]


@dataclass(frozen=True)
class _Picture:
    stem: str  # Path without its ending, from the report's folder.
    file: FigureFile


_Block = _Heading | _Text | _Items | _Grid | _Picture


def _opening(results: Sequence[StudyResult], quick: bool) -> list[_Block]:
    done = sum(result.state == "done" for result in results)
    claims = ", ".join(
        f"{sum(result.count(holds) for result in results)} {verdict}"
        for holds, verdict in ((True, "hold"), (False, "do not hold"), (None, "cannot be judged"))
    )
    blocks: list[_Block] = [_Heading(1, "Studies"), _Text(f"{done} of {len(results)} studies done. Claims: {claims}.")]
    if quick:
        warning = "Quick version: it runs the same code on less, so its numbers are no results."
        blocks.append(_Text(warning, "warning"))
    rows = []
    for result in results:
        counts = [str(result.count(holds)) if result.state == "done" else "-" for holds in (True, False, None)]
        taken = "-" if result.seconds is None else f"{result.seconds:.1f}"
        rows.append([_Link(result.name, f"#{_anchor(result)}"), result.description, *counts, taken, result.state])
    header = ("study", "what", *(text for text in VERDICTS.values()), "time (s)", "state")
    return [*blocks, _Grid("summary", header, rows)]


def _section(result: StudyResult) -> list[_Block]:
    blocks: list[_Block] = [_Heading(2, result.name, _anchor(result)), _Text(result.description)]
    if result.state == "failed":
        blocks.append(_Text(f"failed: {result.error}", "warning"))
    elif result.state != "done":
        blocks.append(_Text("interrupted before its end" if result.state == "interrupted" else "not run", "warning"))
    blocks += [_Picture(f"{result.name}/{stem}", file) for stem, file in result.figures.items()]
    if result.claims:
        rows = [(claim.paper, claim.measured, VERDICTS[claim.holds], claim.why) for claim in result.claims]
        blocks += [
            _Heading(3, "Claims"),
            _Grid("claims", ("the paper, or the target", "measured", "verdict", "why"), rows),
        ]
    for stem, table in result.shown.items():
        rows = [[_number(value) for value in row] for row in table.rows()]
        blocks += [_Heading(3, f"Table {stem}"), _Grid("data", list(table.columns), rows)]
    if result.notes:
        blocks += [_Heading(3, "Notes"), _Items(result.notes)]
    if result.files:
        links = [_Link(name, f"{result.name}/{name}") for name in result.files]
        blocks += [_Heading(3, "Files"), _Items(links)]
    return [*blocks, _Heading(3, "To repeat it"), _Text(result.command, "code")]


def _closing(results: Sequence[StudyResult], command: str) -> list[_Block]:
    found = {"python": platform.python_version(), **versions(), "matplotlib": matplotlib.__version__}
    seeds = {result.name: result.seed for result in results if result.seed is not None}
    same = len(set(seeds.values())) == 1
    told = f"{next(iter(seeds.values()))} in all" if same else ", ".join(f"{k} {v}" for k, v in seeds.items()) or "-"
    return [
        _Heading(2, "How it was made", "how-it-was-made"),
        _Text(f"Versions: {', '.join(f'{name} {version}' for name, version in found.items())}."),
        _Text(f"Seed: {told}."),
        _Text(command, "code"),
    ]


def _anchor(result: StudyResult) -> str:
    return f"study-{result.name}"


def _number(value) -> str:
    if value is None or value != value:  # NaN alone differs from itself.
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


# How it is written: Markdown.


def _markdown(blocks: Sequence[_Block]) -> str:
    return "\n\n".join(_markdown_block(block) for block in blocks) + "\n"


def _markdown_block(block: _Block) -> str:
    match block:
        case _Heading():
            anchor = f'<a id="{html.escape(block.anchor)}"></a>\n\n' if block.anchor else ""
            return f"{anchor}{'#' * block.level} {_plain(block.text)}"
        case _Text(kind="code"):
            return f"    {' '.join(block.text.split())}"
        case _Text():
            return f"**{_plain(block.text)}**" if block.kind == "warning" else _plain(block.text)
        case _Items():
            return "\n".join(f"- {_plain(item)}" for item in block.items)
        case _Picture():
            caption = _plain(block.file.caption)
            return f"![{caption}]({quote(block.stem)}.png)\n\n*{caption}*"
        case _Grid():
            rows = [block.header, ["---"] * len(block.header), *block.rows]
            cells = [[cell if row is rows[1] else _plain(cell) for cell in row] for row in rows]
            return "\n".join(f"| {' | '.join(row)} |" for row in cells)


def _plain(text: str | _Link) -> str:
    """One line of Markdown that shows as `text`, whatever is in it."""
    if isinstance(text, _Link):
        return f"[{_plain(text.text)}]({quote(text.target, safe='/#')})"
    line = html.escape(" ".join(text.split()), quote=False)
    line = re.sub(r"([\\`*\[\]|~$#]|(?<!\w)_|_(?!\w))", r"\\\1", line)
    return re.sub(r"^(\d*)([.)+-])(?=\s)", r"\1\\\2", line)


# How it is written: HTML.

_STYLE = f"""
:root {{ color-scheme: light; }}
body {{ font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; color: {DARK}; background: #fff;
  max-width: 960px; margin: 2rem auto; padding: 0 1rem; }}
h1, h2, h3 {{ line-height: 1.25; break-after: avoid; overflow-wrap: anywhere; }}
h1 {{ font-size: 1.7rem; }}
h2 {{ font-size: 1.3rem; margin-top: 3rem; padding-top: 1rem; border-top: 2px solid {BLUE}; }}
h3 {{ font-size: 1rem; margin: 1.6rem 0 0.5rem; }}
a {{ color: {BLUE}; }}
nav ol, ul.files {{ columns: 15rem; padding-left: 1.4rem; }}
.wide {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 0.88rem; }}
table.summary, table.claims {{ width: 100%; }}
th, td {{ text-align: left; vertical-align: top; padding: 0.35rem 0.7rem 0.35rem 0; border-bottom: 1px solid #E4E4E4; }}
thead th {{ border-bottom: 1px solid {DARK}; font-weight: 600; }}
tr {{ break-inside: avoid; }}
table.claims th:nth-child(1), table.claims th:nth-child(2) {{ width: 27%; }}
table.claims td:nth-child(3) {{ white-space: nowrap; font-weight: 600; }}
table.data td, table.summary td:nth-child(n + 3) {{ font-variant-numeric: tabular-nums; }}
table.data th, table.data td {{ padding-right: 1.4rem; }}
.holds {{ color: #00694D; }} .fails {{ color: #A84300; font-weight: 600; }}
.figures {{ display: flex; flex-wrap: wrap; gap: 0.5rem 1.5rem; align-items: flex-start; }}
figure {{ margin: 0.8rem 0; max-width: 100%; break-inside: avoid; }}
figure img {{ width: 100%; height: auto; display: block; }}
figcaption {{ font-size: 0.85rem; color: #555; margin-top: 0.3rem; }}
.warning {{ border-left: 4px solid {VERMILLION}; padding: 0.3rem 0.8rem; font-weight: 600; overflow-wrap: anywhere; }}
pre {{ background: #F4F4F4; padding: 0.6rem 0.8rem; font-size: 0.85rem; white-space: pre-wrap;
  overflow-wrap: anywhere; }}
@media print {{ body {{ font-size: 10pt; margin: 0; max-width: none; padding: 0; }} .wide {{ overflow: visible; }} }}
"""
# No script and no network, by the page's own order.
_POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"


def _html(blocks: Sequence[_Block], folder: Path) -> str:
    entries = [block for block in blocks if isinstance(block, _Heading) and block.level == 2]
    links = "".join(f"<li>{_cell(_Link(entry.text, f'#{entry.anchor}'))}</li>" for entry in entries)
    body: list[str] = []
    for i, block in enumerate(blocks):
        picture, after = isinstance(block, _Picture), i and isinstance(blocks[i - 1], _Picture)
        if picture and not after:
            body.append('<div class="figures">')
        elif after and not picture:
            body.append("</div>")
        if block is entries[0]:
            body.append(f"<nav><h3>Contents</h3><ol>{links}</ol></nav>")
        body.append(_html_block(block, folder))
    head = f'<meta charset="utf-8">\n<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
    head += '<meta name="viewport" content="width=device-width">\n'
    head += f"<title>{html.escape(blocks[0].text)}</title>\n<style>{_STYLE}</style>"
    lines = "\n".join(body)
    return f'<!DOCTYPE html>\n<html lang="en">\n<head>\n{head}\n</head>\n<body>\n{lines}\n</body>\n</html>\n'


def _html_block(block: _Block, folder: Path) -> str:
    match block:
        case _Heading():
            anchor = f' id="{html.escape(block.anchor)}"' if block.anchor else ""
            return f"<h{block.level}{anchor}>{html.escape(block.text)}</h{block.level}>"
        case _Text(kind="code"):
            return f"<pre>{html.escape(block.text)}</pre>"
        case _Text():
            kind = f' class="{block.kind}"' if block.kind else ""
            return f"<p{kind}>{html.escape(block.text)}</p>"
        case _Items():
            kind = ' class="files"' if block.items and isinstance(block.items[0], _Link) else ""
            return f"<ul{kind}>{''.join(f'<li>{_cell(item)}</li>' for item in block.items)}</ul>"
        case _Picture():
            caption = html.escape(block.file.caption)
            image = f'<img alt="{caption}" src="{_data_uri(folder / block.stem)}">'
            width = f"width: {block.file.width * _SCREEN:.0f}px"
            return f'<figure style="{width}">{image}<figcaption>{caption}</figcaption></figure>'
        case _Grid():
            # Columns' names may break at their underscores, so that a wide table still fits a printed page.
            header = "".join(f"<th>{html.escape(text).replace('_', '_<wbr>')}</th>" for text in block.header)
            rows = "\n".join(f"<tr>{''.join(_table_cell(cell, block) for cell in row)}</tr>" for row in block.rows)
            grid = f'<table class="{block.kind}"><thead><tr>{header}</tr></thead>\n<tbody>{rows}</tbody></table>'
            return f'<div class="wide">{grid}</div>'


def _cell(cell: str | _Link) -> str:
    if isinstance(cell, _Link):
        return f'<a href="{quote(cell.target, safe="/#")}">{html.escape(cell.text)}</a>'
    return html.escape(cell)


def _table_cell(cell: str | _Link, grid: _Grid) -> str:
    kinds = {
        "claims": {VERDICTS[True]: "holds", VERDICTS[False]: "fails"},
        "summary": {"failed": "fails", "interrupted": "fails", "not run": "fails"},
    }.get(grid.kind, {})
    kind = f' class="{kinds[cell]}"' if cell in kinds else ""
    return f"<td{kind}>{_cell(cell)}</td>"


def _data_uri(path: Path) -> str:
    """The figure at `path` (without ending), as a data URI."""
    vector = path.with_name(f"{path.name}.svg")
    if vector.stat().st_size <= LARGEST_SVG:
        return f"data:image/svg+xml;base64,{base64.b64encode(vector.read_bytes()).decode()}"
    return f"data:image/png;base64,{base64.b64encode(path.with_name(f'{path.name}.png').read_bytes()).decode()}"
