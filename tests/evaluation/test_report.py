"""The report of hand-made results: everything is in it, nothing of it is markup, and a browser shows it."""

import base64
import errno
import re
import shutil
import subprocess
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.evaluation import report
from drake_blfdmp.evaluation.report import VERDICTS, write_report
from drake_blfdmp.evaluation.study import Claim, FigureFile, StudyResult, Table
from drake_blfdmp.evaluation.summary import versions
from drake_blfdmp.viewing import style

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
BROWSER = next((found for found in map(shutil.which, BROWSERS) if found), None)
NASTY = '<b id="x">a & b</b> | `c` *d* [e](f) $g$ <script>document.title = "h"</script>'
VOID = {"meta", "img", "link", "br", "hr", "wbr"}
COMMAND = "python run.py studies --all"


@style.styled
def draw(samples):
    """A thick line that fills much of its axes."""
    figure = Figure(figsize=(style.COLUMN, 2.0))
    figure.subplots().plot(np.linspace(0, 1, samples), np.zeros(samples), linewidth=60, color=style.BLUE)
    return figure


@pytest.fixture
def results(tmp_path):
    for name in ("hands", "law"):
        (tmp_path / name).mkdir()
        for ending in ("png", "svg"):
            style.save(draw(50), tmp_path / name / f"line.{ending}")
    hands = StudyResult(
        "hands",
        "Fig. 10: the distance between the hands.",
        "python run.py studies hands",
        state="done",
        seconds=12.34,
        seed=3,
        claims=(
            Claim("inside the band", "0 violations of 1200", True),
            Claim("after about 15 samples", "7 samples", False, "the funnel opens to the start"),
            Claim("a video", "nothing", None, NASTY),
        ),
        figures={"line": FigureFile("The distance, in m.", 3.5)},
        shown={"least": Table({"link": ["hands", NASTY], "error_m": np.array([1.23461, np.nan]), "ok": [True, False]})},
        notes=("The recording is synthetic.", "1. no list"),
        files=("line.png", "line.svg", "series.csv"),
    )  # fmt: skip
    law = replace(hands, name="law", description=NASTY, claims=(Claim("c", "d", True),), shown={}, notes=(), seed=4)
    law = replace(law, figures={"line": FigureFile(NASTY, 3.5)})
    broken = StudyResult("broken", "Breaks.", "python run.py studies broken", "failed", 0.1, error=f"KeyError: {NASTY}")
    return [hands, law, broken, StudyResult("later", "Comes later.", "python run.py studies later")]


def write(results, folder, quick=False):
    """The texts of report.html and report.md."""
    page = write_report(folder, results, quick=quick, command=COMMAND)
    assert page == folder / "report.html"
    return page.read_text(encoding="utf-8"), (folder / "report.md").read_text(encoding="utf-8")


class Page(HTMLParser):
    """A page's tags, properly nested, its texts, links, images and tables."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.texts, self.ids, self.links, self.images, self.tables = [], [], [], [], [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.append(tag)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.links += [attributes["href"]] if tag == "a" else []
        self.images += [attributes] if tag == "img" else []
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("td", "th"):
            self.tables[-1][-1].append("")
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if {"td", "th"} & set(self.open):
            self.tables[-1][-1][-1] += data
        self.texts.append(data)


def test_the_page_holds_everything_and_is_sound(results, tmp_path):
    page = Page(write(results, tmp_path)[0])
    text = " ".join(page.texts)
    for result in results:
        assert result.name in page.texts
        assert result.command in page.texts
        for claim in result.claims:
            assert {claim.paper, claim.measured, VERDICTS[claim.holds]} <= set(page.texts)
            assert claim.why in text
        for figure in result.figures.values():
            assert figure.caption in page.texts
        assert set(result.notes) | set(result.files) <= set(page.texts)
    assert COMMAND in page.texts
    for name, version in versions().items():
        assert f"{name} {version}" in text
    assert "hands 3, law 4" in text
    assert "2 of 4 studies done. Claims: 2 hold, 1 do not hold, 1 cannot be judged." in text
    assert f"failed: KeyError: {NASTY}" in page.texts


def test_the_summary_counts_claims(results, tmp_path):
    summary = Page(write(results, tmp_path)[0]).tables[0]
    assert [row[0] for row in summary[1:]] == ["hands", "law", "broken", "later"]
    assert [row[2:] for row in summary[1:]] == [
        ["1", "1", "1", "12.3", "done"],
        ["1", "0", "0", "12.3", "done"],
        ["-", "-", "-", "0.1", "failed"],
        ["-", "-", "-", "-", "not run"],
    ]


def test_verdicts_differ_in_word_and_sign(results, tmp_path):
    claims = next(table for table in Page(write(results, tmp_path)[0]).tables if "verdict" in table[0])
    assert [row[2] for row in claims[1:]] == ["✓ holds", "✗ does not hold", "? cannot be judged"]
    assert [row[3] for row in claims[1:]] == ["", "the funnel opens to the start", NASTY]


def test_shown_tables_are_printed_and_missing_numbers_are_a_dash(results, tmp_path):
    table = next(table for table in Page(write(results, tmp_path)[0]).tables if "error_m" in table[0])
    assert table == [["link", "error_m", "ok"], ["hands", "1.2346", "yes"], [NASTY, "-", "no"]]


def test_every_link_within_the_page_has_its_target_once(results, tmp_path):
    html, markdown = write(results, tmp_path)
    page = Page(html)
    inner = [link[1:] for link in page.links if link.startswith("#")]
    assert len(inner) == 2 * len(results) + 1  # Contents and summary, and how it was made.
    assert all(page.ids.count(target) == 1 for target in inner)
    assert "hands/series.csv" in page.links
    for target in re.findall(r"\]\(#([^)]+)\)", markdown):
        assert markdown.count(f'<a id="{target}"></a>') == 1


def test_the_page_needs_nothing_else(results, tmp_path):
    html = write(results, tmp_path)[0]
    page = Page(html)
    assert not {"script", "link", "iframe", "object"} & set(page.tags)
    assert "default-src 'none'" in html
    assert len(page.images) == 2
    for image in page.images:
        kind, data = image["src"].split(";base64,")
        assert kind == "data:image/svg+xml"
        assert base64.b64decode(data) == (tmp_path / "hands" / "line.svg").read_bytes()
    assert not re.search(r"""(src|href)=["'](https?:|//|file:)""", html)
    assert "url(" not in html


