"""The graph of a diagram: what is in it, that Graphviz draws it, and what is refused."""

import shutil
import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Integrator, VectorLogSink

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.diagram_graph import check_output, diagram_dot, write_diagram

needs_dot = pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz's dot is not installed")


@pytest.fixture(scope="module")
def diagram():
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source <1>", ConstantVectorSource([1.0, 2.0]))
    adder = builder.AddNamedSystem("adder", Adder(2, 2))
    memory = builder.AddNamedSystem("memory", Integrator(2))
    log = builder.AddNamedSystem("log", VectorLogSink(2))
    builder.Connect(source.get_output_port(), adder.get_input_port(0))
    builder.Connect(adder.get_output_port(), memory.get_input_port())
    builder.Connect(memory.get_output_port(), log.get_input_port())
    builder.ExportInput(adder.get_input_port(1))
    diagram = builder.Build()
    diagram.set_name('a "loop"')
    return diagram


GROUPS = {"numbers": ("source <1>", "adder", "memory", "not there"), "ears": ("log",)}


def test_systems_ports_and_connections_are_in_it(diagram):
    dot = diagram_dot(diagram, GROUPS)
    assert dot.startswith('digraph "a \\"loop\\""')
    assert "source &lt;1&gt;" in dot and "not there" not in dot
    for text in ('label="numbers"', 'label="ears"', "s0:y0:e -> s1:u0:w", "s1:y0:e -> s2:u0:w", "s2:y0:e -> s3:u0:w"):
        assert text in dot
    assert dot.count(" -> s") == 3
    assert "y0 (2)" in dot


def test_what_listeners_hear_is_written_at_their_ports(diagram):
    dot = diagram_dot(diagram, GROUPS, "ears")
    assert "s2:y0:e -> s3:u0:w" not in dot
    assert "memory.y0" in dot


def test_open_ports_are_shown_of_the_own_package_only(diagram):
    assert "u1 (2)" not in diagram_dot(diagram, GROUPS)
    assert '#9E9E9E">u1 (2)' in diagram_dot(diagram, GROUPS, own="pydrake")


@needs_dot
@pytest.mark.parametrize(
    ("suffix", "head"), [(".svg", b"<?xml"), (".png", b"\x89PNG"), (".pdf", b"%PDF"), (".SVG", b"<?xml")]
)
def test_graphviz_draws_it(diagram, suffix, head, tmp_path):
    path = tmp_path / f"graph{suffix}"
    write_diagram(diagram_dot(diagram, GROUPS, "ears"), path)
    assert path.read_bytes().startswith(head)


@needs_dot
def test_the_picture_shows_every_system(diagram, tmp_path):
    write_diagram(diagram_dot(diagram, GROUPS), tmp_path / "graph.svg")
    texts = {element.text for element in ET.parse(tmp_path / "graph.svg").iter() if element.tag.endswith("text")}
    assert {"source <1>", "adder", "memory", "log", "numbers", "ears"} <= texts


def test_text_needs_no_graphviz(diagram, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    dot = diagram_dot(diagram, GROUPS)
    write_diagram(dot, tmp_path / "graph.dot")
    assert (tmp_path / "graph.dot").read_text() == dot
    with pytest.raises(BlfDmpError, match=r"graph.svg: Graphviz's program dot is not installed.*\.dot"):
        write_diagram(dot, tmp_path / "graph.svg")


def test_unknown_suffixes_are_refused(tmp_path):
    for name in ("graph.jpg", "graph"):
        with pytest.raises(BlfDmpError, match=r"unknown suffix; name it \*\.svg, \*\.dot, \*\.png, \*\.pdf"):
            check_output("--diagram", tmp_path / name)


def test_what_cannot_be_written_is_one_line(diagram, tmp_path):
    (tmp_path / "graph.dot").write_text("mine")
    for path in (tmp_path / "graph.dot", tmp_path / "nowhere" / "graph.dot"):
        with pytest.raises(BlfDmpError, match=r"cannot be written \("):
            write_diagram(diagram_dot(diagram, GROUPS), path)
    assert (tmp_path / "graph.dot").read_text() == "mine"


@needs_dot
def test_what_graphviz_refuses_is_one_line(tmp_path):
    with pytest.raises(BlfDmpError, match=r"dot failed \(.*syntax error") as caught:
        write_diagram("digraph {", tmp_path / "graph.svg")
    assert "\n" not in str(caught.value)
