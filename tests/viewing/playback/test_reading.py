"""Whole files: where topics stand, how the bytes are packed, what is wrong with them."""

import subprocess
import sys

import numpy as np
import pytest
from made_files import JOINT_STATE, STRING, TF, MadeFile
from mcap.writer import CompressionType, IndexType

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.kinematics import link_poses
from drake_blfdmp.viewing.playback.reading import read_played
from drake_blfdmp.viewing.playback.topics import MOST_FRAMES

STILL = [0.0, 0.0, 0.0, 1.0]


def arm(path, seconds=2.0, rate=100, **options):
    with MadeFile(path, **options) as file:
        file.description()
        for k in range(round(seconds * rate) + 1):
            t = k / rate
            file.joints(t, {"shoulder": np.sin(t), "rail": 0.1 * t})
    return path


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"compression": CompressionType.ZSTD},
        {"compression": CompressionType.LZ4, "start_ns": 1_700_000_000_000_000_000},
        {"use_chunking": False},
        {"index_types": IndexType.NONE},
        {"index_types": IndexType.NONE, "use_summary_offsets": False, "use_statistics": False},
        {"repeat_channels": False, "repeat_schemas": False},
    ],
    ids=["plain", "zstd", "lz4_and_wall_clock", "no_chunks", "no_index", "no_summary", "channels_in_chunks_only"],
)
def test_however_the_file_is_packed_the_same_is_read(tmp_path, options):
    played = read_played(arm(tmp_path / "arm.mcap", **options))
    assert played.times[0] == 0.0 and played.times[-1] == pytest.approx(2.0) and len(played.times) == 61
    positions = played.models[0].positions
    # Between samples 10 ms apart a sine is off its chord by 1e-4 / 8.
    assert np.allclose(positions["shoulder"], np.sin(played.times), atol=2e-5)
    assert np.allclose(positions["rail"], 0.1 * played.times, atol=1e-9)
    assert not played.warnings


def test_a_part_is_played_with_the_event_that_holds_at_its_start(poked):
    played = read_played(poked, start=1.0, end=3.0)
    assert played.times[0] == 1.0 and played.times[-1] == 3.0
    assert played.events == ((1.0, "contact"), (2.5, "let_go"))
    assert played.label == "default"
    hands = played.vectors["margin"]["hands"]
    assert np.allclose(hands, 0.7 - played.times / 4.0, atol=1e-9)


def test_a_long_file_has_no_more_than_the_most_frames(tmp_path):
    played = read_played(arm(tmp_path / "long.mcap", seconds=120.0, rate=5))
    assert len(played.times) == MOST_FRAMES
    assert np.allclose(played.models[0].positions["rail"], 0.1 * played.times, atol=1e-6)


def test_namespaces_keep_two_robots_of_the_same_names_apart(tmp_path):
    with MadeFile(tmp_path / "two.mcap") as file:
        for side, sign in (("left", 1.0), ("right", -1.0)):
            file.description(topic=f"/{side}/robot_description")
            base = [("world", "base", [0.0, sign, 0.0, *STILL])]
            file.transforms(0.0, base, f"/{side}/tf_static")
            for k in range(101):
                file.joints(k / 100, {"shoulder": sign * k / 100}, f"/{side}/joint_states")
    played = read_played(tmp_path / "two.mcap")
    for model, sign in zip(played.models, (1.0, -1.0), strict=True):
        poses = link_poses(model.robot, model.frames, model.positions)
        assert np.allclose(poses["base"][0, :3, 3], [0, sign, 0])
        assert np.allclose(poses["slide"][-1, :3, 3], [0.4 * np.cos(1), sign + 0.4 * np.sin(sign), 0.1])


def test_one_namespaced_robot_takes_the_tf_there_is_at_whatever_rates(tmp_path):
    with MadeFile(tmp_path / "one.mcap") as file:
        file.description(topic="/arm/robot_description")
        for k in range(201):
            file.transforms(k / 100, [("odom", "base", [k / 100, 0.0, 0.0, *STILL])])
            if k % 10 == 0:
                file.transforms(k / 100, [("base", "upper", [0.0, k / 100, 0.1, *STILL])])
    played = read_played(tmp_path / "one.mcap")
    (model,) = played.models
    poses = link_poses(model.robot, model.frames, model.positions)
    assert np.allclose(poses["upper"][:, :2, 3], played.times[:, None], atol=1e-9)
    assert played.warnings == (f"{tmp_path / 'one.mcap'}: joint rail: no position; drawn at 0",)


