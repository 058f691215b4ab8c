"""Makes a complete file of one whose writer was killed, whoever wrote it: what is whole of it, and its journal's rest.

Without pydrake, and in bounded memory: records are copied as they are, one after the other; only the index is new.
"""

from pathlib import Path
from typing import BinaryIO

from drake_blfdmp.recording.mcap_copy import DAMAGE, McapCopy, Progress, Recovery
from drake_blfdmp.recording.mcap_file import RecorderError
from drake_blfdmp.ros2 import mcap_records as mcap


def recover(
    filename: str | Path, out: str | Path | None = None, progress: Progress = lambda what, share: None
) -> Recovery:
    """Write a complete, indexed file of what is whole of another; nothing is overwritten and the other stays.

    Args:
        filename: an MCAP file of any profile. Its journal is looked for beside it.
        out: the new file; `<stem>-recovered.mcap` beside the other when None.
        progress: called with what is done and the share of it.

    Raises:
        RecorderError: there is no such file or it is no MCAP file, nothing in it is whole, or the new file exists or
            cannot be written.
    """
    path = Path(filename)
    target = path.with_name(f"{path.stem}-recovered.mcap") if out is None else Path(out)
    try:
        size = path.stat().st_size
        with path.open("rb") as stream:
            if _is_intact(stream, size, progress):
                return Recovery(None)
            if target.exists():
                raise FileExistsError
            with target.open("xb") as output:
                try:
                    return McapCopy(path, stream, size, target, output, progress).run()
                except BaseException:
                    target.unlink()
                    raise
    except FileExistsError:
        raise RecorderError(f"{target}: already exists and is not overwritten; name another with --out") from None
    except mcap.NotMcapError:
        raise RecorderError(f"{path}: not an MCAP file; give a file that ends in .mcap") from None
    except mcap.TooLargeError as error:
        raise RecorderError(
            f"{path}: {error}, more than the {mcap.LARGEST / 1e6:.0f} MB that are read at once; use mcap recover"
        ) from None
    except OSError as error:
        where = error.filename or target
        raise RecorderError(
            f"{where}: cannot be {'read' if where == str(path) else 'written'} ({error.strerror}); "
            "check the name and the space there, or name another with --out"
        ) from None


def _is_intact(stream: BinaryIO, size: int, progress: Progress) -> bool:
    """Whether every checksum is right up to the end; leaves the stream at its beginning."""
    stream.seek(max(size - len(mcap.MAGIC), 0))
    if stream.read() == mcap.MAGIC and size > len(mcap.MAGIC):  # Else it ends too early, which is seen at once.
        stream.seek(0)
        told = 0
        try:
            for record in mcap.read_records(stream, size):
                for _ in mcap.opened(record):
                    pass
                if record.start > told:
                    told = record.start + size // 100
                    progress("checking", record.start / size)
            return True
        except (mcap.NotMcapError, mcap.TooLargeError):
            raise
        except DAMAGE:
            pass
        finally:
            progress("checking", 1.0)
    stream.seek(0)
    return False
