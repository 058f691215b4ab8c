"""The figures of a study drawn from its file, `study.mcap`, and nothing else: without studies, plans or Drake.

The studies' runner draws them so too, therefore figures that are drawn again later are the same, byte for byte, with
the same version of this package and of matplotlib.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.recording.plain_data import PlainDataError
from drake_blfdmp.recording.read import McapRun, read_mcap
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.drawing import Drawing, stems

RECORD = "study"
"""The metadata record that makes a recording a study's."""

Progress = Callable[[str, float], None]


def read_study(path: Path) -> McapRun:
    """A study's file, every checksum verified.

    Raises:
        RecorderError: there is no such file, it is damaged, or no study's; one line says which.
    """
    found = read_mcap(path)
    if RECORD not in found.metadata:
        raise RecorderError(f"{path}: holds no study (no metadata record '{RECORD}'); give a study.mcap")
    return found


def draw(drawing: Drawing, folder: Path, stem: str) -> float:
    """Draw a figure to `<stem>.png` and `<stem>.svg` of a folder; returns its width, inches."""
    figure = drawing.figure()
    style.save(figure, folder / f"{stem}.png")
    style.save(figure, folder / f"{stem}.svg")
    return float(figure.get_figwidth())


def draw_study(
    attachments: Mapping[str, bytes], folder: Path, progress: Progress = lambda what, share: None
) -> dict[str, float]:
    """Draw all figures of a study's attachments to a folder, which exists: stem to width, inches.

    Raises:
        PlainDataError: one is damaged or unknown to this version. What its function raises is passed on.
    """
    names, widths = stems(attachments), {}
    for i, stem in enumerate(names):
        progress(f"drawing {stem}", i / len(names))
        widths[stem] = draw(Drawing.of(stem, attachments), folder, stem)
    return widths


def redraw_study(
    path: Path, folder: Path, progress: Progress = lambda what, share: None, found: McapRun | None = None
) -> list[Path]:
    """Draw the figures of a study's file again, each as PNG and SVG.

    Args:
        path: the study's file.
        folder: is made where it does not exist.
        progress: called with what is being done and the share of it done.
        found: the file, where it has been read already.

    Returns:
        What was written.

    Raises:
        BlfDmpError: the file cannot be read, a figure's file exists already, or the folder cannot be written to; or,
            once all others are drawn, there are figures that this version cannot draw, and why.
    """
    found = read_study(path) if found is None else found
    names = stems(found.attachments)
    files = {stem: [folder / f"{stem}.{ending}" for ending in ("png", "svg")] for stem in names}
    for file in (file for pair in files.values() for file in pair):
        if file.exists():
            raise BlfDmpError(f"{file}: exists already; nothing is overwritten, name another folder")
    failed = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for i, stem in enumerate(names):
            progress(f"drawing {stem}", i / len(names))
            try:
                draw(Drawing.of(stem, found.attachments), folder, stem)
            except OSError:
                raise
            except Exception as error:  # Data of another version, or made up, may fail anywhere in a drawing.
                why = "" if isinstance(error, PlainDataError) else f"{type(error).__name__}: "
                failed.append(f"figure '{stem}': {why}{' '.join(str(error).split())}")
                del files[stem]
    except OSError as error:
        raise BlfDmpError(
            f"figures cannot be written to {folder}: {error.strerror or error}; name another folder"
        ) from None
    if failed:
        version = found.metadata[RECORD].get("version_drake_blfdmp", "unknown")
        raise BlfDmpError(f"{path}, written by drake_blfdmp {version}: {'; '.join(failed)}")
    progress("drawing", 1.0)
    return [file for pair in files.values() for file in pair]
