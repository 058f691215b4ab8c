"""The package's own MCAP of a recording: `/skeleton`, a visualization_msgs/msg/MarkerArray a sample, for ROS 2 tools.

Each point is a sphere whose namespace is its name in `skeleton.POINTS`; a missing point is left out. The headers'
stamps are the recording's times, the messages' sequence numbers its frame numbers. The alpha of the colour is the
sensor's confidence, where it told any; the poses of the wrists' spheres have the hands' orientations, where there are
any, and 0 0 0 0 for one that is missing. The bytes depend on the recording alone.
"""

from functools import lru_cache
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer

import drake_blfdmp
from drake_blfdmp.demonstration.demonstration import Recording
from drake_blfdmp.demonstration.formats.ros.ros_bag import OWN_METADATA, SKELETON_TOPIC
from drake_blfdmp.errors import RecordingError
from drake_blfdmp.ros2.cdr import CdrTemplate
from drake_blfdmp.ros2.messages import DEFINITIONS, MARKERS, Sphere, spheres_template
from drake_blfdmp.skeleton import POINTS, WRISTS

_FRAMES = {"z": "world", "-y": "camera_optical_frame"}  # What REP 103 and 105 call frames with these axes up.
_FRAME = "recording"
_DIAMETER = 0.05  # m, as the Azure Kinect's driver draws joints.
_COLOURS = {"left": (0.0, 0.45, 0.70), "right": (0.84, 0.37, 0.0)}  # Blue and orange that everybody can tell apart.
_LIFETIME_NS = 250_000_000  # So that a point that goes missing vanishes from a viewer.
_LATEST_S = 2**31 - 1  # What a stamp can hold.


def write_mcap(path: Path, recording: Recording) -> None:
    """Writes a new file.

    Raises:
        RecordingError: times that a ROS 2 stamp cannot hold.
        OSError: the file exists or cannot be written.
    """
    if len(recording.t) and float(np.abs(recording.t).max()) > _LATEST_S:
        raise RecordingError(
            f"{path}: a time of {np.abs(recording.t).max():.6g} s is more than a ROS 2 stamp holds; write a .csv"
        )
    frame = _FRAMES.get(recording.up or "", _FRAME)
    told = recording.confidence is not None
    turning = np.isin(np.arange(len(POINTS)), WRISTS) & (recording.orientations is not None)
    values = [recording.x[:, k] for k in range(len(POINTS))]
    if recording.orientations is not None:
        for hand, k in enumerate(WRISTS):
            values[k] = np.hstack([values[k], np.nan_to_num(recording.orientations[:, hand][:, [1, 2, 3, 0]])])
    confidence = np.ones(recording.x.shape[:2]) if recording.confidence is None else recording.confidence.astype(float)

    @lru_cache(maxsize=1024)
    def template(seen: bytes, alphas: bytes) -> CdrTemplate:
        """The message of those points that are seen, by their confidences."""
        alpha = np.frombuffer(alphas)
        spheres = [
            Sphere(POINTS[k], 0, _DIAMETER, (*_COLOURS[POINTS[k].split("_")[0]], float(alpha[k])), turning[k])
            for k in np.flatnonzero(np.frombuffer(seen, bool))
        ]
        return spheres_template(frame, spheres, lifetime_ns=_LIFETIME_NS)

    t_ns = np.round(recording.t * 1e9).astype(np.int64)
    # Stamps may be negative, MCAP's own times may not.
    log_ns = t_ns - min(0, int(t_ns.min())) if len(t_ns) else t_ns
    finite = np.all(np.isfinite(recording.x), axis=2)
    with path.open("xb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(profile="ros2", library=f"drake_blfdmp {drake_blfdmp.__version__}")
        writer.add_metadata(
            OWN_METADATA,
            {
                "source": Path(recording.source).name,
                "format": recording.format,
                "synthetic": str(recording.synthetic),
                "up": recording.up or "",
                "confidence": "alpha" if told else "",
            },
        )
        schema = writer.register_schema(name=MARKERS, encoding="ros2msg", data=DEFINITIONS[MARKERS].encode())
        channel = writer.register_channel(topic=SKELETON_TOPIC, message_encoding="cdr", schema_id=schema)
        for k, (seen, alphas) in enumerate(zip(finite, confidence, strict=True)):
            numbers = (
                np.concatenate([values[point][k] for point in np.flatnonzero(seen)]) if seen.any() else np.empty(0)
            )
            message = template(seen.tobytes(), alphas.tobytes()).encode(int(t_ns[k]), numbers)
            writer.add_message(
                channel,
                log_time=int(log_ns[k]),
                publish_time=int(log_ns[k]),
                sequence=int(recording.frames[k]) & 0xFFFFFFFF,
                data=message,
            )
        writer.finish()
