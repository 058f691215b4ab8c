"""Records named vectors, wrenches and events of a simulated run in MCAP; the base of `McapRecorder`."""

import math
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Self

from pydrake.systems.framework import Context

from drake_blfdmp.recording.mcap_file import McapFile, RecorderError
from drake_blfdmp.recording.sampler import Sampler
from drake_blfdmp.recording.topic_inputs import LOGGER, TopicInputs
from drake_blfdmp.ros2 import messages as ros2_messages


class TopicRecorder(TopicInputs):
    """What every recorder does: samples at a rate, a topic a signal, events, attachments, and a file that is complete.

    .. pydrake_system::

        name: TopicRecorder
        input_ports:
        - <name given to AddVectorInput>
        - <name given to AddVectorInputs>
        - <name given to AddWrenchInput>
        - <name given to AddWrenchInputs>
        - <name given to AddMessageInput>
        - <name given to AddTemplateInput>
        - <name given to AddEventInput>

    A sample is read when it is due and written with others: with the first sample that comes 0.4 s of wall time later,
    at once where samples are 0.1 s or more apart, and in any case before `Event`, `AddAttachment`, `Flush` and `Close`
    return. Whoever lets a simulation stand still calls `Flush`.
    """

    def __init__(
        self,
        *,
        filename: str | Path,
        rate: float = 100.0,
        chunk_duration: float = 1.0,
        metadata: Mapping[str, object] | None = None,
    ):
        """Creates the file and declares the event.

        Args:
            filename: the file to create; it must not exist.
            rate: samples per simulated second, Hz.
            chunk_duration: simulated time in a chunk, s.
            metadata: what is to be known of the run: the metadata record "run".

        Raises:
            RecorderError: the file exists or cannot be created.
        """
        super().__init__()
        self._optional: set[str] = set()  # Ports that need no source.
        self._sampler: Sampler | None = None
        self._last_ns: int | None = None
        self.DeclarePeriodicPublishEvent(1.0 / rate, 0.0, self._publish)
        self._file = McapFile(filename, chunk_duration=chunk_duration)
        self._file.before_close = self.Flush
        self._file.add_metadata("run", metadata or {})
        self._events_channel = self._file.add_channel("/events", ros2_messages.LOG)

    @property
    def path(self) -> Path:
        """The file."""
        return self._file.path

    def Event(self, name: str, t: float) -> None:
        """Records that `name` (grasp, lift, release and so on) happened at simulated time `t` (s).

        Raises:
            RecorderError: `t` is negative or no number.
        """
        if not (math.isfinite(t) and t >= 0):
            raise RecorderError(f"recorder: event '{name}' at t = {t} s; give a time from 0 on")
        self.Flush()
        if not self._file.closed:
            t_ns = round(t * 1e9)
            self._file.write(self._events_channel, t_ns, ros2_messages.log_message(t_ns, LOGGER, name))

    def AddAttachment(self, name: str, data: bytes | str, media_type: str = "text/plain") -> None:
        """Stores a whole file (scenario, skill, summary) in the recording.

        Raises:
            RecorderError: the recorder is closed.
        """
        if self._file.closed:
            raise RecorderError(f"{self._file.path}: attachment '{name}' comes after Close(); add it before")
        self.Flush()
        self._file.add_attachment(name, data.encode() if isinstance(data, str) else data, media_type)

    def Flush(self) -> None:
        """Writes what is held, so that nothing read so far is lost with the process; for whoever pauses a simulation.

        Raises:
            RecorderError: it cannot be written.
        """
        if self._sampler is not None and not self._file.closed:
            self._sampler.flush(self._file)

    def Close(self) -> None:
        """Completes the file; a second call does nothing.

        Raises:
            RecorderError: the rest cannot be written.
        """
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self.Close()

    def _check_connected(self, context: Context) -> None:
        for port in map(self.get_input_port, range(self.num_input_ports())):
            if port.get_name() not in self._optional and not port.HasValue(context):
                raise RecorderError(f"recorder: input port '{port.get_name()}' is not connected; connect it")

    def _make_sampler(self, context: Context, t_ns: int) -> Sampler:
        """At the first sample, at `t_ns` (ns): says what a sample is."""
        return Sampler(self._recorded, self._encoded, self._poses)

    def _publish(self, context: Context) -> None:
        """Takes one sample of everything."""
        file = self._file
        if file.closed:
            return
        t_ns = round(context.get_time() * 1e9)
        if self._last_ns is not None and t_ns < self._last_ns:
            raise RecorderError(
                f"{file.path}: time went back from {self._last_ns * 1e-9:.6g} s to {t_ns * 1e-9:.6g} s; "
                "use a new recorder, and a new file, for each run"
            )
        self._last_ns, self._sampled = t_ns, True
        if self._sampler is None:
            self._check_connected(context)
            self._sampler = self._make_sampler(context, t_ns)
        self._sampler.sample(context, t_ns, file)
