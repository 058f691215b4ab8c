"""docs/summary.md against what `summary.json` is made of."""

import ast
import re
from pathlib import Path

import pytest

from drake_blfdmp.evaluation.success import Thresholds

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = (ROOT / "docs" / "summary.md").read_text(encoding="utf-8")
NAMED = {part for code in re.findall(r"`([^`\n]+)`", DOCUMENT) for part in code.split(".")}
NAMED |= {word for heading in re.findall(r"^## (.+?)(?::.*)?$", DOCUMENT, re.MULTILINE) for word in heading.split(", ")}
MAKERS = {
    "summary": ("MakeSummary",),
    "metrics": ("link_metrics", "robot_metrics", "feedback_metrics", "box_metrics"),
}


def _keys():
    for module, names in MAKERS.items():
        source = (ROOT / "drake_blfdmp" / "evaluation" / f"{module}.py").read_text(encoding="utf-8")
        functions = {node.name: node for node in ast.parse(source).body if isinstance(node, ast.FunctionDef)}
        for name in names:
            for node in ast.walk(functions[name]):
                if isinstance(node, ast.Dict):
                    yield from (key.value for key in node.keys if isinstance(key, ast.Constant))


@pytest.mark.parametrize("key", sorted(set(_keys())))
def test_every_entry_is_documented(key):
    assert key in NAMED, f"docs/summary.md does not say what {key} means"


def test_the_documented_thresholds_are_those_in_force():
    thresholds = Thresholds()
    for text in (
        f"at least {thresholds.lifted_m:.2f} m",
        f"within {1000 * thresholds.placement_m:.0f} mm",
        f"more than {thresholds.tilt_deg:.0f} degrees",
        f"within {1000 * thresholds.tracking_m:.0f} mm, root mean square",
    ):
        assert text in DOCUMENT
