"""What is drawn, and the page it becomes, read as data: the browser's part is in test_playback_in_browser."""

import json
import re
from base64 import b64decode

import numpy as np
import pytest
from made_files import MadeFile, poke
from meshcat import geometry

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.link_state import COLOURS
from drake_blfdmp.viewing.looks import LEGEND
from drake_blfdmp.viewing.playback.animation import Tracks
from drake_blfdmp.viewing.playback.meshes import NoMeshError, find_mesh, mesh_geometry
from drake_blfdmp.viewing.playback.page import render_page
from drake_blfdmp.viewing.playback.player import make_sheet
from drake_blfdmp.viewing.playback.poses import translation
from drake_blfdmp.viewing.playback.reading import read_played
from drake_blfdmp.viewing.playback.scene import Scene

STILL = [0.0, 0.0, 0.0, 1.0]


def recording(page):
    text = re.search(r'<script type="application/json" id="recording">(.*?)</script>', page, re.DOTALL).group(1)
    return json.loads(text)


def floats(text):
    return np.frombuffer(b64decode(text), dtype="<f4")


def track(data, path, name):
    """Times and values (F, n) of one track; None where the property does not change."""
    found = [t for t in data["tracks"]["clips"].get(path, ()) if t["name"] == name]
    if not found:
        return None
    times, values = floats(data["tracks"]["times"][found[0]["times"]]), found[0]["values"]
    values = floats(values) if isinstance(values, str) else np.array(values)
    return times, values.reshape(len(times), -1)


def objects(data):
    return {c["path"]: c["object"] for c in data["commands"] if c["type"] == "set_object"}


@pytest.fixture(scope="module")
def sheet(poked):
    return make_sheet([read_played(poked)])


@pytest.fixture(scope="module")
def data(sheet):
    return recording(render_page(sheet[0]))


def test_links_move_as_tf_says_and_what_stands_has_no_track(data):
    times, position = track(data, "/0/robot0/slide", "position")
    u = times / 4.0
    expected = np.stack([np.cos(u), np.sin(u), 0 * u], axis=-1) * (0.4 + 0.2 * u)[:, None] + [0, 0, 0.1]
    assert np.allclose(position, expected, atol=1e-4)
    assert track(data, "/0/robot0/base", "position") is None
    assert {"/0/robot0/base/0", "/0/robot0/upper/0", "/0/robot0/tool/0/top"} <= set(objects(data))
    assert "/0/robot0/finger" not in data["tracks"]["clips"], "nothing of it is seen"


def test_points_hang_at_the_person_s_frame(data):
    times, position = track(data, "/0/person/left_wrist", "position")
    assert np.allclose(
        position, np.stack([1.2 - 0.1 - 0.05 * times, 0 * times + 0.35, 0 * times + 1.0], axis=-1), atol=1e-6
    )


def test_links_take_the_colour_of_their_margin(data):
    for state, since in (("inside", 0.0), ("near", 2.0), ("outside", 2.8)):
        times, visible = track(data, f"/0/person/hands/rods/{state}", "visible")
        assert visible.ravel().tolist()[0] == (state == "inside")
        assert state == "inside" or times[1] == pytest.approx(since, abs=0.04)
    made = objects(data)
    assert made["/0/person/left_forearm/rods/near"]["materials"][0]["color"] == int(COLOURS["near"][1:], 16)
    assert "/0/person/left_forearm/rods/outside" not in made, "it never is"
    assert set(LEGEND.items()) <= set(map(tuple, data["legend"]))


def test_sleeves_are_where_the_band_lets_the_hands_be(data):
    commands = [c for c in data["commands"] if c["path"] == "/0/person/band/left"]
    assert commands[0]["matrix"][14] == pytest.approx(-(0.16 + 0.36) / 4)
    scale = [c for c in data["commands"] if c["path"] == "/0/person/band/left/sleeve" and c["type"] == "set_property"]
    assert scale[0]["value"] == pytest.approx([1.0, 1.0, (0.36 - 0.16) / 2])


