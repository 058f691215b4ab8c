"""Collecting people frame by frame, as formats hold them that list whoever is seen in each frame."""

from array import array
from collections.abc import Sequence

import numpy as np

from drake_blfdmp.demonstration.formats.confidence import confidence_of_numbers
from drake_blfdmp.demonstration.raw_recording import Body, RawRecording
from drake_blfdmp.errors import RecordingError

MAX_BODIES = 1000  # A tracker that loses people gives them new numbers, but not so many.
_UNSAID = (np.nan,) * 6
_UNTURNED = ((np.nan,) * 4,) * 2


class _Track:
    """One person's rows, flat: compact, and nothing for the garbage collector to look through."""

    def __init__(self):
        self.frames = array("q")
        self.t = array("d")
        self.x = array("d")
        self.confidence = array("d")
        self.orientations = array("d")


class GatheredBodies:
    """People by id, each with the frames in which it appears; `where` is the file, for messages."""

    def __init__(self, where: str):
        self._where = where
        self._tracks: dict[str, _Track] = {}

    def add(
        self,
        name: object,
        frame: int,
        t: float | None,
        x: Sequence[Sequence[float]],
        confidence: Sequence[float] | None = None,
        orientations: Sequence[Sequence[float]] = _UNTURNED,
    ) -> None:
        """One person in one frame.

        Args:
            name: the id in the file; what cannot be printed of it is dropped.
            frame: frame number.
            t: the file's clock, or None where it has none (then in every call).
            x: (6, 3) points, NaN where missing.
            confidence: (6,) as in the file (see `confidence_of_numbers`), NaN where a point has none; None where the
                person has none.
            orientations: (2, 4) of left and right hand, quaternions w x y z; NaN where missing.

        Raises:
            RecordingError: more people than any recording has.
        """
        key = "".join(character for character in str(name)[:60] if character.isprintable())
        track = self._tracks.get(key)
        if track is None:
            if len(self._tracks) == MAX_BODIES:
                raise RecordingError(
                    f"{self._where}: frame {frame}: more than {MAX_BODIES} people; repair their ids or cut the file"
                )
            track = self._tracks[key] = _Track()
        track.frames.append(frame)
        track.t.append(np.nan if t is None else t)
        for point in x:
            track.x.extend(point)
        track.confidence.extend(_UNSAID if confidence is None else confidence)
        for hand in orientations:
            track.orientations.extend(hand)

    def recording(self, *, has_clock: bool, notes: tuple[str, ...] = (), **stated) -> RawRecording:
        """What was gathered, with `notes` and `stated` as further fields of RawRecording.

        Points at exactly (0, 0, 0) are missing: writers put that for a joint not seen, and no joint lies in a sensor.

        Raises:
            RecordingError: nobody was added.
        """
        if not self._tracks:
            raise RecordingError(f"{self._where}: no frame holds a person; record with somebody in view")
        tracks = self._tracks.values()
        x = np.concatenate([np.array(track.x) for track in tracks]).reshape(-1, 6, 3)
        at_origin = np.all(x == 0.0, axis=-1)
        x[at_origin] = np.nan
        said = np.concatenate([np.array(track.confidence) for track in tracks]).reshape(-1, 6)
        # The scale shows in the largest number, so it is found from all people together.
        confidence, sentence = confidence_of_numbers(said, x)
        if confidence is not None:
            confidence = np.where(np.isfinite(x).all(axis=-1), confidence, 0.0)
        bodies: dict[str, Body] = {}
        first = 0
        for name, track in self._tracks.items():
            part = slice(first, first + len(track.frames))
            first = part.stop
            bodies[name] = Body(
                x[part],
                np.array(track.frames),
                np.array(track.t) if has_clock else None,
                None if confidence is None else confidence[part],
                np.array(track.orientations).reshape(-1, 2, 4),
            )
        origin = f"{at_origin.sum()} points at exactly (0, 0, 0) count as missing" if at_origin.any() else ""
        return RawRecording(bodies, notes=tuple(note for note in (*notes, sentence, origin) if note), **stated)
