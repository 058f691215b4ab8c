"""`run.py convert`: any readable recording as this package's CSV or MCAP."""

import argparse
from pathlib import Path

from drake_blfdmp.commands.recording_options import add_recording_options, reader_arguments


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `convert`."""
    parser = argparse.ArgumentParser(
        prog="run.py convert",
        description="Read a recording of any known format and write its six points in m and s, as they were recorded: "
        "nothing is removed, filled, rotated or smoothed, unless --clean is given.",
    )
    parser.add_argument("file", type=Path, metavar="IN", help="recording, or the directory of a ROS 2 bag")
    parser.add_argument("out", type=Path, metavar="OUT", help="a new file, .csv or .mcap")
    parser.add_argument("--clean", action="store_true", help="repair it first: uniform clock, gaps filled, z up")
    add_recording_options(parser)
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """Convert one recording.

    Args:
        arguments: after `convert`.
        root: the checkout; not needed here.

    Returns:
        0.

    Raises:
        BlfDmpError: the file cannot be read or cleaned, the output is there already or of an unknown kind.
    """
    options = parse(arguments)
    from drake_blfdmp.commands.outputs import refuse_existing
    from drake_blfdmp.demonstration.cleaning import CleaningOptions, clean
    from drake_blfdmp.demonstration.demonstration import as_recording
    from drake_blfdmp.demonstration.formats import read_recording
    from drake_blfdmp.demonstration.formats.writing import check_suffix, write_recording
    from drake_blfdmp.evaluation.console import ProgressBar

    check_suffix(options.out)
    refuse_existing("convert", options.out)
    bar = ProgressBar()
    try:
        bar("reading", 0.0)
        recording = read_recording(options.file, **reader_arguments(options))
        if options.clean:
            bar("cleaning", 0.0)
            recording = as_recording(clean(recording, CleaningOptions(up=options.up)))
        bar("writing", 0.0)
        write_recording(options.out, recording)
        bar("writing", 1.0)
    finally:
        bar.finish()
    for sentence in recording.evidence:
        print(sentence)
    print(f"{options.out}: {len(recording.t)} frames of {options.file} ({recording.format})")
    return 0
