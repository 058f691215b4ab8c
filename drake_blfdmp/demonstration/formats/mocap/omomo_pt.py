"""Body-model fits of people with objects as PyTorch tensors (OMOMO in the layout of InterMimic), read without PyTorch.

A zip archive whose member `*/data/0` holds the raw numbers of one float tensor, frames x 591. Columns 162:318 are 52
joints x (x, y, z) in metres, z up, world frame, columns 321:325 the object's orientation x y z w there; 30 frames a
second. The pickle beside it is never executed.

Source: Li, Wu, Liu, "Object motion guided human motion synthesis", ACM TOG 2023.
"""

import re
import zipfile
from pathlib import Path

import numpy as np

from drake_blfdmp.demonstration.formats.documents.json_points import one_name_each
from drake_blfdmp.demonstration.formats.recording_format import Joints
from drake_blfdmp.demonstration.raw_recording import RawRecording, one_body
from drake_blfdmp.errors import RecordingError

CLOCK_HZ = 30.0
COLUMNS = 591
FIRST_JOINT_COLUMN = 162
OBJECT_COLUMN = 321
_FINGERS = tuple(f"{finger}{bone}" for finger in ("Index", "Middle", "Pinky", "Ring", "Thumb") for bone in (1, 2, 3))
JOINTS = (
    "Pelvis", "L_Hip", "L_Knee", "L_Ankle", "L_Toe", "R_Hip", "R_Knee", "R_Ankle", "R_Toe",
    "Torso", "Spine", "Chest", "Neck", "Head",
    "L_Thorax", "L_Shoulder", "L_Elbow", "L_Wrist", *(f"L_{name}" for name in _FINGERS),
    "R_Thorax", "R_Shoulder", "R_Elbow", "R_Wrist", *(f"R_{name}" for name in _FINGERS),
)  # fmt: skip
_MAX_BYTES = 256 << 20
_NAME_AT = 30  # Of the first member's name, behind the zip's local header.


class OmomoPt:
    """Reader of such tensors; `joints` may name any of `JOINTS`."""

    name = "omomo_pt"

    def sniff(self, head: bytes) -> bool:
        """Whether a zip archive begins with PyTorch's `data.pkl`."""
        return head.startswith(b"PK\x03\x04") and re.match(rb"[^\0]{0,500}/data\.pkl", head[_NAME_AT:]) is not None

    def read(self, path: Path, joints: Joints | None) -> RawRecording:
        """Reads the file; frames are counted from 0.

        Raises:
            RecordingError: a damaged archive, or another tensor than frames x 591 single-precision numbers.
        """
        chosen = one_name_each(path, JOINTS, joints)
        values = _tensor(path)
        columns = [FIRST_JOINT_COLUMN + 3 * JOINTS.index(name) for name in chosen]
        x = np.stack([values[:, column : column + 3] for column in columns], axis=1).astype(float)
        # What is held tells better than the hands how it turns: those of a body model slide on it.
        q = values[:, [OBJECT_COLUMN + 3, *range(OBJECT_COLUMN, OBJECT_COLUMN + 3)]].astype(float)
        notes = ("orientations: the object's, for both hands",) if q.any() else ()
        return one_body(
            x, orientations=np.repeat(q[:, None], 2, axis=1), unit="m", clock_hz=CLOCK_HZ, up="z", notes=notes
        )


def _tensor(path: Path) -> np.ndarray:
    """(N, 591) the numbers of the archive's one tensor."""
    data = b""
    kind = b""
    order = "<"
    damage = ""
    try:
        with zipfile.ZipFile(path) as archive:
            members = {name.partition("/")[2]: archive.getinfo(name) for name in archive.namelist()}
            stored = members.get("data/0")
            if stored is None or "data.pkl" not in members or "data/1" in members:
                raise RecordingError(f"{path}: no PyTorch file of one tensor; save frames x {COLUMNS} alone")
            wanted = [stored, members["data.pkl"], *([members["byteorder"]] if "byteorder" in members else [])]
            if any(member.compress_type != zipfile.ZIP_STORED for member in wanted):
                raise RecordingError(f"{path}: a compressed archive; save it with torch.save, which does not compress")
            if sum(member.file_size for member in wanted) > _MAX_BYTES:
                raise RecordingError(f"{path}: a tensor of more than {_MAX_BYTES >> 20} MB; cut it into shorter files")
            data, kind = archive.read(stored), archive.read(members["data.pkl"])
            if "byteorder" in members and archive.read(members["byteorder"]).strip() == b"big":
                order = ">"
    except RecordingError:
        raise
    except Exception as error:  # zipfile raises whatever damaged bytes bring about.
        damage = " ".join(f"{type(error).__name__}: {error}".split())[:120]
    if damage:
        raise RecordingError(f"{path}: a damaged PyTorch file ({damage}); copy or save it again")
    # The storage's class is named in the pickle as plain text; the text is looked at, nothing is loaded.
    if b"FloatStorage" not in kind or not data or len(data) % (4 * COLUMNS):
        raise RecordingError(
            f"{path}: a tensor of {len(data)} bytes, no single-precision frames x {COLUMNS}; "
            "only the layout of OMOMO in InterMimic is known, convert the joints to a CSV"
        )
    return np.frombuffer(data, f"{order}f4").reshape(-1, COLUMNS)