def refusal(path, **options):
    with pytest.raises(BlfDmpError) as error:
        read_played(path, **options)
    text = str(error.value)
    assert "\n" not in text and text.startswith(str(path)), text
    assert error.value.exit_status == 2
    return text


def test_what_is_no_recording_is_refused(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.mcap")
    assert "cannot be read" in refusal(tmp_path)
    (tmp_path / "text.mcap").write_text("dear diary, today nothing happened")
    assert "is no MCAP file" in refusal(tmp_path / "text.mcap")
    (tmp_path / "empty.mcap").write_bytes(b"")
    assert "is empty" in refusal(tmp_path / "empty.mcap")
    with MadeFile(tmp_path / "ros1.mcap", profile="ros1") as file:
        file.description()
    assert "profile 'ros1'" in refusal(tmp_path / "ros1.mcap")


def test_files_without_anything_to_draw_or_to_move_are_refused(tmp_path):
    def made(name, fill):
        with MadeFile(tmp_path / name, **({"encoding": "json"} if "json" in name else {})) as file:
            fill(file)
        return tmp_path / name

    def camera(file):
        file.raw("/camera", "sensor_msgs/msg/Image", 0.0, b"pixels")

    def still(file):
        file.description()
        file.joints(1.0, {"shoulder": 0.5})

    def strange(file):
        file.description()
        file.raw("/tf", "my_msgs/msg/Thing", 0.0, b"\x00\x01\x00\x00")
        file.raw("/tf", "my_msgs/msg/Thing", 1.0, b"\x00\x01\x00\x00")

    def other_robot(file):
        file.description()
        for t in (0.0, 1.0):
            file.joints(t, {"wheel": t})

    def no_shapes(file):
        file.description('<robot name="r"><link name="l"/></robot>')
        for t in (0.0, 1.0):
            file.joints(t, {"wheel": t})

    assert "nothing to draw" in (text := refusal(made("none.mcap", lambda file: None))) and "topics: none" in text
    assert "nothing to draw" in (text := refusal(made("camera.mcap", camera))) and "/camera" in text
    assert "no transforms" in refusal(made("alone.mcap", lambda file: file.description()))
    assert "zero duration" in (text := refusal(made("still.mcap", still))) and "t = 1.000 s" in text
    assert "schema 'my_msgs/msg/Thing' in place of tf2_msgs/msg/TFMessage" in refusal(made("strange.mcap", strange))
    assert "encoded as 'json'" in refusal(made("json.mcap", still))
    assert "no transforms" in (text := refusal(made("other.mcap", other_robot))) and "shoulder" in text
    assert "no visual shapes" in refusal(made("no_shapes.mcap", no_shapes))


def test_messages_that_are_not_what_they_say_are_refused(tmp_path):
    for name, topic, kind in (("a", "/joint_states", JOINT_STATE), ("b", "/robot_description", STRING)):
        with MadeFile(tmp_path / f"{name}.mcap") as file:
            file.description(topic="/robot_description" if name == "a" else "/ns/robot_description")
            file.joints(0.0, {"shoulder": 0.0})
            file.joints(1.0, {"shoulder": 0.0})
            file.raw(topic, kind, 1.0, b"\x00\x01\x00\x00\xff\xff\xff\x7f")
        assert topic in refusal(tmp_path / f"{name}.mcap")


def test_time_that_goes_back_is_refused_and_a_little_disorder_is_told(tmp_path):
    def made(name, times):
        with MadeFile(tmp_path / name) as file:
            file.description()
            for t in times:
                file.joints(t, {"shoulder": t})
        return tmp_path / name

    assert "time goes back from 2.000 s to 0.500 s" in refusal(made("back.mcap", [0.0, 1.0, 2.0, 0.5, 3.0]))
    played = read_played(made("late.mcap", [0.0, 1.0, 2.0, 1.99, 3.0]))
    assert "1 messages came late" in played.warnings[0]


@pytest.mark.parametrize(
    ("part", "said"),
    [
        ({"start": 1.5, "end": 1.0}, "--from 1.5 is not before --to 1"),
        ({"start": 1.0, "end": 1.0}, "--from 1 is not before --to 1"),
        ({"start": 9.0}, "not before the file's end at 2.00 s"),
        ({"start": -1.0}, "give seconds from 0"),
        ({"end": float("nan")}, "give seconds from 0"),
    ],
)
def test_a_part_that_is_empty_is_refused(tmp_path, part, said):
    assert said in refusal(arm(tmp_path / "arm.mcap", rate=10), **part)


def test_a_truncated_file_says_so_and_plays_up_to_there_when_asked(tmp_path):
    whole = arm(tmp_path / "whole.mcap").read_bytes()
    cut = tmp_path / "cut.mcap"
    for share in (0.3, 0.6, 0.9):
        cut.write_bytes(whole[: int(share * len(whole))])
        assert f"python run.py recover {cut}" in (text := refusal(cut)) and "truncated" in text
        played = read_played(cut, partial=True)
        assert 0.1 < played.times[-1] < 2.0
        assert np.allclose(played.models[0].positions["rail"], 0.1 * played.times, atol=1e-9)
        assert "what stands before is played" in played.warnings[0]
    cut.write_bytes(whole[:-4])
    assert "within its index" in refusal(cut)


def test_a_damaged_chunk_is_noticed(tmp_path):
    path = arm(tmp_path / "arm.mcap")
    data = bytearray(path.read_bytes())
    middle = data.index(b"shoulder", len(data) // 2)
    data[middle : middle + 8] = b"SHOULDER"
    path.write_bytes(data)
    assert "damaged near byte" in refusal(path)
    assert read_played(path, partial=True).times[-1] > 0.1


_MEASURE = """
import sys, resource
from drake_blfdmp.viewing.playback.page import render_page
from drake_blfdmp.viewing.playback.player import make_sheet
from drake_blfdmp.viewing.playback.reading import read_played
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
render_page(make_sheet([read_played(sys.argv[1])])[0])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
"""


def test_memory_does_not_grow_with_the_file(tmp_path):
    path = tmp_path / "large.mcap"
    with MadeFile(path, chunk_size=1 << 20) as file:
        file.description()
        edges = [("world", "base", [0.0, 0.0, 0.0, *STILL]), ("base", "upper", [0.0, 0.0, 0.1, *STILL])]
        file.transforms(0.0, edges)
        once = []
        raw, file.raw = file.raw, lambda topic, kind, t, data, schema=None: once.append(data)
        file.transforms(0.0, edges * 200)
        file.raw = raw
        for k in range(2000):
            file.raw("/tf", TF, 0.01 * k, once[0])
    assert path.stat().st_size > 70e6
    done = subprocess.run([sys.executable, "-c", _MEASURE, path], capture_output=True, text=True, check=True)
    kilobytes = int(done.stdout)
    unit = 1024 if sys.platform != "darwin" else 1
    assert kilobytes * unit < 40e6, "a file of 70 MB must not come into memory"


@pytest.mark.parametrize("chunks", [True, False])
def test_whatever_byte_is_wrong_there_is_one_line_or_a_page(tmp_path, chunks):
    from drake_blfdmp.viewing.playback.page import render_page
    from drake_blfdmp.viewing.playback.player import make_sheet

    whole = arm(tmp_path / "whole.mcap", seconds=0.4, rate=20, use_chunking=chunks).read_bytes()
    random = np.random.default_rng(7)
    path = tmp_path / "wrong.mcap"
    played = 0
    for _ in range(150):
        data = bytearray(whole)
        for at in random.integers(0, len(data), random.integers(1, 8)):
            data[at] = random.integers(0, 256)
        path.write_bytes(data[: random.integers(len(data) // 2, len(data))] if random.random() < 0.2 else data)
        try:
            render_page(make_sheet([read_played(path, partial=bool(random.random() < 0.5))])[0])
            played += 1
        except BlfDmpError as error:
            assert "\n" not in str(error)
    assert 0 < played < 150


def test_two_publishers_of_one_topic_are_both_heard(tmp_path):
    with MadeFile(tmp_path / "two.mcap") as file:
        file.description()
        for name, sign in (("shoulder", 1.0), ("rail", -1.0)):
            file.another_publisher("/joint_states")
            for k in range(101):
                file.joints(k / 100, {name: sign * k / 100})
    positions = read_played(tmp_path / "two.mcap").models[0].positions
    assert set(positions) == {"shoulder", "rail"}
    assert positions["shoulder"][-1] == 1.0 and positions["rail"][-1] == -1.0
