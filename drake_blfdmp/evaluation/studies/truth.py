"""How near original and modified motions come to what the modelled person really did.

The recording is of a person whom the virtual Kinect filmed, so the truth is known; it is put on the task's clock, into
the same frame, and shifted just as the learned motion was.
"""

import copy
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from drake_blfdmp.demonstration.alignment import weighted_mean
from drake_blfdmp.demonstration.modelled_person import ModelledPerson, hold_and_place
from drake_blfdmp.demonstration.timing import task_motion
from drake_blfdmp.demonstration.torso_frame import into_frames, torso_frames
from drake_blfdmp.evaluation.metrics import rms_distance
from drake_blfdmp.evaluation.studies.noise_metrics import KINDS
from drake_blfdmp.evaluation.study import Table
from drake_blfdmp.planning.scenario import Scenario
from drake_blfdmp.planning.sources import CleanRecording, LoadSource, Source
from drake_blfdmp.planning.task import MakeMotion, MakeTask, RollOutTask, Task


def on_task_clock(points: np.ndarray, scenario: Scenario, source: Source, task: Task, t: np.ndarray) -> np.ndarray:
    """Points (M, 6, 3) on the demonstration's clock at task times t (N,): (N, 6, 3), shifted as the learned motion."""
    demonstration, motion = source.demonstration, task.motion
    shift = motion.x - task_motion(demonstration, source.holding, scenario.timing, scenario.learning.cutoff_hz).x

    def at(times: np.ndarray, clock: np.ndarray, values: np.ndarray) -> np.ndarray:
        columns = values.reshape(len(values), 18).T
        return np.stack([np.interp(times, clock, column) for column in columns], axis=-1).reshape(-1, 6, 3)

    return at(np.interp(t, motion.t, motion.recorded), demonstration.t, points) + at(t, motion.t, shift)


def true_points(scenario: Scenario, source: Source) -> np.ndarray:
    """What the modelled person really did (M, 6, 3) on the demonstration's clock, in the demonstration's frame.

    Of several takes the mean, as the demonstration is: every take shows the same motion, but its time map errs, too.
    """
    if source.together is not None:
        takes = [replace(one.demonstration, x=true_points(scenario, one)) for one in source.together.sources]
        return weighted_mean(source.together.alignment.shown(takes), source.together.weights)
    recording, known = source.recording, source.recording.known
    person = ModelledPerson(upper_arm=known.upper_arm, forearm=known.forearm, box_width=known.box_width)
    clock, x = hold_and_place(person)
    # The demonstration's clock starts with the first frame in which the sensor finds the person.
    found = recording.t[np.isfinite(recording.x).all(axis=(1, 2))][0]
    t, columns = source.demonstration.t + found, x.reshape(len(x), 18).T
    truth = np.stack([np.interp(t, clock, column) for column in columns], axis=-1).reshape(-1, 6, 3)
    if scenario.recording.frame == "world":
        return truth
    world = CleanRecording(scenario, recording)
    return into_frames(truth, torso_frames(world.x, world.rate_hz))


def by_kind(a: np.ndarray, b: np.ndarray) -> dict[str, float]:
    """RMS distance of shoulders, elbows and hands, m."""
    return {kind: rms_distance(a[:, list(points)], b[:, list(points)]) for kind, points in KINDS.items()}


def against_truth(
    scenario: Scenario, seeds: range, progress: Callable[[str, float], None] = lambda what, share: None
) -> Table:
    """RMS distance of the original and the modified motion from the person's own, a row a seed of the sensor.

    Args:
        scenario: of the modelled person; every seed films and learns anew.
        progress: called with the seed and the share of them done, 0 to 1.
    """
    columns: dict[str, list] = {"seed": list(seeds)}
    for i, seed in enumerate(seeds):
        progress(f"seed {seed}", i / len(seeds))
        one = copy.deepcopy(scenario)
        one.seed = seed
        source = LoadSource(one)
        task = MakeTask(one, source, MakeMotion(one, source))
        for name, coupled in (("original", False), ("modified", True)):
            rollout = RollOutTask(one, task, coupled=coupled)
            truth = on_task_clock(true_points(one, source), one, source, task, rollout.t)
            for kind, value in by_kind(rollout.x, truth).items():
                columns.setdefault(f"{name}_{kind}_rms_m", []).append(value)
    return Table(columns)
