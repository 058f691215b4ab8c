import numpy as np
import pytest

from drake_blfdmp.viewing import person_shape


def corners(surface):
    vertices, faces = surface
    assert vertices.shape[0] == faces.shape[0] == 3
    assert faces.min() >= 0 and faces.max() < vertices.shape[1]
    return vertices.T[faces.T]


def volume(triangles):
    return np.einsum("ti,ti->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6.0


def test_the_body_is_closed_looks_outward_and_has_a_persons_size():
    vertices, faces = person_shape.body()
    edges = np.concatenate([faces[[0, 1]], faces[[1, 2]], faces[[2, 0]]], axis=1)
    # Vertices at one place, as at the poles, count as one.
    _, place = np.unique(vertices.round(9), axis=1, return_inverse=True)
    directed = place[edges]
    directed = directed[:, directed[0] != directed[1]]
    there, back = (set(map(tuple, pairs.T)) for pairs in (directed, directed[::-1]))
    assert there == back, "a hole"
    assert 0.03 < volume(corners((vertices, faces))) < 0.08  # m^3; a person without arms and legs.
    height, width = np.ptp(vertices[2]), np.ptp(vertices[0])
    assert 0.9 < height < 1.05 and 0.3 < width < 0.45


def test_legs_stand_on_the_floor_one_on_each_side_and_end_under_the_body():
    vertices, _ = person_shape.legs()
    assert vertices[2].min() == 0.0
    left, right = vertices[:, vertices[0] < 0], vertices[:, vertices[0] > 0]
    np.testing.assert_allclose(np.sort(left[0]), np.sort(-right[0]), atol=1e-12)
    bottom_of_body = person_shape.LEG + person_shape.body()[0][2].min()
    assert vertices[2].max() == pytest.approx(bottom_of_body + person_shape.SHOULDER_ABOVE_HIP, abs=0.02)
    toes = vertices[:, vertices[2] < 0.03]
    assert toes[1].max() > -2.0 * toes[1].min() > 0, "the feet do not point forward"
