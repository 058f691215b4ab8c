"""People in tf2_msgs TFMessage: frames named like joints, each brought into the frame at the root of its tree.

A tree may be sent whole in one message or frame by frame in many (as OpenNI trackers do): samples of the six frames
that belong to one instant become one row.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from drake_blfdmp.demonstration.formats.gathered_bodies import MAX_BODIES
from drake_blfdmp.demonstration.formats.point_names import resolve
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.formats.ros.body_names import hand_note, named_bodies
from drake_blfdmp.demonstration.formats.ros.ros_fields import alike, columns, reader_of, stamps
from drake_blfdmp.demonstration.formats.ros.ros_frames import up_of
from drake_blfdmp.demonstration.formats.ros.ros_topics import Topic, printable, times_of
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.quaternions import multiply, normalised
from drake_blfdmp.skeleton import POINTS, WRISTS


class Transform(NamedTuple):
    """A frame in its parent's: times (n,) rising, ns; translations (n, 3), m; rotations (n, 4) as x y z w."""

    parent: str
    t_ns: np.ndarray
    p: np.ndarray
    q: np.ndarray
    static: bool


def read_transforms(where: str, topics: Sequence[Topic], joints: Joints | None) -> RawRecording:
    """The people in all transforms of a bag.

    Args:
        where: the file, for messages.
        topics: of TFMessage messages; one whose name ends in tf_static holds for all times.
        joints: see `read_recording`; names of frames.

    Raises:
        RecordingError: a message that is none, nobody's arms, or frames that have no common root.
    """
    tree, note = _tree(where, topics)
    moving = [name for name, transform in tree.items() if not transform.static]
    wanted = {point: name for point, name in (joints or {}).items() if point != "time"}
    found = {} if wanted else named_bodies(tree)
    if not found:
        found = {"": {point: str(name) for point, name in resolve(where, list(tree), wanted).items()}}
    if len(found) > MAX_BODIES:
        raise RecordingError(f"{where}: more than {MAX_BODIES} different people; repair their ids or cut the file")
    if not moving:
        raise RecordingError(f"{where}: all transforms are static; record the topic /tf")
    bodies, roots = {}, set()
    for rest, frames in found.items():
        samples, turns, root = _samples(where, tree, [frames[point] for point in POINTS])
        roots.add(root)
        bodies[rest or "0"] = _rows(samples, turns)
    return RawRecording(
        bodies,
        unit="m",  # REP 103: lengths in ROS are in metres.
        time_unit="s",
        up=up_of(roots),
        notes=(
            f"joints: frames of /tf, in {', '.join(sorted(roots))}",
            *hand_note(sorted({name for frames in found.values() for name in frames.values()})),
            note,
        ),
    )


