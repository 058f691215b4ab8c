"""The figures of a study again, from its study.mcap and nothing else."""

import argparse
from pathlib import Path


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `figures`."""
    parser = argparse.ArgumentParser(
        prog="run.py figures",
        description="Draw the figures of a study again, from its study.mcap alone: neither the study nor the plan is\n"
        "carried out. With the same versions they are the same, byte for byte.",
        epilog="Exit status: 0 all drawn; 2 bad input, or a figure that this version cannot draw.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("file", type=Path, metavar="FILE.mcap", help="a study's file")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the figures; default runs/figures-<time>")
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """Draw.

    Args:
        arguments: after `figures`.
        root: not used.

    Raises:
        BlfDmpError: bad input.
    """
    options = parse(arguments)
    from drake_blfdmp.evaluation.carry_out import MakeRunFolder
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.viewing.redrawing import read_study, redraw_study

    found = read_study(options.file)
    folder = MakeRunFolder(options.out, "figures")
    bar = ProgressBar()
    try:
        files = redraw_study(options.file, folder, bar, found)
    finally:
        bar.finish()
    print(f"{len(files)} files: {folder}")
    return 0
