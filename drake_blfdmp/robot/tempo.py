"""The tempo that the arms can keep: how far the phase must slow down so that the palms stay on their way.

The joint limits let the share s of the commanded twist through. A phase that runs on regardless leaves the palms
behind; slowed down to the tempo c it asks for c times the twist, and the share of that is 1 again. The tempo is the
state of

    tempo' = (1 - tempo) / rise - tempo (1 - share) / fall

With share = min(1, c / tempo), c being what the limits allow, this is a stable equation of first order: no overshoot,
no chatter, at rest at tempo = (c rise + fall) / (rise + fall), c but for some fall / rise of the difference to 1. The
share itself would do neither: fed back it settles at sqrt(c), and the palms fall behind.
"""

import numpy as np


def next_tempo(tempo, share, time_step: float, fall: float, rise: float, floor: float):
    """The tempo (...) one step later.

    Args:
        tempo: (...) now, in [floor, 1].
        share: (...) smallest share of the commanded twists that is met, in [0, 1].
        time_step: s.
        fall: time constant while nothing is met, s.
        rise: time constant of the way back to 1, s.
        floor: never slower than this; > 0, else a goal that no joint can reach would stop the phase for good.
    """
    up, down = -np.expm1(-time_step / rise), -np.expm1(-time_step / fall)
    return np.clip(tempo + up * (1.0 - tempo) - down * tempo * (1.0 - share), floor, 1.0)


def tempo_towards(tempo, wanted, time_step: float, fall: float, rise: float):
    """The tempo (...) one step later on its way to a wanted one (...): of first order, quick down and slow up.

    Args:
        time_step: s.
        fall: time constant while the wanted tempo is lower, s.
        rise: time constant while it is higher, s.
    """
    constant = np.where(np.asarray(wanted) < tempo, fall, rise)
    return tempo - np.expm1(-time_step / constant) * (wanted - tempo)
