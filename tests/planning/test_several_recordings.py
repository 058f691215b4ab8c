"""One skill from several recordings of a task: errors that average out, spread, weights, dimensions, and refusals."""

import json
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from drake_blfdmp.demonstration.demonstration import Demonstration, Recording
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hold_and_place
from drake_blfdmp.demonstration.smoothing import smooth
from drake_blfdmp.demonstration.torso_frame import to_torso_frame
from drake_blfdmp.demonstration.virtual_kinect import VirtualKinect, record_hold_and_place
from drake_blfdmp.errors import RecordingError, ScenarioError
from drake_blfdmp.evaluation.summary import together
from drake_blfdmp.planning.scenario import LoadScenario, RecordingConfig, Scenario, SyntheticConfig
from drake_blfdmp.planning.sources import MOTION_HINT, LoadSource, MakeSource
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask
from drake_blfdmp.skeleton import POINTS
from drake_blfdmp.skill.geometry import link_lengths

PERSON, SENSOR = ModelledPerson(), VirtualKinect()
INDEPENDENT = VirtualKinect(shortening=0.0, occlusion_pull_m=0.0)
"""A sensor whose errors have no part that is the same in every recording."""


@cache
def film(seed, sensor=SENSOR, person=PERSON):
    return record_hold_and_place(person, sensor, seed)[0]


@cache
def source(seeds, sensor=SENSOR):
    return MakeSource(Scenario(), [film(seed, sensor) for seed in seeds])


@cache
def learned(seeds, sensor=SENSOR):
    return MakeTask(Scenario(), source(seeds, sensor), MakeMotion(Scenario(), source(seeds, sensor)))


def rms(error):
    return float(np.sqrt(np.mean(np.sum(error**2, axis=-1))))


@cache
def error(seeds, sensor):
    """RMS distance, m, of the smoothed demonstration from what the person did at the same times, around the task."""
    t, x = hold_and_place()
    truth = to_torso_frame(Demonstration(t=t, x=x, source="truth")).x
    found = source(seeds, sensor)
    mine, holding = found.demonstration, found.holding
    own = mine.t if found.together is None else found.together.weights @ found.together.alignment.recorded
    keep = (mine.t > holding.start_s - 0.7) & (mine.t < holding.end_s + 0.7)
    was = make_interp_spline(t, smooth(t, truth), k=3)(own)
    return rms((smooth(mine.t, mine.x) - was)[keep])


def test_independent_errors_of_five_recordings_fall_as_one_over_the_root_of_five():
    single = np.sqrt(np.mean([error((seed,), INDEPENDENT) ** 2 for seed in range(5)]))
    assert 0.40 < error(tuple(range(5)), INDEPENDENT) / single < 0.52  # 1/sqrt(5) is 0.447.


def test_what_every_recording_has_wrong_alike_stays():
    single = np.sqrt(np.mean([error((seed,), SENSOR) ** 2 for seed in range(5)]))
    together = error(tuple(range(5)), SENSOR)
    assert together < 0.70 * single
    assert together > error(tuple(range(5)), INDEPENDENT)  # Bones seen too short, hands pulled to the box.


def test_the_mean_shortens_the_links_and_the_law_makes_them_right():
    single = [RollOutTask(Scenario(), learned((seed,)), coupled=False) for seed in range(5)]
    five = learned(tuple(range(5)))
    before = np.mean([link_lengths(one.x).mean(axis=0) for one in single], axis=0)
    mean = link_lengths(RollOutTask(Scenario(), five, coupled=False).x).mean(axis=0)
    bones = [0, 1, 3, 4]
    assert (mean[bones] < before[bones]).all() and (mean[bones] > 0.94 * before[bones]).all()
    coupled = RollOutTask(Scenario(), five)
    assert coupled.margins.min() > 0.0
    np.testing.assert_allclose(link_lengths(coupled.x)[-1, bones], [0.22, 0.28, 0.28, 0.22], atol=1e-3)


def test_takes_of_the_modelled_person_are_films_of_consecutive_seeds():
    found = LoadSource(replace(Scenario(), seed=3, synthetic=SyntheticConfig(takes=2)))
    np.testing.assert_array_equal(found.demonstration.x, source((3, 4)).demonstration.x)
    assert found.demonstration.synthetic


def test_one_recording_is_as_it_was():
    one = source((0,))
    assert one.together is None and one.demonstration.source == one.recording.source
    skill = learned((0,)).skill
    assert skill.spread is None and skill.mobility is None


