"""A recording's health as text for a terminal."""

import shlex
from collections.abc import Sequence
from textwrap import wrap

from drake_blfdmp.demonstration.health import Health

_WIDTH = 100


def health_text(health: Health, command: Sequence[str] = ()) -> str:
    """The report; `command` is how this recording is run, without the suggested settings."""
    clock = health.clock
    rate = "no running clock"
    if clock.rate_hz is not None:
        rate = f"{clock.rate_hz:.1f} Hz (mean {clock.mean_rate_hz:.1f}, jitter {1000 * clock.jitter_s:.1f} ms)"
    lines = [
        f"{health.source}: {health.format}, {clock.frames} frames, {clock.duration_s:.2f} s at {rate}",
        f"  {clock.dropped} frames dropped, {clock.repeated} repeated, {clock.out_of_order} out of order, longest gap "
        f"{clock.longest_gap_s:.2f} s",
        *(line for sentence in health.evidence for line in _wrapped(sentence)),
        "",
        f"{'point':<16}{'seen':>8}{'guessed':>10}{'noise':>12}",
    ]
    for name, point in health.points.items():
        guessed = "not said" if point.guessed is None else f"{100 * point.guessed:.1f} %"
        noise = "" if point.noise_m is None else f"{1000 * point.noise_m:.1f} mm"
        lines.append(f"{name:<16}{100 * point.seen:>6.1f} %{guessed:>10}{noise:>12}")
    lines += ["", f"{'length, raw':<16}{'mean':>9}{'std':>10}{'least':>10}{'most':>10}{'jumps':>7}"]
    for name, length in health.lengths.items():
        lines.append(
            f"{name:<16}{length.mean_m:>7.3f} m{length.std_m:>8.3f} m{length.min_m:>8.3f} m{length.max_m:>8.3f} m"
            f"{length.jumps:>7d}"
        )
    if health.orientations is None:
        lines.append("orientations of the hands: none, so a box keeps its pitch")
    else:
        left, right = (100 * share for share in health.orientations)
        lines.append(f"orientations of the hands: left in {left:.0f} %, right in {right:.0f} % of the frames")
    lines.append("")
    if health.bones_m is not None:
        repairs = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in health.repairs.items() if n)
        lines.append(f"cleaning: {repairs or 'nothing to repair'}")
        lines += [line for note in health.notes for line in _wrapped(note)]
        lines.append(f"the person's bones: upper arm {health.bones_m[0]:.3f} m, forearm {health.bones_m[1]:.3f} m")
        if health.walked_m is not None and health.walked_m > 0.3:
            lines.append(f"the person walks {health.walked_m:.1f} m: the torso frame (the default) takes that out")
    if health.holding is not None:
        held = health.holding
        lines.append(
            f"held in both hands from {held.start_s:.2f} to {held.end_s:.2f} s, {held.hand_distance_m:.3f} m apart, "
            f"wobble {1000 * held.wobble_m:.0f} mm: a box {held.hand_distance_m:.2f} m wide"
        )
    if health.holding is not None and health.holding.turn_deg is not None:
        turn = health.holding.turn_deg
        lines.append(f"turned about the line between the hands by up to {turn:.0f} degrees meanwhile")
    lines += ["", "verdict: " + ("a two-handed skill can be learned" if health.suitable else "not as it stands")]
    lines += [line for reason in health.reasons for line in _wrapped(reason)]
    if command and (health.suitable or health.settings):
        settings = [part for setting in health.settings for part in ("--set", setting)]
        what = "run it:  " if health.suitable else "as a motion without a box:  "
        lines.append(what + shlex.join([*command, *settings]))
    return "\n".join(lines)


def _wrapped(sentence: str) -> list[str]:
    return wrap(sentence, _WIDTH, initial_indent="  - ", subsequent_indent="    ", break_on_hyphens=False)
