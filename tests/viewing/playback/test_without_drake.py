"""Playback needs neither Drake nor SciPy nor matplotlib: a process that plays a file has none of them loaded."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]

_LIBRARY = """
import pkgutil, sys
from importlib import import_module
import drake_blfdmp.viewing.playback as playback
for module in pkgutil.iter_modules(playback.__path__):
    import_module(f"{playback.__name__}.{module.name}")
from drake_blfdmp.viewing.playback.page import render_page
from drake_blfdmp.viewing.playback.player import make_sheet
from drake_blfdmp.viewing.playback.reading import read_played
assert len(render_page(make_sheet([read_played(sys.argv[1])])[0])) > 1e5
"""
_COMMAND = """
import sys
sys.path.insert(0, sys.argv[3])
import run
assert run.main(["playback", sys.argv[1], "--html", sys.argv[2]]) == 0
"""
_LOADED = """
print(sorted({name.split(".")[0] for name in sys.modules} & {"pydrake", "scipy", "matplotlib", "yaml"}))
"""


@pytest.mark.parametrize("script", [_LIBRARY, _COMMAND], ids=["library", "command"])
def test_no_drake_no_scipy_no_matplotlib_is_loaded(poked, tmp_path, script):
    arguments = [str(poked), str(tmp_path / "page.html"), str(ROOT)]
    done = subprocess.run([sys.executable, "-c", script + _LOADED, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"
