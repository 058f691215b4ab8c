"""What is listed by hand in pyproject.toml, against the tree."""

import ast
import sys
import tomllib
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import drake_blfdmp

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SOURCES = [*sorted((ROOT / "drake_blfdmp").rglob("*.py")), ROOT / "run.py"]


def test_every_package_is_listed():
    tree = {".".join(file.parent.relative_to(ROOT).parts) for file in (ROOT / "drake_blfdmp").rglob("__init__.py")}
    assert set(PROJECT["tool"]["setuptools"]["packages"]) == tree | {"drake_blfdmp._models"}


def test_every_model_goes_into_the_wheel():
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["drake_blfdmp._models"]
    packed = {file for pattern in patterns for file in (ROOT / "models").glob(pattern)}
    assert packed == {file for file in (ROOT / "models").iterdir() if file.is_file()}


def test_the_version_is_the_same_everywhere():
    version = PROJECT["project"]["version"]
    assert drake_blfdmp.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\n## [{version}]" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_every_imported_distribution_is_a_declared_dependency():
    imported = set()
    for file in SOURCES:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                imported |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                imported.add((node.module or "").split(".")[0])
    foreign = imported - set(sys.stdlib_module_names) - {"drake_blfdmp"}
    distributions = packages_distributions()
    extras = PROJECT["project"]["optional-dependencies"]
    offered = [text for name, texts in extras.items() if name not in ("test", "dev") for text in texts]
    declared = {text.split(">=")[0] for text in PROJECT["project"]["dependencies"] + offered}
    # What is not installed here, as an extra may not be, goes by its module's name.
    assert {name.lower() for module in foreign for name in distributions.get(module, [module])} <= declared


@pytest.mark.parametrize("file", SOURCES, ids=lambda file: str(file.relative_to(ROOT)))
def test_sources_keep_to_the_house_rules(file):
    tree = ast.parse(file.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree), "says nothing about itself"
    for node in ast.walk(tree):
        # `assert` vanishes under -O, so it must not refuse bad input; pydrake.all costs a second at every start.
        assert not isinstance(node, ast.Assert), f"line {node.lineno}: assert"
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module] if isinstance(node, ast.ImportFrom) else []
        assert "pydrake.all" not in names, f"line {node.lineno}: pydrake.all"
