"""What cleaning gains and what it costs, on what the virtual Kinect made of a motion that is known exactly.

    python studies/benchmark_cleaning.py [--seeds N] [--frames N] [--figure FILE]

Four tables: how much nearer the hands come to the truth, for each step and sensor (the truth is only compared with);
how that depends on how slow the error is; what a filter could reach at most that knew the spectra of the true motion
and of the error; and the time that a long recording takes. `--figure` also draws one recording before and after.
"""

import argparse
import re
import statistics
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.fft import dct

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from drake_blfdmp.demonstration.bones import FOREARMS, link_lengths  # noqa: E402
from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean  # noqa: E402
from drake_blfdmp.demonstration.demonstration import Demonstration, Recording  # noqa: E402
from drake_blfdmp.demonstration.modelled_person import hold_and_place  # noqa: E402
from drake_blfdmp.demonstration.sensors import SENSORS, VirtualKinect  # noqa: E402
from drake_blfdmp.demonstration.virtual_kinect import film, record_hold_and_place  # noqa: E402
from drake_blfdmp.errors import RecordingError  # noqa: E402
from drake_blfdmp.skeleton import POINTS, WRISTS  # noqa: E402
from drake_blfdmp.viewing import style  # noqa: E402

ALL = CleaningOptions(smoothing="auto", restore_bones=True, restore_hold=True)
STEPS = {
    "default": CleaningOptions(),
    "smoothing auto": CleaningOptions(smoothing="auto"),
    "bones": CleaningOptions(restore_bones=True),
    "bones, hold": CleaningOptions(restore_bones=True, restore_hold=True),
    "all": ALL,
    "all, no guesses": replace(ALL, least_confidence=0.75, max_gap_s=4.0),
}
CAMERAS = {"VirtualKinect()": VirtualKinect(), **SENSORS}
CORRELATIONS_S = (0.01, 0.02, 0.04, 0.08, 0.2, 0.4, 0.8)
REPEATS = 5


def true_points(recording: Recording, demonstration: Demonstration) -> np.ndarray:
    """(M, 6, 3) what the person really did at the demonstration's instants; the recording may have lost its ends."""
    clock, x = hold_and_place()
    trimmed = [re.search(r"trimmed: frames (\d+) to", note) for note in demonstration.notes]
    first = next((int(found[1]) for found in trimmed if found), recording.frames[0])
    t = demonstration.t + recording.t[int(np.flatnonzero(recording.frames == first)[0])]
    return np.stack([np.interp(t, clock, column) for column in x.reshape(len(x), -1).T], axis=-1).reshape(-1, 6, 3)


def hands_rms(x: np.ndarray, truth: np.ndarray) -> float:
    """Root mean square distance of the hands from the truth where they are seen, m."""
    return float(np.sqrt(np.nanmean(np.sum((x - truth)[:, WRISTS] ** 2, axis=-1))))


def accuracy(seeds: range) -> None:
    """The hands' distance from the truth, a line each sensor and step."""
    print(f"hands, mm RMS, seeds {seeds[0]} to {seeds[-1]}")
    for name, sensor in CAMERAS.items():
        for step, options in STEPS.items():
            pairs, ratios, refused = [], [], 0
            for seed in seeds:
                recording, truth = record_hold_and_place(sensor=sensor, seed=seed)
                try:
                    demonstration = clean(recording, options)
                except RecordingError:
                    refused += 1
                    continue
                raw = hands_rms(recording.x, truth)
                pairs.append((raw, hands_rms(demonstration.x, true_points(recording, demonstration))))
                ratios.append(pairs[-1][0] / pairs[-1][1])
            raw, cleaned = 1e3 * np.mean(pairs, axis=0)
            spread = f"{np.mean(ratios):.2f} ({min(ratios):.2f} to {max(ratios):.2f})"
            print(f"{name:<16} {step:<16} raw {raw:6.1f} cleaned {cleaned:6.1f} ratio {spread} refused {refused}")


def by_correlation(seeds: range) -> None:
    """How the gain of all steps depends on how slow the sensor's error is."""
    print("hands, all steps, VirtualKinect(correlation_s=...)")
    for correlation in CORRELATIONS_S:
        pairs = []
        for seed in seeds:
            recording, truth = record_hold_and_place(sensor=VirtualKinect(correlation_s=correlation), seed=seed)
            demonstration = clean(recording, ALL)
            left = hands_rms(demonstration.x, true_points(recording, demonstration))
            pairs.append((hands_rms(recording.x, truth), left))
        raw, cleaned = np.array(pairs).T
        print(
            f"{correlation:5.2f} s raw {1e3 * raw.mean():6.1f} cleaned {1e3 * cleaned.mean():6.1f} ratio "
            f"{np.mean(raw / cleaned):.2f} ({np.min(raw / cleaned):.2f} to {np.max(raw / cleaned):.2f})"
        )


