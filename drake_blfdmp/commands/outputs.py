"""Files that commands write where they are told to: nothing is overwritten."""

from pathlib import Path

from drake_blfdmp.errors import BlfDmpError


def refuse_existing(what: str, path: Path | None) -> None:
    """Refuse, before any work, to write where something is already or no folder is.

    Raises:
        BlfDmpError: the file exists, or its folder does not.
    """
    if path is None:
        return
    if path.exists():
        raise BlfDmpError(f"{what} {path}: exists already; nothing is overwritten, name another")
    if not path.absolute().parent.is_dir():
        raise BlfDmpError(f"{what} {path}: the folder {path.absolute().parent} does not exist; make it first")
