"""`--diagram`: the graph of what would be run."""

import re

import pytest

from drake_blfdmp.evaluation import run_diagram
from drake_blfdmp.planning import plan as planning


@pytest.fixture(scope="module")
def dot(default_plan):
    return run_diagram.RunDiagramDot(default_plan)


def test_every_system_of_a_run_stands_in_a_frame(dot):
    systems = re.findall(r"<B>([^<]+)</B>", dot)
    framed = {name for names in run_diagram.GROUPS.values() for name in names}
    assert framed - {"point_coupler", "push", "skill_clock", "passed_times"} == set(systems)
    assert len(systems) == len(set(systems))
    assert "@0" not in dot  # No system without a name of its own.


def test_the_graph_is_the_same_every_time(dot, default_plan):
    assert run_diagram.RunDiagramDot(default_plan) == dot


def test_the_command_draws_and_does_not_run(command_line, default_plan, monkeypatch, tmp_path, capfd):
    monkeypatch.setattr(planning, "MakePlan", lambda scenario, progress: default_plan)
    monkeypatch.chdir(tmp_path)
    assert command_line.main(["--diagram", "graph.dot"]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["graph.dot"]
    assert capfd.readouterr().out == "diagram: graph.dot\n"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--diagram", "graph.jpg"], ["graph.jpg", "*.svg"]),
        (["--diagram", "there.dot"], ["there.dot", "exists already"]),
        (["--diagram", "nowhere/graph.dot"], ["nowhere", "make it first"]),
        (["--diagram", "graph.dot", "--out", "run"], ["--diagram only draws", "--out"]),
        (["--diagram", "graph.dot", "--set", "box.mass=-1"], ["box.mass must be positive"]),
    ],
)
def test_bad_input_gets_one_line(command_line, arguments, words, monkeypatch, tmp_path, capfd):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.dot").write_text("mine")
    assert command_line.main(arguments) == 2
    out, err = capfd.readouterr()
    assert out == "" and len(err.splitlines()) == 1
    for word in words:
        assert word in err
    assert [path.name for path in tmp_path.iterdir()] == ["there.dot"]
