"""`Skill`: everything a transformation system needs to move, learned once, changed and saved at will."""

import json
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from drake_blfdmp.errors import SkillError
from drake_blfdmp.skeleton import POINTS
from drake_blfdmp.skill.basis import forcing
from drake_blfdmp.skill.canonical import DEFAULT_GAMMA
from drake_blfdmp.skill.orientation import OrientationSkill

VERSION = 1


@dataclass(frozen=True)
class Skill:
    """Movement primitives (1)-(2) of the six points, with one phase.

    Attributes:
        weights: (n, 6, 3) theta of every point and axis.
        centers, widths: (n,) c_k and h_k of the basis.
        start, goal: (6, 3) m, in the demonstration's frame.
        tau: time scale, s; the phase reaches exp(-gamma) at t = tau.
        gamma: decay of the phase.
        alpha_z, beta_z: gains of (1).
        events: named times, s, on the skill's clock (for example grasp and release); they scale with the duration.
        source: what it was learned from.
        spread: (M, 6, 3) standard deviation over several recordings of the task, m, at M times spaced evenly from 0 to
            tau, so that it scales with the duration; None when learned from one recording.
        mobility: (6,) how readily each point gives way to the default law; only the ratios count. None leaves it to the
            law.
        orientation: how what the hands hold turns about the line between them and beside it, in that line's frame
            (`demonstration.hand_orientation`), on the same phase; None where the recording has no orientations.
    """

    weights: np.ndarray
    centers: np.ndarray
    widths: np.ndarray
    start: np.ndarray
    goal: np.ndarray
    tau: float
    alpha_z: float
    beta_z: float
    gamma: float = DEFAULT_GAMMA
    events: dict[str, float] = field(default_factory=dict)
    source: str = ""
    spread: np.ndarray | None = None
    mobility: np.ndarray | None = None
    orientation: OrientationSkill | None = None

    def __post_init__(self):
        n = len(self.centers)
        shapes = {"weights": (n, 6, 3), "widths": (n,), "start": (6, 3), "goal": (6, 3)}
        for name, shape in shapes.items():
            value = np.asarray(getattr(self, name))
            if value.shape != shape:
                raise SkillError(f"skill: {name} has shape {value.shape}, expected {shape}")
            if not np.all(np.isfinite(value)):
                raise SkillError(f"skill: {name} holds a number that is not finite")
        for name in ("tau", "gamma", "alpha_z", "beta_z"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise SkillError(f"skill: {name} must be a positive number, not {getattr(self, name)}")
        if self.spread is not None:
            spread = np.asarray(self.spread)
            if spread.ndim != 3 or len(spread) < 2 or spread.shape[1:] != (6, 3):
                raise SkillError(f"skill: spread has shape {spread.shape}, expected (2 or more, 6, 3)")
            if not np.all(np.isfinite(spread) & (spread >= 0)):
                raise SkillError("skill: spread holds a number that is negative or not finite")
        if self.mobility is not None:
            mobility = np.asarray(self.mobility)
            if mobility.shape != (6,) or not np.all(np.isfinite(mobility) & (mobility > 0)):
                raise SkillError("skill: mobility must be 6 positive numbers, one for each point")
        if self.orientation is not None and len(self.orientation.weights) != n:
            raise SkillError(f"skill: orientation has {len(self.orientation.weights)} basis functions, expected {n}")

    def forcing(self, s, weights=None):
        """f(s) of all points: (..., 18) for a phase of shape (...), with other weights (n, 18) where they are given."""
        weights = self.weights.reshape(len(self.centers), 18) if weights is None else weights
        return forcing(s, weights, self.centers, self.widths)

    def spread_at(self, t) -> np.ndarray | None:
        """The spread (..., 6, 3), m, at times t (...), s, on the skill's clock, held after its end; or None."""
        if self.spread is None:
            return None
        place = np.clip(np.asarray(t) / self.tau, 0.0, 1.0) * (len(self.spread) - 1)
        before = np.minimum(place.astype(int), len(self.spread) - 2)
        share = (place - before)[..., None, None]
        return (1.0 - share) * self.spread[before] + share * self.spread[before + 1]

    def with_duration(self, tau: float) -> "Skill":
        """The same path in another time; events move along."""
        ratio = tau / self.tau
        return replace(self, tau=tau, events={k: t * ratio for k, t in self.events.items()})

    def with_start(self, start) -> "Skill":
        """The same skill from another start (6, 3), m."""
        return replace(self, start=np.array(start, dtype=float))

    def with_goal(self, goal) -> "Skill":
        """The same skill to another goal (6, 3), m."""
        return replace(self, goal=np.array(goal, dtype=float))

    def with_goal_orientation(self, goal) -> "Skill":
        """The same skill to another orientation (4,), a quaternion w x y z.

        Raises:
            SkillError: this skill has no orientation.
        """
        if self.orientation is None:
            raise SkillError("skill: it has no orientation whose goal could change; learn it from one that has")
        return replace(self, orientation=self.orientation.with_goal(goal))

    def save(self, path: Path) -> None:
        """Write the skill as JSON; numbers survive a round trip to the last bit.

        Raises:
            SkillError: the file exists already (it is not touched) or cannot be written.
        """
        document = {
            "format": "drake_blfdmp skill",
            "version": VERSION,
            "source": self.source,
            "points": list(POINTS),
            "tau_s": self.tau,
            "gamma": self.gamma,
            "alpha_z": self.alpha_z,
            "beta_z": self.beta_z,
            "events_s": self.events,
            "start_m": self.start.tolist(),
            "goal_m": self.goal.tolist(),
            "centers": self.centers.tolist(),
            "widths": self.widths.tolist(),
            "weights": self.weights.tolist(),
        }
        # Only where there is one: a skill of one recording is the same file as ever.
        for name, value in (("spread_m", self.spread), ("mobility", self.mobility)):
            if value is not None:
                document[name] = np.asarray(value).tolist()
        if self.orientation is not None:
            own = self.orientation
            document["orientation"] = {name: np.asarray(value).tolist() for name, value in vars(own).items()}
        try:
            with Path(path).open("x", encoding="utf-8") as file:
                json.dump(document, file, indent=1)
                file.write("\n")
        except FileExistsError as error:
            raise SkillError(f"{path}: exists already; choose another name or remove it") from error
        except OSError as error:
            raise SkillError(f"{path}: cannot be written ({error.strerror})") from error

    @staticmethod
    def load(path: Path) -> "Skill":
        """Read what `save` wrote.

        Raises:
            SkillError: not a skill, another version, other points, or a field missing or out of range.
        """
        try:
            document = json.loads(Path(path).read_text(encoding="utf-8"))
        except (OSError, UnicodeDecodeError, json.JSONDecodeError) as error:
            raise SkillError(f"{path}: cannot be read as a skill ({error})") from error
        if not isinstance(document, dict) or document.get("format") != "drake_blfdmp skill":
            raise SkillError(f"{path}: is not a skill file")
        if document.get("version") != VERSION:
            raise SkillError(f"{path}: has version {document.get('version')}, this program reads {VERSION}")
        if document.get("points") != list(POINTS):
            raise SkillError(f"{path}: its points are {document.get('points')}, expected {', '.join(POINTS)}")
        try:
            return Skill(
                weights=np.array(document["weights"], dtype=float),
                centers=np.array(document["centers"], dtype=float),
                widths=np.array(document["widths"], dtype=float),
                start=np.array(document["start_m"], dtype=float),
                goal=np.array(document["goal_m"], dtype=float),
                tau=float(document["tau_s"]),
                alpha_z=float(document["alpha_z"]),
                beta_z=float(document["beta_z"]),
                gamma=float(document["gamma"]),
                events={str(name): float(t) for name, t in document["events_s"].items()},
                source=str(document["source"]),
                spread=_optional(document, "spread_m"),
                mobility=_optional(document, "mobility"),
                orientation=_orientation(document),
            )
        except SkillError as error:
            raise SkillError(f"{path}: {error}") from error
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise SkillError(f"{path}: the skill is incomplete or damaged ({error})") from error


def _optional(document: dict, name: str) -> np.ndarray | None:
    return np.array(document[name], dtype=float) if document.get(name) is not None else None


def _orientation(document: dict) -> OrientationSkill | None:
    own = document.get("orientation")
    if own is None:
        return None
    return OrientationSkill(**{name: np.array(own[name], dtype=float) for name in ("weights", "start", "goal")})
