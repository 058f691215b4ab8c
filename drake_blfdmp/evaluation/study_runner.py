"""Finding the studies of a folder and running them one after the other, with a report that is whole at any moment.

A study is a pair NAME.yaml and NAME.py, the latter with a function `study`; `evaluation.study` says what that is given
and what it hands back.
"""

import ast
import importlib.util
import shlex
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from drake_blfdmp import interruption
from drake_blfdmp.errors import BlfDmpError, ScenarioError
from drake_blfdmp.evaluation.report import write_report
from drake_blfdmp.evaluation.study import FigureFile, Study, StudyContext, StudyResult
from drake_blfdmp.evaluation.study_file import FILE, csv_text, write_study
from drake_blfdmp.planning.scenario import DumpScenario, LoadScenario
from drake_blfdmp.viewing.redrawing import draw_study, read_study

ORDER = (
    "measurement_noise",
    "trajectories",
    "tracking_errors",
    "joint_distances",
    "hand_distance",
    "two_frankas",
    "squeeze",
    "published_law",
    "two_rounds",
    "generalisation",
    "guarantee",
    "sampling",
    "robustness",
)
"""The paper's order; studies that are not named here come after these, by the alphabet."""

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class StudyScript:
    """A study as it lies in its folder; `description` is the first line of the script's docstring."""

    name: str
    description: str
    script: Path
    scenario: Path


@dataclass(frozen=True)
class StudyOptions:
    """What a person asks of all studies of one run.

    Args:
        settings: `key.path=value`, applied to every study's scenario.
        command: the whole command line, for the report.
    """

    settings: Sequence[str] = ()
    quick: bool = False
    recordings: Path | None = None
    workers: int = 2
    command: str = ""

    def repeat(self, name: str) -> str:
        """The command that runs one study with these options again."""
        words = ["python", "run.py", "studies", name, *(["--quick"] if self.quick else [])]
        words += [word for setting in self.settings for word in ("--set", setting)]
        words += [] if self.recordings is None else ["--recordings", str(self.recordings)]
        return shlex.join(words)


def FindStudies(folder: Path) -> dict[str, StudyScript]:
    """The studies of a folder, by name, in `ORDER`. No script is imported; one that does not parse is found as well."""
    found = {}
    for scenario in folder.glob("*.yaml"):
        script = scenario.with_suffix(".py")
        if not script.is_file():
            continue
        try:
            tree = ast.parse(script.read_bytes())
        except (SyntaxError, ValueError) as error:
            description = f"(the script does not parse: {error})"
        else:
            if not any(isinstance(node, ast.FunctionDef) and node.name == "study" for node in tree.body):
                continue
            description = (ast.get_docstring(tree) or "(no description)").splitlines()[0]
        found[script.stem] = StudyScript(script.stem, description, script, scenario)
    rank = {name: i for i, name in enumerate(ORDER)}
    return {name: found[name] for name in sorted(found, key=lambda name: (rank.get(name, len(ORDER)), name))}


def ChooseStudies(found: Mapping[str, StudyScript], names: Sequence[str]) -> list[StudyScript]:
    """The studies of these names, each once, in the order of `found`.

    Raises:
        BlfDmpError: a name is not among them, or there is nothing to choose.
    """
    if not names:
        raise BlfDmpError("studies: there are none to run")
    for name in names:
        if name not in found:
            raise BlfDmpError(f"studies: there is no '{name}'; choose from {', '.join(found) or 'none at all'}")
    return [script for name, script in found.items() if name in names]


def CheckOptions(scripts: Sequence[StudyScript], options: StudyOptions) -> None:
    """Refuse what no study can run with, before any does.

    Raises:
        BlfDmpError: a setting or the seed is wrong, `recordings` is no folder, or there is less than one worker.
    """
    if options.recordings is not None and not options.recordings.is_dir():
        raise BlfDmpError(f"--recordings {options.recordings}: is no folder; name one that holds recordings")
    if options.workers < 1:
        raise BlfDmpError(f"--workers {options.workers}: give one or more")
    for script in scripts:
        try:
            LoadScenario(script.scenario)
        except ScenarioError:
            continue  # Not the options' fault: it fails when its turn comes.
        scenario = LoadScenario(script.scenario, options.settings)
        if scenario.seed < 0:
            raise BlfDmpError(f"the seed is {scenario.seed}; give zero or a positive whole number")
        if scenario.task.kind != "hold":
            raise BlfDmpError(f"studies: {script.name} is about a held box; task.kind={scenario.task.kind} is no study")


