"""The tree of frames that /tf and /tf_static span, at the frame times of a playback."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.poses import matrices


@dataclass
class FrameTree:
    """Frames, each a child of one other; a frame that is nobody's child is a root, and all roots are in one place.

    Attributes:
        edges: child -> (parent, poses (F, 7) or (1, 7) of the child in the parent).
        where: the file, for messages.
    """

    edges: Mapping[str, tuple[str, np.ndarray]] = field(default_factory=dict)
    where: str = ""
    _poses: dict[str, np.ndarray] = field(default_factory=dict)

    def __contains__(self, frame: str) -> bool:
        return frame in self.edges

    @property
    def roots(self) -> set[str]:
        """Frames that are parents only."""
        return {parent for parent, _ in self.edges.values()} - set(self.edges)

    def pose(self, frame: str) -> np.ndarray:
        """X_WF (F, 4, 4), or (1, 4, 4) where nothing moves, of a frame of the tree, or of a root.

        Raises:
            BlfDmpError: the frames form a ring.
        """
        chain = [frame]
        while chain[-1] in self.edges and chain[-1] not in self._poses:
            parent = self.edges[chain[-1]][0]
            if parent in chain:
                ring = " -> ".join([*chain[chain.index(parent) :], parent])
                raise BlfDmpError(f"{self.where}: the frames of /tf form a ring ({ring}); one of them has two parents")
            chain.append(parent)
        X = self._poses.get(chain[-1], np.eye(4)[None])
        for child in reversed(chain):
            if child in self._poses or child not in self.edges:
                continue
            X = X @ matrices(self.edges[child][1])
            self._poses[child] = X
        return X