def test_a_force_is_an_arrow_as_long_as_it_is_strong_while_it_is_there(data):
    times, visible = track(data, "/0/forces/0/arrow", "visible")
    assert visible.ravel().tolist() == [False, True] and times[1] == pytest.approx(2.0, abs=0.04)
    (scale,) = [text for text, _ in data["legend"] if text.startswith("force")]
    assert scale == "force, 20 N in 10 cm"
    _, shaft = track(data, "/0/forces/0/arrow/shaft", "scale")
    assert shaft[-1, 2] == pytest.approx(0.2 - 0.06), "40 N, and the head"


def test_events_title_and_clock_are_the_file_s(data):
    assert [(e["time"], e["text"]) for e in data["events"]] == [(0.5, "contact"), (2.5, "let go")]
    assert data["title"] == "poke.mcap: law default"
    assert data["start"] == 0.0 and data["duration"] == pytest.approx(4.0)


def test_the_same_file_makes_the_same_page_without_any_address(poked, sheet):
    page = render_page(sheet[0])
    assert page == render_page(make_sheet([read_played(poked)])[0])
    assert not re.findall(r"""(?:src|href)=["'](?!data:)""", page)
    assert set(re.findall(r"https?://[\w./-]+", page)) <= {"http://www.w3.org/1999/xhtml"}
    assert len(page) < 2e6


def test_texts_from_files_are_never_markup(tmp_path):
    path = poke(tmp_path / "poke.mcap", 0.2, law="</script><img src=x>", events=False)
    page = render_page(make_sheet([read_played(path)])[0])
    assert "<img" not in page
    assert recording(page)["title"] == "poke.mcap: law </script><img src=x>"


def test_several_files_are_told_apart(tmp_path, poked):
    other = poke(tmp_path / "other.mcap", 2.0, law="gams", shift=0.5)
    files = [read_played(poked), read_played(other)]
    overlaid = recording(render_page(make_sheet(files)[0]))
    made = objects(overlaid)
    assert "/1/robot0/base/0" not in made, "what stands in the same place is drawn once"
    first, second = (made[f"/{k}/robot0/upper/0"]["materials"][0] for k in (0, 1))
    assert first["opacity"] == 1.0 and second["opacity"] < 0.6 and first["color"] != second["color"]
    assert {"law default", "law gams"} <= {text for text, _ in overlaid["legend"]}
    assert overlaid["duration"] == pytest.approx(4.0) and not overlaid["anchors"]
    assert {e["label"] for e in overlaid["events"]} >= {"law default: contact", "law gams: contact"}

    beside = recording(render_page(make_sheet(files, side_by_side=True)[0]))
    assert objects(beside)["/1/robot0/base/0"]["materials"][0]["opacity"] == 0.5, "as in the file"
    (moved,) = [c["matrix"] for c in beside["commands"] if c["path"] == "/1"]
    apart = np.hypot(moved[12], moved[13])
    assert apart > 2.0 and len(beside["anchors"]) == 2
    camera, target = np.array(beside["camera"]), np.array(beside["target"])
    right = np.cross(target - camera, [0, 0, 1])
    assert np.dot(right, moved[12:15]) > 0, "the second is to the right of the first"


def test_files_of_one_law_go_by_their_names_and_too_many_are_refused(tmp_path):
    paths = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        paths.append(poke(tmp_path / name / "run.mcap", 0.2))
    sheet, _ = make_sheet([read_played(path) for path in paths])
    assert [label for label, _ in sheet.files] == ["a/run (law default)", "b/run (law default)"]
    with pytest.raises(BlfDmpError, match="at most 8"):
        make_sheet([read_played(paths[0])] * 9)
    with pytest.raises(BlfDmpError, match="--speed 0 is out of range"):
        make_sheet([read_played(paths[0])], speed=0.0)


