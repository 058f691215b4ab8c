"""`run.py inspect`: what a recording holds, what is wrong with it, and whether a skill can be learned from it."""

import argparse
import json
from pathlib import Path

from drake_blfdmp.commands.recording_options import add_recording_options, reader_arguments


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `inspect`."""
    parser = argparse.ArgumentParser(
        prog="run.py inspect",
        description="Say what a recording holds, what is wrong with it, and whether a two-handed skill can be learned.",
        epilog="Exit status: 0 suited to a two-handed skill, 1 readable but not suited, 2 not readable.",
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="recording, or the directory of a ROS 2 bag")
    parser.add_argument("--json", action="store_true", help="print the report as JSON")
    parser.add_argument("--figure", type=Path, metavar="PNG", help="draw the report (.png or .svg)")
    parser.add_argument("--html", type=Path, metavar="FILE", help="write an animated page, which opens offline")
    add_recording_options(parser)
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """Inspect one recording.

    Args:
        arguments: after `inspect`.
        root: the checkout; not needed here.

    Returns:
        0 where a two-handed skill can be learned, else 1.

    Raises:
        BlfDmpError: the file cannot be read, or an output is there already or cannot be written.
    """
    options = parse(arguments)
    from drake_blfdmp.commands.outputs import refuse_existing
    from drake_blfdmp.demonstration.cleaning import CleaningOptions
    from drake_blfdmp.demonstration.formats import read_recording
    from drake_blfdmp.demonstration.health import examine
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.evaluation.health_text import health_text

    refuse_existing("--figure", options.figure)
    refuse_existing("--html", options.html)
    bar = ProgressBar()
    try:
        bar("reading", 0.0)
        recording = read_recording(options.file, **reader_arguments(options))
        bar("examining", 0.0)
        examined = examine(recording, CleaningOptions(up=options.up))
        bar("examining", 1.0)
    finally:
        bar.finish()
    if options.json:
        print(json.dumps(examined.health.as_dict(), indent=2))
    else:
        print(
            health_text(
                examined.health, ["python", "run.py", "--recording", str(options.file), *_reading(options, arguments)]
            )
        )
    if options.figure is not None:
        from drake_blfdmp.viewing.health_figure import health_figure
        from drake_blfdmp.viewing.style import save

        save(health_figure(examined), options.figure)
        _said(f"figure: {options.figure}", options)
    if options.html is not None:
        from drake_blfdmp.commands.drake_log import quieten
        from drake_blfdmp.viewing.meshcat_scene import start_meshcat
        from drake_blfdmp.viewing.recording_page import write_recording_page

        quieten()
        try:
            write_recording_page(examined, options.html, start_meshcat(port=0), bar)
        finally:
            bar.finish()
        _said(f"page: {options.html}", options)
    return 0 if examined.health.suitable else 1


def _reading(options: argparse.Namespace, arguments: list[str]) -> list[str]:
    """The options that say how the file is read: the arguments without it, and without what is written and how."""
    kept, skip = [], False
    for part in arguments:
        name = part.partition("=")[0]
        if not skip and name not in ("--json", "--figure", "--html") and part != str(options.file):
            kept.append(part)
        skip = part in ("--figure", "--html")
    return kept


def _said(text: str, options: argparse.Namespace) -> None:
    if not options.json:
        print(text)
