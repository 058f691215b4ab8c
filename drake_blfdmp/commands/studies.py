"""The paper's figures and claims: list and run the studies."""

import argparse
import os
import shlex
from pathlib import Path


def parse(arguments: list[str]) -> argparse.Namespace:
    """The command line after `studies`."""
    parser = argparse.ArgumentParser(
        prog="run.py studies",
        description="List the studies, or run some or all of them into one folder with one report. A study repeats a\n"
        "figure or a claim of the paper, or goes beyond it.",
        epilog="Exit status: 0 all ran, whether or not their claims hold; 1 one failed; 2 bad input; 130 interrupted.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("name", nargs="*", metavar="NAME", help="studies to run; none: list them")
    parser.add_argument("--all", action="store_true", help="run all of them")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder for the results; default runs/studies-<time>")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of everything random, in every study")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY.PATH=VALUE", help="change one value in each; repeatable"
    )
    parser.add_argument("--quick", action="store_true", help="the same code on less, in seconds; not for results")
    parser.add_argument(
        "--recordings", type=Path, metavar="DIR", help="folder of real recordings, for studies that use them"
    )
    parser.add_argument(
        "--workers", type=int, default=min(2, os.cpu_count() or 1), metavar="N", help="processes; default %(default)s"
    )
    return parser.parse_args(arguments)


def main(arguments: list[str], root: Path) -> int:
    """List or run studies.

    Args:
        arguments: after `studies`.
        root: the checkout whose `studies` are meant.

    Returns:
        0 where all ran, 1 where one failed.

    Raises:
        BlfDmpError: bad input.
    """
    options = parse(arguments)
    from drake_blfdmp.commands.drake_log import quieten
    from drake_blfdmp.errors import BlfDmpError
    from drake_blfdmp.evaluation import study_runner as runner
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.evaluation.folders import MakeRunFolder

    quieten()
    if options.name and options.all:
        raise BlfDmpError("studies: give names or --all, not both")
    found = runner.FindStudies(root / "studies")
    if not options.name and not options.all:
        print(runner.listing(found))
        return 0
    scripts = runner.ChooseStudies(found, options.name or list(found))
    asked = runner.StudyOptions(
        settings=[*([] if options.seed is None else [f"seed={options.seed}"]), *options.set],
        quick=options.quick,
        recordings=options.recordings and options.recordings.resolve(),
        workers=options.workers,
        command=shlex.join(["python", "run.py", "studies", *arguments]),
    )
    runner.CheckOptions(scripts, asked)
    folder = MakeRunFolder(options.out, "studies")
    bar = ProgressBar()
    try:
        results = runner.RunStudies(scripts, folder, asked, bar)
    except KeyboardInterrupt:
        bar.finish()
        print(f"report so far: {folder / 'report.html'}")
        raise
    finally:
        bar.finish()
    print(f"\n{runner.summary_table(results)}\n")
    failed = [result for result in results if result.state == "failed"]
    for result in failed:
        print(f"failed: {result.name}: {result.error}")
    print(f"report: {folder / 'report.html'}")
    return 1 if failed else 0
