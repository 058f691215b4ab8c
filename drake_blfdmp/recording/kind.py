"""What kind of recording a file is, by the name of its metadata record. Without pydrake."""

from collections.abc import Collection
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.records import Metadata

from drake_blfdmp.recording.stream import McapStream
from drake_blfdmp.ros2 import mcap_records as mcap


def find_record(filename: str | Path, names: Collection[str]) -> str | None:
    """The first of the metadata records called `names` in a file, or None where it has none of them.

    Our own files begin with it; another file is read to its end, without looking into its chunks.

    Raises:
        RecorderError: there is no such file, it is no MCAP file, or it is truncated or damaged before such a record.
    """
    path = Path(filename)
    try:
        with path.open("rb") as stream:
            for record in mcap.read_records(stream, path.stat().st_size):
                if record.opcode == mcap.METADATA:
                    name = Metadata.read(ReadDataStream(BytesIO(record.data or b""))).name
                    if name in names:
                        return name
    except (OSError, ValueError, McapError):
        # The stream of its messages says what is wrong, from where on, and what to do.
        for _ in McapStream(path, topics=set()).messages():
            pass
    return None
