"""docs/diagram.md and its picture against the diagram of the default run."""

import re
from pathlib import Path

import pytest

from drake_blfdmp.evaluation.run_diagram import RunDiagramDot

DOCS = Path(__file__).resolve().parents[2] / "docs"
DRAKES = {
    "plant",
    "scene_graph",
    "recorder",
    "recorded_signals",
    "recorded_slow_signals",
    "points_and_margin",
    "ghost",
    "skeleton",
    "meshcat_visualizer(visualizer)",
}


@pytest.fixture(scope="module")
def boxes(default_plan):
    """System -> its ports, as drawn."""
    found = {}
    for table in re.findall(r"label=<(<TABLE.*?</TABLE>)>", RunDiagramDot(default_plan)):
        name = re.search(r"<B>([^<]+)</B>", table)[1]
        found[name] = [
            text.rsplit("</FONT>", 1)[-1].split(" (")[0]
            for text in re.findall(r'COLOR="#(?:263238|9E9E9E)">(.*?)</FONT></TD>', table)
        ]
    return found


def test_the_table_has_every_system_and_port(boxes):
    rows = [line for line in (DOCS / "diagram.md").read_text(encoding="utf-8").splitlines() if line.startswith("| `")]
    for name, ports in boxes.items():
        (row,) = [row for row in rows if f"`{name}`" in row.split("|")[1]]
        documented = re.findall(r"`([^`]+)`", "".join(row.split("|")[3:5]))
        if name not in DRAKES:
            assert sorted(documented) == sorted(ports), name


def test_the_picture_is_of_this_diagram(boxes):
    picture = (DOCS / "figures" / "diagram.svg").read_text(encoding="utf-8")
    for name, ports in boxes.items():
        assert f">{name}<" in picture
        for port in ports:
            assert re.search(rf">{re.escape(port)}( \(\d+\))?<", picture), (name, port)