def test_a_figure_too_large_as_svg_goes_in_as_png(results, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "LARGEST_SVG", 100)
    for image in Page(write(results, tmp_path)[0]).images:
        kind, data = image["src"].split(";base64,")
        assert kind == "data:image/png"
        assert base64.b64decode(data) == (tmp_path / "hands" / "line.png").read_bytes()


def test_nothing_said_is_taken_for_markup(results, tmp_path):
    html, markdown = write(results, tmp_path)
    page = Page(html)
    assert "b" not in page.tags
    assert "x" not in page.ids
    assert page.texts.count(NASTY) >= 4  # A why, a cell, a description, a caption.
    assert [image["alt"] for image in page.images] == ["The distance, in m.", NASTY]
    assert "<b" not in markdown and "<script" not in markdown
    for sign in ("|", "`", "*", "[", "$"):
        nasty = next(line for line in markdown.splitlines() if line.startswith("&lt;b"))
        assert not re.search(rf"(?<!\\){re.escape(sign)}", nasty), sign
    assert r"- 1\. no list" in markdown


def test_rows_of_markdown_have_as_many_cells_as_their_headers(results, tmp_path):
    grids = [block for block in write(results, tmp_path)[1].split("\n\n") if block.startswith("| ")]
    assert len(grids) == 4
    for grid in grids:
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in grid.splitlines()}) == 1


def test_markdown_shows_the_figures_beside_it(results, tmp_path):
    pictures = re.findall(r"!\[.*\]\((.*)\)$", write(results, tmp_path)[1], re.MULTILINE)
    assert pictures == ["hands/line.png", "law/line.png"]
    assert all((tmp_path / path).is_file() for path in pictures)


def test_the_quick_version_says_that_it_is_one(results, tmp_path):
    assert all("Quick version" not in text for text in write(results, tmp_path))
    assert all("Quick version" in text for text in write(results, tmp_path, quick=True))


def test_the_same_results_give_the_same_bytes_and_leave_nothing_else(results, tmp_path):
    first = write(results, tmp_path)
    assert write(results, tmp_path) == first
    assert {path.name for path in tmp_path.iterdir()} == {"hands", "law", "report.html", "report.md"}


def test_a_report_that_cannot_be_made_is_one_line(results, tmp_path):
    (tmp_path / "law" / "line.svg").unlink()
    with pytest.raises(BlfDmpError, match="cannot be written .*line.svg"):
        write(results, tmp_path)


def test_a_full_disk_leaves_the_report_that_was_there(results, tmp_path, monkeypatch):
    before = write(results[:1], tmp_path)
    whole = Path.write_text

    def half(path, text, **how):
        whole(path, text[: len(text) // 2], **how)
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    with monkeypatch.context() as patched, pytest.raises(BlfDmpError, match="No space left"):
        patched.setattr(Path, "write_text", half)
        write(results, tmp_path)
    after = [(tmp_path / name).read_text(encoding="utf-8") for name in ("report.html", "report.md")]
    assert tuple(after) == before


@pytest.mark.skipif(BROWSER is None, reason=f"no browser on the path, tried {', '.join(BROWSERS)}")
def test_a_browser_shows_the_figures(results, tmp_path):
    write(results, tmp_path)
    picture = tmp_path / "picture.png"
    switches = "headless no-sandbox use-angle=swiftshader enable-unsafe-swiftshader no-first-run disable-quic "
    switches += "disable-background-networking disable-component-update disable-sync hide-scrollbars "
    switches += "enable-logging=stderr window-size=1000,1200"
    command = [BROWSER, *(f"--{switch}" for switch in switches.split()), f"--user-data-dir={tmp_path / 'profile'}"]
    command += [f"--screenshot={picture}", (tmp_path / "report.html").as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    pixels = imread(picture)[..., :3]
    blue = np.all(np.abs(pixels - np.array([0x00, 0x72, 0xB2]) / 255) < 0.03, axis=-1)
    assert blue.sum() > 10_000, "no figure"  # Links and rules alone are a few hundred.
    assert "Content Security Policy" not in done.stderr
