"""The coupling laws a scenario can choose; one file each, pure functions of one signature.

    law(x, velocity, nominal_acceleration, previous_acceleration, bands, primitive, gains) -> coupling acceleration

Args:
    x, velocity: (..., 6, 3) m, m/s.
    nominal_acceleration: (..., 6, 3) x'' without coupling, of a sampled system its mean over the coming step, m/s^2.
    previous_acceleration: (..., 6, 3) x'' that was taken at the previous sample, m/s^2; zero at the first.
    bands: (..., 6, 5) as in `skill.bands`.
    primitive: tau and alpha_z.
    gains: the law's own, its defaults if left out.

Returns:
    (..., 6, 3), m/s^2, to be added to the nominal acceleration.

- `default`: a barrier on every link, all met at once.
- `published`, `published_loop`, `published_lagged`: the paper's (9)-(17) in three readings of (12); `follower` is the
  law on one axis, `rounds` its order on the skeleton.
- `gams`: the coupling of the paper's [17].
- `none`: none.
"""

from collections.abc import Callable

from drake_blfdmp.errors import ScenarioError
from drake_blfdmp.skill.laws.default import default
from drake_blfdmp.skill.laws.gams import gams
from drake_blfdmp.skill.laws.none import none
from drake_blfdmp.skill.laws.published import published
from drake_blfdmp.skill.laws.published_lagged import published_lagged
from drake_blfdmp.skill.laws.published_loop import published_loop

LAWS: dict[str, Callable] = {
    law.__name__: law for law in (default, published, published_loop, published_lagged, gams, none)
}


def law(name: str) -> Callable:
    """The law of that name.

    Raises:
        ScenarioError: there is none.
    """
    if name not in LAWS:
        raise ScenarioError(f"law: unknown law '{name}'; there are {', '.join(LAWS)}")
    return LAWS[name]
