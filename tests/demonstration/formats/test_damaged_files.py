"""Whatever happens to a file of these formats, it is read or refused in one line."""

import copy
import json
import warnings

import numpy as np
import pytest
from file_samples import SAMPLES
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from synthetic_carry import carry

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats import FORMATS, read_recording
from drake_blfdmp.errors import RecordingError

T, X = carry(duration=0.4)
PIECES = (
    b"1e308", b"9" * 400, b"9" * 5000, b"nan", b"-1", b"0", b"null", b"{}", b"[]", b'""', b'"a"', b"true", b"\n",
    b"\xff\xff\xff\x7f", b"\0\0\0\0",
)  # fmt: skip
VALUES = (
    None, True, 0, -1, 3, 1e308, float("nan"), float("inf"), 10**400, "", "abc", "1.5", "x\ny", [], {}, [[]], [{}],
    {"x": 1}, {"x": 1, "y": 2, "z": "q"}, [1, 2], [1, 2, 3], [1, 2, 3, 4], [[1, 2, 3]], {"left_wrist": [1, 2, 3]},
)  # fmt: skip
MANY = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    folder = tmp_path_factory.mktemp("samples")
    return {name: write(folder / name, T, X) for name, write in SAMPLES.items()}


def read_or_refuse(path, name):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            recording = read_recording(path, format=name)
        except RecordingError as error:
            assert "\n" not in str(error)
            assert str(path) in str(error)
            return
    assert isinstance(recording, Recording)
    assert recording.x.shape == (len(recording.t), 6, 3)
    assert np.isfinite(recording.t).all()
    assert not np.isinf(recording.x).any()


@pytest.mark.parametrize("name", SAMPLES)
def test_samples_are_recognised_and_read(samples, name):
    if name == "c3d":
        pytest.importorskip("c3d")
    assert next(format for format, reader in FORMATS.items() if reader.sniff(samples[name].read_bytes())) == name
    recording = read_recording(samples[name])
    np.testing.assert_allclose(recording.x, X, atol=1e-6)
    np.testing.assert_allclose(recording.t - recording.t[0], T, atol=1e-6)


@pytest.mark.parametrize("name", SAMPLES)
@MANY
@given(data=st.data())
def test_damaged_bytes(samples, tmp_path, name, data):
    content = bytearray(samples[name].read_bytes())
    whole = data.draw(st.booleans())
    for _ in range(data.draw(st.integers(1, 4))):
        most = max(0, len(content) - 1)
        start = data.draw(st.integers(0, most if whole else min(most, 2500)))
        end = min(start + data.draw(st.integers(1, 60)), len(content))
        what = data.draw(st.sampled_from(("flip", "cut", "double", "insert", "end")))
        if what == "flip" and content:
            content[start] = data.draw(st.integers(0, 255))
        elif what == "cut":
            del content[start:end]
        elif what == "double":
            content[start:start] = content[start:end]
        elif what == "insert":
            content[start:end] = data.draw(st.sampled_from(PIECES))
        elif data.draw(st.booleans()):
            del content[start + 1 :]
    path = tmp_path / "a"
    path.write_bytes(content)
    read_or_refuse(path, name)


@pytest.mark.parametrize("name", [name for name in SAMPLES if name.endswith("json")])
@MANY
@given(data=st.data())
def test_damaged_documents(samples, tmp_path, name, data):
    root = [json.loads(samples[name].read_text())]
    for _ in range(data.draw(st.integers(1, 3))):
        node, key = root, 0
        for _ in range(data.draw(st.integers(0, 6))):
            if isinstance(node[key], list | dict) and node[key]:
                node = node[key]
                key = data.draw(st.sampled_from([*node] if isinstance(node, dict) else range(len(node))))
        what = data.draw(st.sampled_from(("replace", "replace", "remove", "double")))
        if what == "replace" or node is root:
            node[key] = copy.deepcopy(data.draw(st.sampled_from(VALUES)))
        elif what == "remove":
            del node[key]
        elif isinstance(node, list):
            node.insert(key, copy.deepcopy(node[key]))
        else:
            node[f"{key}2"] = node.pop(key)
    path = tmp_path / "a"
    path.write_text(json.dumps(root[0]))
    read_or_refuse(path, name)


@pytest.mark.parametrize("name", SAMPLES)
def test_cut_anywhere(samples, tmp_path, name):
    path = tmp_path / "a"
    content = samples[name].read_bytes()
    for end in {*range(1, 100, 9), *range(100, len(content), max(1, len(content) // 80))}:
        path.write_bytes(content[:end])
        read_or_refuse(path, name)