def bound(seeds: range) -> None:
    """What a filter leaves of the hands' error that knows the true motion's and the error's spectra."""
    print("hands, mm RMS, left by the best filter that knows the true spectra")
    count = len(hold_and_place()[0]) - 5  # Recordings may end some frames early.
    for step in ("default", "bones, hold"):
        errors, raw = [], []
        for seed in seeds:
            recording, truth = record_hold_and_place(seed=seed)
            demonstration = clean(recording, STEPS[step])
            errors.append((demonstration.x - true_points(recording, demonstration))[:count, WRISTS].reshape(count, -1))
            raw.append(hands_rms(recording.x, truth))
        motion = hold_and_place()[1][:count, WRISTS].reshape(count, -1)
        motion = motion - np.linspace(motion[0], motion[-1], count)
        power = np.square(dct(motion, axis=0, norm="ortho"))
        noise = np.mean(np.square(dct(np.array(errors), axis=1, norm="ortho")), axis=0)
        left = float(np.sqrt(3.0 * np.mean(power * noise / (power + noise))))
        print(f"{step:<16} raw {1e3 * np.mean(raw):6.1f} left {1e3 * left:6.1f} ratio {np.mean(raw) / left:.2f}")


def long_recording(frames: int, seed: int = 0) -> Recording:
    """A person who carries to and fro, filmed at 30 Hz, with jumps, gaps, swapped hands and frames out of order."""
    rng = np.random.default_rng(seed)
    clock, once = hold_and_place()
    there_and_back = np.concatenate([once, once[-2:0:-1]])
    x = np.resize(there_and_back, (frames, *once.shape[1:]))
    recording = film(VirtualKinect(), np.arange(frames) * (clock[1] - clock[0]), x, seed)
    x, t = recording.x.copy(), recording.t.copy()
    for start in rng.integers(0, len(x), len(x) // 100):
        x[start : start + 1 + rng.integers(8), rng.integers(len(POINTS))] += 0.5 * rng.standard_normal(3)
    for start in rng.integers(0, len(x), len(x) // 200):
        x[start : start + 1 + rng.integers(10), rng.integers(len(POINTS))] = np.nan
    for start in rng.integers(0, len(x), len(x) // 2000):
        x[start : start + 10, WRISTS] = x[start : start + 10, WRISTS[::-1]]
    late = rng.integers(1, len(x) - 2, len(x) // 1000)
    t[late], t[late + 1] = t[late + 1], t[late]
    return replace(recording, t=t, x=x)


def speed(frames: int) -> None:
    """Seconds that a long recording takes, medians."""
    recording = long_recording(frames)
    print(f"{len(recording.t)} frames, s, medians of {REPEATS}")
    for name in ("default", "smoothing auto", "all"):
        options = replace(STEPS[name], restore_hold=False)  # A hold is looked for in one carry, not in a thousand.
        walls = []
        for _ in range(REPEATS):
            started = time.perf_counter()
            demonstration = clean(recording, options)
            walls.append(time.perf_counter() - started)
        print(f"{name:<16} {statistics.median(walls):5.2f}  {demonstration.repairs}")


@style.styled
def before_and_after(seed: int) -> Figure:
    """One recording of the virtual Kinect: forearms' lengths and one wrist's height, raw, cleaned and true."""
    recording = record_hold_and_place(seed=seed)[0]
    demonstration = clean(recording, ALL)
    exact = true_points(recording, demonstration)
    figure = Figure(figsize=(style.COLUMN, 3.6))
    axes = figure.subplots(3, 1, sharex=True)
    raw_lengths, lengths = link_lengths(recording.x), link_lengths(demonstration.x)
    true_length = float(link_lengths(exact)[0, FOREARMS[0]])
    for axis, index, side in zip(axes[:2], FOREARMS, ("left", "right"), strict=True):
        axis.plot(recording.t, raw_lengths[:, index], **style.UNCOUPLED | {"label": "raw", "linewidth": 0.8})
        axis.plot(demonstration.t, lengths[:, index], **style.COUPLED | {"label": "cleaned"})
        axis.axhline(true_length, **style.PLANNED | {"label": "true", "dashes": (1, 2)})
        axis.set_ylabel(f"{side}\nforearm (m)")
    low, high = style.finite_range(raw_lengths[:, FOREARMS], pad=0.05)
    for axis in axes[:2]:
        axis.set_ylim(low, high)
    wrist = int(WRISTS[1])
    axes[2].plot(recording.t, recording.x[:, wrist, 2], **style.UNCOUPLED | {"label": "raw", "linewidth": 0.8})
    axes[2].plot(demonstration.t, demonstration.x[:, wrist, 2], **style.COUPLED | {"label": "cleaned"})
    axes[2].plot(demonstration.t, exact[:, wrist, 2], **style.PLANNED | {"label": "true", "dashes": (1, 2)})
    axes[2].set_ylabel("right wrist's\nheight (m)")
    style.finish_time_axis(axes[2], demonstration.t)
    figure.align_ylabels(axes)
    style.legend_above(figure, axes[0], columns=3)
    return figure


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--frames", type=int, default=100_000)
    parser.add_argument("--figure", type=Path, help="where to draw one recording before and after")
    arguments = parser.parse_args()
    accuracy(range(arguments.seeds))
    by_correlation(range(arguments.seeds))
    bound(range(arguments.seeds))
    speed(arguments.frames)
    if arguments.figure is not None:
        print(style.save(before_and_after(seed=1), arguments.figure))


if __name__ == "__main__":
    main()
