"""An MCAP file of ROS 2 messages, of a run or of another system, as what playback draws, at its frame times.

Two walks over the file: the first finds topics and times and looks into no message, the second samples. Memory depends
on the number of frames alone.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from mcap.records import Channel

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.ros2.cdr import CdrReader
from drake_blfdmp.ros2.messages import JOINT_STATE, TF, WRENCH
from drake_blfdmp.skeleton import POINTS
from drake_blfdmp.viewing.playback.chunks import Contents, DamageError, Progress, look_through, messages
from drake_blfdmp.viewing.playback.frames import FrameTree
from drake_blfdmp.viewing.playback.sampling import LONGEST_GAP_NS, TopicSampler
from drake_blfdmp.viewing.playback.topics import frame_times, last_part, moving_span, wanted_topics
from drake_blfdmp.viewing.playback.urdf import Robot, parse_urdf

_MOST_EVENTS = 200
_SLOW_HZ = 2.0


def _silent(what: str, share: float) -> None:
    pass


@dataclass(frozen=True)
class Wrench:
    """A force at the origin of a frame.

    Attributes:
        force: (F, 3) N, in that frame.
    """

    topic: str
    frame: str
    force: np.ndarray


@dataclass(frozen=True)
class Model:
    """A robot, its frames and its joints' positions (F,), rad or m."""

    robot: Robot
    frames: FrameTree
    positions: Mapping[str, np.ndarray]


@dataclass(frozen=True)
class Played:
    """A file at F frame times.

    Attributes:
        path: the file.
        label: what tells it from other files: its law, or its name.
        times: (F,) s since the file's first message.
        models: what is drawn.
        frames: all frames, for what is no robot.
        vectors: points, margin, link_lengths, bands -> element -> values (F,); absent ones are empty.
        events: (s since the first message, text).
        warnings: what was left out, a line each.
    """

    path: Path
    label: str
    times: np.ndarray
    models: tuple[Model, ...] = ()
    frames: FrameTree = field(default_factory=FrameTree)
    vectors: Mapping[str, Mapping[str, np.ndarray]] = field(default_factory=dict)
    wrenches: tuple[Wrench, ...] = ()
    events: tuple[tuple[float, str], ...] = ()
    warnings: tuple[str, ...] = ()


def read_played(
    path: str | Path,
    *,
    start: float | None = None,
    end: float | None = None,
    partial: bool = False,
    progress: Progress = _silent,
) -> Played:
    """Reads a file for playback.

    Args:
        path: an MCAP file.
        start, end: the part that is played, s since the file's first message that is drawn; all of it by default.
        partial: play what stands before the damage of a damaged file.
        progress: called with what is being done and the share of it done.

    Raises:
        BlfDmpError: the file is missing, damaged, no MCAP or no ROS 2; nothing in it can be drawn or nothing moves;
            its time stands still or goes back; the part asked for is empty.
    """
    path = Path(path)
    contents = look_through(path, progress)
    warnings: list[str] = []
    if contents.damage:
        if not partial:
            raise BlfDmpError(_damaged(path, contents.damage))
        warnings.append(f"{path}: {contents.damage}; what stands before is played")
    topics = wanted_topics(contents)
    first_ns, last_ns = moving_span(contents, topics)
    times = frame_times(path, (last_ns - first_ns) * 1e-9, start, end)
    times_ns = first_ns + np.round(times * 1e9).astype(np.int64)
    samplers = {
        number: TopicSampler(f"{path}: {channel.topic}", contents.type_of(channel), times_ns)
        for number, channel in topics.items()
        if contents.type_of(channel) in (JOINT_STATE, TF, WRENCH) and last_part(channel) != "tf_static"
    }
    descriptions: dict[str, str] = {}
    static: dict[str, dict[str, tuple[str, np.ndarray]]] = {}
    events: list[tuple[float, str]] = []
    sparse = [
        number
        for number in topics
        if number not in samplers or contents.times[number].count < _SLOW_HZ * (last_ns - first_ns) * 1e-9
    ]
    near = np.stack([times_ns - 2 * LONGEST_GAP_NS, times_ns + 2 * LONGEST_GAP_NS], axis=-1)
    try:
        for number, t_ns, message in messages(contents, topics, int(times_ns[-1]), near, sparse, progress):
            if number in samplers:
                samplers[number].add(t_ns, message)
                continue
            channel = topics[number]
            where = f"{path}: {channel.topic}"
            namespace = channel.topic.rpartition("/")[0]
            if last_part(channel) == "tf_static":
                _take_static(where, message, t_ns, static.setdefault(namespace, {}))
            else:
                _take_text(where, channel, message, (t_ns - first_ns) * 1e-9, namespace, descriptions, events)
    except DamageError as error:
        if not partial:
            raise BlfDmpError(_damaged(path, str(error))) from None
        warnings.append(f"{path}: {error}; what stands before is played")
    sampled = {number: sampler.finish() for number, sampler in samplers.items()}
    warnings += [f"{s.where}: {s.late} messages came late and are left out" for s in samplers.values() if s.late]
    played = _gathered(path, contents, topics, times, sampled, descriptions, static, warnings)
    inside = [(max(t, times[0]), text) for t, text in sorted(events) if t <= times[-1] + 1e-9]
    before = [k for k, (t, _) in enumerate(inside) if t <= times[0]]
    # Of what happened before the part that is played, only the last still holds.
    inside = inside[before[-1] :] if before else inside
    if len(inside) > _MOST_EVENTS:
        warnings.append(f"{path}: {len(inside)} events, of which the first {_MOST_EVENTS} are shown")
    return Played(**{**vars(played), "events": tuple(inside[:_MOST_EVENTS]), "warnings": tuple(warnings)})


