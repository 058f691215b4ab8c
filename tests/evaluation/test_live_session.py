"""A run that someone takes part in: paused, its goal moved, pushed; and one that nobody touches."""

import json
import urllib.request
from dataclasses import fields, replace

import numpy as np
import pytest
import umsgpack
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from waving import recorded, wave, write_csv

from drake_blfdmp.diagrams.hold_and_place import AddHoldAndPlace, SetInitialState
from drake_blfdmp.evaluation import carry_out
from drake_blfdmp.evaluation.carry_out import CarryOut
from drake_blfdmp.evaluation.live_session import PAUSED, PUSH_N, LiveSession
from drake_blfdmp.planning.free_plan import MakeFreePlan
from drake_blfdmp.planning.scenario import LoadScenario
from drake_blfdmp.planning.sources import MakeSource
from drake_blfdmp.recording.read import read_mcap
from drake_blfdmp.viewing.live_controls import CONTINUE, PAUSE, SPEED, goal_slider
from drake_blfdmp.viewing.meshcat_scene import start_meshcat

MOVE_AT, PUSH_AT, PAUSE_AT = 7, 10, 12  # Slices of 0.1 s.
FAR = 1.0  # m; farther than the slider goes.


def click(meshcat, name):
    meshcat._InjectWebsocketMessage(umsgpack.packb({"type": "button", "name": name}))


@pytest.fixture(scope="module")
def scenario(command_line, tmp_path_factory):
    """A short motion without a box, drawn and recorded less often than usual."""
    file = write_csv(tmp_path_factory.mktemp("live") / "waving.csv", *wave(duration_s=1.5))
    place = ["retarget.scale=0.8", "retarget.world=[0, 0.3, 1.0]"]
    studies = command_line.ROOT / "studies" / "hold_and_place.yaml"
    rates = ["simulation.scene_rate_hz=5", "simulation.record_rate_hz=50"]
    return LoadScenario(studies, [f"recording.file={file}", "task.kind=motion", *place, *rates])


@pytest.fixture(scope="module")
def carried_out(scenario, tmp_path_factory):
    """Carries it out without figures: (meshcat, progress) -> Run."""

    def run(**options):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(carry_out, "write_figures", lambda *_: None)
            return CarryOut(scenario, tmp_path_factory.mktemp("live") / "run", **options)

    return run


@pytest.fixture(scope="module")
def alone(carried_out):
    return carried_out()


@pytest.fixture(scope="module")
def acted(carried_out):
    """The run with all that can be done to it, the web server's answer in the pause, and the viewer."""
    meshcat = start_meshcat(port=0)
    slices, answers = [], []

    def act(what, share):
        if what == "simulating":
            slices.append(share)
            if len(slices) == MOVE_AT:
                meshcat.SetSliderValue(goal_slider("x"), meshcat.GetSliderValue(goal_slider("x")) + 0.05)
            elif len(slices) == PUSH_AT:
                click(meshcat, "push left palm +y")
            elif len(slices) == PAUSE_AT:
                click(meshcat, PAUSE)
        elif what == PAUSED:
            answers.append(urllib.request.urlopen(meshcat.web_url(), timeout=5).status)
            if len(answers) == 3:
                click(meshcat, CONTINUE)

    return carried_out(meshcat=meshcat, progress=act), answers, meshcat


def test_a_run_that_nobody_touches_is_the_run_without_a_viewer(carried_out, alone):
    meshcat = start_meshcat(port=0)
    watched = carried_out(meshcat=meshcat)
    assert (watched.folder / "run.mcap").read_bytes() == (alone.folder / "run.mcap").read_bytes()
    summaries = [json.loads((run.folder / "summary.json").read_text()) for run in (watched, alone)]
    for summary in summaries:
        del summary["timing"]
    assert summaries[0] == summaries[1]
    # Its page has no controls that nobody listens to.
    sizes = [(run.folder / "scene.html").stat().st_size for run in (watched, alone)]
    assert sizes[0] == sizes[1]
    assert meshcat.GetButtonNames() == [] and meshcat.GetSliderNames() == []


def test_what_was_done_is_in_the_recording_at_its_simulated_time(acted):
    recorded = read_mcap(acted[0].folder / "run.mcap")
    assert recorded.damage == ""
    events = dict(recorded.events)
    assert events["paused"] == events["continued"] == pytest.approx(0.1 * PAUSE_AT)
    assert events[f"left palm pushed +y {PUSH_N:g} N"] == pytest.approx(0.1 * PUSH_AT)
    (moved,) = [t for name, t in recorded.events if name.startswith("goal moved to x ")]
    assert moved == pytest.approx(0.1 * MOVE_AT + 0.1)  # Said once the slider rests.


def test_a_pause_stops_the_simulation_and_not_the_server(acted, alone):
    run, answers, _ = acted
    assert answers == [200] * 3
    np.testing.assert_array_equal(run.log.t, alone.log.t)
    assert run.summary["timing"]["simulated_s"] == alone.summary["timing"]["simulated_s"]


