"""The way from a `Recording` to a file of this package's own, by the file's suffix."""

from collections.abc import Callable
from pathlib import Path

from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.csv_writer import write_csv
from drake_blfdmp.demonstration.formats.ros.mcap_writer import write_mcap
from drake_blfdmp.errors import RecordingError

WRITERS: dict[str, Callable[[Path, Recording], None]] = {".csv": write_csv, ".mcap": write_mcap}


def check_suffix(path: Path) -> None:
    """Refuse a name whose suffix tells no format.

    Raises:
        RecordingError: an unknown suffix.
    """
    if path.suffix.lower() not in WRITERS:
        raise RecordingError(
            f"{path}: no format is known by the suffix '{path.suffix}'; give a name that ends in {' or '.join(WRITERS)}"
        )


def write_recording(path: str | Path, recording: Recording) -> None:
    """Writes a recording, as it is, to a new file that `read_recording` reads.

    Args:
        path: ends in .csv or .mcap.
        recording: in metres and seconds.

    Raises:
        RecordingError: an unknown suffix, a file that is there already, or one that cannot be written.
    """
    path = Path(path)
    check_suffix(path)
    try:
        WRITERS[path.suffix.lower()](path, recording)
    except FileExistsError:
        raise RecordingError(f"{path}: is there already and is not overwritten; choose another name") from None
    except (OSError, ValueError) as error:
        raise RecordingError(
            f"{path}: cannot be written ({getattr(error, 'strerror', None) or error}); free space there or choose "
            "another place"
        ) from None
