"""URDF as far as playback needs it: links with what is drawn of them, and the joints between them."""

import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass, field

import numpy as np

from drake_blfdmp.errors import BlfDmpError
from drake_blfdmp.viewing.playback.poses import from_xyz_rpy

DEFAULT_COLOUR = (0.7, 0.7, 0.72, 1.0)
_MOVABLE = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True)
class Visual:
    """One shape of a link.

    Attributes:
        kind: box, cylinder (along z), sphere, capsule (along z) or mesh.
        size: box (3,) edges; cylinder and capsule radius, length; sphere radius; mesh scale (3,); m.
        X_LV: (4, 4) pose in the link.
        colour: red green blue alpha in [0, 1].
        mesh: where the mesh is, as the file has it; else empty.
        painted: whether the file says a colour; a mesh may bring its own otherwise.
    """

    kind: str
    size: tuple[float, ...]
    X_LV: np.ndarray
    colour: tuple[float, float, float, float] = DEFAULT_COLOUR
    mesh: str = ""
    painted: bool = True


@dataclass(frozen=True)
class Joint:
    """A joint; kinds that move by other than one number are as if fixed.

    Attributes:
        X_PJ: (4, 4) its frame in the parent link at rest.
        axis: (3,) unit, in the joint's frame.
        mimic: (joint, multiplier, offset) it follows; None for none.
    """

    name: str
    kind: str
    parent: str
    child: str
    X_PJ: np.ndarray
    axis: np.ndarray
    mimic: tuple[str, float, float] | None = None

    @property
    def movable(self) -> bool:
        """Whether one number moves it."""
        return self.kind in _MOVABLE


@dataclass(frozen=True)
class Robot:
    """What a description holds.

    Attributes:
        links: name -> its shapes.
        joints: child link -> the joint above it.
        warnings: what was left out, a line each.
    """

    name: str
    links: dict[str, list[Visual]] = field(default_factory=dict)
    joints: dict[str, Joint] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def parse_urdf(text: str, where: str) -> Robot:
    """Reads a URDF.

    Args:
        text: the XML.
        where: file and topic, for messages.

    Raises:
        BlfDmpError: it is no URDF, or a number in it is none.
    """
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise BlfDmpError(f"{where}: is no XML ({error}); record a URDF there") from None
    if root.tag != "robot":
        raise BlfDmpError(f"{where}: is <{root.tag}> in place of a URDF's <robot>; record a URDF there")
    warnings: list[str] = []
    try:
        colours = {
            material.get("name", ""): colour
            for material in root.findall("material")
            if (colour := _colour(material)) is not None
        }
        # A material may be defined in any visual and used by name in another.
        for material in root.findall("link/visual/material"):
            colour = _colour(material)
            if colour is not None:
                colours.setdefault(material.get("name", ""), colour)
        links = {link.get("name", ""): _visuals(link, colours, where, warnings) for link in root.findall("link")}
        joints = {joint.child: joint for joint in map(_joint, root.findall("joint"))}
    except ValueError as error:
        raise BlfDmpError(f"{where}: a number in the URDF cannot be read ({error}); repair the URDF") from None
    return Robot(root.get("name", ""), links, joints, tuple(warnings))


def _numbers(text: str | None, count: int, default: tuple[float, ...] = ()) -> tuple[float, ...]:
    if text is None:
        if not default:
            raise ValueError("an attribute is missing")
        return default
    numbers = tuple(float(part) for part in text.split())
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise ValueError(f"'{text}' are not {count} numbers")
    return numbers


def _origin(element: ElementTree.Element) -> np.ndarray:
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    zero = (0.0, 0.0, 0.0)
    return from_xyz_rpy(_numbers(origin.get("xyz"), 3, zero), _numbers(origin.get("rpy"), 3, zero))


def _colour(material: ElementTree.Element | None) -> tuple[float, float, float, float] | None:
    colour = None if material is None else material.find("color")
    if colour is None:
        return None
    red, green, blue, alpha = np.clip(_numbers(colour.get("rgba"), 4), 0.0, 1.0)
    return float(red), float(green), float(blue), float(alpha)


def _visuals(link: ElementTree.Element, colours: dict, where: str, warnings: list[str]) -> list[Visual]:
    visuals = []
    for visual in link.findall("visual"):
        geometry = visual.find("geometry")
        shape = next(iter(geometry), None) if geometry is not None else None
        if shape is None:
            continue
        material = visual.find("material")
        known = _colour(material) or (colours.get(material.get("name", "")) if material is not None else None)
        mesh = ""
        if shape.tag == "box":
            size = _numbers(shape.get("size"), 3)
        elif shape.tag in ("cylinder", "capsule"):
            size = (*_numbers(shape.get("radius"), 1), *_numbers(shape.get("length"), 1))
        elif shape.tag == "sphere":
            size = _numbers(shape.get("radius"), 1)
        elif shape.tag == "mesh":
            size, mesh = _numbers(shape.get("scale"), 3, (1.0, 1.0, 1.0)), shape.get("filename", "")
        else:
            warnings.append(f"{where}: link {link.get('name')}: a {shape.tag} is not drawn")
            continue
        colour = known or DEFAULT_COLOUR
        visuals.append(Visual(shape.tag, size, _origin(visual), colour, mesh, known is not None))
    return visuals


def _joint(joint: ElementTree.Element) -> Joint:
    parent, child, axis, mimic = (joint.find(tag) for tag in ("parent", "child", "axis", "mimic"))
    if parent is None or child is None:
        raise ValueError(f"joint {joint.get('name')} lacks a parent or a child")
    direction = np.array(_numbers(None if axis is None else axis.get("xyz"), 3, (1.0, 0.0, 0.0)))
    norm = float(np.linalg.norm(direction))
    follows = None
    if mimic is not None:
        multiplier, offset = _numbers(mimic.get("multiplier"), 1, (1.0,)), _numbers(mimic.get("offset"), 1, (0.0,))
        follows = (mimic.get("joint", ""), multiplier[0], offset[0])
    return Joint(
        joint.get("name", ""),
        joint.get("type", "fixed"),
        parent.get("link", ""),
        child.get("link", ""),
        _origin(joint),
        direction / norm if norm > 0.0 else np.array([1.0, 0.0, 0.0]),
        follows,
    )
