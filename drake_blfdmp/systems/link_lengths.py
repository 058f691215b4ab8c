"""The five links' lengths beside their bands, as a Drake system."""

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_blfdmp.skeleton import LINKS, POINTS
from drake_blfdmp.skill import geometry

ELEMENTS = tuple(f"{link.name}{end}" for end in ("", "_lower", "_upper") for link in LINKS)
"""Names of the output's elements."""


class LinkLengths(LeafSystem):
    """Lengths of the five links and the limits they are to stay between.

    .. pydrake_system::

        name: LinkLengths
        input_ports:
        - position
        - bands
        output_ports:
        - link_lengths

    No state. `position` (18) is in the order of `skeleton.POINTS`, m; `bands` (30) as from DistanceBands.
    `link_lengths` (15), m: the lengths in the order of `skeleton.LINKS`, then the lower and the upper limits.
    """

    def __init__(self):
        super().__init__()
        self._position = self.DeclareVectorInputPort("position", 3 * len(POINTS))
        self._bands = self.DeclareVectorInputPort("bands", 6 * len(LINKS))
        self.DeclareVectorOutputPort("link_lengths", len(ELEMENTS), self._calc)

    def _calc(self, context, output):
        lengths = geometry.link_lengths(np.asarray(self._position.Eval(context)).reshape(len(POINTS), 3))
        output.SetFromVector(np.concatenate([lengths, np.asarray(self._bands.Eval(context))[: 2 * len(LINKS)]]))
