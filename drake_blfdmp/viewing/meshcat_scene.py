"""The Meshcat scene of a run: starting the server, where one looks from, and the page that keeps a recording."""

# pyright: reportArgumentType=false, reportCallIssue=false
# (Drake's own type stubs state array types that no array has.)

import html
import logging
import socket
from collections.abc import Mapping
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatAnimation, MeshcatParams

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.looks import CAMERA_IN_WORLD, FIELD_OF_VIEW, TARGET_IN_WORLD

_log = logging.getLogger(__name__)
_LEAST_PORT = 1024  # Drake ends the process for lower ones.
_LARGEST_PAGE_MB = 5.0

# Meshcat keeps the upright angle of view; a narrow window would cut the scene off at both sides.
_FIT_WINDOW = f"""<script>
function fit_window() {{
  const half = (degrees) => Math.tan((degrees * Math.PI) / 360);
  const across = half({FIELD_OF_VIEW[1]}) / (window.innerWidth / window.innerHeight);
  const angle = (Math.atan(Math.max(half({FIELD_OF_VIEW[0]}), across)) * 360) / Math.PI;
  viewer.set_property(["Cameras", "default", "rotated", "<object>"], "fov", angle);
  viewer.set_dirty();
}}
window.addEventListener("resize", fit_window);
setTimeout(fit_window, 0);
setTimeout(fit_window, 500);
</script>
"""


def start_meshcat(*, host: str = "localhost", port: int | None = None, show_grid: bool = True) -> Meshcat:
    """Starts Meshcat's server on this machine alone (Drake's own default is every interface).

    Args:
        host: name or address of the interface to listen on.
        port: at least 1024, or 0 for any free one; the first free one of 7000-7999 when None.
        show_grid: whether the floor's grid is drawn.

    Returns: the server, with a light background and no axes.

    Raises:
        BlfDmpError: the host is unknown, or the port is out of range or taken.
    """
    if port is not None and port != 0 and not _LEAST_PORT <= port <= 65535:
        raise BlfDmpError(f"Meshcat: port {port} is out of range; use 0 or 1024 to 65535")
    try:
        # Drake ends the whole process for a host it cannot resolve, so it is asked for here first.
        socket.getaddrinfo(host, port)
    except (OSError, UnicodeError) as error:
        raise BlfDmpError(f"Meshcat: host {host!r} is unknown; use localhost or an address of this machine") from error
    properties = [
        MeshcatParams.PropertyTuple(path="/Background", property="top_color", value=[0.96, 0.97, 0.99]),
        MeshcatParams.PropertyTuple(path="/Background", property="bottom_color", value=[0.78, 0.81, 0.85]),
        MeshcatParams.PropertyTuple(path="/Axes", property="visible", value=False),
        MeshcatParams.PropertyTuple(path="/Grid", property="visible", value=show_grid),
    ]
    try:
        return Meshcat(MeshcatParams(host=host, port=port, initial_properties=properties, show_stats_plot=False))
    except RuntimeError as error:
        which = "ports 7000 to 7999 are" if port is None else f"port {port} is"
        raise BlfDmpError(f"Meshcat: {which} taken on {host}; close the other viewer or name another port") from error


def set_scene_camera(
    meshcat: Meshcat,
    camera_in_world: tuple[float, float, float] = CAMERA_IN_WORLD,
    target_in_world: tuple[float, float, float] = TARGET_IN_WORLD,
) -> None:
    """Looks from `camera_in_world` (p_WC, m) to `target_in_world` (p_WT, m); arms, box and person by default.

    Raises:
        BlfDmpError: the two points are the same.
    """
    if tuple(camera_in_world) == tuple(target_in_world):
        raise BlfDmpError(f"Meshcat: camera and target are both at {tuple(target_in_world)}; move one of them")
    meshcat.SetCameraPose(camera_in_world, target_in_world)
    meshcat.SetProperty("/Cameras/default/rotated/<object>", "fov", FIELD_OF_VIEW[0])


def write_scene_html(
    meshcat: Meshcat,
    path: Path,
    *,
    title: str = "Dual-arm skill",
    legend: Mapping[str, str] | None = None,
    repeat: bool = True,
) -> Path:
    """Ends a recording and writes it as one page that needs neither network nor server.

    A page over 5 MB is written all the same, with a warning that says what makes it smaller.

    Args:
        meshcat: the scene, with what was recorded since `meshcat.StartRecording`.
        path: the page; its directory is made when it does not exist.
        title: the page's title, also shown in its corner.
        legend: text -> CSS colour of the swatch beside it (`skeleton_drawer.LEGEND`, for one).
        repeat: whether the animation starts again at its end.

    Returns: `path`.

    Raises:
        BlfDmpError: the page cannot be written.
    """
    meshcat.StopRecording()
    try:
        recording = meshcat.get_mutable_recording()
    except RuntimeError:  # Nothing was recorded: the page shows the scene as it stands.
        pass
    else:
        mode = MeshcatAnimation.LoopMode.kLoopRepeat if repeat else MeshcatAnimation.LoopMode.kLoopOnce
        recording.set_loop_mode(mode)
        recording.set_clamp_when_finished(True)
        meshcat.PublishRecording()
    page = _with_caption(meshcat.StaticHtml(), title, legend or {})
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise BlfDmpError(
            f"Meshcat: page {path} cannot be written: {error.strerror or error}; name another file"
        ) from error
    megabytes = path.stat().st_size / 1e6
    if megabytes > _LARGEST_PAGE_MB:
        _log.warning("Meshcat: page %s has %.1f MB; record fewer frames per second", path, megabytes)
    return path


def _with_caption(page: str, title: str, legend: Mapping[str, str]) -> str:
    """`page` with its title set, and title and legend laid over its lower left corner."""
    escaped = html.escape(title)
    before, found, after = page.partition("<title>")
    page = before + found + escaped + after[after.index("</title>") :] if found else page
    swatch = "display:inline-block;width:1.1em;height:0.7em;margin-right:0.5em;border-radius:2px;background:"
    rows = "".join(
        f'<div><span style="{swatch}{html.escape(colour)}"></span>{html.escape(text)}</div>'
        for text, colour in legend.items()
    )
    caption = (
        '<div id="caption" style="position:fixed;left:12px;bottom:12px;padding:8px 12px;border-radius:4px;'
        "background:rgba(255,255,255,0.85);color:#222;font:13px/1.5 sans-serif;pointer-events:none;"
        f'max-width:min(26em, 80vw)"><div style="font-weight:bold">{escaped}</div>{rows}</div>\n'
    )
    before, end, after = page.rpartition("</body>")
    return before + caption + _FIT_WINDOW + end + after
