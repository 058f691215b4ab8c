"""`run.py figures`: the figures of a recording again, from its file and nothing else."""

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path

Progress = Callable[[str, float], None]


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `figures`."""
    parser = argparse.ArgumentParser(
        prog="run.py figures",
        description="Draw every figure of a study again, from its study.mcap alone. With the same versions of this\n"
        "package and of matplotlib they are the same, byte for byte, as those that the study drew.",
        epilog="Exit status: 0 all drawn; 2 bad input, or a figure that this version cannot draw.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE.mcap", help="what run.py recorded")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="new or empty folder for the figures; default <FILE>-figures beside it"
    )
    return parser.parse_args(arguments)


def draw_study(file: Path, folder: Path, progress: Progress) -> list[Path]:
    """Draw the figures of a study's file to a folder; raises BlfDmpError where the file is bad."""
    from drake_blfdmp.viewing.redrawing import redraw_study

    return redraw_study(file, folder, progress)


DRAWERS: Mapping[str, Callable[[Path, Path, Progress], list[Path]]] = {
    "study": draw_study,
}
"""Metadata record -> what draws the recordings that have it; it makes the folder once it has read the file."""


def main(arguments: list[str], root: Path) -> int:
    """Draw.

    Args:
        arguments: after `figures`.
        root: the checkout; not needed here.

    Returns:
        0.

    Raises:
        BlfDmpError: the file cannot be read or is none of ours, or the folder is not empty or cannot be written to.
    """
    options = parse(arguments)
    from drake_blfdmp.evaluation.carry_out import RefuseUsedFolder
    from drake_blfdmp.evaluation.console import ProgressBar

    folder = options.out or options.file.with_name(f"{options.file.stem}-figures")
    RefuseUsedFolder(folder)
    bar = ProgressBar()
    try:
        written = DRAWERS["study"](options.file, folder, bar)
    finally:
        bar.finish()
    print(f"{len(written)} files: {folder}")
    return 0
