import dataclasses
import subprocess
import sys
from itertools import pairwise

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.image import imread
from scipy.spatial.transform import Rotation

from drake_blfdmp.errors import BlfDmpError, RecordingError
from drake_blfdmp.skeleton import HANDS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.figures import FIGURES, OF_THE_BOX, SPREAD, write_figures
from drake_blfdmp.viewing.robot_figures import box_height_tilt, contact_forces, joint_angles, swivel, tilt_angle
from drake_blfdmp.viewing.skill_figures import hands_distance, lengths, link_lengths, paths, spread


def draw(figure):
    """Lays `figure` out as for a file; returns the renderer that measures it."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return canvas.get_renderer()


def line(axis, label):
    (found,) = [drawn for drawn in axis.get_lines() if drawn.get_label() == label]
    return np.asarray(found.get_xdata()), np.asarray(found.get_ydata())


def several(run_log):
    """A made-up spread that grows with time, (N, 6, 3), m."""
    return (0.01 + 0.005 * run_log.t)[:, None, None] * np.array([0.2, 0.6, 1.0, 0.2, 0.6, 1.0])[:, None] * np.ones(3)


def drawn(run_log):
    """All figures that there can be."""
    return {**FIGURES, SPREAD: lambda log: spread(log, several(run_log))}


def test_writes_every_figure_readably_large_and_not_blank(run_log, tmp_path):
    written = write_figures(run_log, tmp_path / "new" / "figures")
    assert [path.stem for path in written] == list(FIGURES)
    for path in written:
        pixels = imread(path)[..., :3]
        assert pixels.shape[1] >= style.COLUMN * 200
        inked = np.mean(np.any(pixels < 0.9, axis=-1))
        assert 0.005 < inked < 0.6, path.name
        border = np.concatenate([pixels[0], pixels[-1], pixels[:, 0], pixels[:, -1]])
        assert np.mean(border > 0.9) > 0.99, f"{path.name} is cut off at its border"


def test_same_log_gives_same_bytes_whatever_a_person_set_in_matplotlib(run_log, tmp_path):
    first = [path.read_bytes() for path in write_figures(run_log, tmp_path / "a")]
    with matplotlib.rc_context({"lines.linewidth": 9.0, "font.size": 30, "axes.facecolor": "black", "savefig.dpi": 10}):
        second = [path.read_bytes() for path in write_figures(run_log, tmp_path / "b")]
    assert first == second
    assert b"matplotlib" not in b"".join(first)


def test_figures_leave_pyplot_and_its_state_alone():
    code = "import sys, drake_blfdmp.viewing.figures; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_texts_of_a_figure_do_not_overlap(run_log):
    for name, make in drawn(run_log).items():
        figure = make(run_log)
        renderer = draw(figure)
        boxes = [
            (text.get_text(), text.get_window_extent(renderer))
            for axis in figure.axes
            for text in (axis.title, axis.xaxis.label, axis.yaxis.label)
            if text.get_text()
        ]
        boxes += [(t.get_text(), t.get_window_extent(renderer)) for legend in figure.legends for t in legend.texts]
        boxes += [("event", t.get_window_extent(renderer)) for axis in figure.axes[:1] for t in axis.texts]
        for i, (first, a) in enumerate(boxes):
            assert figure.bbox.x0 <= a.x0 and a.x1 <= figure.bbox.x1 and a.y1 <= figure.bbox.y1, (name, first)
            for second, b in boxes[i + 1 :]:
                # Slanted names lie in boxes that overlap although the letters do not.
                assert (first == second == "event") or not a.overlaps(b), (name, first, second)


def test_legends_lie_outside_all_axes(run_log):
    for name, make in drawn(run_log).items():
        figure = make(run_log)
        renderer = draw(figure)
        assert len(figure.legends) == 1, name
        legend = figure.legends[0].get_window_extent(renderer)
        assert not any(legend.overlaps(axis.get_window_extent(renderer)) for axis in figure.axes), name


def test_hands_distance_shows_the_distance_and_its_offset_in_millimetres(run_log):
    above, below = hands_distance(run_log).axes
    distance = np.linalg.norm(run_log.position[:, 5] - run_log.position[:, 2], axis=-1)
    np.testing.assert_allclose(line(above, "coupled")[1], distance)
    middle = (run_log.lower[:, HANDS] + run_log.upper[:, HANDS]) / 2
    np.testing.assert_allclose(line(below, "coupled")[1], 1000 * (distance - middle))
    assert above.texts[0].get_text() == "grasp"
    low, high = below.get_ylim()
    assert low < 1000 * np.min(run_log.lower[:, HANDS] - middle)
    assert high > 1000 * np.max(run_log.upper[:, HANDS] - middle)


def test_link_lengths_shows_before_above_after(run_log):
    axes = link_lengths(run_log).axes
    np.testing.assert_allclose(line(axes[0], "upper arm")[1], lengths(run_log.uncoupled)[:, 0])
    np.testing.assert_allclose(line(axes[3], "upper arm")[1], lengths(run_log.position)[:, 0])
    np.testing.assert_allclose(line(axes[5], "upper arm")[1], lengths(run_log.position)[:, 4])
    np.testing.assert_allclose(line(axes[5], "forearm")[1], lengths(run_log.position)[:, 3])
    np.testing.assert_allclose(line(axes[4], "hands")[1], lengths(run_log.position)[:, HANDS])


def test_paths_keep_one_scale_in_all_views(run_log):
    figure = paths(run_log)
    draw(figure)
    scales = []
    for axis in figure.axes:
        box = axis.get_window_extent()
        scales += [box.width / np.ptp(axis.get_xlim()), box.height / np.ptp(axis.get_ylim())]
    np.testing.assert_allclose(scales, scales[0], rtol=0.02)


def test_spread_draws_every_points_mean_and_one_sigma_around_it(run_log):
    sigma = several(run_log)
    axes = np.reshape(spread(run_log, sigma).axes, (2, 3))
    for arm in range(2):
        for axis in range(3):
            for k, kind in enumerate(("shoulder", "elbow", "wrist")):
                mean, width = run_log.demonstrated[:, 3 * arm + k, axis], sigma[:, 3 * arm + k, axis]
                np.testing.assert_allclose(line(axes[arm, axis], kind)[1], mean)
                edges = axes[arm, axis].collections[k].get_paths()[0].vertices[:, 1]
                assert edges.min() == pytest.approx((mean - width).min())
                assert edges.max() == pytest.approx((mean + width).max())
                low, high = axes[arm, axis].get_ylim()
                assert low < edges.min() and edges.max() < high
    assert axes[0, 2].get_ylim() == axes[1, 2].get_ylim() and axes[0, 1].get_ylim() == axes[1, 1].get_ylim()


def test_a_run_whose_skill_has_a_spread_gets_its_figure(run_log, tmp_path):
    one, more = (
        write_figures(dataclasses.replace(run_log, spread=sigma), tmp_path / name)
        for name, sigma in (("one", None), ("several", several(run_log)))
    )
    assert [path.stem for path in one] == list(FIGURES)
    assert [path.stem for path in more] == [*FIGURES, SPREAD]
    pixels = imread(more[-1])[..., :3]
    assert pixels.shape[1] >= style.PAGE * 200 and 0.005 < np.mean(np.any(pixels < 0.9, axis=-1)) < 0.6


def test_a_motion_without_a_box_gets_every_figure_but_the_boxs(run_log, tmp_path):
    bare = dataclasses.replace(run_log, box=None, box_desired=None, palm_force=np.zeros((len(run_log.t), 2)))
    written = [path.stem for path in write_figures(bare, tmp_path)]
    assert written == [name for name in FIGURES if name not in OF_THE_BOX]
    assert set(FIGURES) - set(written) == {"contact_forces", "box_height_tilt"}
    with pytest.raises(RecordingError, match="without a box has no height"):
        box_height_tilt(bare)


def test_joint_angles_always_show_both_limits(run_log):
    axes = np.reshape(joint_angles(run_log).axes, (7, 2))
    for arm in range(2):
        for joint in range(7):
            low, high = axes[joint, arm].get_ylim()
            index = 7 * arm + joint
            assert low < run_log.q_lower[index] and run_log.q_upper[index] < high
            np.testing.assert_allclose(line(axes[joint, arm], "measured")[1], run_log.q[:, index])


def test_contact_forces_tell_left_from_right(run_log):
    (axis,) = contact_forces(run_log).axes
    np.testing.assert_allclose(line(axis, "left palm")[1], run_log.palm_force[:, 0])
    np.testing.assert_allclose(line(axis, "right palm")[1], run_log.palm_force[:, 1])


@settings(max_examples=50, deadline=None)
@given(st.floats(0.0, np.pi), st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi))
def test_tilt_is_the_angle_about_a_level_axis_and_blind_to_yaw(tilt, level, yaw, planned_yaw):
    planned = Rotation.from_euler("z", planned_yaw)
    axis = np.array([np.cos(level), np.sin(level), 0.0])
    actual = Rotation.from_rotvec(tilt * axis) * Rotation.from_euler("z", yaw)
    scalar_first = [rotation.as_quat()[None, [3, 0, 1, 2]] for rotation in (actual, planned)]
    assert tilt_angle(*scalar_first)[0] == pytest.approx(tilt, abs=1e-12)


def test_box_tilt_is_drawn_in_degrees(run_log):
    height, tilt = box_height_tilt(run_log).axes
    np.testing.assert_allclose(line(height, "planned")[1], run_log.box_desired[:, 6])
    assert np.max(tilt.get_lines()[0].get_ydata()) == pytest.approx(np.degrees(0.03), rel=0.01)


def test_a_box_that_only_stands_is_not_drawn_by_its_micrometres(run_log):
    still = np.tile(run_log.box[0], (len(run_log.t), 1))
    still[:, 6] += 1e-7 * np.sin(run_log.t)
    height, _ = box_height_tilt(dataclasses.replace(run_log, box=still, box_desired=still)).axes
    low, high = height.get_ylim()
    assert high - low == pytest.approx(0.02) and low < still[0, 6] < high


def test_swivel_has_no_jump_where_the_angle_wraps(run_log):
    assert np.max(np.abs(np.diff(run_log.swivel[:, 1]))) > 6.0, "the made-up log should wrap"
    for axis in swivel(run_log).axes:
        robot, person = line(axis, "robot")[1], line(axis, "person, mirrored")[1]
        assert np.max(np.abs(np.diff(robot))) < 10.0
        assert np.max(np.abs(robot - person)) < 10.0


def test_swivel_steps_over_samples_without_an_elbow_plane(run_log):
    swivelled = run_log.swivel.copy()
    swivelled[100:140] = np.nan
    robot = line(swivel(dataclasses.replace(run_log, swivel=swivelled)).axes[1], "robot")[1]
    assert np.isnan(robot).sum() == 40
    assert np.max(np.abs(robot[140:] - robot[139 - 40])) < 90.0


@given(
    st.lists(st.tuples(st.sampled_from(["grasp", "lift", "lower", "release"]), st.floats(-1.0, 11.0)), max_size=12),
    st.floats(0.01, 0.3),
)
def test_event_labels_keep_their_distance_and_lose_no_name(events, gap):
    merged = style.merge_events(events, (0.0, 10.0), gap)
    times = [time for _, time in merged]
    assert all(later - earlier >= gap * 10.0 for earlier, later in pairwise(times))
    names = sorted(name for label, _ in merged for name in label.split(", "))
    assert names == sorted(name for name, time in events if 0.0 <= time <= 10.0)


def test_a_run_without_events_and_of_two_samples_is_drawn(run_log, tmp_path):
    first_two = {
        field.name: getattr(run_log, field.name)[:2]
        for field in dataclasses.fields(run_log)
        if np.ndim(getattr(run_log, field.name)) and len(getattr(run_log, field.name)) == len(run_log.t)
    }
    assert len(write_figures(dataclasses.replace(run_log, **first_two, events=()), tmp_path)) == len(FIGURES)


@pytest.mark.parametrize("name", ["lower", "q", "palm_force", "box_desired", "swivel", "q_lower", "spread"])
def test_a_signal_of_wrong_shape_is_named(run_log, tmp_path, name):
    run_log = dataclasses.replace(run_log, spread=several(run_log))
    broken = dataclasses.replace(run_log, **{name: getattr(run_log, name)[:-1]})
    with pytest.raises(RecordingError, match=rf"^run log: {name} has shape .*expected [^\n]*$"):
        write_figures(broken, tmp_path)
    assert not list(tmp_path.iterdir())


def test_times_that_do_not_grow_are_refused(run_log, tmp_path):
    with pytest.raises(RecordingError, match="growing times"):
        write_figures(dataclasses.replace(run_log, t=run_log.t[::-1]), tmp_path)


def test_a_directory_that_is_a_file_is_refused(run_log, tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(BlfDmpError, match=r"taken.*name another directory"):
        write_figures(run_log, tmp_path / "taken")
