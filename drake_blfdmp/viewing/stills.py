"""Pictures of the person and of anything else at given instants, side by side on a page; `rendering` makes them."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from drake_blfdmp.skeleton import LINKS
from drake_blfdmp.viewing import style
from drake_blfdmp.viewing.rendering import Triangles, capsule_corners, coloured, joined

INSIDE, OUTSIDE, BODY = style.GREEN, style.VERMILLION, "#5A6470"
LEGEND = {"link inside its band": INSIDE, "link outside (drawn thicker)": OUTSIDE}
"""Text -> colour, of `skeleton`."""


def rod(start, end, radius: float, colour) -> Triangles:
    """A capsule from one point (3,) to another, m."""
    along = np.asarray(end) - start
    length = float(np.linalg.norm(along))
    z = along / length if length > 0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(z, [0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z], axis=-1)
    return coloured(capsule_corners(radius, length) @ rotation.T + 0.5 * (start + np.asarray(end)), colour)


def skeleton(points, inside, radius: float = 0.025) -> Triangles:
    """The person: bones, the line of the hands, joints, shoulders and head.

    Args:
        points: (6, 3) in the order of `skeleton.POINTS`, m.
        inside: (5,) whether each link is inside its band; one outside is vermillion, and thicker.
        radius: of the bones, m.
    """
    points = np.asarray(points, dtype=float)
    parts = []
    for link, within in zip(LINKS, inside, strict=True):
        size, colour = (radius, INSIDE) if within else (1.5 * radius, OUTSIDE)
        # The hands' link is no bone.
        size *= 0.5 if link.name == "hands" else 1.0
        parts.append(rod(points[link.a], points[link.b], size, colour))
    parts += [rod(point, point, 1.6 * radius, BODY) for point in points]
    middle = 0.5 * (points[0] + points[3])
    head = middle + np.array([0.0, 0.0, 0.24])
    parts += [rod(points[0], points[3], radius, BODY), rod(middle, head, radius, BODY), rod(head, head, 0.1, BODY)]
    return joined(*parts)


@style.styled
def strip(rows: Mapping[str, Sequence[np.ndarray]], titles: Sequence[str], legend: Mapping[str, str]) -> Figure:
    """Rows of pictures, a page wide.

    Args:
        rows: name to pictures, those of one row of one size.
        titles: of the columns.
        legend: text to colour.
    """
    above, below, beside = 0.22, 0.22, 0.18  # Inches for titles, legend and names.
    width = (style.PAGE - beside) / len(titles)
    heights = [width * row[0].shape[0] / row[0].shape[1] for row in rows.values()]
    height = above + below + sum(heights)
    figure = Figure(figsize=(style.PAGE, height), layout="none")
    place = {"left": beside / style.PAGE, "right": 1.0, "bottom": below / height, "top": 1.0 - above / height}
    grid = figure.add_gridspec(len(rows), len(titles), height_ratios=heights, wspace=0.0, hspace=0.0, **place)
    for i, (name, row) in enumerate(rows.items()):
        for j, image in enumerate(row):
            axis = figure.add_subplot(grid[i, j])
            axis.imshow(image, interpolation="antialiased", aspect="auto")
            axis.set_axis_off()
            if i == 0:
                axis.set_title(titles[j], pad=3)
            if j == 0:
                x = -0.5 * beside / width
                axis.text(x, 0.5, name, transform=axis.transAxes, rotation=90, ha="center", va="center", fontsize=8)
    handles = [Patch(facecolor=colour, label=text) for text, colour in legend.items()]
    figure.legend(handles=handles, loc="lower center", ncols=len(handles), borderaxespad=0.2)
    return figure
