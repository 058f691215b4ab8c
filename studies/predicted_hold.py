"""What palms and motors bear in a run beside what is predicted of it without simulation (`robot.held_box`).

    python studies/predicted_hold.py FOLDER [--figure FILE.png]

FOLDER is a run's, as `run.py` leaves it. The prediction knows the commanded postures, the box and its friction, and
nothing of what the simulation made of them. How the box comes to lie between palms that close it does not know: it is
made twice, with a table that holds the box in its place and with one that lets it slide.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from drake_blfdmp.errors import BlfDmpError, TaskError  # noqa: E402
from drake_blfdmp.planning.held_squeeze import Motors  # noqa: E402
from drake_blfdmp.planning.scenario import LoadScenario  # noqa: E402
from drake_blfdmp.recording.read import Series, read_mcap  # noqa: E402
from drake_blfdmp.robot.grasp_force import PALM_FRICTION, combined_friction  # noqa: E402
from drake_blfdmp.robot.held_box import CarryQuasiStatically, HeldBox  # noqa: E402
from drake_blfdmp.robot.plant import MakeKinematicPlant  # noqa: E402
from drake_blfdmp.viewing import style  # noqa: E402
from drake_blfdmp.viewing.study_figures.predicted_hold import predicted_hold  # noqa: E402

POSTURES = 25
TABLES = {"held by its table": False, "sliding on it": True}
"""What the table does to the box while the palms close, and whether it slides then."""

PALMS = ("/contact/left_palm", "/contact/right_palm")


def at(series: Series, t: np.ndarray) -> np.ndarray:
    """The samples at times t, or just after."""
    return series.values[np.minimum(np.searchsorted(series.t, t - 1e-9), len(series.t) - 1)]


def simulated(series: dict[str, Series], t: np.ndarray, limits: np.ndarray) -> dict[str, np.ndarray]:
    """Each row of the figure (N, 2) at times t (N,)."""
    wrenches = np.stack([at(series[name], t) for name in PALMS], axis=1)  # (N, 2, force and torque, 3) on the palm.
    force, torque = wrenches[:, :, 0], wrenches[:, :, 1]
    effort = np.abs(at(series["/joint_states"], t)[:, : len(limits), 2]) / limits
    return {
        "force": -force[..., 2],
        "centre_x": -1e3 * torque[..., 1] / force[..., 2],
        "centre_y": 1e3 * torque[..., 0] / force[..., 2],
        "effort": 100.0 * effort.reshape(len(t), 2, -1).max(axis=-1),
    }


def compare(folder: Path) -> tuple[np.ndarray, dict, dict[str, tuple[np.ndarray, dict]], float]:
    """Times and rows as simulated, times and rows as predicted with each table, and how long one prediction took, s.

    Raises:
        BlfDmpError: the folder has no whole run, or one that carries no box.
    """
    run, scenario = read_mcap(folder / "run.mcap"), LoadScenario(folder / "scenario.yaml")
    events, series = dict(run.events), run.series
    if not {"lift", "lower"} <= events.keys():
        raise TaskError(f"{folder}: its recording has no events 'lift' and 'lower'; give a run that carries a box")
    width = json.loads((folder / "summary.json").read_text())["plan"]["box_width_m"]
    friction = float(combined_friction(scenario.reality.friction_scale * scenario.box.friction, PALM_FRICTION))
    below = np.array([0.0, 0.0, -scenario.task.grasp_above])
    box = HeldBox(width, scenario.reality.mass_scale * scenario.box.mass, friction, below)
    t, plant = np.linspace(events["lift"], events["lower"], POSTURES), MakeKinematicPlant()
    postures = at(series["/desired_position"], t)
    limits, _, apart = Motors(plant, postures)
    started, predicted = time.perf_counter(), {}
    for table, slides in TABLES.items():
        hold = CarryQuasiStatically(plant, postures, 0.5 * (width - apart), box, slides=slides)
        reached = len(hold.force)
        predicted[table] = (
            t[:reached],
            {
                "force": hold.force,
                "centre_x": 1e3 * hold.centre[..., 0],
                "centre_y": 1e3 * hold.centre[..., 1],
                "effort": 100.0 * (np.abs(hold.effort) / limits).reshape(reached, 2, -1).max(axis=-1),
            },
        )
    took = (time.perf_counter() - started) / len(TABLES)
    fine = np.arange(events["lift"], events["lower"], 0.04)
    return fine, simulated(series, fine, limits), predicted, took


def main() -> int:
    """Compare, print and draw."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--figure", type=Path, default=None)
    options = parser.parse_args()
    try:
        fine, found, predictions, took = compare(options.folder)
    except (BlfDmpError, OSError) as error:
        print(f"{parser.prog}: {error}", file=sys.stderr)
        return 2
    print(f"{POSTURES} postures predicted in {took:.2f} s")
    for table, (t, predicted) in predictions.items():
        print(f"{table}" + ("" if len(t) == POSTURES else f": it slips after {len(t)} of them"))
        for name, unit in (("force", "N"), ("centre_x", "mm"), ("centre_y", "mm"), ("effort", "% of the limit")):
            if len(t):
                there = np.stack([np.interp(t, fine, column) for column in found[name].T], axis=-1)
                off = np.abs(predicted[name] - there)
                print(f"  {name:<10}{np.median(off):6.1f} {unit} off in the median, {off.max():.1f} at most")
    if options.figure is not None:
        style.save(predicted_hold(fine, found, predictions), options.figure)
        print(f"figure: {options.figure}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
