"""`run.py recover`: a complete recording from one whose writer was killed."""

import argparse
from pathlib import Path


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `recover`."""
    parser = argparse.ArgumentParser(
        prog="run.py recover",
        description="Write a complete, indexed MCAP file of what is whole of another, which was cut off or damaged: "
        "everything up to the break, and what its journal (FILE.journal) holds of the rest. Any MCAP file will do. "
        "The file itself stays as it is.",
        epilog="Exit status: 0 recovered or intact, 2 nothing to recover.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="an .mcap file")
    parser.add_argument(
        "--out", type=Path, metavar="OUT", help="the new file; default <name>-recovered.mcap beside the other"
    )
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """Recover one file.

    Args:
        arguments: after `recover`.
        root: the checkout; not needed here.

    Returns:
        0.

    Raises:
        BlfDmpError: the file cannot be read, nothing in it is whole, or the output is there already.
    """
    options = parse(arguments)
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.recording.journal import journal_of
    from drake_blfdmp.recording.recover import recover

    bar = ProgressBar()
    try:
        done = recover(options.file, options.out, bar)
    finally:
        bar.finish()
    if done.path is None:
        left_over = journal_of(options.file)
        more = f"; {left_over} is left over and can be deleted" if left_over.exists() else ""
        print(f"{options.file}: intact, nothing to recover{more}")
        return 0
    print(f"{options.file}: {done.damage}")
    journal = f", {done.from_journal} of them from its journal" if done.from_journal else ""
    print(f"{done.path}: {done.messages} messages on {done.topics} topics, up to t = {done.until_s:.6g} s{journal}")
    return 0
