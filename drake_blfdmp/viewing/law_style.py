"""One fixed look for every law, so that a curve means the same in all figures; colour and line style both differ.

Keys are those of `skill.laws.LAWS`; values are keyword arguments of matplotlib's `plot`.
"""

from typing import Any

from drake_blfdmp.viewing import style

ORANGE, SKY, PINK = "#E69F00", "#56B4E9", "#CC79A7"
"""The colours of Okabe and Ito that `style` does not use."""

LAW_LOOKS: dict[str, dict[str, Any]] = {
    "default": style.COUPLED | {"label": "default", "zorder": 4},
    "published": {"color": ORANGE, "linewidth": 1.4, "linestyle": (0, (6, 1.5, 1, 1.5)), "label": "published"},
    "published_loop": {"color": PINK, "linewidth": 1.4, "linestyle": (0, (7, 1.5)), "label": "published, loop"},
    "published_lagged": {"color": style.DARK, "linewidth": 0.9, "linestyle": "-", "label": "published, lagged"},
    "gams": {"color": SKY, "linewidth": 1.5, "linestyle": (0, (3, 1.2, 1, 1.2, 1, 1.2)), "label": "Gams et al."},
    "none": style.UNCOUPLED,
}

GAMS_LEARNED: dict[str, Any] = {
    "color": style.GREEN,
    "linewidth": 1.2,
    "linestyle": (0, (1, 1)),
    "label": "Gams et al., learned",
}
"""The coupling of Gams et al. with the reference that their iterative learning finds."""
