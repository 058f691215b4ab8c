import re
from pathlib import Path

import numpy as np

from drake_blfdmp.recording.read import read_mcap

DOCS = Path(__file__).resolve().parents[2] / "docs" / "mcap.md"


def test_the_recorder_in_a_foreign_diagram_as_documented(tmp_path, monkeypatch):
    code = re.search(r"```\n(from pydrake.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)[1]
    monkeypatch.chdir(tmp_path)
    exec(compile(code, str(DOCS), "exec"), {})
    run = read_mcap(tmp_path / "pendulum.mcap")
    assert run.events == (("done", 2.0),)
    assert run.attachments == {"notes.txt": b"a pendulum"}
    swing, joints = run.series["/swing"], run.series["/joint_states"]
    assert swing.names == ("angle", "rate") and len(swing.t) == 201
    np.testing.assert_allclose(swing.values, joints.values[:, 0, :2], rtol=1e-6)
    assert swing.values[:, 0].min() < -0.45
