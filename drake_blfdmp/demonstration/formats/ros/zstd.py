"""Zstandard, as ROS 2 bags are compressed with: never more out of it than a recording may hold."""

from pathlib import Path

from drake_blfdmp.demonstration.formats.text import MAX_FILE_BYTES
from drake_blfdmp.errors import RecordingError

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_PIECE = 1 << 20


def decompress_file(source: Path, target: Path) -> None:
    """Writes the content of `source` to the new file `target`.

    Raises:
        RecordingError: damaged, or more than a recording may hold.
    """
    import zstandard

    written = 0
    with source.open("rb") as file, target.open("xb") as out:
        try:
            with zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True) as reader:
                while piece := reader.read(_PIECE):
                    written += len(piece)
                    if written > MAX_FILE_BYTES:
                        raise RecordingError(
                            f"{source}: holds more than {MAX_FILE_BYTES >> 30} GB; cut the recording into shorter files"
                        )
                    out.write(piece)
        except (zstandard.ZstdError, MemoryError) as error:
            raise RecordingError(f"{source}: cut off or damaged ({error}); copy it again") from None


def decompress(data: bytes, most: int) -> bytes:
    """The content of `data`, at most `most` bytes.

    Raises:
        ValueError: damaged, or more.
    """
    import zstandard

    try:
        with zstandard.ZstdDecompressor().stream_reader(data) as reader:
            content = reader.read(most + 1)
    except (zstandard.ZstdError, MemoryError) as error:
        raise ValueError(str(error)) from None
    if len(content) > most:
        raise ValueError(f"a message of more than {most >> 20} MB")
    return content