def _damaged(path: Path, damage: str) -> str:
    return (
        f"{path}: truncated or damaged: {damage}; `python run.py recover {path}` writes what is there to a new file, "
        "or play it as it is with --partial"
    )


def _take_static(where: str, message: bytes, t_ns: int, edges: dict[str, tuple[str, np.ndarray]]) -> None:
    sampler = TopicSampler(where, TF, np.array([t_ns]))
    sampler.add(t_ns, message)
    for (parent, child), values in sampler.finish().items():
        edges[child] = (parent, values[:1])


def _take_text(
    where: str,
    channel: Channel,
    message: bytes,
    t: float,
    namespace: str,
    descriptions: dict[str, str],
    events: list[tuple[float, str]],
) -> None:
    """Takes a description or an event."""
    try:
        reader = CdrReader(message)
        if last_part(channel) == "robot_description":
            descriptions[namespace] = reader.string()
        else:
            reader.stamp()
            reader.uint8()
            reader.string()
            events.append((t, reader.string()))
    except (ValueError, IndexError) as error:
        raise BlfDmpError(f"{where}: a message cannot be decoded ({error}); playback reads little-endian CDR") from None


def _gathered(
    path: Path,
    contents: Contents,
    topics: Mapping[int, Channel],
    times: np.ndarray,
    sampled: Mapping[int, Mapping[tuple[str, ...], np.ndarray]],
    descriptions: Mapping[str, str],
    static: Mapping[str, Mapping[str, tuple[str, np.ndarray]]],
    warnings: list[str],
) -> Played:
    """Puts together what belongs together: a robot with the frames and joint states of its namespace."""
    edges: dict[str, dict[str, tuple[str, np.ndarray]]] = {name: dict(found) for name, found in static.items()}
    positions: dict[str, dict[str, np.ndarray]] = {}
    vectors: dict[str, dict[str, np.ndarray]] = {}
    wrenches: list[Wrench] = []
    for number, channel in topics.items():  # A topic may have several channels, one a publisher.
        series, kind = sampled.get(number, {}), contents.type_of(channel)
        namespace, _, last = channel.topic.rpartition("/")
        if kind == WRENCH:
            wrenches += [Wrench(channel.topic, name[0], values[:, :3]) for name, values in series.items()]
        elif kind == TF:
            for (parent, child), values in series.items():
                edges.setdefault(namespace, {})[child] = (parent, values)
        elif last == "joint_states":
            positions.setdefault(namespace, {}).update({name[0]: values[:, 0] for name, values in series.items()})
        elif kind == JOINT_STATE:
            vectors.setdefault(last, {}).update({name[0]: values[:, 0] for name, values in series.items()})
    everything = {child: edge for found in edges.values() for child, edge in found.items()}
    joints = {name: values for found in positions.values() for name, values in found.items()}
    models = []
    for namespace, text in sorted(descriptions.items()):
        robot = parse_urdf(text, f"{path}: {namespace}/robot_description")
        warnings += robot.warnings
        # A second robot in a namespace of its own may use the first one's names.
        own = edges.get(namespace, everything) if len(descriptions) > 1 else everything
        mine = positions.get(namespace, joints) if len(descriptions) > 1 else joints
        model = Model(robot, FrameTree(own, str(path)), mine)
        lost = [j.name for j in robot.joints.values() if j.movable and not _known(j.name, j.child, model)]
        unseen = {j.name for j in robot.joints.values() if not _moves_something(j.child, model)}
        if lost and len(lost) < sum(joint.movable for joint in robot.joints.values()):
            seen = [name for name in lost if name not in unseen]
            also = " and others" if len(seen) > 1 else ""
            warnings += [f"{path}: joint {name}{also}: no position; drawn at 0" for name in seen[:1]]
        elif lost and len(descriptions) == 1 and "points" not in vectors and not set(robot.links) & set(own):
            raise BlfDmpError(
                f"{path}: no transforms: neither /tf nor /joint_states knows any link or joint of the robot "
                f"'{robot.name}', as joint {lost[0]}; record what belongs to this /robot_description"
            )
        models.append(model)
    if not any(visuals for model in models for visuals in model.robot.links.values()) and not _has_points(vectors):
        raise BlfDmpError(f"{path}: nothing to draw: its /robot_description has no visual shapes")
    law = contents.metadata.get("run", {}).get("law", "")
    return Played(path, law, times, tuple(models), FrameTree(everything, str(path)), vectors, tuple(wrenches))


def _known(joint: str, child: str, model: Model) -> bool:
    mimic = model.robot.joints[child].mimic
    return joint in model.positions or child in model.frames or (mimic is not None and mimic[0] in model.positions)


def _moves_something(link: str, model: Model) -> bool:
    """Whether the joint above `link` decides where anything is that is drawn."""
    rest, passed = [link], set()
    while rest:
        link = rest.pop()
        if link in model.frames or link in passed:
            continue
        passed.add(link)
        if model.robot.links.get(link):
            return True
        rest += [joint.child for joint in model.robot.joints.values() if joint.parent == link]
    return False


def _has_points(vectors: Mapping[str, Mapping[str, np.ndarray]]) -> bool:
    return all(f"{point}_{axis}" in vectors.get("points", {}) for point in POINTS for axis in "xyz")
