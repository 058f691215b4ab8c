"""The whole scene as one plain URDF, for viewers that know nothing of Drake.

Names are those under which `recording.plant_names` records: links and joints of an arm are prefixed with its model
instance. Drake's own shapes are replaced by URDF's: a capsule by a cylinder and two spheres, an ellipsoid by a sphere.
"""

import copy
import xml.etree.ElementTree as ET
from collections.abc import Sequence

import yaml
from pydrake.geometry import Box, Cylinder
from scipy.spatial.transform import Rotation

from drake_blfdmp.robot.box import BoxParameters, TableParameters
from drake_blfdmp.robot.box_look import BoxLook
from drake_blfdmp.robot.look import VisualPart
from drake_blfdmp.robot.models import ModelsDirectory
from drake_blfdmp.robot.table_look import TableLook

DRAKE = "{http://drake.mit.edu}"


def MakeSceneDescription(box: BoxParameters | None, tables: Sequence[TableParameters]) -> str:
    """URDF text of both arms on their pedestals, the tables and the box, if any, in a tree below the link `world`."""
    scene = ET.Element("robot", name="dual_panda_scene")
    ET.SubElement(scene, "link", name="world")
    directory = ModelsDirectory()
    directives = yaml.load((directory / "dual_panda.dmd.yaml").read_text(encoding="utf-8"), _Loader)["directives"]
    models = {d["add_model"]["name"]: d["add_model"]["file"].rsplit("/", 1)[1] for d in directives if "add_model" in d}
    for weld in (d["add_weld"] for d in directives if "add_weld" in d):
        instance, root = weld["child"].split("::")
        model = ET.parse(directory / models[instance]).getroot()
        _append(scene, model, instance)
        x, y, z = weld["X_PC"]["translation"]
        roll, pitch, yaw = (angle * 0.017453292519943295 for angle in weld["X_PC"]["rotation"]["deg"])
        _fix(scene, f"{instance}_{root}", f"{x} {y} {z}", f"{roll} {pitch} {yaw}")
    for table in tables:
        x, y, z = table.top_center
        look = TableLook(table.size, table.thickness, z)
        _fix(scene, _link(scene, table.name, look, ("slab_visual", "leg_visual")), f"{x} {y} {z}", "0 0 0")
    if box is not None:
        name = _link(scene, "box", BoxLook(box.size), ("visual",))
        joint = ET.SubElement(scene, "joint", name="box_free", type="floating")
        ET.SubElement(joint, "parent", link="world")
        ET.SubElement(joint, "child", link=name)
    ET.indent(scene)
    return '<?xml version="1.0"?>\n' + ET.tostring(scene, encoding="unicode") + "\n"


class _Loader(yaml.SafeLoader):
    """Reads Drake's !Rpy as the plain mapping below it."""


_Loader.add_constructor("!Rpy", lambda loader, node: loader.construct_mapping(node, deep=True))


def _append(scene: ET.Element, model: ET.Element, prefix: str) -> None:
    for element in model:
        if element.tag == "material":
            element = copy.deepcopy(element)
            element.set("name", f"{prefix}_{element.get('name')}")
        elif element.tag == "link":
            element = _renamed_link(element, prefix)
        elif element.tag == "joint":
            element = copy.deepcopy(element)
            element.set("name", f"{prefix}_{element.get('name')}")
            for end in element.iter():
                if end.tag in ("parent", "child"):
                    end.set("link", f"{prefix}_{end.get('link')}")
            _drop_drake(element)
        else:
            continue
        scene.append(element)


def _renamed_link(link: ET.Element, prefix: str) -> ET.Element:
    link = copy.deepcopy(link)
    link.set("name", f"{prefix}_{link.get('name')}")
    for part in [*link.findall("visual"), *link.findall("collision")]:
        material = part.find("material")
        if material is not None:
            material.set("name", f"{prefix}_{material.get('name')}")
        shape = next(part.iterfind("geometry/*"))
        if shape.tag == f"{DRAKE}capsule":
            for ball in (-0.5, 0.5):
                link.append(_capsule_end(part, shape, ball))
            shape.tag = "cylinder"
        elif shape.tag == f"{DRAKE}ellipsoid":
            radius = min(float(shape.get(axis)) for axis in "abc")
            shape.tag, shape.attrib = "sphere", {"radius": f"{radius:g}"}
    _drop_drake(link)
    return link


def _capsule_end(part: ET.Element, capsule: ET.Element, share: float) -> ET.Element:
    """The sphere at one end of a capsule: the same part, moved along the capsule's axis."""
    end = copy.deepcopy(part)
    end.set("name", f"{part.get('name')}_{'top' if share > 0 else 'bottom'}")
    origin = end.find("origin")
    if origin is None:
        origin = ET.SubElement(end, "origin")
    xyz = [float(value) for value in origin.get("xyz", "0 0 0").split()]
    rpy = [float(value) for value in origin.get("rpy", "0 0 0").split()]
    along = Rotation.from_euler("xyz", rpy).apply([0.0, 0.0, share * float(capsule.get("length"))])
    origin.set("xyz", " ".join(f"{a + b:.6g}" for a, b in zip(xyz, along, strict=True)))
    shape = next(end.iterfind("geometry/*"))
    shape.tag, shape.attrib = "sphere", {"radius": capsule.get("radius")}
    return end


def _drop_drake(element: ET.Element) -> None:
    for parent in list(element.iter()):
        for key in [key for key in parent.attrib if key.startswith(DRAKE)]:
            del parent.attrib[key]
        for child in [child for child in parent if isinstance(child.tag, str) and child.tag.startswith(DRAKE)]:
            parent.remove(child)


def _link(scene: ET.Element, name: str, look: Sequence[VisualPart], touched: Sequence[str]) -> str:
    """A link of visual parts, of which some, by their names, are what it is touched with, too."""
    link = ET.SubElement(scene, "link", name=name)
    for part in look:
        for kind in ("visual", "collision") if part.name in touched else ("visual",):
            element = ET.SubElement(link, kind, name=f"{name}_{part.name}")
            xyz = " ".join(f"{value:.6g}" for value in part.at)
            ET.SubElement(element, "origin", xyz=xyz, rpy=f"0 {part.tilt:.6g} 0")
            _add_shape(ET.SubElement(element, "geometry"), part.shape)
            if kind == "visual":
                # A material's name is the whole robot's: one for each colour.
                rgba = " ".join(f"{value:g}" for value in part.color)
                material = ET.SubElement(element, "material", name=f"colour_{rgba.replace(' ', '_')}")
                ET.SubElement(material, "color", rgba=rgba)
    return name


def _add_shape(geometry: ET.Element, shape: Box | Cylinder) -> None:
    if isinstance(shape, Box):
        ET.SubElement(geometry, "box", size=" ".join(f"{value:.6g}" for value in shape.size()))
    else:
        ET.SubElement(geometry, "cylinder", radius=f"{shape.radius():.6g}", length=f"{shape.length():.6g}")


def _fix(scene: ET.Element, child: str, xyz: str, rpy: str) -> None:
    joint = ET.SubElement(scene, "joint", name=f"world_to_{child}", type="fixed")
    ET.SubElement(joint, "origin", xyz=xyz, rpy=rpy)
    ET.SubElement(joint, "parent", link="world")
    ET.SubElement(joint, "child", link=child)