def test_the_motion_goes_where_its_goal_was_moved(acted, alone):
    run, _, _ = acted
    shift = (run.log.palm - alone.log.palm)[:, :, 4:].mean(axis=1)
    (note,) = [note for note in run.summary["plan"]["notes"] if note.startswith("goal moved by hand")]
    moved = 1e-3 * np.array([float(value) for value in note[note.index("(") + 1 : note.index(")")].split(",")])
    assert moved[0] == pytest.approx(0.05, abs=0.0035) and not moved[1:].any()
    np.testing.assert_allclose(shift[-1], moved, atol=2e-3)
    before = run.log.t <= 0.1 * MOVE_AT
    np.testing.assert_array_equal(run.log.palm[before], alone.log.palm[before])
    assert run.summary["success"]


def test_a_push_is_felt_while_it_lasts_and_noted(acted, alone):
    run, _, _ = acted
    off = [np.abs((one.log.palm - one.log.palm_desired)[:, 0, 5]) for one in (run, alone)]
    pushed = (run.log.t > 0.1 * PUSH_AT + 0.05) & (run.log.t < 0.1 * PUSH_AT + 0.2)
    assert off[0][pushed].max() > 4.0 * off[1][pushed].max()
    note = f"left palm pushed by hand with {PUSH_N:g} N: +y at {0.1 * PUSH_AT:.1f} s"
    assert note in run.summary["plan"]["notes"]


@pytest.fixture
def session(scenario):
    """A session of a run that stands at its start, its simulator and its viewer."""
    plan = MakeFreePlan(scenario, MakeSource(scenario, [recorded(*wave(duration_s=1.5))]))
    meshcat, builder, told = start_meshcat(port=0), DiagramBuilder(), []
    made = LiveSession(meshcat, lambda what, share: told.append(what))
    parts = AddHoldAndPlace(builder, plan)
    made.AddToBuilder(builder, parts, lambda name, t: None)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    SetInitialState(parts, diagram, simulator.get_mutable_context())
    return made, simulator, meshcat


def test_speed_and_what_comes_while_a_goal_is_dragged(session):
    made, simulator, meshcat = session
    x = goal_slider("x")
    assert made(simulator) == 0.0 and simulator.get_target_realtime_rate() == 0.0
    meshcat.SetSliderValue(SPEED, 2.0)
    for value in (0.01, 0.02, 0.05):
        meshcat.SetSliderValue(x, value)
        made(simulator)
        assert made.events == []
    made(simulator), made(simulator)
    assert simulator.get_target_realtime_rate() == 2.0
    ((name, t),) = made.events
    assert name.startswith("goal moved to x 0.050, y ") and t == 0.0
    meshcat.SetSliderValue(x, FAR)
    made(simulator), made(simulator)
    assert float(made.events[-1][0].split()[4].rstrip(",")) <= 0.15 + 0.01


def test_it_can_be_interrupted_while_it_is_paused(session):
    made, simulator, meshcat = session

    def interrupt(what, share):
        assert what == PAUSED
        raise KeyboardInterrupt

    made._progress = interrupt
    click(meshcat, PAUSE)
    with pytest.raises(KeyboardInterrupt):
        made(simulator)
    assert simulator.get_context().get_time() == 0.0


# A box.


@pytest.fixture(scope="module")
def placed(default_plan):
    """A carry up to where the hands are open again, its goal moved on the way and the box pushed: session and box."""
    simulation = replace(default_plan.scenario.simulation, time_step=0.004)  # Half the steps of the plant.
    plan = replace(default_plan, scenario=replace(default_plan.scenario, simulation=simulation))
    meshcat, builder = start_meshcat(port=0), DiagramBuilder()
    made = LiveSession(meshcat)
    parts = AddHoldAndPlace(builder, plan)
    made.AddToBuilder(builder, parts, lambda name, t: None)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    SetInitialState(parts, diagram, context)
    plant_context = parts.plant.GetMyContextFromRoot(context)
    for t in np.arange(0.1, default_plan.task.skill.events["release_end"] + 0.2, 0.1):
        if round(10 * t) == 60:
            meshcat.SetSliderValue(goal_slider("x"), 0.06)
            meshcat.SetSliderValue(goal_slider("y"), 0.60)
        elif round(10 * t) == 90:
            click(meshcat, "push box -x")
        made(simulator)
        simulator.AdvanceTo(t)
    return plan, made, parts.plant.EvalBodyPoseInWorld(plant_context, parts.box).translation(), meshcat


def test_the_box_is_put_down_where_the_sliders_were_moved_to(placed):
    plan, made, box, meshcat = placed
    assert goal_slider("x") not in meshcat.GetSliderNames()  # Once it goes down they would promise too much.
    moved = made.Finish()
    np.testing.assert_allclose(moved.goal[4:], [0.06, 0.60, plan.goal[6]], atol=1e-9)
    np.testing.assert_array_equal(moved.goal[:4], plan.goal[:4])
    assert np.linalg.norm(box - moved.goal[4:]) < 0.003
    assert [name for name, _ in made.events] == [
        "goal moved to x 0.060, y 0.600 m",
        "goal stays at x 0.060, y 0.600 m",
        f"box pushed -x {PUSH_N:g} N",
    ]
    assert moved.notes[-2:] == (
        "goal moved by hand by (-68, +55) mm in x, y",
        f"box pushed by hand with {PUSH_N:g} N: -x at 8.9 s",
    )
    others = {item.name for item in fields(plan)} - {"goal", "notes"}
    assert all(getattr(moved, name) is getattr(plan, name) for name in others)
