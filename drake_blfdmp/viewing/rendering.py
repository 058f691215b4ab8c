"""Shapes as triangles, a camera and pictures of them, by NumPy: no GPU, no browser.

Every shape becomes triangles, every triangle a cloud of points closer together than the pixels, and of all points that
fall into one pixel the nearest to the camera stays. That is a depth buffer. Unlike triangles sorted by their distance
it is right where shapes intersect, as a Panda's capsules do everywhere, and where the box's tape lies 1 mm above its
faces.
"""

from dataclasses import dataclass

import numpy as np
from matplotlib.colors import to_rgb

AROUND = 24
"""Segments of a circle."""

LIGHT = np.array([0.45, 0.35, 0.82]) / np.linalg.norm([0.45, 0.35, 0.82])
"""Towards the light, in W."""

AMBIENT = 0.42
OUTLINE = 0.25
STEP = 0.03  # A jump of the depth that counts as an outline, m.
SPACING = 0.7  # Of the points on a triangle, in pixels.
OVERSAMPLING = 2


@dataclass(frozen=True)
class Triangles:
    """Triangles in one frame: corners (T, 3, 3), m, counter-clockwise from outside; colours (T, 3), red green blue."""

    corners: np.ndarray
    colours: np.ndarray


@dataclass(frozen=True)
class Camera:
    """A pinhole camera in W with z up in the picture; the picture's coordinates are tangents of the viewing angle.

    Attributes:
        eye, target: (3,) where it is and where it looks, m; not one above the other.
    """

    eye: np.ndarray
    target: np.ndarray

    def axes(self) -> np.ndarray:
        """Right, up and forward as rows (3, 3)."""
        forward = np.asarray(self.target, dtype=float) - self.eye
        right = np.cross(forward, [0.0, 0.0, 1.0])
        rows = np.array([right, np.cross(right, forward), forward])
        return rows / np.linalg.norm(rows, axis=1, keepdims=True)

    def project(self, points):
        """Coordinates (..., 2), to the right and up, and depth (...), m, of points (..., 3) in W."""
        seen = (np.asarray(points) - self.eye) @ self.axes().T
        return seen[..., :2] / seen[..., 2:], seen[..., 2]


def revolved(profile) -> np.ndarray:
    """Corners (T, 3, 3) of the solid that a profile (P, 2) of radius and height, bottom to top, sweeps about z."""
    r, z = np.asarray(profile, dtype=float).T
    angle = 2.0 * np.pi * np.arange(AROUND + 1) / AROUND
    ring = np.stack([np.outer(r, np.cos(angle)), np.outer(r, np.sin(angle)), np.outer(z, np.ones_like(angle))], axis=-1)
    a, b, c, d = ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]
    corners = np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]).reshape(-1, 3, 3)
    return corners[np.linalg.norm(normals(corners), axis=-1) > 1e-15]


def capsule_corners(radius: float, length: float) -> np.ndarray:
    """A capsule along z (T, 3, 3): a cylinder of `length` with half balls on both ends; a ball where it is 0."""
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, AROUND // 2 + 2)
    half = np.where(angle < 0, -0.5 * length, 0.5 * length)
    return revolved(np.stack([radius * np.cos(angle), half + radius * np.sin(angle)], axis=-1))


def cylinder_corners(radius: float, length: float) -> np.ndarray:
    """A cylinder along z (T, 3, 3)."""
    half = 0.5 * length
    return revolved([(0.0, -half), (radius, -half), (radius, half), (0.0, half)])


def box_corners(size) -> np.ndarray:
    """A box (12, 3, 3) of size (3,)."""
    faces = []
    for axis in range(3):
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        for sign in (-1, 1):
            face = np.insert(square[::sign], axis, sign, axis=1)
            # (x, z) is a left-handed pair, so the faces along y turn the other way.
            face = face[::-1] if axis == 1 else face
            faces += [face[[0, 1, 2]], face[[0, 2, 3]]]
    return 0.5 * np.array(faces, dtype=float) * np.asarray(size)


def normals(corners) -> np.ndarray:
    """Outward normals (T, 3) of triangles, as long as twice their area, m^2."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def joined(*parts: Triangles) -> Triangles:
    """All triangles of several."""
    return Triangles(np.concatenate([p.corners for p in parts]), np.concatenate([p.colours for p in parts]))


def coloured(corners, colour) -> Triangles:
    """Triangles of one colour: a name or red, green, blue."""
    return Triangles(np.asarray(corners), np.tile(to_rgb(colour), (len(corners), 1)))


def lit(triangles: Triangles) -> np.ndarray:
    """Colours (T, 3) under the light, by Lambert's law and a share of ambient light."""
    n = normals(triangles.corners)
    bright = np.clip(n @ LIGHT / np.linalg.norm(n, axis=-1), 0.0, None)
    return triangles.colours * (AMBIENT + (1.0 - AMBIENT) * bright)[:, None]


