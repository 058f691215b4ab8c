"""The live view's sliders and buttons, clicked as a browser's message clicks them, and in a real browser."""

import time
from contextlib import contextmanager

import numpy as np
import pytest
import umsgpack
from browser import LivePage, needs_browser, patiently

from drake_blfdmp.viewing.live_controls import CONTINUE, PAUSE, SPEED, LiveControls, Place, goal_slider
from drake_blfdmp.viewing.meshcat_scene import set_scene_camera, start_meshcat

X, Y = goal_slider("x"), goal_slider("y")
PLANNED = {"x": (0.1276, -0.15, 0.055), "y": (0.5447, -0.08, 0.09)}
PUSHES = ("push box +x", "push box -x")


@pytest.fixture(scope="module")
def meshcat():
    return start_meshcat(port=0)


@contextmanager
def every_control(meshcat):
    made = LiveControls(
        meshcat,
        goal=PLANNED,
        step=0.005,
        pushes=PUSHES,
        place=Place(np.array([0.1276, 0.5447, 0.35]), 0.06, (0.30, 0.20)),
    )
    try:
        yield made
    finally:
        made.delete()


@pytest.fixture
def controls(meshcat):
    with every_control(meshcat) as made:
        yield made


def click(meshcat, name):
    meshcat._InjectWebsocketMessage(umsgpack.packb({"type": "button", "name": name}))


@pytest.mark.parametrize("planned", [0.1276, -0.0374999, 0.0, 0.5000001, 1 / 3])
def test_untouched_the_goal_is_exactly_where_it_was_planned(meshcat, planned):
    controls = LiveControls(meshcat, goal={"y": (planned, -0.1, 0.1)}, step=0.005, pushes=())
    np.testing.assert_array_equal(controls.goal_offset(), 0.0)
    assert abs(meshcat.GetSliderValue(Y) - planned) <= 0.0025 + 1e-12
    controls.delete()


def test_a_moved_slider_says_where_the_goal_is_in_the_world(meshcat, controls):
    meshcat.SetSliderValue(X, 0.15)
    meshcat.SetSliderValue(Y, 0.5)
    np.testing.assert_allclose(controls.goal_offset(), [0.15 - 0.1276, 0.5 - 0.5447, 0.0], atol=1e-12)


def test_no_slider_leaves_its_range(meshcat, controls):
    for value, limit in ((9.0, 1), (-9.0, 0)):
        for name in (X, Y):
            meshcat.SetSliderValue(name, value)
        allowed = np.array([PLANNED[axis][1:] for axis in "xy"])
        offset = controls.goal_offset()[:2]
        assert (offset >= allowed[:, 0] - 1e-12).all() and (offset <= allowed[:, 1] + 1e-12).all()
        np.testing.assert_allclose(offset, allowed[:, limit], atol=0.005)


def test_an_axis_without_room_has_no_slider(meshcat):
    controls = LiveControls(meshcat, goal={"x": (0.1, 0.0, 0.0), "y": (0.5, 0.0, 0.05)}, step=0.005, pushes=())
    assert X not in meshcat.GetSliderNames() and Y in meshcat.GetSliderNames()
    controls.delete()


def test_a_click_pushes_once(meshcat, controls):
    assert controls.pushed() == []
    click(meshcat, PUSHES[1])
    assert controls.pushed() == [PUSHES[1]]
    assert controls.pushed() == []


def test_pause_and_continue_are_one_button_and_a_double_click_is_one_click(meshcat, controls):
    assert not controls.paused()
    click(meshcat, PAUSE), click(meshcat, PAUSE)
    assert controls.paused() and controls.paused()
    assert CONTINUE in meshcat.GetButtonNames() and PAUSE not in meshcat.GetButtonNames()
    click(meshcat, CONTINUE)
    assert not controls.paused()
    assert PAUSE in meshcat.GetButtonNames() and CONTINUE not in meshcat.GetButtonNames()


def test_the_goals_sliders_go_when_it_is_settled_and_all_goes_at_the_end(meshcat, controls):
    meshcat.SetSliderValue(X, 0.15)
    controls.delete_goal(np.array([0.01, 0.0, 0.0]))
    assert meshcat.GetSliderNames() == [SPEED] and not controls.movable
    np.testing.assert_array_equal(controls.goal_offset(), [0.01, 0.0, 0.0])
    controls.delete()
    assert meshcat.GetSliderNames() == [] and meshcat.GetButtonNames() == []
    assert not meshcat.HasPath("/live")


@needs_browser
def test_in_a_browser_the_controls_are_there_and_are_heard(meshcat, tmp_path):
    patiently(lambda: use_the_controls(meshcat, tmp_path))


def use_the_controls(meshcat, tmp_path):
    set_scene_camera(meshcat)
    row = "[...document.querySelectorAll('.property-name')].find(e => e.textContent === %r)"
    with every_control(meshcat) as controls, LivePage(meshcat.web_url(), tmp_path) as page:
        for label in (X, Y, SPEED, *PUSHES, PAUSE):
            page.wait_for(f"Boolean({row % label})")
        page.evaluate("document.querySelector('.close-button').click()")

        page.evaluate(f"{row % PAUSE}.closest('li').click()")
        assert heard(controls.paused)
        page.wait_for(f"Boolean({row % CONTINUE})")

        page.evaluate(f"{row % PUSHES[0]}.closest('li').click()")
        assert heard(controls.pushed) == [PUSHES[0]]
        shown = page.evaluate("[...document.querySelectorAll('.property-name')].map(e => e.textContent)")
        assert shown[-6:] == [X, Y, SPEED, *PUSHES, CONTINUE]  # Nothing jumps.

        field = f"{row % X}.closest('li').querySelector('input')"
        page.evaluate(
            f"(() => {{ const field = {field}; field.value = '0.15'; field.dispatchEvent(new Event('change')); }})()"
        )
        assert heard(lambda: controls.goal_offset()[0]) == pytest.approx(0.15 - 0.1276)

        page.evaluate("document.dispatchEvent(new KeyboardEvent('keydown', {code: 'KeyP', bubbles: true}))")
        assert heard(lambda: not controls.paused())
        beside = page.screenshot(tmp_path / "page.png")[:, :600]
        assert np.sum(beside[..., 1] - beside[..., 0] > 0.2) > 500  # The green mark on the table.


def heard(what, tries=200):
    """What comes once the browser's message is here."""
    for _ in range(tries):
        if found := what():
            return found
        time.sleep(0.05)
    raise AssertionError("never heard")