def _tree(where: str, topics: Sequence[Topic]) -> tuple[dict[str, Transform], str]:
    """Child -> its transform (to the parent that it has most often), and how times were found."""
    parts: dict[tuple[str, str, bool], list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
    for topic in topics:
        static = topic.name.endswith("tf_static")
        log_ns = np.array(topic.log_ns, float)

        def walk(message: bytes, cdr: bool = topic.cdr):
            reader = reader_of(message, cdr)
            return _walk(reader, cdr), reader.structure

        try:
            for frames, numbers, raw in alike(topic.messages, walk):
                for parent, child, stamp, at in frames:
                    values = columns(raw, at, 7, "<f8")
                    sample = (stamps(raw, stamp, topic.cdr), log_ns[numbers], values)
                    parts.setdefault((child, parent, static), []).append(sample)
        except ValueError as error:
            raise RecordingError(f"{where}: {topic.name}: {error}; record it again, or cut it before that") from None
    joined = {key: [np.concatenate(some) for some in zip(*samples, strict=True)] for key, samples in parts.items()}
    stamp_ns = [stamp for (_, _, static), (stamp, _, _) in joined.items() if not static]
    log_ns = [log for (_, _, static), (_, log, _) in joined.items() if not static]
    told, note = False, ""
    if stamp_ns:
        every = np.concatenate(stamp_ns)
        told = np.ptp(every) > 0 or len(every) <= len(stamp_ns)
        _, note = times_of(every if told else np.zeros(len(every), np.int64), np.concatenate(log_ns))
    tree: dict[str, Transform] = {}
    for (child, parent, static), (stamp, log, values) in joined.items():
        clock = stamp if told else np.round(log).astype(np.int64)
        # The last one of those sent for the same time.
        t_ns, index = np.unique(clock[::-1], return_index=True)
        values = values[::-1][index]
        if child not in tree or len(t_ns) > len(tree[child].t_ns):
            tree[child] = Transform(parent, t_ns, values[:, :3], values[:, 3:], static)
    return tree, note


def _walk(reader, cdr: bool) -> list[tuple[str, str, int, int]]:
    """Parent, child, and the bytes where the stamp and the seven numbers stand, of each transform."""
    found = []
    for _ in range(reader.uint32()):
        if not cdr:
            reader.place(1, 4)  # seq
        stamp = reader.place(2, 4)
        parent, child = (printable(reader.string()).removeprefix("/") for _ in range(2))
        found.append((parent, child, stamp, reader.place(7, 8)))
    if reader.left > (7 if cdr else 0):
        raise ValueError(f"{reader.left} bytes more than a TFMessage")
    return found


def _samples(
    where: str, tree: dict[str, Transform], frames: Sequence[str]
) -> tuple[list[tuple[np.ndarray, np.ndarray]], list[np.ndarray], str]:
    """Times (n,) ns and positions (n, 3) of each frame's origin in the root, its turns (n, 4) there, the root's name.

    Turns are quaternions w x y z.
    """
    samples, turns, roots = [], [], []
    for frame in frames:
        chain, name = [], frame
        while name in tree:
            chain.append(tree[name])
            name = tree[name].parent
            if len(chain) > len(tree):
                raise RecordingError(f"{where}: frame {frame} is its own ancestor; repair the tree of frames")
        roots.append(name)
        # A wrist may be fixed to a forearm that moves: the clock is that of the first frame that does.
        clock = next((transform.t_ns for transform in chain if not transform.static), None)
        if clock is None:
            raise RecordingError(f"{where}: frame {frame} never moves in {name}; record the topic /tf")
        # Numbers that are none are NaN afterwards, without a word: they count as missing.
        with np.errstate(over="ignore", invalid="ignore"):
            x, turn = _at(chain[0], clock)
            turn = normalised(np.roll(turn, 1, axis=-1))
            for transform in chain[1:]:
                p, q = _at(transform, clock)
                x = np.einsum("nij,nj->ni", _matrices(q), x) + p
                turn = multiply(normalised(np.roll(q, 1, axis=-1)), turn)
        samples.append((clock, x))
        turns.append(turn)
    if len(set(roots)) > 1:
        raise RecordingError(
            f"{where}: the frames' trees have different roots ({', '.join(sorted(set(roots)))}); "
            "record /tf_static, too, or name frames of one tree with joints"
        )
    return samples, turns, roots[0]


def _matrices(q: np.ndarray) -> np.ndarray:
    """Rotation matrices (n, 3, 3); NaN for what is no rotation."""
    norm = np.linalg.norm(q, axis=1)
    good = (norm > 1e-9) & (norm < 1e9)
    matrices = np.full((len(q), 3, 3), np.nan)
    if good.any():
        matrices[good] = Rotation.from_quat(q[good]).as_matrix()
    return matrices


def _at(transform: Transform, t_ns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The transform at other times: between samples on the straight line (of unit quaternions, too), held outside."""
    known = transform.t_ns
    if transform.static or len(known) == 1:
        return np.broadcast_to(transform.p[-1], (len(t_ns), 3)), np.broadcast_to(transform.q[-1], (len(t_ns), 4))
    after = np.clip(np.searchsorted(known, t_ns), 1, len(known) - 1)
    before = after - 1
    w = np.clip((t_ns - known[before]) / (known[after] - known[before]), 0.0, 1.0)[:, None]
    q0, q1 = transform.q[before], transform.q[after]
    q1 = np.where(np.sum(q0 * q1, axis=1, keepdims=True) < 0.0, -q1, q1)
    return _between(transform.p[before], transform.p[after], w), _between(q0, q1, w)


def _between(a: np.ndarray, b: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Exactly a sample where the time is its own, so that a NaN beside it does not spread."""
    return np.where(w == 0.0, a, np.where(w == 1.0, b, a + w * (b - a)))


def _rows(samples: Sequence[tuple[np.ndarray, np.ndarray]], turns: Sequence[np.ndarray]) -> Body:
    """One row an instant from the six points' own samples; of their turns those of the wrists are kept."""
    t_ns = np.concatenate([t for t, _ in samples])
    point = np.repeat(np.arange(len(POINTS)), [len(t) for t, _ in samples])
    order = np.argsort(t_ns, kind="stable")
    t_ns, point = t_ns[order], point[order]
    x = np.concatenate([x for _, x in samples])[order]
    steps = [float(np.median(np.diff(t))) for t, _ in samples if len(t) > 1]
    longest = 0.5 * min(steps) if steps else 0.0
    row = np.empty(len(t_ns), int)
    current, start, seen = -1, 0, set(range(len(POINTS)))
    for k, (now, which) in enumerate(zip(t_ns.tolist(), point.tolist(), strict=True)):
        # A new row where a point comes again, or where half a period has passed since the row's first.
        if which in seen or now - start > longest:
            current, start, seen = current + 1, now, set()
        seen.add(which)
        row[k] = current
    rows = np.full((current + 1, len(POINTS), 3), np.nan)
    rows[row, point] = x
    turned = np.full((current + 1, len(POINTS), 4), np.nan)
    turned[row, point] = np.concatenate(turns)[order]
    first = np.searchsorted(row, np.arange(current + 1))
    return Body(rows, np.arange(current + 1), t_ns[first] / 1e9, orientations=turned[:, WRISTS])
