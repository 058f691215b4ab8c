"""ROS 2 bags: a directory with metadata.yaml and SQLite or MCAP files, whole or compressed, or a single SQLite file."""

import tempfile
from pathlib import Path

import yaml

from drake_blfdmp.demonstration.formats.recording_format import HEAD_BYTES, Joints
from drake_blfdmp.demonstration.formats.ros.mcap_bag import MAGIC, add_mcap
from drake_blfdmp.demonstration.formats.ros.ros_bag import read_bag
from drake_blfdmp.demonstration.formats.ros.ros_topics import Bag, printable
from drake_blfdmp.demonstration.formats.ros.sqlite_bag import SQLITE_MAGIC, add_sqlite
from drake_blfdmp.demonstration.formats.ros.zstd import ZSTD_MAGIC, decompress_file
from drake_blfdmp.demonstration.raw_recording import RawRecording
from drake_blfdmp.errors import RecordingError

INDEX = "metadata.yaml"
_INFORMATION = "rosbag2_bagfile_information"


class RosBag2:
    """Reader of ROS 2 bags; `joints` names markers' texts, namespaces, joints or numbers, or frames."""

    name = "rosbag2"

    def sniff(self, head: bytes) -> bool:
        """Whether the file begins as SQLite or zstd, or is a bag's metadata.yaml."""
        return head.startswith((SQLITE_MAGIC, ZSTD_MAGIC)) or _INFORMATION.encode() + b":" in head

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads all files of the bag, one after another; times are the messages' stamps.

        Raises:
            RecordingError: metadata that name no files, a missing or damaged file, or nobody in the bag.
        """
        bag = Bag(path)
        for file in _files(path):
            _add(bag, file)
        return read_bag(bag, joints)


def _files(path: Path) -> list[Path]:
    """The bag's files in order; `path` is a directory, its metadata.yaml, or a single file."""
    index = path / INDEX if path.is_dir() else path
    with index.open("rb") as file:
        head = file.read(HEAD_BYTES + 1)
    if head.startswith((SQLITE_MAGIC, ZSTD_MAGIC, MAGIC)):
        return [path]
    if len(head) > HEAD_BYTES:
        raise RecordingError(f"{index}: larger than {HEAD_BYTES >> 10} kB; give the bag's .db3 or .mcap file instead")
    try:
        # Strings alone: neither dates nor merged keys, of which a broken file could have anything. Not by the loader in
        # C either, which nested brackets crash.
        names = yaml.load(head, Loader=yaml.BaseLoader)[_INFORMATION]["relative_file_paths"]
        # Early versions name the bag's directory, too; a file elsewhere is never meant.
        files = list(dict.fromkeys(index.parent / Path(name).name for name in names))
    except (yaml.YAMLError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise RecordingError(
            f"{index}: names no files ({type(error).__name__}); give the bag's .db3 or .mcap file instead"
        ) from None
    absent = [printable(file.name) for file in files if not file.is_file()]
    if absent or not files:
        what = f"'{absent[0]}', which is not there" if absent else "no file"
        raise RecordingError(f"{index}: names {what}; give the bag's .db3 or .mcap file instead")
    return files


def _add(bag: Bag, file: Path) -> None:
    """Adds the messages of one file, whatever its name.

    Raises:
        RecordingError: a file that is none of the three, or damaged.
    """
    with file.open("rb") as opened:
        head = opened.read(len(SQLITE_MAGIC))
    if head.startswith(ZSTD_MAGIC):
        with tempfile.TemporaryDirectory() as folder:
            whole = Path(folder) / file.stem
            decompress_file(file, whole)
            _add_plain(bag, file, whole)
    else:
        _add_plain(bag, file, file)


def _add_plain(bag: Bag, named: Path, file: Path) -> None:
    with file.open("rb") as opened:
        head = opened.read(len(SQLITE_MAGIC))
    if head.startswith(MAGIC):
        add_mcap(bag, file, named)
    elif head.startswith(SQLITE_MAGIC):
        add_sqlite(bag, file, named)
    else:
        raise RecordingError(f"{named}: is neither SQLite nor MCAP; copy the bag again")