def picture(triangles: Triangles, camera: Camera, window, width: int) -> np.ndarray:
    """The picture (height, width, 4), red green blue alpha in [0, 1], first row on top.

    Args:
        triangles: of the scene, in W.
        camera: from where it is seen.
        window: (left, right, bottom, top) of the picture in the camera's coordinates.
        width: of the picture, pixels.
    """
    left, right, bottom, top = window
    fine = width * OVERSAMPLING / (right - left)
    size = np.array([round(width * (top - bottom) / (right - left)), width]) * OVERSAMPLING
    facing = np.einsum("ti,ti->t", normals(triangles.corners), camera.eye - triangles.corners[:, 0]) > 0
    corners, colours = triangles.corners[facing], lit(triangles)[facing]
    which, points = _sprinkled(corners, camera, fine)
    place, depth = camera.project(points)
    column = np.floor((place[:, 0] - left) * fine).astype(int)
    row = np.floor((top - place[:, 1]) * fine).astype(int)
    keep = (column >= 0) & (column < size[1]) & (row >= 0) & (row < size[0]) & (depth > 0)
    pixel = (row * size[1] + column)[keep]
    order = np.argsort(-depth[keep], kind="stable")  # Far to near: NumPy keeps the last of several assignments.
    image, nearest = np.zeros((size[0] * size[1], 4)), np.full(size[0] * size[1], np.inf)
    image[pixel[order], :3] = colours[which[keep][order]]
    image[pixel[order], 3] = 1.0
    nearest[pixel[order]] = depth[keep][order]
    image, nearest = image.reshape(*size, 4), nearest.reshape(size)
    image[_outlines(nearest), :3] *= OUTLINE
    blocks = image.reshape(size[0] // OVERSAMPLING, OVERSAMPLING, width, OVERSAMPLING, 4)
    alpha = blocks[..., 3:].mean(axis=(1, 3))
    mixed = (blocks[..., :3] * blocks[..., 3:]).mean(axis=(1, 3)) / np.where(alpha > 0, alpha, 1.0)
    return np.concatenate([mixed, alpha], axis=-1)


def _sprinkled(corners, camera: Camera, fine: float):
    """Points on every triangle, no farther apart than SPACING pixels: the triangles' indices (M,) and points (M, 3)."""
    place = camera.project(corners)[0] * fine
    sides = np.linalg.norm(place[:, [1, 2, 0]] - place[:, [2, 0, 1]], axis=-1)  # Opposite each corner.
    # From the corner opposite the shortest side: rays to that side, and steps along the rays.
    turn = (np.argmin(sides, axis=1)[:, None] + np.arange(3)) % 3
    apex, b, c = np.moveaxis(np.take_along_axis(corners, turn[..., None], axis=1), 1, 0)
    steps = np.ceil(sides.max(axis=1) / SPACING).astype(int) + 1
    rays = np.ceil(sides.min(axis=1) / SPACING).astype(int) + 1
    count = steps * rays
    which = np.repeat(np.arange(len(corners)), count)
    local = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    step, ray = np.divmod(local, rays[which])
    s = (step / (steps[which] - 1))[:, None]
    t = (ray / (rays[which] - 1))[:, None]
    base, b, c = apex[which], b[which], c[which]
    return which, base + s * (b + t * (c - b) - base)


def _outlines(depth) -> np.ndarray:
    """Where (H, W) the depth jumps to something farther off: silhouettes and the edges of what lies behind."""
    known = np.where(np.isinf(depth), 1e3, depth)
    edge = np.zeros(depth.shape, dtype=bool)
    for axis in (0, 1):
        for way in (-1, 1):
            jump = np.roll(known, way, axis=axis) - known
            edge |= jump > STEP
    return edge & np.isfinite(depth)


def window_of(scenes, camera: Camera, margin: float = 0.02) -> tuple[float, float, float, float]:
    """(left, right, bottom, top) that holds all scenes, with a margin as a share of the width."""
    place = np.concatenate([camera.project(scene.corners.reshape(-1, 3))[0] for scene in scenes])
    (left, bottom), (right, top) = place.min(axis=0), place.max(axis=0)
    pad = margin * (right - left)
    return float(left - pad), float(right + pad), float(bottom - pad), float(top + pad)
