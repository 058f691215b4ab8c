"""A diagram as a graph that fits on a screen: Graphviz text, and pictures of it by Graphviz's program `dot`."""

import html
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from pydrake.systems.framework import Diagram, PortDataType, System

from drake_blfdmp.errors import BlfDmpError

SUFFIXES = (".svg", ".dot", ".png", ".pdf")

_FILLS = ("#E3F0FA", "#E8F4E4", "#F6EFE0", "#F0E9F5")
_PROGRAM_S = 120.0
"""The layout takes a fraction of a second; longer than this, s, and something is wrong."""


def check_output(what: str, path: Path) -> None:
    """Refuse, before any work, a file that cannot become a diagram's picture.

    Raises:
        BlfDmpError: an unknown suffix, or `dot` is needed and missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise BlfDmpError(f"{what} {path}: unknown suffix; name it {', '.join('*' + suffix for suffix in SUFFIXES)}")
    if path.suffix.lower() != ".dot" and shutil.which("dot") is None:
        raise BlfDmpError(
            f"{what} {path}: Graphviz's program dot is not installed; install graphviz, or write a .dot file"
        )


def diagram_dot(
    diagram: Diagram, groups: Mapping[str, Sequence[str]], listeners: str = "", own: str = "drake_blfdmp"
) -> str:
    """A diagram in Graphviz's language: a box a system, its ports in it, an arrow a connection.

    Drake's own `GetGraphvizString` shows every port of every system, the plant's sixty too. Here systems of other
    packages than `own` show only the ports that are connected; those of `own` also show, in grey, what is not.

    Args:
        groups: frame around systems -> their names, in the direction of the data; the rest stands outside. What goes
            back to an earlier group is written at its port, not drawn.
        listeners: the group that only listens. What comes into it from outside is written likewise.
    """
    systems = list(diagram.GetSystems())
    numbers = {system: i for i, system in enumerate(systems)}
    wires = sorted(
        (
            (source, int(output), target, int(entry))
            for (target, entry), (source, output) in diagram.connection_map().items()
        ),
        key=lambda wire: (
            numbers[wire[0]],
            wire[1],
            numbers[wire[2]],
            wire[3],
        ),  # Drake's order changes with addresses.
    )
    listening = set(groups.get(listeners, ()))
    group_of = {name: k for k, names in enumerate(groups.values()) for name in names}
    heard = {
        (target, entry): f"{source.get_name()}.{source.get_output_port(output).get_name()}"
        for source, output, target, entry in wires
        if (target.get_name() in listening and source.get_name() not in listening)
        or group_of.get(source.get_name(), 0) > group_of.get(target.get_name(), 0)
    }
    left = {}
    for i, system in enumerate(systems):
        inputs = {entry: heard.get((target, entry), "") for _, _, target, entry in wires if target is system}
        outputs = {output for source, output, _, _ in wires if source is system}
        table = _table(system, inputs, outputs, type(system).__module__.startswith(own))
        left[system.get_name()] = f"s{i} [label=<{table}>]"
    lines = [
        f"digraph {_quoted(diagram.get_name())} {{",
        "rankdir=LR; nodesep=0.18; ranksep=0.5; newrank=true;",
        'graph [fontname="Helvetica", fontsize=15];',
        'node [shape=plain, fontname="Helvetica", fontsize=11];',
        'edge [arrowsize=0.6, color="#37474F"];',
    ]
    for k, (group, names) in enumerate(groups.items()):
        members = [left.pop(name) for name in names if name in left]
        if members:
            fill = _FILLS[k % len(_FILLS)]
            lines.append(
                f'subgraph "cluster_{k}" {{ label={_quoted(group)}; labeljust=l; style="rounded,filled"; '
                f'color="{fill}"; fillcolor="{fill}";'
            )
            lines += [*members, "}"]
    lines += left.values()
    lines += [
        f"s{numbers[source]}:y{output}:e -> s{numbers[target]}:u{entry}:w"
        for source, output, target, entry in wires
        if (target, entry) not in heard
    ]
    # Listeners go to the right of what they listen to most; without an arrow they would stand before everything.
    first = [name for name in next(iter(groups.values()), ()) if diagram.HasSubsystemNamed(name)]
    drawn = {target.get_name() for _, _, target, entry in wires if (target, entry) not in heard}
    for name in sorted(listening - drawn):
        if first and diagram.HasSubsystemNamed(name):
            ends = (numbers[diagram.GetSubsystemByName(end)] for end in (first[-1], name))
            lines.append("s{} -> s{} [style=invis, weight=0]".format(*ends))
    return "\n".join([*lines, "}", ""])


def write_diagram(dot: str, path: Path) -> None:
    """Write a graph as its suffix says: the text itself (.dot), or a picture of it (.svg, .png, .pdf).

    Raises:
        BlfDmpError: as `check_output`; `dot` fails; or the file cannot be written.
    """
    check_output("diagram", path)
    suffix = path.suffix.lower()
    data = dot.encode()
    if suffix != ".dot":
        command = ["dot", f"-T{suffix[1:]}", *(["-Gdpi=110"] if suffix == ".png" else [])]
        try:
            done = subprocess.run(command, input=data, capture_output=True, timeout=_PROGRAM_S)
        except (OSError, subprocess.TimeoutExpired) as error:
            raise BlfDmpError(f"diagram {path}: dot cannot be run ({error}); write a .dot file instead") from error
        if done.returncode or not done.stdout:
            reason = " ".join(done.stderr.decode(errors="replace").split())
            raise BlfDmpError(f"diagram {path}: dot failed ({reason}); write a .dot file instead")
        data = done.stdout
    try:
        with path.open("xb") as file:
            file.write(data)
    except OSError as error:
        raise BlfDmpError(f"diagram {path}: cannot be written ({error.strerror})") from error


def _table(system: System, inputs: Mapping[int, str], outputs: set[int], all_ports: bool) -> str:
    """A system's box; `inputs` are the connected ones, each with where it comes from if that is not drawn."""
    left = [
        _cell(f"u{i}", _sized(system.get_input_port(i)), i in inputs, "LEFT", inputs.get(i, ""))
        for i in range(system.num_input_ports())
        if all_ports or i in inputs
    ]
    right = [
        _cell(f"y{i}", _sized(system.get_output_port(i)), i in outputs, "RIGHT")
        for i in range(system.num_output_ports())
        if all_ports or i in outputs
    ]
    rows = max(len(left), len(right))
    sides = [column + ["<TD></TD>"] * (rows - len(column)) for column in (left, right) if column]
    body = "".join(f"<TR>{''.join(cells)}</TR>" for cells in zip(*sides, strict=True))
    kind = re.sub(r"_?\U0001d4e3.*$", "", type(system).__name__)  # Without the scalar type.
    name = system.get_name()
    kind = (
        "" if kind.lower() == name.replace("_", "").lower() else f'<BR/><FONT POINT-SIZE="9">{html.escape(kind)}</FONT>'
    )
    return (
        '<TABLE BORDER="1" CELLBORDER="0" CELLSPACING="0" CELLPADDING="2" BGCOLOR="white" COLOR="#546E7A">'
        f'<TR><TD COLSPAN="{max(1, len(sides))}"><B>{html.escape(name)}</B>{kind}</TD></TR>{body}</TABLE>'
    )


def _sized(port) -> str:
    size = f" ({port.size()})" if port.get_data_type() == PortDataType.kVectorValued else ""
    return html.escape(port.get_name()) + size


def _cell(tag: str, text: str, connected: bool, side: str, source: str = "") -> str:
    colour = "#263238" if connected else "#9E9E9E"
    origin = f'<FONT COLOR="#1565C0">{html.escape(source)} &#8594; </FONT>' if source else ""
    return f'<TD PORT="{tag}" ALIGN="{side}"><FONT POINT-SIZE="9" COLOR="{colour}">{origin}{text}</FONT></TD>'


def _quoted(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
