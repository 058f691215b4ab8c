"""Folders for results: a new one each time, or one that is empty; nothing is overwritten."""

import time
from pathlib import Path

from drake_blfdmp.errors import BlfDmpError


def RefuseUsedFolder(what: str, folder: Path) -> None:
    """Refuse, before any work, to write into a folder in which something is.

    Args:
        what: begins the message, the option that named the folder for one.

    Raises:
        BlfDmpError: it is a file, or not empty.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise BlfDmpError(f"{what} {folder}: exists already and is not empty; nothing is overwritten, name another")


def MakeRunFolder(folder: Path | None, name: str) -> Path:
    """Create the run's folder; by default `runs/<name>-<date and time>`, made unique.

    Raises:
        BlfDmpError: a given folder exists and is not empty, or cannot be made.
    """
    try:
        if folder is not None:
            folder = Path(folder)
            RefuseUsedFolder("--out", folder)
            folder.mkdir(parents=True, exist_ok=True)
            return folder
        stamp = time.strftime("%Y%m%d-%H%M%S")
        for extra in ("", *(f"-{i}" for i in range(2, 1000))):
            folder = Path("runs") / f"{name}-{stamp}{extra}"
            try:
                folder.mkdir(parents=True)
                return folder
            except FileExistsError:
                continue
    except OSError as error:
        raise BlfDmpError(f"{folder}: the run's folder cannot be made ({error.strerror})") from error
    raise BlfDmpError(f"runs/{name}-{stamp}: too many runs in one second; name a folder with --out")