def test_a_file_without_person_margin_or_force_is_drawn_without(tmp_path):
    with MadeFile(tmp_path / "points.mcap") as file:
        from drake_blfdmp.skeleton import POINTS

        for t in (0.0, 0.5, 1.0):
            values = {f"{name}_{axis}": 0.1 * k + 0.01 * t for k, name in enumerate(POINTS) for axis in "xyz"}
            file.joints(t, values, "/points")
        file.wrench(0.0, "/lost", "nowhere", [1.0, 0.0, 0.0])
        file.wrench(1.0, "/lost", "nowhere", [1.0, 0.0, 0.0])
    sheet, warnings = make_sheet([read_played(tmp_path / "points.mcap")])
    made = objects(recording(render_page(sheet)))
    assert "/0/person/hands/rods/unknown" in made and "/0/person/band/left/sleeve" not in made
    assert not set(LEGEND) & set(sheet.legend)
    assert warnings == [f"{tmp_path / 'points.mcap'}: /lost: its frame 'nowhere' is not in /tf; its force is not drawn"]


MESH_ROBOT = """<robot name="r"><link name="l">{}</link><joint name="j" type="revolute">
<parent link="l"/><child link="m"/></joint>
<link name="m"><visual><geometry><box size="1 1 1"/></geometry></visual></link></robot>"""
OBJ = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def test_meshes_are_found_or_skipped_with_a_line_each(tmp_path, monkeypatch):
    share = tmp_path / "install" / "share" / "my_arm" / "meshes"
    share.mkdir(parents=True)
    (share / "part.obj").write_text(OBJ)
    (tmp_path / "ros" / "other").mkdir(parents=True)
    (tmp_path / "ros" / "other" / "x.stl").write_bytes(b"\0" * 80 + (0).to_bytes(4, "little"))
    (tmp_path / "near.dae").write_text('<COLLADA><asset><unit name="mm" meter="0.001"/></asset></COLLADA>')
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "ros"))
    assert find_mesh("package://my_arm/meshes/part.obj", tmp_path) == share / "part.obj"
    assert find_mesh("package://other/x.stl", tmp_path) == tmp_path / "ros" / "other" / "x.stl"
    assert find_mesh("near.dae", tmp_path) == tmp_path / "near.dae"
    assert find_mesh((tmp_path / "near.dae").as_uri(), tmp_path) == tmp_path / "near.dae"
    assert mesh_geometry(tmp_path / "near.dae")[1] == 0.001
    for name in ("package://none/x.stl", "http://host/x.stl", "gone.obj"):
        with pytest.raises(NoMeshError):
            find_mesh(name, tmp_path)

    names = ("package://my_arm/meshes/part.obj", "package://none/x.stl", "near.glb")
    (tmp_path / "near.glb").write_bytes(b"glTF")
    shapes = "".join(f'<visual><geometry><mesh filename="{name}"/></geometry></visual>' for name in names)
    with MadeFile(tmp_path / "mesh.mcap") as file:
        file.description(MESH_ROBOT.format(shapes))
        for t in (0.0, 1.0):
            file.joints(t, {"j": t})
    sheet, warnings = make_sheet([read_played(tmp_path / "mesh.mcap")])
    assert objects(recording(render_page(sheet)))["/0/robot0/l/0"]["geometries"][0]["data"] == OBJ
    assert len(warnings) == 2 and "package://none/x.stl is not drawn: neither in ROS_PACKAGE_PATH" in warnings[0]
    assert "near.glb is not drawn" in warnings[1]


def test_tracks_keep_a_clock_once_and_leave_out_what_is_still():
    scene, times = Scene(), np.array([0.0, 1.0, 2.0])
    scene.move("/a", times, translation(np.outer(times, [1.0, 0.0, 0.0])))
    scene.move("/b", times, translation(np.outer(times, [0.0, 2.0, 0.0])))
    scene.move("/c", times, translation(np.ones((3, 3))))
    scene.show("/d", times, np.array([True, True, False]))
    scene.show("/e", times, np.array([True, True, True]))
    lowered = scene.tracks.lower()
    assert len(lowered["times"]) == 2 and set(lowered["clips"]) == {"/a", "/b", "/d"} and len(scene.tracks) == 3
    assert lowered["clips"]["/d"][0]["values"] == [True, False]
    assert Tracks().lower() == {"times": [], "clips": {}}


def test_identifiers_say_nothing_of_the_machine():
    scene = Scene()
    scene.add("/a", geometry.Sphere(0.1), "#ff0000")
    assert scene.commands[0]["object"]["object"]["uuid"] == "00000001"
