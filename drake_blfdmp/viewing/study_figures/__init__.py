"""Drawings of the studies, one concept a file: arrays in, a figure out.

- `looks`: recorded, original (uncoupled) and modified (coupled) motion.
- `noise`: measuring errors, and spreads of lengths (Fig. 2).
- `trajectories`: paths and skeletons (Fig. 6).
- `errors`: errors per axis over time (Fig. 7).
- `lengths`: lengths of the arms' bones in their bands (Figs. 8 and 9).
- `laws`: hands' distance (Fig. 10) and all five links with every law, Remark 2. `one_axis`: the published law alone.
- `frankas`: stills and swivel angles of the two arms (Fig. 11).
- `squeeze`: deformation and least squeeze.
- `random_problems`: shares, margins and times of violations. `sampling`: shares over gains and rate.
- `generalisation`: other starts, goals, durations and boxes.
"""

from drake_blfdmp.viewing.study_figures.errors import axis_errors
from drake_blfdmp.viewing.study_figures.lengths import arm_lengths

__all__ = ["arm_lengths", "axis_errors"]
