"""One HTML page that holds everything: Meshcat's viewer, the scene, its animation and the control bar; no network."""

import html
import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshcat
import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.control_bar import BAR, SCRIPT, START, STYLE
from drake_blfdmp.viewing.playback.scene import Scene
from drake_blfdmp.viewing.playback.surroundings import View


@dataclass(frozen=True)
class Event:
    """Something that happened.

    Attributes:
        time: s since the start of what is played.
        text: short, for the slider.
        label: for the caption.
        file: the number of the file it stands in.
    """

    time: float
    text: str
    label: str
    file: int = 0


@dataclass(frozen=True)
class Sheet:
    """What a page is made of.

    Attributes:
        title: the page's.
        legend: text -> CSS colour.
        files: (name, CSS colour) of each.
        anchors: (3,) of each, m in W: where its caption hangs; none, and captions are at the top.
        start: what the clock shows at the beginning, s.
        duration: s.
        speed: at the beginning.
    """

    title: str
    scene: Scene
    view: View
    legend: Mapping[str, str]
    files: Sequence[tuple[str, str]]
    anchors: Sequence[np.ndarray]
    events: Sequence[Event]
    start: float
    duration: float
    speed: float = 1.0


def render_page(sheet: Sheet, *, script: str = START) -> str:
    """The page's text; the same for the same sheet.

    Args:
        sheet: what it shows.
        script: what it does at last; it plays by default.
    """
    data = {
        "title": sheet.title,
        "commands": sheet.scene.commands,
        "tracks": sheet.scene.tracks.lower(),
        "camera": sheet.view.camera,
        "target": sheet.view.target,
        "field_of_view": sheet.view.field_of_view,
        "legend": list(sheet.legend.items()),
        "files": [{"name": name, "colour": colour} for name, colour in sheet.files],
        "anchors": list(sheet.anchors),
        "events": [vars(event) for event in sheet.events],
        "start": sheet.start,
        "duration": sheet.duration,
        "speed": sheet.speed,
    }
    # Within a script element only `<` can be mistaken for markup.
    recording = json.dumps(data, default=_plain, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8"><title>{html.escape(sheet.title)}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        # Browsers ask the server for an icon unless the page has one.
        '<link rel="icon" href="data:,">\n'
        f'<style>{STYLE}</style></head>\n<body>\n<div><div id="meshcat-pane"></div></div>\n{BAR}'
        f'<script>{_viewer()}</script>\n<script type="application/json" id="recording">{recording}</script>\n'
        '<script>const viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));</script>\n'
        f"<script>{SCRIPT}{script}</script>\n</body>\n</html>\n"
    )


def _viewer() -> str:
    """Meshcat's viewer, as the meshcat package brings it."""
    file = Path(meshcat.viewer_assets_path()) / "dist" / "main.min.js"
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise BlfDmpError(
            f"{file}: Meshcat's viewer cannot be read ({error.strerror}); install meshcat again"
        ) from None


def _plain(value: Any) -> Any:
    """What JSON does not know: arrays, and the typed arrays in meshcat's geometries (MessagePack extensions)."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if hasattr(value, "type") and hasattr(value, "data"):
        return {"$kind": value.type, "data": b64encode(value.data).decode("ascii")}
    raise TypeError(f"{type(value).__name__} is no JSON")
