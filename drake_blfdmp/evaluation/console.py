"""What a person sees while a run goes on: a bar a stage, on standard error."""

import sys
import time
from typing import TextIO

from drake_blfdmp import interruption


class ProgressBar:
    """One line a stage, redrawn in place on a terminal, written once at its end elsewhere."""

    def __init__(self, stream: TextIO | None = None, width: int = 20):
        """Write to `stream`, standard error by default."""
        self._stream = stream or sys.stderr
        self._live = self._stream.isatty()
        self._width = width
        self._what = ""
        self._started = 0.0
        self._drawn = 0.0

    def __call__(self, what: str, share: float) -> None:
        """Show that `what` is done by `share`, 0 to 1.

        Raises:
            KeyboardInterrupt: a signal came that was lost on its way (`interruption.check`).
        """
        interruption.check()
        now = time.monotonic()
        if what != self._what:
            self.finish()
            self._what, self._started, self._drawn = what, now, 0.0
            if not self._live:
                self._stream.write(f"{what} ...\n")
                self._stream.flush()
        if self._live and (share >= 1.0 or now - self._drawn > 0.1):
            done = round(self._width * min(max(share, 0.0), 1.0))
            bar = "#" * done + "." * (self._width - done)
            self._stream.write(f"\r{what:<48.48} [{bar}] {now - self._started:5.1f} s")
            self._stream.flush()
            self._drawn = now
        elif not self._live and now - max(self._drawn, self._started) > 10.0:
            self._stream.write(f"  {100 * share:.0f} % after {now - self._started:.0f} s\n")
            self._stream.flush()
            self._drawn = now

    def finish(self) -> None:
        """End the line of the stage shown last."""
        if self._what and self._live:
            self._stream.write("\n")
            self._stream.flush()
        self._what = ""


def report(summary: dict) -> str:
    """What a run prints at its end, but for the folder's name."""
    recording, plan = summary["recording"], summary["plan"]
    kind = "synthetic" if recording["synthetic"] else "recorded"
    repairs = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in recording["repairs"].items() if n)
    if summary["box"] is None:
        start, end = recording["played_s"]
        done = f"played from {start:.2f} to {end:.2f} s, without a box"
    else:
        start, end = recording["held_s"]
        done = f"held from {start:.2f} to {end:.2f} s, box {plan['box_width_m']:.3f} m wide"
    place = ", ".join(f"{value:.2f}" for value in plan["world_m"])
    return "\n".join(
        [
            "",
            f"{recording['source']} ({kind}), law {summary['law']}",
            f"{done}; repairs: {repairs or 'none'}",
            f"retargeted at scale {plan['scale']:g}, shoulders to ({place}) m",
            *(f"note: {note}" for note in plan["notes"]),
            "",
            table(summary),
            "",
            *(f"failed: {failure}" for failure in summary["failures"]),
            "success" if summary["success"] else "no success",
        ]
    )


def table(summary: dict) -> str:
    """The short table at the end of a run."""
    links, box, robot, timing = summary["links"], summary["box"], summary["robot"], summary["timing"]
    uncoupled = summary["links_uncoupled"]
    lines = [
        f"{'link':<16}{'desired':>9}{'uncoupled':>17}{'coupled':>17}{'violations':>12}{'inside after':>14}",
    ]
    for name, link in links.items():
        free = uncoupled[name]
        inside = link["samples_until_inside"]
        desired = "moving" if link["desired_m"] is None else f"{link['desired_m']:.3f} m"
        lines.append(
            f"{name:<16}{desired:>9}"
            f"{free['min_m']:>9.3f}-{free['max_m']:.3f} m"
            f"{link['min_m']:>9.3f}-{link['max_m']:.3f} m"
            f"{link['violations']:>12d}"
            f"{'never' if inside is None else f'{inside} samples':>14}"
        )
    lines.append("")
    if box is not None:
        force = box["squeeze_force_n"]
        lines.append(
            f"box    lifted {box['lifted_m']:.3f} m, placed within {1000 * box['placement_error_m']:.1f} mm, tilt at "
            f"most {box['max_tilt_deg']:.2f} deg, squeeze {force[0]:.0f}-{force[1]:.0f} N, "
            f"slip {1000 * box['max_slip_m']:.1f} mm"
        )
    lines += [
        f"robot  palms follow within {1000 * robot['palm_tracking_rms_m']:.1f} mm rms, joint margin "
        f"{robot['min_joint_margin_rad']:.2f} rad, effort {100 * robot['max_effort_ratio']:.0f} %, speed "
        f"{100 * robot['max_velocity_ratio']:.0f} %, clearance {1000 * robot['min_clearance_m']:.0f} mm",
        f"time   {timing['simulated_s']:.1f} s simulated in {timing['wall_s']:.1f} s: {timing['realtime_rate']:.2f} x "
        "real time",
    ]
    return "\n".join(lines)
