"""A URDF's meshes: where they are on this machine, and as meshcat's geometries."""

import os
import re
from pathlib import Path
from urllib.parse import unquote, urlparse

from meshcat import geometry

_READERS = {
    ".stl": geometry.StlMeshGeometry.from_file,
    ".obj": geometry.ObjMeshGeometry.from_file,
    ".dae": geometry.DaeMeshGeometry.from_file,
}
_UNIT = re.compile(r"<unit\b[^>]*\bmeter\s*=\s*[\"']([^\"']+)[\"']")


class NoMeshError(Exception):
    """A mesh cannot be drawn; the message says why."""


def find_mesh(name: str, beside: Path) -> Path:
    """The file of a mesh.

    Args:
        name: as the URDF has it: `package://package/path`, sought in the folders of ROS_PACKAGE_PATH and in `share` of
            those of AMENT_PREFIX_PATH; `file:///path`; a path, also one relative to `beside`.
        beside: the folder of the recording.

    Raises:
        NoMeshError: it is not there.
    """
    parts = urlparse(name) if "://" in name else None
    if parts is not None and parts.scheme == "package":
        inside = Path(parts.netloc) / unquote(parts.path).lstrip("/")
        tried = [folder / inside for folder in _package_folders()]
        # A folder may also be the package itself.
        tried += [folder.parent / inside for folder in _package_folders() if folder.name == parts.netloc]
        tried.append(beside / inside)
        where = "neither in ROS_PACKAGE_PATH nor in AMENT_PREFIX_PATH nor beside the recording"
    elif parts is not None and parts.scheme == "file":
        tried, where = [Path(unquote(parts.path))], "not there"
    elif parts is not None:
        raise NoMeshError(f"a {parts.scheme} address is not opened")
    else:
        tried, where = [beside / name], "not there"  # An absolute name stays what it is.
    for file in tried:
        if file.is_file():
            return file
    raise NoMeshError(where)


def mesh_geometry(file: Path) -> tuple[geometry.Geometry, float]:
    """The mesh, and what its unit is in m.

    Raises:
        NoMeshError: it cannot be read, or is of a format that Meshcat does not draw.
    """
    read = _READERS.get(file.suffix.lower())
    if read is None:
        raise NoMeshError(f"Meshcat draws {', '.join(_READERS)} alone")
    try:
        mesh = read(str(file))
    except (OSError, UnicodeDecodeError) as error:
        raise NoMeshError(f"cannot be read ({error})") from None
    if file.suffix.lower() == ".dae":
        # Meshcat draws the numbers as they are.
        found = _UNIT.search(file.read_text(encoding="utf-8", errors="replace")[:20000])
        try:
            return mesh, float(found.group(1)) if found else 1.0
        except ValueError:
            return mesh, 1.0
    return mesh, 1.0


def _package_folders() -> list[Path]:
    ros = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    ament = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    return [Path(folder) for folder in ros if folder] + [Path(folder) / "share" for folder in ament if folder]
