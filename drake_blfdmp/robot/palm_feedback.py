"""What the robot feels, in the terms of its plan: the palms' distance in the hands' band, and how far the arms lag.

**Distance.** The plan commands a distance rho_c between the palms. Without a box in between, the palms are where they
are: their distance rho is what must stay in the band. A box keeps them apart at its own width, whatever is commanded;
what rho_c then decides is the force, by F = (w - rho_c) / c, with w the box's believed width and c the arms'
compliance. So what must stay in the band is the distance that the force betrays:

    rho_eff = (1 - beta) rho + beta w - c F,    beta: from 0 without contact to 1 at `contact_force`, smoothly.

Where arms, box and width are as believed, rho_eff = rho_c both in free space and in contact, and across. A box that is
wider than believed shows as a smaller rho_eff, for it is pressed harder; a push that takes force from a palm as a
larger one. The band of rho_eff is therefore, in contact, a band of the force: lo < w - c F < hi.

**Feedback.** The error e = rho_eff - rho_c lags what is commanded by the arms' own dynamics. Fed back as it is, it
would make the law, with poles at 8 and 20 1/s, swing with arms that answer at some 30 1/s. It is therefore filtered,

    e_f'' = a^2 (e - e_f) - 2 a e_f',

and the law is given rho_c + e_f with its rate, and e_f'' as acceleration that it need not demand. What it proves
(`skill.barrier`) then holds of rho_c + e_f exactly, and of the robot's rho_eff up to e - e_f: its band is kept while
|e - e_f| is less than what rho_c + e_f leaves of it. The loop that is closed so is F(s) (1 - G(s)), with the filter F
and the arms' answer G: less than 1 in size at every frequency, as F is small where G falls behind, so it is stable.

**Lag.** A box held between palms moves as their middle does. How far that is off the commanded one is the tracking
error that phase stopping goes by; the palms' distance, which a squeeze keeps off its command on purpose, is not in it.
"""

from typing import Any

import numpy as np

from drake_blfdmp.skill.profiles import smooth_step
from drake_blfdmp.skill.transformation import step_matrices, uncoupled_step


def effective_distance(distance, force, width, compliance, contact_force):
    """rho_eff (...), m, see above.

    Args:
        distance: (...) between the palms, m.
        force: (...) that a palm presses with, N, >= 0.
        width: believed, of the box, m.
        compliance: of both arms together along their normals, m/N.
        contact_force: N, > 0, at which the width takes the place of the distance.
    """
    touching = smooth_step(np.asarray(force) / contact_force)[0]
    return (1.0 - touching) * distance + touching * width - compliance * np.asarray(force)


def filter_matrices(rate: float, length: float):
    """The exact step, of `length` s, of the filter e_f'' = rate^2 (e - e_f) - 2 rate e_f', for `filtered`."""
    return step_matrices(length, 1.0, 2.0 * rate, 0.5 * rate)


def filtered(offset, offset_rate, error, matrices):
    """e_f (...) and e_f' one step later, the error (...) held meanwhile."""
    return uncoupled_step(offset, offset_rate, 0.0, error, matrices)


def palm_positions(body_poses: Any, palms: tuple[int, int]) -> np.ndarray:
    """Where the palms are (2, 3), m in W, by the value of the plant's body_poses port and their bodies' indices."""
    return np.array([body_poses[index].translation() for index in palms])


def middle_error(palms, commanded):
    """How far the palms' middle is off the commanded one (...), m; both (..., 2, 3) in W."""
    return np.linalg.norm(np.mean(np.asarray(palms) - np.asarray(commanded), axis=-2), axis=-1)


def kept_share(error, slack: float, scale: float):
    """Which share of its full tempo a phase keeps: 1 up to `slack`, 1/2 at `slack + scale` (...), m.

    The phase stopping 1/(1 + a e^2) of Ijspeert, Nakanishi, Hoffmann, Pastor, Schaal, "Dynamical movement primitives",
    Neural Computation 25, 2013, with a dead zone, so that what gravity and motion ask of any PD costs no time.
    """
    return 1.0 / (1.0 + (np.maximum(np.asarray(error) - slack, 0.0) / scale) ** 2)