def RunStudies(
    scripts: Sequence[StudyScript],
    folder: Path,
    options: StudyOptions,
    progress: Progress = lambda what, share: None,
) -> list[StudyResult]:
    """Run the studies in turn, each into a folder of its own below `folder`, and write the report after each.

    A study that fails does not stop the others; `error.txt` in its folder has the traceback. An interruption
    (KeyboardInterrupt) is passed on once the report says what was not run.

    Returns: one result a script, in the same order.

    Raises:
        BlfDmpError: the report cannot be written.
    """
    results = [StudyResult(script.name, script.description, options.repeat(script.name)) for script in scripts]

    def report() -> None:
        write_report(folder, results, quick=options.quick, command=options.command)

    for i, script in enumerate(scripts):

        def stage(what: str, share: float, where: str = f"[{i + 1}/{len(scripts)}] {script.name}") -> None:
            progress(f"{where}: {what}", share)

        try:
            results[i] = _run(script, results[i], folder / script.name, options, stage)
            report()
        except KeyboardInterrupt:
            if results[i].state == "not run":
                results[i] = replace(results[i], state="interrupted", files=_files(folder / script.name))
            report()
            raise
    return results


def _run(
    script: StudyScript, result: StudyResult, folder: Path, options: StudyOptions, progress: Progress
) -> StudyResult:
    """The result of one study, done or failed."""
    started = time.perf_counter()
    progress("starting", 0.0)
    try:
        folder.mkdir()
        scenario = LoadScenario(script.scenario, options.settings)
        result = replace(result, seed=scenario.seed)
        (folder / "scenario.yaml").write_text(DumpScenario(scenario), encoding="utf-8")
        context = StudyContext(scenario, options.quick, progress, options.recordings, options.workers, folder)
        study = LoadStudy(script)(context)
        if not isinstance(study, Study):
            raise BlfDmpError(f"{script.script}: study() returned a {type(study).__name__}; return a Study")
        progress("writing", 0.0)
        about = {"name": script.name, "description": script.description, "quick": options.quick}
        write_study(folder / FILE, study, scenario, about)
        for stem, table in study.tables.items():
            (folder / f"{stem}.csv").write_text(csv_text(table), encoding="utf-8", newline="")
        # From the file and nothing else, so that they can be drawn again.
        widths = draw_study(read_study(folder / FILE).attachments, folder, progress)
        result = replace(
            result,
            state="done",
            claims=tuple(study.claims),
            figures={stem: FigureFile(study.captions[stem], width) for stem, width in widths.items()},
            shown={stem: study.tables[stem] for stem in study.shown},
            notes=tuple(study.notes),
        )
        progress("writing", 1.0)
    except (Exception, SystemExit) as error:
        interruption.check()
        if folder.is_dir():
            (folder / "error.txt").write_text(traceback.format_exc(), encoding="utf-8")
        message = " ".join(str(error).split())
        result = replace(result, state="failed", error=f"{type(error).__name__}: {message}".rstrip(": "))
    return replace(result, seconds=time.perf_counter() - started, files=_files(folder))


def LoadStudy(script: StudyScript) -> Callable[[StudyContext], object]:
    """The function `study` of a script, which is run for it.

    Raises:
        BlfDmpError: the script has no such function. Whatever the script raises itself is passed on.
    """
    name = f"drake_blfdmp_study_{script.name}"
    spec = importlib.util.spec_from_file_location(name, script.script)
    if spec is None or spec.loader is None:
        raise BlfDmpError(f"{script.script}: is no Python script")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # Where dataclasses look their own module up.
    spec.loader.exec_module(module)
    study = getattr(module, "study", None)
    if not callable(study):
        raise BlfDmpError(f"{script.script}: has no function study(context)")
    return study


def _files(folder: Path) -> tuple[str, ...]:
    return tuple(sorted(path.name for path in folder.iterdir())) if folder.is_dir() else ()


def listing(found: Mapping[str, StudyScript]) -> str:
    """A line for each study: its name and what it is."""
    width = max((len(name) for name in found), default=0)
    return "\n".join(f"{name:<{width}} - {script.description}" for name, script in found.items()) or "no studies"


def summary_table(results: Sequence[StudyResult]) -> str:
    """The short table for a terminal."""
    width = max(len(result.name) for result in results)
    lines = [f"{'study':<{width}}  {'holds':>5} {'does not':>8} {'not judged':>10} {'time':>9}"]
    for result in results:
        counts = [str(result.count(holds)) if result.state == "done" else "-" for holds in (True, False, None)]
        taken = "-" if result.seconds is None else f"{result.seconds:.1f} s"
        state = "" if result.state == "done" else f"  {result.state}"
        lines.append(f"{result.name:<{width}}  {counts[0]:>5} {counts[1]:>8} {counts[2]:>10} {taken:>9}{state}")
    return "\n".join(lines)
