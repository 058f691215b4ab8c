"""An MCAP file under construction: ROS 2 profile, simulated time only, nothing lost but the chunk in progress."""

from collections.abc import Mapping
from pathlib import Path

from mcap.writer import CompressionType, Writer

import drake_blfdmp
from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.ros2.messages import DEFINITIONS

CHUNK_BYTES = 256 * 1024


class RecorderError(BlfDmpError):
    """A recording of a run cannot be written or read."""


def _qos(*, transient_local: bool) -> str:
    """Quality of service as rosbag2 stores it: a latched topic is sent again to whoever subscribes late."""
    # The numbers are rmw's: history keep_last, reliability reliable, durability transient_local or volatile; "infinite"
    # is the largest duration. Numbers, not names, because every rosbag2 reads those.
    infinite = "{sec: 9223372036, nsec: 854775807}"
    return (
        f"- {{history: 1, depth: {1 if transient_local else 10}, reliability: 1, "
        f"durability: {1 if transient_local else 2}, deadline: {infinite}, lifespan: {infinite}, liveliness: 1, "
        f"liveliness_lease_duration: {infinite}, avoid_ros_namespace_conventions: false}}\n"
    )


class McapFile:
    """Writes messages to a new MCAP file.

    The bytes depend on what is written and on nothing else (no wall clock, no process or machine name), so equal runs
    give equal files. A chunk is closed, compressed and handed to the operating system after `chunk_duration` of
    SIMULATED time, or at 256 KiB: cutting by the wall clock would lose the equality. A process killed outright
    loses at most the chunk in progress, that is `chunk_duration` divided by the run's real-time rate of wall time.

    Args:
        filename: the file to create.
        chunk_duration: s of simulated time.

    Raises:
        RecorderError: the file exists, or cannot be created.
    """

    def __init__(self, filename: str | Path, *, chunk_duration: float = 0.25):
        self.path = Path(filename)
        try:
            # Closed in close().
            self._stream = self.path.open("xb")
        except FileExistsError:
            raise RecorderError(f"{self.path}: already exists and is not overwritten; choose another name") from None
        except OSError as error:
            raise RecorderError(
                f"{self.path}: cannot be created ({error.strerror}); give a name in a writable folder"
            ) from None
        self._chunk_ns = round(chunk_duration * 1e9)
        self._chunk_end: int | None = None
        self._schemas: dict[str, int] = {}
        self._latest_ns = 0
        self.closed = False
        self._writer = Writer(
            self._stream,
            chunk_size=CHUNK_BYTES,
            compression=CompressionType.ZSTD,
            enable_data_crcs=True,
        )
        self._writer.start(profile="ros2", library=f"drake_blfdmp {drake_blfdmp.__version__}")

    def add_metadata(self, name: str, data: Mapping[str, object]) -> None:
        """Adds a metadata record; values are written as `str(value)`."""
        try:
            self._writer.add_metadata(name, {str(key): str(value) for key, value in data.items()})
        except OSError as error:
            raise self._cannot_write(error) from None

    def add_attachment(self, name: str, data: bytes, media_type: str) -> None:
        """Adds an attachment, logged at the latest message's simulated time; its creation time is 0, "not known"."""
        try:
            self._writer.add_attachment(
                create_time=0, log_time=self._latest_ns, name=name, media_type=media_type, data=data
            )
        except OSError as error:
            raise self._cannot_write(error) from None

    def add_channel(
        self, topic: str, message_type: str, metadata: Mapping[str, str] | None = None, *, transient_local: bool = False
    ) -> int:
        """Adds a topic of one of the types in `ros2.messages.DEFINITIONS`; returns its number for `write`."""
        if message_type not in self._schemas:
            self._schemas[message_type] = self._writer.register_schema(
                name=message_type, encoding="ros2msg", data=DEFINITIONS[message_type].encode()
            )
        return self._writer.register_channel(
            topic=topic,
            message_encoding="cdr",
            schema_id=self._schemas[message_type],
            metadata={"offered_qos_profiles": _qos(transient_local=transient_local), **(metadata or {})},
        )

    def write(self, channel: int, t_ns: int, data: bytes) -> None:
        """Adds a message at simulated time `t_ns` (ns)."""
        try:
            if self._chunk_end is None:
                self._chunk_end = t_ns + self._chunk_ns
            elif t_ns >= self._chunk_end:
                self._writer.flush()
                self._chunk_end = t_ns + self._chunk_ns
            self._latest_ns = max(self._latest_ns, t_ns)
            self._writer.add_message(channel, log_time=t_ns, data=data, publish_time=t_ns)
        except OSError as error:
            raise self._cannot_write(error) from None

    def close(self) -> None:
        """Writes the last chunk, the indexes and the summary, and closes the file; a second call does nothing."""
        if self.closed:
            return
        self.closed = True
        try:
            try:
                self._writer.finish()
            finally:
                self._stream.close()
        except OSError as error:
            raise self._cannot_write(error) from None

    def _cannot_write(self, error: OSError) -> RecorderError:
        return RecorderError(f"{self.path}: writing failed ({error.strerror}); free space there or record elsewhere")
