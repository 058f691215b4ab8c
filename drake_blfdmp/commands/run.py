"""The main job: carry out one scenario."""

import argparse
import sys
from pathlib import Path

from drake_blfdmp.commands.recording_options import add_recording_options, quoted, recording_settings

DEFAULT_SCENARIO = Path("studies") / "hold_and_place.yaml"


def parse(arguments: list[str], description: str) -> argparse.Namespace:
    """The command line without a command's name."""
    parser = argparse.ArgumentParser(
        prog="run.py",
        description=description,
        epilog="other commands, each with --help: run.py inspect FILE, run.py convert IN OUT, run.py figures FILE, "
        "run.py studies",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenario", type=Path, metavar="FILE", help="scenario (YAML); default: hold and place")
    parser.add_argument(
        "--set", action="append", default=[], metavar="KEY.PATH=VALUE", help="change one value; repeatable"
    )
    parser.add_argument(
        "--recording",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="recording of a person's shoulders, elbows, wrists; several of the same task become one skill",
    )
    parser.add_argument(
        "--out", type=Path, metavar="DIR", help="folder for the results; default runs/<scenario>-<time>"
    )
    parser.add_argument(
        "--diagram",
        type=Path,
        metavar="FILE",
        help="only draw the Drake diagram that would be run: .svg, .png, .pdf (needs graphviz) or .dot",
    )
    parser.add_argument(
        "--meshcat",
        action="store_true",
        help="show the simulation live, on this machine only; controls move the goal, push, pause",
    )
    parser.add_argument("--seed", type=int, help="seed of everything random")
    add_recording_options(parser)
    return parser.parse_args(arguments)


def settings(options: argparse.Namespace) -> list[str]:
    """The options that are short for a setting, as settings.

    Raises:
        ScenarioError: an option of a wrong form.
    """
    result = []
    if options.recording is not None:
        first, *others = [quoted(str(path.resolve())) for path in options.recording]
        result.append(f"recording.file={first}")
        if others:
            result.append(f"recording.also=[{', '.join(others)}]")
    result += recording_settings(options)
    if options.seed is not None:
        result.append(f"seed={options.seed}")
    return [*result, *options.set]


def main(arguments: list[str], root: Path, description: str = "") -> int:
    """Carry out one scenario.

    Args:
        arguments: without the program's name.
        root: the checkout, whose `studies` hold the default scenario.
        description: what `--help` says first.

    Returns:
        0 for success (or a diagram drawn), 1 for a run without success.

    Raises:
        BlfDmpError: bad input.
    """
    options = parse(arguments, description)
    if options.diagram is not None:
        return _draw(options, root)
    from drake_blfdmp.commands.drake_log import quieten
    from drake_blfdmp.evaluation.carry_out import CarryOut
    from drake_blfdmp.evaluation.console import ProgressBar, report
    from drake_blfdmp.planning.scenario import LoadScenario
    from drake_blfdmp.viewing.meshcat_scene import start_meshcat

    quieten()
    scenario = LoadScenario(options.scenario or root / DEFAULT_SCENARIO, settings(options))
    meshcat = start_meshcat() if options.meshcat else None
    if meshcat is not None:
        print(f"live view: {meshcat.web_url()} (Open Controls: goal, speed, pushes, pause)", file=sys.stderr)
    bar = ProgressBar()
    try:
        result = CarryOut(scenario, options.out, meshcat=meshcat, progress=bar)
    finally:
        bar.finish()
    print(report(result.summary))
    print(f"results: {result.folder}")
    return 0 if result.summary["success"] else 1


def _draw(options: argparse.Namespace, root: Path) -> int:
    """Draw the diagram of a scenario in place of running it."""
    from drake_blfdmp.commands.drake_log import quieten
    from drake_blfdmp.commands.outputs import refuse_existing
    from drake_blfdmp.errors import BlfDmpError
    from drake_blfdmp.evaluation.console import ProgressBar
    from drake_blfdmp.evaluation.run_diagram import RunDiagramDot
    from drake_blfdmp.planning.plan import MakePlan
    from drake_blfdmp.planning.scenario import LoadScenario
    from drake_blfdmp.viewing.diagram_graph import check_output, write_diagram

    for name, given in (("--out", options.out), ("--meshcat", options.meshcat)):
        if given:
            raise BlfDmpError(f"--diagram only draws; leave {name} away")
    quieten()
    check_output("--diagram", options.diagram)
    refuse_existing("--diagram", options.diagram)
    bar = ProgressBar()
    try:
        scenario = LoadScenario(options.scenario or root / DEFAULT_SCENARIO, settings(options))
        dot = RunDiagramDot(MakePlan(scenario, bar))
    finally:
        bar.finish()
    write_diagram(dot, options.diagram)
    print(f"diagram: {options.diagram}")
    return 0
