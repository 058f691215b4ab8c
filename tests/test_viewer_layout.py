"""The layout for Lichtblick and Foxglove fits what a run records."""

import json
import re
from pathlib import Path

from drake_blfdmp.recording.stream import McapStream

ROOT = Path(__file__).resolve().parents[1]
PANELS = {"3D", "Plot", "RosOut"}  # Of Lichtblick and Foxglove alike; RosOut is the Log panel.


def panels(node):
    """Names of the panels in a layout's tree."""
    return [node] if isinstance(node, str) else panels(node["first"]) + panels(node["second"])


def test_every_panel_and_path_leads_somewhere(default_run):
    layout = json.loads((ROOT / "docs" / "viewers" / "lichtblick_layout.json").read_text(encoding="utf-8"))
    configs = layout["configById"]
    assert sorted(panels(layout["layout"])) == sorted(configs)
    assert {name.split("!")[0] for name in configs} == PANELS
    names, types = {}, {}
    stream = McapStream(default_run.folder / "run.mcap")
    for sample in stream:
        names.setdefault(sample.topic, sample.names)
        types.setdefault(sample.topic, sample.type)
    plotted = 0
    for name, config in configs.items():
        for path in config.get("paths", ()):
            if path["value"] == "0":  # A line at zero.
                continue
            plotted += 1
            topic, _, field = path["value"].partition(".")
            element = re.fullmatch(r"position\[(\d+)\]", field)
            if element is None:
                assert (types[topic], field) == ("geometry_msgs/msg/WrenchStamped", "wrench.force.z")
                continue
            found = names[topic][int(element[1])]
            if topic == "/joint_states":
                arm, number = path["label"].split()
                assert found == f"{arm}_arm_panda_joint{number}", name
            else:
                assert path["label"] == re.sub("_(lower|upper)$", r" \1", found), name
    assert plotted == 5 + 15 + 3 + 14
    scene = configs["3D!scene"]
    for topic in scene["topics"]:
        assert types[topic] in ("std_msgs/msg/String", "visualization_msgs/msg/MarkerArray")
    assert scene["followTf"] == scene["layers"]["grid"]["frameId"] == "world"