def test_the_skill_keeps_the_spread_on_its_own_clock():
    task, found = learned(tuple(range(5))), source(tuple(range(5)))
    demonstration, spread = found.demonstration, found.together.spread
    times = np.linspace(0.0, task.skill.tau, 57)
    recorded = np.interp(times, task.motion.t, task.motion.recorded)
    want = make_interp_spline(demonstration.t, spread, k=1)(recorded)
    np.testing.assert_allclose(task.skill.spread_at(times), want, atol=1.5e-3)
    slow = MakeTask(Scenario(), found, task.motion, 1.5).skill
    np.testing.assert_allclose(slow.spread_at(1.5 * times), task.skill.spread_at(times), atol=1e-12)


def test_the_spread_is_of_the_size_of_one_recordings_error():
    spread = rms(source(tuple(range(5)), INDEPENDENT).together.spread)
    assert spread == pytest.approx(np.mean([error((seed,), INDEPENDENT) for seed in range(5)]), rel=0.2)


def test_the_summary_tells_of_every_recording():
    entry = together(SimpleNamespace(source=source((0, 1)), task=learned((0, 1))))
    assert [one["source"] for one in entry["recordings"]] == [film(0).source, film(1).source]
    assert [one["weight"] for one in entry["recordings"]] == [0.5, 0.5]
    assert list(entry["spread_rms_m"]) == list(POINTS)
    spread = learned((0, 1)).skill.spread
    assert entry["spread_rms_m"]["left_wrist"] == pytest.approx(rms(spread[:, 2]))
    assert entry["spread_rms_m"]["left_shoulder"] < entry["spread_rms_m"]["left_wrist"]
    json.dumps(entry, allow_nan=False)
    assert together(SimpleNamespace(source=source((0,)), task=learned((0,)))) is None


def with_weights(*weights):
    return replace(Scenario(), recording=RecordingConfig(weights=list(weights)))


def test_weights_are_shares():
    films = [film(0), film(1), film(2)]
    equal, thrice = MakeSource(Scenario(), films), MakeSource(with_weights(3, 3, 3), films)
    np.testing.assert_allclose(equal.demonstration.x, thrice.demonstration.x, atol=1e-12)
    almost_one = MakeSource(with_weights(1.0, 1e-9, 1e-9), films)
    own, alone = almost_one.together.alignment.recorded[0], source((0,)).demonstration
    np.testing.assert_allclose(almost_one.demonstration.x, make_interp_spline(alone.t, alone.x, k=3)(own), atol=1e-6)


def test_bones_are_the_weighted_mean_and_the_box_is_the_median():
    persons = [ModelledPerson(upper_arm=length, box_width=width) for length, width in ((0.20, 0.3), (0.24, 0.31))]
    films = [film(0, person=person) for person in persons] + [film(1, person=persons[0])]
    dimensions = MakeSource(with_weights(1, 2, 1), films).dimensions
    assert dimensions.upper_arm == pytest.approx(0.22) and dimensions.box_width == 0.30
    given = with_weights(1, 2, 1)
    given = replace(given, bands=replace(given.bands, upper_arm=0.23), box=replace(given.box, width=0.27))
    dimensions = MakeSource(given, films).dimensions
    assert dimensions.upper_arm == pytest.approx(0.23) and dimensions.box_width == 0.27


def test_the_uncertainty_of_a_mean_falls_with_the_recordings(monkeypatch):
    from drake_blfdmp.planning import sources

    sigma = np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0]) * 1e-2
    cleaned = sources.clean
    monkeypatch.setattr(sources, "clean", lambda *a: replace(cleaned(*a), uncertainty=sigma))
    mean = MakeSource(with_weights(1, 1, 2), [film(seed) for seed in range(3)]).demonstration.uncertainty
    np.testing.assert_allclose(mean, sigma * np.sqrt(0.25**2 + 0.25**2 + 0.5**2))
    monkeypatch.setattr(sources, "clean", lambda *a: replace(cleaned(*a), uncertainty=None))
    assert MakeSource(Scenario(), [film(seed) for seed in range(2)]).demonstration.uncertainty is None


def test_a_recording_of_something_else_is_told_of():
    films = [film(0), film(1), film(0, person=ModelledPerson(carry_right=-0.28))]
    films[2] = replace(films[2], source="odd.csv")
    (note,) = MakeSource(Scenario(), films).together.notes
    assert note.startswith("odd.csv shares only ")
    assert source(tuple(range(5))).together.notes == ()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda x: x * 0 + x[:1], "nobody moves"),
        (lambda x: x[:, [0, 0, 0, 0, 0, 0]], "measures 0 m"),
        (lambda x: x * [0.0, 0.0, 1.0], "bad.csv"),
    ],
)
def test_a_recording_that_fails_is_named(change, message):
    bad = replace(film(1), x=change(film(1).x), source="bad.csv")
    with pytest.raises(RecordingError, match=message) as caught:
        MakeSource(Scenario(), [film(0), bad])
    assert "bad.csv" in str(caught.value) and "\n" not in str(caught.value)


