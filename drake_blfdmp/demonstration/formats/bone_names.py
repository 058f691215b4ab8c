"""Which bones of an animation skeleton begin in the six points: the spellings of BVH exporters.

A bone is named for what it moves: `LeftArm` (Mixamo, MotionBuilder, CMU), `lShldr` (Poser), `upperarm_l` (Unreal) turns
about the shoulder, `LeftForeArm` about the elbow, `LeftHand` about the wrist; `LeftShoulder` is the collar bone where
there is such an arm, and the shoulder where there is not.
"""

import re
from collections.abc import Iterable

# The order is a rank: of two matching names the earlier one wins.
_SIDES = {"left": ("left", "l", "lft"), "right": ("right", "r", "rgt")}
_PARTS = {
    "shoulder": ("upperarm", "uparm", "uarm", "arm", "humerus", "shldr", "shoulder"),
    "elbow": ("elbow", "forearm", "lowerarm", "lowarm", "loarm", "farm", "radius"),
    "wrist": ("wrist", "hand"),
}
_ALIASES = {
    spelling: (f"{side}_{part}", rank)
    for part, part_names in _PARTS.items()
    for rank, part_name in enumerate(part_names)
    for side, side_names in _SIDES.items()
    for side_name in side_names
    for spelling in (side_name + part_name, part_name + side_name)
}


def guess_bones(names: Iterable[str]) -> dict[str, str]:
    """Point of `skeleton.POINTS` -> the bone that begins there, for the points that have one.

    Prefixes before a separator ("mixamorig:", "Bip01 ", "Character1_", "DEF-") do not matter.
    """
    best: dict[str, tuple[tuple[int, int], str]] = {}
    for name in names:
        words = [word for word in re.split(r"[^a-z0-9]+", name.lower()) if word][:12]
        for dropped in range(len(words)):
            point, rank = _ALIASES.get("".join(words[dropped:]), (None, 0))
            if point is not None:
                if point not in best or (rank, dropped) < best[point][0]:
                    best[point] = ((rank, dropped), name)
                break
    return {point: name for point, (_, name) in best.items()}
