import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from drake_blfdmp.viewing.band_limits import HandsBand


class Tree:
    """Stands where Meshcat does and keeps the last of every transform and property."""

    def __init__(self):
        self.objects, self.poses, self.properties = [], {}, {}

    def SetObject(self, path, shape, rgba):
        self.objects.append(path)

    def SetTransform(self, path, pose, time_in_recording=None):
        self.poses[path] = pose

    def SetProperty(self, path, name, value, time_in_recording=None):
        self.properties[path, name] = value


places = arrays(float, 3, elements=st.floats(-1.0, 1.0))
distances = st.floats(0.05, 1.0)


@given(places, places, distances, distances)
def test_a_hand_is_inside_its_sleeve_exactly_when_the_distance_is_inside_its_band(left, right, one, other):
    lower, upper = sorted((one, other))
    distance = np.linalg.norm(right - left)
    assume(distance > 0.01 and upper - lower > 1e-3 and np.abs(distance - [lower, upper]).min() > 1e-6)
    tree = Tree()
    HandsBand(tree, "/band").draw(left, right, lower, upper, 0.1)
    for side, hand in (("left", left), ("right", right)):
        in_sleeve = (tree.poses["/band"] @ tree.poses[f"/band/{side}"]).inverse() @ hand
        half = tree.properties[f"/band/{side}/sleeve", "scale"][2] / 2
        assert np.abs(in_sleeve[:2]).max() < 1e-9, "the hand is off the sleeve's axis"
        assert (abs(in_sleeve[2]) < half) == (lower < distance < upper)


def test_it_is_hidden_until_drawn_and_makes_nothing_new():
    tree = Tree()
    band = HandsBand(tree, "/band")
    assert tree.properties["/band", "visible"] is False
    made = list(tree.objects)
    band.draw(np.zeros(3), np.array([0.3, 0.0, 0.0]), np.nan, 0.3)
    assert tree.properties["/band", "visible"] is False, "limits that are not known are drawn"
    band.draw(np.zeros(3), np.array([0.3, 0.0, 0.0]), 0.28, 0.32)
    assert tree.properties["/band", "visible"] is True
    assert tree.objects == made
