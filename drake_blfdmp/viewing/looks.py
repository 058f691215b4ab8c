"""How the person, the bands and the view look in every scene: sizes, words of the legend, camera; no Drake in it."""

from collections.abc import Mapping

from drake_blfdmp.link_state import COLOURS, INSIDE, NEAR, OUTSIDE

CAMERA_IN_WORLD = (1.40, 3.35, 1.75)  # In front of the arms, which reach along +y from x = -0.2 and 0.2 m; p_WC, m.
TARGET_IN_WORLD = (0.45, 0.10, 0.82)
FIELD_OF_VIEW = (34.5, 41.0)
"""Degrees, upright and across, that a window of any shape shows at least; Meshcat's own 75 distort."""

LEGEND: Mapping[str, str] = {
    "link inside its band": COLOURS[INSIDE],
    "link near its band's edge": COLOURS[NEAR],
    "link outside its band": COLOURS[OUTSIDE],
}
"""Text -> CSS colour."""

BODY = "#7F97B8"
PERSON_LEGEND: Mapping[str, str] = {"the person, life-size, as the skill moves": BODY}

BAND_COLOUR = "#0072B2"
BAND_OPACITY = 0.45
BAND_RADIUS = 0.06
"""Of the sleeves, m: wider than a wrist, so that the wrist does not hide them."""
BAND_LEGEND: Mapping[str, str] = {"where the hands' band lets each hand be": BAND_COLOUR}

ROD_RADIUS = 0.018
"""Of the skeleton's links, m."""
BODY_OPACITY = 0.35

SHORTEST_LEGS, LONGEST_LEGS = 0.5, 1.4
"""Of a person's, as modelled: where the floor is not that of a person who stands, legs would be stilts or stumps."""
