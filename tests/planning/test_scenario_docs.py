"""docs/scenario.md against the dataclasses it describes."""

import re
from dataclasses import fields, is_dataclass
from pathlib import Path

import pytest
import yaml

from drake_blfdmp.planning.scenario import Scenario

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "scenario.md"
ROW = re.compile(r"^\| `([\w.]+)` \| (.+?) \| .+ \|$", re.MULTILINE)


def _leaves(value, prefix=""):
    for item in fields(value):
        child = getattr(value, item.name)
        if is_dataclass(child):
            yield from _leaves(child, f"{prefix}{item.name}.")
        else:
            yield f"{prefix}{item.name}", child


KEYS = dict(_leaves(Scenario()))
DOCUMENTED = dict(ROW.findall(DOCUMENT.read_text(encoding="utf-8")))


def test_no_key_is_documented_that_is_not_there():
    assert sorted(set(DOCUMENTED) - set(KEYS)) == []


@pytest.mark.parametrize("key", KEYS)
def test_every_key_is_documented_with_its_default(key):
    assert key in DOCUMENTED, f"docs/scenario.md has no row for {key}"
    assert yaml.safe_load(DOCUMENTED[key].strip("`")) == KEYS[key]
