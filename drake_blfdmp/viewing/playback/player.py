"""From files to a page: one file, or several over each other or side by side, on one clock."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.bounds import Bounds
from drake_blfdmp.viewing.playback.chunks import Progress
from drake_blfdmp.viewing.playback.forces import draw_forces, metres_per_newton
from drake_blfdmp.viewing.playback.kinematics import link_poses
from drake_blfdmp.viewing.playback.page import Event, Sheet
from drake_blfdmp.viewing.playback.poses import translation
from drake_blfdmp.viewing.playback.reading import Played
from drake_blfdmp.viewing.playback.robots import Tint, draw_robot
from drake_blfdmp.viewing.playback.scene import Scene
from drake_blfdmp.viewing.playback.skeleton import draw_person
from drake_blfdmp.viewing.playback.surroundings import View, add_surroundings, run_view, view_of

# Okabe and Ito's colours, those left away that mean something in the scene.
COLOURS = ("#5A6470", "#56B4E9", "#D55E00", "#F0E442", "#CC79A7", "#7B4FA3", "#8A6D3B", "#44AA99")
_GAP = 0.4  # Between files side by side, m.
_ABOVE = 0.1  # Captions over the files, m.
_WIDE = (30.0, 56.0)  # Degrees: what is side by side is wider than tall.
_LONGEST_TEXT = 60


def make_sheet(
    files: Sequence[Played],
    *,
    side_by_side: bool = False,
    speed: float = 1.0,
    progress: Progress = lambda what, share: None,
) -> tuple[Sheet, list[str]]:
    """Draws files that were read for the same part of their time.

    Args:
        files: at least one; all begin at the same instant of the page.
        side_by_side: beside each other in place of over each other, where the second and further ones are tinted and
            translucent.
        speed: at the beginning.
        progress: called with what is being done and the share of it done.

    Returns: what `render_page` takes, and what is not drawn, a line each.

    Raises:
        BlfDmpError: the speed is out of range, there are too many files, or a file's frames or links form a ring.
    """
    if not 0.01 <= speed <= 100.0:
        raise BlfDmpError(f"--speed {speed:g} is out of range; give 0.01 to 100")
    if len(files) > len(COLOURS):
        raise BlfDmpError(f"playback of {len(files)} files: at most {len(COLOURS)} can be told apart; name fewer")
    scene, warnings, legend = Scene(), [], {}
    labels = _labels(files)
    scale = metres_per_newton([wrench for file in files for wrench in file.wrenches])
    standing: dict[str, np.ndarray] = {}
    each: list[Bounds] = []
    for number, file in enumerate(files):
        tint = Tint(COLOURS[number]) if number and not side_by_side else None
        times, path = file.times - file.times[0], f"/{number}"
        bounds = Bounds()
        links: dict[str, np.ndarray] = {}
        for index, model in enumerate(file.models):
            poses = link_poses(model.robot, model.frames, model.positions)
            links = {**poses, **links}
            warnings += [
                f"{file.path}: {line}"
                for line in draw_robot(
                    scene,
                    f"{path}/robot{index}",
                    model,
                    poses,
                    times,
                    file.path.parent,
                    tint=tint,
                    standing=None if side_by_side else standing,
                    bounds=bounds,
                )
            ]
        legend |= draw_person(scene, f"{path}/person", file, times, tint=tint, bounds=bounds)
        solid = 1.0 if tint is None else tint.opacity
        arrows, lost = draw_forces(scene, f"{path}/forces", file, links, times, scale, solid)
        legend |= arrows
        warnings += [f"{file.path}: {line}" for line in lost]
        each.append(bounds)
        progress("drawing", (number + 1) / len(files))
    run = all("points" in file.vectors for file in files)
    everything, view, anchors = _arranged(scene, each, run, side_by_side)
    add_surroundings(scene, everything)
    if len(files) > 1 and not side_by_side:
        legend |= {label: colour for label, colour in zip(labels, COLOURS, strict=False)}
    events = [
        Event(t - file.times[0], *_texts(text, labels[number] if len(files) > 1 else ""), number)
        for number, file in enumerate(files)
        for t, text in file.events
    ]
    sheet = Sheet(
        title=_title(files, labels),
        scene=scene,
        view=view,
        legend=legend,
        files=list(zip(labels, COLOURS, strict=False)),
        anchors=anchors if side_by_side else (),
        events=sorted(events, key=lambda event: event.time),
        start=float(files[0].times[0]),
        duration=float(max(file.times[-1] - file.times[0] for file in files)),
        speed=speed,
    )
    return sheet, warnings


def _arranged(
    scene: Scene, each: Sequence[Bounds], run: bool, side_by_side: bool
) -> tuple[Bounds, View, list[np.ndarray]]:
    """Moves files apart, left to right as they are seen.

    Returns: what is around all of them, the view of it, and a point above each.
    """
    view = run_view() if run else view_of(each[0])
    everything, reach, anchors = Bounds(), 0.0, []
    for number, bounds in enumerate(each):
        shift = np.zeros(3)
        if side_by_side and not bounds.empty:
            along = bounds.corners() @ view.right
            if number:
                shift = (reach + _GAP - float(along.min())) * view.right
                scene.place(f"/{number}", translation(shift))
            reach = float(along.max() + shift @ view.right)
        if not bounds.empty:
            everything.include(bounds.corners() + shift)
        top = bounds.middle + shift
        top[2] = 0.0 if bounds.empty else bounds.high[2] + _ABOVE
        anchors.append(top)
    if side_by_side:
        return everything, view_of(everything, view.camera - view.target, _WIDE), anchors
    return everything, view if run else view_of(everything, view.camera - view.target), anchors


def _labels(files: Sequence[Played]) -> list[str]:
    """What tells the files apart: their law where that does, else the names of file and folder that differ."""
    laws = [f"law {file.label}" if file.label else "" for file in files]
    if all(laws) and len(set(laws)) == len(laws):
        return laws
    stems = [file.path.stem for file in files]
    if len(set(stems)) < len(stems):
        stems = [f"{file.path.absolute().parent.name}/{file.path.stem}" for file in files]
    names = [f"{stem} ({law})" if law else stem for stem, law in zip(stems, laws, strict=True)]
    return [name if names.count(name) == 1 else f"{k + 1}: {name}" for k, name in enumerate(names)]


def _title(files: Sequence[Played], labels: Sequence[str]) -> str:
    if len(files) > 1:
        return " and ".join(labels) if len(files) == 2 else f"{len(files)} recordings"
    name = Path(files[0].path).name
    return f"{name}: law {files[0].label}" if files[0].label else name


def _texts(event: str, label: str) -> tuple[str, str]:
    """An event's short and long text."""
    text = " ".join(event.replace("_", " ").split())
    text = text if len(text) <= _LONGEST_TEXT else text[: _LONGEST_TEXT - 1] + "…"
    return (text if len(text) <= 24 else text[:23] + "…"), (f"{label}: {text}" if label else text)
