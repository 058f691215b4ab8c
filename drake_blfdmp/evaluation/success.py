"""When a run counts as a success: the stated thresholds, and a sentence for each that is missed."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """What a successful run keeps.

    Attributes:
        lifted_m: the box's centre rises at least this much.
        placement_m: it ends at most this far from where the plan puts it.
        tilt_deg: its up axis never leaves the plan's by more than this.
        tracking_m: without a box the palms are off the plan by at most this, root mean square, once they have settled.
    """

    lifted_m: float = 0.10
    placement_m: float = 0.010
    tilt_deg: float = 5.0
    tracking_m: float = 0.010


def find_failures(summary: dict, thresholds: Thresholds = Thresholds()) -> list[str]:
    """One sentence for every threshold that a summary misses; an empty list is success.

    Args:
        summary: with the entries `links`, `robot`, `feedback` and `box` of `summary.json`.
    """
    robot = summary["robot"]
    failures = _task_failures(summary, thresholds)
    if not summary["feedback"]["finished"]:
        failures.append(
            "The motion was not finished: the arms could not keep up, or were held up, and its phase was slowed down "
            f"to {summary['feedback']['min_tempo']:.2f} of its tempo."
        )
    for name, link in summary["links"].items():
        if link["violations"]:
            failures.append(
                f"The link {name} left its band at {link['violations']} steps, by up to "
                f"{1000 * link['largest_excess_m']:.1f} mm."
            )
    if robot["min_joint_margin_rad"] < 0:
        failures.append(f"A joint passed its limit by {-robot['min_joint_margin_rad']:.3f} rad.")
    if robot["max_velocity_ratio"] > 1:
        failures.append(f"A joint moved at {robot['max_velocity_ratio']:.2f} times its velocity limit.")
    if robot["max_effort_ratio"] >= 1:
        failures.append("An actuator ran into its effort limit.")
    if robot["min_clearance_m"] <= 0:
        failures.append(
            f"Bodies that must not touch overlapped by {-1000 * robot['min_clearance_m']:.1f} mm (arms, tables, box)."
        )
    return failures


def _task_failures(summary: dict, thresholds: Thresholds) -> list[str]:
    """What went wrong with the box; in a motion without one, with the palms."""
    failures, box = [], summary["box"]
    if box is None:
        off = summary["robot"]["palm_tracking_rms_m"]
        if off > thresholds.tracking_m:
            failures.append(
                f"The palms were {1000 * off:.1f} mm off the plan (root mean square), more than "
                f"{1000 * thresholds.tracking_m:.0f} mm."
            )
        return failures
    if box["dropped"]:
        failures.append("The box was dropped: a palm lost contact while it should have been held.")
    if box["lifted_m"] < thresholds.lifted_m:
        failures.append(
            f"The box was lifted by {box['lifted_m']:.3f} m only, less than {thresholds.lifted_m:.2f} m: the planned "
            f"motion rises by {summary['plan']['lift_m']:.3f} m."
        )
    if box["placement_error_m"] > thresholds.placement_m:
        failures.append(
            f"The box ended {1000 * box['placement_error_m']:.1f} mm from where the plan puts it, more than "
            f"{1000 * thresholds.placement_m:.0f} mm."
        )
    limit = box["squeeze_limit_n"]
    if limit is not None and box["squeeze_force_n"][1] > limit:
        failures.append(f"A palm pressed with {box['squeeze_force_n'][1]:.0f} N, more than {limit:.0f} N.")
    if box["max_tilt_deg"] > thresholds.tilt_deg:
        failures.append(f"The box tilted by {box['max_tilt_deg']:.1f} degrees, more than {thresholds.tilt_deg:.0f}.")
    return failures
