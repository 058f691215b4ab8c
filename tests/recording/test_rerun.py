"""A third reader, written in Rust: Rerun's, which needs `python -m pip install -e '.[viewers]'`."""

import numpy as np
import pytest
import recorded_run as run

chunks = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed: pip install -e '.[viewers]'")

STEPS = 101
TIMES = ("message_log_time", "message_publish_time")


@pytest.fixture(scope="module")
def entities(tmp_path_factory):
    """Entity -> column -> what Rerun makes of the recording, in the order of time."""
    path = tmp_path_factory.mktemp("rerun") / "run.mcap"
    run.record(path, chunk_duration=0.25)
    found: dict[str, list] = {}
    for chunk in chunks.McapReader(path).stream().to_chunks():
        batch = chunk.to_record_batch()
        columns = {
            name: (column.cast("int64") if name in TIMES else column).to_pylist()
            for name, column in zip(batch.schema.names, batch.columns, strict=True)
        }
        found.setdefault(str(chunk.entity_path), []).append(columns)
    return found


def series(entities, entity, column):
    """(times in ns, values) of a column over all chunks."""
    rows = []
    for columns in entities[entity]:
        if column in columns and "message_log_time" in columns:
            times = columns["message_log_time"]
            assert times == columns["message_publish_time"]
            rows += [(t, value) for t, value in zip(times, columns[column], strict=True) if value is not None]
    rows.sort(key=lambda row: row[0])
    return np.array([t for t, _ in rows]), [value for _, value in rows]


def test_scalars_are_what_the_plant_had(entities):
    for entity, ports in (
        ("/joint_states/position", ("left_state", "right_state")),
        ("/joint_states/velocity", ("left_state", "right_state")),
        ("/joint_states/effort", ("left_effort", "right_effort")),
        ("/margin/position", ("margin",)),
    ):
        times, values = series(entities, entity, "Scalars:scalars")
        assert np.array_equal(times, np.arange(STEPS) * 10_000_000), entity
        for t, value in zip(times, values, strict=True):
            states = [run.signal(t * 1e-9, port) for port in ports]
            if ports[0] == "left_state":
                half = 0 if entity.endswith("position") else 1
                states = [np.split(state, 2)[half] for state in states]
            assert value == list(np.concatenate(states)), (entity, t)


def test_names_and_description(entities):
    names = [columns["SeriesLines:names"][0] for columns in entities["/margin/position"]]
    assert names[0] == ["hands", "margin.left_a"]
    assert series(entities, "/robot_description", "TextDocument:text")[1] == [[run.URDF]]


def test_poses(entities):
    times, children = series(entities, "/tf", "Transform3D:child_frame")
    _, translations = series(entities, "/tf", "Transform3D:translation")
    _, quaternions = series(entities, "/tf", "Transform3D:quaternion")
    assert len(times) == STEPS * len(run.BODIES)
    for t, [child], [p], [xyzw] in zip(times, children, translations, quaternions, strict=True):
        X = run.poses_at(t * 1e-9)[run.BODIES[child]]
        wxyz = X.rotation().ToQuaternion().wxyz()
        np.testing.assert_allclose(p, X.translation(), rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(xyzw, [*wxyz[1:], wxyz[0]], atol=1e-7)


def test_counts(entities):
    [properties] = [c for c in entities["/__mcap_properties"] if "McapStatistics:message_count" in c]
    assert properties["McapStatistics:message_count"] == [[4 * STEPS + 3]]
