"""docs/mcap_topics.md against a run's file, read by an independent reader."""

import re
from collections import defaultdict
from itertools import pairwise
from pathlib import Path

import pytest
from mcap.reader import make_reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

DOCUMENT = (Path(__file__).resolve().parents[2] / "docs" / "mcap_topics.md").read_text(encoding="utf-8")
HEADER = ["topic", "type", "unit", "frame", "rate", "what"]
NOT_IN_A_BOX_RUN = {"/turn"}
FRAME_IN_TABLE_ALONE = {"/points", "/planned_palms", "/planned_box", "/swivel"}
UNIT_IN_TABLE_ALONE = {"/robot_description", "/tf_static", "/tf", "/joint_states", "/skeleton"}


def rows():
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in DOCUMENT.splitlines() if line[:1] == "|"]
    return {row[0].strip("`"): dict(zip(HEADER, row, strict=True)) for row in cells if row[0].startswith("`/")}


def attachments():
    return re.findall(r"^\| `([\w.]+)` \|", DOCUMENT, re.MULTILINE)


@pytest.fixture(scope="module")
def recorded(default_run):
    """Topic -> (type, unit, frames, log times in s); names of the attachments; metadata."""
    store, topics, times, frames = get_typestore(Stores.EMPTY), {}, defaultdict(list), defaultdict(set)
    with (default_run.folder / "run.mcap").open("rb") as stream:
        reader = make_reader(stream)
        for schema, channel, message in reader.iter_messages():
            name = channel.topic
            if name not in topics:
                topics[name] = schema.name, channel.metadata.get("unit", "")
                store.register(get_types_from_msg(schema.data.decode(), schema.name))
            times[name].append(message.log_time * 1e-9)
            if len(times[name]) <= 3:
                decoded = store.deserialize_cdr(message.data, schema.name)
                for part in getattr(decoded, "transforms", getattr(decoded, "markers", [decoded])):
                    if hasattr(part, "header"):
                        frames[name].add(part.header.frame_id)
        kept = [attachment.name for attachment in reader.iter_attachments()]
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    return {name: (*topics[name], frames[name], times[name]) for name in topics}, kept, metadata


def test_every_topic_is_documented_and_every_documented_topic_is_there(recorded):
    assert set(rows()) - NOT_IN_A_BOX_RUN == set(recorded[0])


@pytest.mark.parametrize("topic", sorted(set(rows()) - NOT_IN_A_BOX_RUN))
def test_type_unit_frame_and_rate_are_as_documented(recorded, topic):
    kind, unit, frames, times = recorded[0][topic]
    row = rows()[topic]
    assert row["type"] == kind
    if topic not in UNIT_IN_TABLE_ALONE:
        assert row["unit"] == unit
    if topic not in FRAME_IN_TABLE_ALONE:
        assert (frames or {""}) == {row["frame"]}
    samples = len(recorded[0]["/joint_states"][3])
    if row["rate"] == "each sample":
        assert len(times) == samples
    elif row["rate"] == "slow":
        assert len(times) == -(-samples // 4)
        assert min(b - a for a, b in pairwise(times)) >= 1 / 25 - 1e-9
    elif row["rate"].startswith("once"):
        assert times == [0.0]
    else:
        assert row["rate"] == "when it happens" and 0 < len(times) < 20


def test_attachments_are_documented(recorded):
    assert set(attachments()) - {"last_states.json"} == set(recorded[1])


def test_the_metadata_say_what_the_document_promises(recorded):
    run = recorded[2]["run"]
    for key in re.findall(r"`(\w+)`", DOCUMENT.split("## Metadata")[1].split("| attachment")[0]):
        assert key in (*run, *run.values(), "run", "motion") or any(name.startswith(key) for name in run), key