def test_a_failure_that_does_not_know_its_file_gets_the_name(monkeypatch):
    from drake_blfdmp.planning import sources

    def fail(*_):
        raise RecordingError("recording: something")

    monkeypatch.setattr(sources, "find_holding", fail)
    with pytest.raises(RecordingError) as caught:
        MakeSource(Scenario(), [film(0), film(1)])
    assert str(caught.value) == f"{film(0).source}: recording: something, {MOTION_HINT}"


def test_the_held_interval_of_the_scenario_is_the_first_recordings():
    held = replace(Scenario(), task=replace(Scenario().task, held=[2.5, 5.0]))
    first, second = MakeSource(held, [film(0), film(1)]).together.sources
    assert (first.holding.start_s, first.holding.end_s) == (2.5, 5.0)
    assert second.holding == source((1,)).holding
    with pytest.raises(ScenarioError, match="not an interval"):
        MakeSource(replace(held, task=replace(held.task, held=[2.5, 50.0])), [film(0), film(1)])


def write_csv(path, recording: Recording):
    columns = [f"{point}_{axis}" for point in POINTS for axis in "xyz"]
    rows = np.column_stack([recording.t, recording.x.reshape(len(recording.t), 18)])
    lines = [",".join(["time", *columns]), *(",".join(f"{value:.6f}" for value in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def test_files_are_read_and_learned_together(tmp_path):
    paths = [write_csv(tmp_path / f"{name}.csv", film(seed)) for name, seed in (("first", 0), ("second", 1))]
    scenario = LoadScenario(
        write_yaml(tmp_path),
        [f"recording.file={paths[0]}", f"recording.also={paths[1]}", "recording.weights=[2, 1]", "recording.up=z"],
    )
    found = LoadSource(scenario)
    assert [one.recording.source for one in found.together.sources] == [str(path) for path in paths]
    np.testing.assert_allclose(found.together.weights, [2 / 3, 1 / 3])
    want = MakeSource(with_weights(2, 1), [film(0), film(1)])
    np.testing.assert_allclose(
        found.together.sources[1].demonstration.x, want.together.sources[1].demonstration.x, atol=1e-4
    )
    assert all(str(path) in found.demonstration.source for path in paths)
    assert set(found.estimated) == {"upper_arm", "forearm", "box_width"}


def test_a_missing_second_file_is_named(tmp_path):
    first = write_csv(tmp_path / "first.csv", film(0))
    missing = tmp_path / "missing.csv"
    scenario = replace(Scenario(), recording=RecordingConfig(file=str(first), also=[str(missing)], up="z"))
    with pytest.raises(RecordingError, match="missing.csv"):
        LoadSource(scenario)


def test_frames_are_the_first_files_alone(tmp_path):
    paths = [write_csv(tmp_path / f"{seed}.csv", film(seed)) for seed in (0, 1)]
    config = RecordingConfig(file=str(paths[0]), also=[str(paths[1])], frames=[5, 230], up="z")
    first, second = LoadSource(replace(Scenario(), recording=config)).together.sources
    assert len(first.recording.t) == 226 and len(second.recording.t) == len(film(1).t)


def test_what_reading_and_cleaning_are_told_arrives(tmp_path):
    path = write_csv(tmp_path / "take.csv", film(0))
    settings = [f"recording.file={path}", "recording.up=z"]

    def demonstration(*more):
        return LoadSource(LoadScenario(write_yaml(tmp_path), [*settings, *more])).demonstration

    plain = demonstration()
    assert demonstration("recording.cleaning.rate_hz=60").rate_hz == pytest.approx(60.0)
    half = demonstration("recording.rate_hz=15")
    assert half.duration_s == pytest.approx(2 * plain.duration_s, rel=0.15)
    with pytest.raises(RecordingError, match="max_gap_s|missing between"):
        demonstration("recording.cleaning.max_gap_s=0.01")
    with pytest.raises(RecordingError, match="take.csv.*no person 'nobody'"):
        demonstration("recording.body=nobody")
    with pytest.raises(RecordingError, match="take.csv.*unit of time 'weeks'"):
        demonstration("recording.time_unit=weeks")
    with pytest.raises(RecordingError, match="take.csv"):  # 8 ms are too short.
        demonstration("recording.time_unit=ms")


def write_yaml(folder):
    path = folder / "scenario.yaml"
    path.write_text("")
    return path
