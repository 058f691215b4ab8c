"""From a recording of a person to two simulated Frankas that hold a box, move it and place it.

    python run.py                                   the main job, on a synthetic recording
    python run.py --recording FILE                  the same with your own recording
    python run.py --scenario FILE --set box.mass=2  any scenario, with changes
    python run.py studies                           the paper's figures and claims: what there is; --help tells more

Exit status: 0 success, 1 the run ended without success, 2 bad input.
"""

import argparse
import logging
import os
import shlex
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent


def parse(arguments: list[str] | None = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="run.py",
        description=(__doc__ or "").split("\n\n")[0],
        epilog="python run.py studies: the paper's figures and claims, listed and run; --help there tells more",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenario", type=Path, metavar="FILE", help="scenario (YAML); default: hold and place")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY.PATH=VALUE", help="change one value; repeatable"
    )
    parser.add_argument(
        "--recording", type=Path, metavar="FILE", help="recording of a person's shoulders, elbows, wrists"
    )
    parser.add_argument("--format", help="the recording's format, where its content does not tell")
    parser.add_argument("--frames", metavar="A:B", help="first and last frame, inclusive")
    parser.add_argument(
        "--joints",
        nargs="+",
        default=[],
        metavar="NAME=COLUMN",
        help="left_wrist=HandL takes the columns of HandL; left_wrist=a,b,c three columns",
    )
    parser.add_argument("--unit", choices=["m", "cm", "mm"], help="the recording's unit of length")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for the results; default runs/<scenario>-<time>"
    )
    parser.add_argument("--meshcat", action="store_true", help="show the simulation live, on this machine only")
    parser.add_argument("--seed", type=int, help="seed of everything random")
    return parser.parse_args(arguments)


def settings(options: argparse.Namespace) -> list[str]:
    """The options that are short for a setting, as settings."""
    from drake_blfdmp.errors import ScenarioError

    result = []
    if options.recording is not None:
        result.append(f"recording.file={_quoted(str(options.recording.resolve()))}")
    for name in ("format", "unit"):
        if getattr(options, name) is not None:
            result.append(f"recording.{name}={getattr(options, name)}")
    if options.frames is not None:
        first, colon, last = options.frames.partition(":")
        if not colon or not first.strip().isdigit() or not last.strip().isdigit():
            raise ScenarioError(f"--frames {options.frames}: write it as FIRST:LAST, for example 1016:1242")
        result.append(f"recording.frames=[{int(first)}, {int(last)}]")
    for joint in options.joints:
        name, equals, columns = joint.partition("=")
        if not equals or not columns:
            raise ScenarioError(f"--joints {joint}: write it as NAME=COLUMN, for example left_wrist=HandLeft")
        result.append(f"recording.joints={{{name}: [{', '.join(_quoted(c) for c in columns.split(','))}]}}")
    if options.seed is not None:
        result.append(f"seed={options.seed}")
    return [*result, *options.set]


def _quoted(text: str) -> str:
    return "'" + text.replace("'", "''") + "'"


def run(options: argparse.Namespace) -> int:
    """Carry out one scenario; the exit status."""
    from drake_blfdmp.evaluation.carry_out import CarryOut
    from drake_blfdmp.evaluation.console import ProgressBar, table
    from drake_blfdmp.planning.scenario import LoadScenario
    from drake_blfdmp.viewing.meshcat_scene import start_meshcat

    scenario = LoadScenario(options.scenario or ROOT / "studies" / "hold_and_place.yaml", settings(options))
    meshcat = start_meshcat() if options.meshcat else None
    if meshcat is not None:
        print(f"live view: {meshcat.web_url()}", file=sys.stderr)
    bar = ProgressBar()
    try:
        result = CarryOut(scenario, options.out, meshcat=meshcat, progress=bar)
    finally:
        bar.finish()
    summary = result.summary
    kind = "synthetic" if summary["recording"]["synthetic"] else "recorded"
    print(f"\n{summary['recording']['source']} ({kind}), law {summary['law']}")
    repairs = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in summary["recording"]["repairs"].items() if n)
    held = summary["recording"]["held_s"]
    width = summary["plan"]["box_width_m"]
    print(f"held from {held[0]:.2f} to {held[1]:.2f} s, box {width:.3f} m wide; repairs: {repairs or 'none'}")
    place = ", ".join(f"{value:.2f}" for value in summary["plan"]["world_m"])
    print(f"retargeted at scale {summary['plan']['scale']:g}, shoulders to ({place}) m")
    for note in summary["plan"]["notes"]:
        print(f"note: {note}")
    print(f"\n{table(summary)}\n")
    for failure in summary["failures"]:
        print(f"failed: {failure}")
    print("success" if summary["success"] else "no success")
    print(f"results: {result.folder}")
    return 0 if summary["success"] else 1


def parse_studies(arguments: list[str]) -> argparse.Namespace:
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


def studies(arguments: list[str]) -> int:
    """List or run studies; the exit status."""
    options = parse_studies(arguments)
    from drake_blfdmp.errors import BlfDmpError
    from drake_blfdmp.evaluation import study_runner as runner
    from drake_blfdmp.evaluation.carry_out import MakeRunFolder
    from drake_blfdmp.evaluation.console import ProgressBar

    if options.name and options.all:
        raise BlfDmpError("studies: give names or --all, not both")
    found = runner.FindStudies(ROOT / "studies")
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


def main(arguments: list[str] | None = None) -> int:
    """Parse and run; one line for anything a user can cause."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = None if arguments[:1] == ["studies"] else parse(arguments)
    from drake_blfdmp.errors import BlfDmpError

    logging.getLogger("drake").setLevel(logging.WARNING)
    try:
        return studies(arguments[1:]) if options is None else run(options)
    except BlfDmpError as error:
        print(f"run.py: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("run.py: interrupted", file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
