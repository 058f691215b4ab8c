"""Opens a run's recording in Rerun: the scene with the person's skeleton and the contact forces, beside the curves.

    python -m pip install 'rerun-sdk>=0.41'
    python docs/viewers/rerun_run.py run.mcap                 # opens the viewer
    python docs/viewers/rerun_run.py run.mcap --save run.rrd  # or a file for `rerun run.rrd`, or rerun.io/viewer

Rerun reads the recording itself: geometry from /robot_description, poses from /tf, curves from the JointStates. What
it does not draw of its own (MarkerArray, WrenchStamped) is drawn here from the same file.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from drake_blfdmp.recording.stream import McapStream
from drake_blfdmp.skeleton import LINKS

TIMELINE = "message_log_time"
ROBOT = "/dual_panda_scene"  # The name in /robot_description.
GREEN, ORANGE, RED = (0, 158, 115), (230, 159, 0), (208, 0, 0)
METRES_PER_NEWTON = 0.003


def blueprint(at_end: bool) -> rrb.Blueprint:
    """Scene left, curves right; the time cursor runs, or stands at the end."""
    scene = rrb.Spatial3DView(
        name="scene",
        origin="/",
        contents=["+ /**", f"- {ROBOT}/collision_geometries/**"],
        spatial_information=rrb.SpatialInformation(target_frame="world"),
        eye_controls=rrb.EyeControls3D(position=(2.3, -1.3, 1.9), look_target=(0.5, 0.0, 0.95), eye_up=(0, 0, 1)),
    )
    curves = [
        rrb.TimeSeriesView(name=name, origin=origin, plot_legend=rrb.PlotLegend(visible=origin == "/margin/position"))
        for name, origin in (
            ("margins: below 0 is outside the band", "/margin/position"),
            ("link lengths and bands, m", "/link_lengths/position"),
            ("palms' forces, N", "/palm_force/position"),
            ("joint angles, rad", "/joint_states/position"),
        )
    ]
    return rrb.Blueprint(
        rrb.Horizontal(scene, rrb.Vertical(*curves), column_shares=[3, 2]),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="following" if at_end else "playing"),
    )


def log_skeleton(filename: Path) -> None:
    """Points and links in frame `person`, coloured by margin; the palms' forces as arrows in their links' frames."""
    rr.log("person/skeleton", rr.CoordinateFrame("person"), static=True)
    margin = np.ones(len(LINKS))
    for sample in McapStream(filename, topics={"/points", "/margin", "/contact/left_palm", "/contact/right_palm"}):
        rr.set_time(TIMELINE, timestamp=np.datetime64(round(sample.t * 1e9), "ns"))
        if sample.topic == "/margin":
            margin = sample.values
        elif sample.topic == "/points":
            points = sample.values.reshape(-1, 3)
            colours = [GREEN if m > 0.2 else ORANGE if m >= 0.0 else RED for m in margin]
            strips = [points[[link.a, link.b]] for link in LINKS]
            rr.log("person/skeleton/points", rr.CoordinateFrame("person"), rr.Points3D(points, radii=0.03))
            rr.log(
                "person/skeleton/links",
                rr.CoordinateFrame("person"),
                rr.LineStrips3D(strips, colors=colours, radii=0.02),
            )
        else:
            force = METRES_PER_NEWTON * sample.values[0]
            rr.log(
                f"force{sample.topic}",
                rr.CoordinateFrame(sample.frames[0]),
                rr.Arrows3D(vectors=[force], origins=[-force], colors=[RED], radii=0.008),
            )


def main() -> None:
    """Send the recording, what is drawn in addition, and the arrangement."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--save", type=Path, metavar="RRD", help="write a file in place of opening the viewer")
    parser.add_argument("--at-end", action="store_true", help="show the end, and what is still to come")
    options = parser.parse_args()
    rr.init("drake_blfdmp", spawn=options.save is None)
    if options.save is not None:
        rr.save(options.save, default_blueprint=blueprint(options.at_end))
    rr.log_file_from_path(options.file)
    log_skeleton(options.file)
    rr.send_blueprint(blueprint(options.at_end))


if __name__ == "__main__":
    main()
