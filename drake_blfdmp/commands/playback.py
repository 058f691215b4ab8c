"""`run.py playback`: MCAP recordings in Meshcat, from the files alone; Drake is neither needed nor loaded."""

import argparse
import sys
import webbrowser
from pathlib import Path


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `playback`."""
    parser = argparse.ArgumentParser(
        prog="run.py playback",
        description="Play MCAP recordings in the browser: robots, box, person, bands, forces and events, all from the "
        "files. Recordings of other ROS 2 systems play too, by /robot_description with /tf or /joint_states.",
        epilog="Without --html or --video the page is served on this machine until Ctrl-C.",
    )
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="recording, .mcap; several are overlaid")
    parser.add_argument("--side-by-side", action="store_true", help="several beside each other in place of overlaid")
    parser.add_argument("--html", type=Path, metavar="OUT", help="write one page that opens offline, and serve nothing")
    parser.add_argument("--video", type=Path, metavar="OUT", help="write a video, .mp4 or .gif (ffmpeg and Chromium)")
    parser.add_argument("--from", type=float, dest="start", metavar="S", help="begin at this time, s")
    parser.add_argument("--to", type=float, dest="end", metavar="S", help="end at this time, s")
    parser.add_argument("--speed", type=float, default=1.0, metavar="X", help="times as fast as it was (default 1)")
    parser.add_argument("--partial", action="store_true", help="of a truncated file, play what is there")
    parser.add_argument("--port", type=int, metavar="N", help="serve here (default: the first free one from 7000)")
    parser.add_argument("--no-open", action="store_true", help="only print the address, open no browser")
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """Play recordings.

    Args:
        arguments: after `playback`.
        root: the checkout; not needed here.

    Returns:
        0.

    Raises:
        BlfDmpError: a file cannot be played, or an output is there already or cannot be written.
    """
    options = parse(arguments)
    from drake_blfdmp.commands.outputs import refuse_existing
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.viewing.playback.page import render_page
    from drake_blfdmp.viewing.playback.player import make_sheet
    from drake_blfdmp.viewing.playback.reading import read_played
    from drake_blfdmp.viewing.playback.video import check_video, write_video

    refuse_existing("--html", options.html)
    refuse_existing("--video", options.video)
    if options.video is not None:
        check_video(options.video)
    bar = ProgressBar()
    try:
        files = [
            read_played(file, start=options.start, end=options.end, partial=options.partial, progress=bar)
            for file in options.files
        ]
        sheet, warnings = make_sheet(files, side_by_side=options.side_by_side, speed=options.speed, progress=bar)
    finally:
        bar.finish()
    for warning in [line for file in files for line in file.warnings] + warnings:
        print(f"warning: {warning}", file=sys.stderr)
    page = render_page(sheet)
    if options.html is not None:
        _write(page, options.html)
    if options.video is not None:
        try:
            frames = write_video(sheet, options.video, bar)
        finally:
            bar.finish()
        print(f"video: {options.video}, {frames} frames")
    if options.html is None and options.video is None:
        _serve(page, options)
    return 0


def _write(page: str, path: Path) -> None:
    from drake_blfdmp.errors import BlfDmpError

    try:
        with path.open("x", encoding="utf-8") as stream:
            try:
                stream.write(page)
                stream.flush()
            except OSError:
                path.unlink()  # Half a page is of no use to anyone.
                raise
    except OSError as error:
        raise BlfDmpError(f"--html {path}: cannot be written ({error.strerror}); name another file") from None
    print(f"page: {path}, {path.stat().st_size / 1e6:.1f} MB")


def _serve(page: str, options: argparse.Namespace) -> None:
    """Serve the page until Ctrl-C."""
    from drake_blfdmp.viewing.playback.server import PageServer

    with PageServer(page, options.port) as server:
        print(f"playback: {server.url} (Ctrl-C ends it)", flush=True)
        if not options.no_open:
            webbrowser.open(server.url)
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()
