"""How the recorded, the original (uncoupled) and the modified (coupled) motion look in every figure of the studies."""

from drake_blfdmp.viewing import style

RECORDED = style.DEMONSTRATED | {"label": "recorded"}
ORIGINAL = style.UNCOUPLED | {"label": "original"}
MODIFIED = style.COUPLED | {"label": "modified"}
BROKEN = {
    "color": style.VERMILLION,
    "linewidth": 2.6,
    "solid_capstyle": "butt",
    "label": "original, bone outside its band",
}
