"""What a table looks like: a slab with an edging, on a leg with a foot."""

from pydrake.geometry import Box, Cylinder

from drake_blfdmp.robot.look import VisualPart

TOP_COLOR = (0.50, 0.56, 0.62, 1.0)
EDGING_COLOR = (0.24, 0.27, 0.31, 1.0)
LEG_COLOR = (0.30, 0.31, 0.33, 1.0)


def TableLeg(size: tuple[float, float], thickness: float, height: float) -> VisualPart | None:
    """The leg of a table, which is touched as it is seen; None where the slab stands on the floor. As `TableLook`."""
    if height <= thickness:
        return None
    leg = Cylinder(0.15 * min(size), height - thickness)
    return VisualPart("leg_visual", leg, (0.0, 0.0, -0.5 * (height + thickness)), LEG_COLOR)


def TableLook(size: tuple[float, float], thickness: float, height: float) -> list[VisualPart]:
    """What a table looks like, in its frame at the centre of the upper face.

    Args:
        size: of the slab along x and y, m.
        thickness: of the slab, m.
        height: of the upper face over the floor, m.
    """
    # An edging round the slab, 1 mm proud of its sides and short of its top, tells the top's outline from behind it.
    edging = Box(size[0] + 0.002, size[1] + 0.002, 0.7 * thickness)
    parts = [
        VisualPart("slab_visual", Box(*size, thickness), (0.0, 0.0, -thickness / 2), TOP_COLOR),
        VisualPart("edging_visual", edging, (0.0, 0.0, -0.65 * thickness), EDGING_COLOR),
    ]
    leg = TableLeg(size, thickness, height)
    if leg is not None:
        foot_height = min(0.02, height - thickness)
        foot = Cylinder(0.45 * min(size), foot_height)
        parts += [leg, VisualPart("foot_visual", foot, (0.0, 0.0, foot_height / 2 - height), LEG_COLOR)]
    return parts
