"""Joints of several degrees of freedom as chains of joints with one each, by links without mass."""

from __future__ import annotations

from typing import NamedTuple
from xml.etree.ElementTree import Element, SubElement

import numpy as np

# Suffixes of the coordinates: slides along x and y of a plane or x, y, z; then the angles of the
# rotation Rz(yaw) Ry(pitch) Rx(roll), or of a plane's about its normal.
CHAINS = {
    "floating": ("x", "y", "z", "yaw", "pitch", "roll"),
    "planar": ("x", "y", "yaw"),
    "ball": ("yaw", "pitch", "roll"),
}
AXES = {"x": 0, "y": 1, "z": 2, "yaw": 2, "pitch": 1, "roll": 0}
UNLIMITED = 1e18  # limit of a sliding joint without limits, as in URDFs
DRAWN_DEG = 70  # largest angle between two others that states have, which are singular at 90


class JointChain(NamedTuple):
    """A joint's chain, as elements of a URDF: joints, links and passive joints; what to know."""

    elements: list[Element]
    notes: list[str]


def build_chain(joint: Element, normal: np.ndarray) -> JointChain:
    """The chain of a URDF's joint of several degrees of freedom; normal (3,): of a planar one.

    No motor drives its joints. The placement is that of the first, and the last moves the child.
    """
    name, kind = joint.get("name", ""), joint.get("type", "")
    axes = _complete_axes(normal) if kind == "planar" else np.eye(3)
    names = [f"{name}_{suffix}" for suffix in CHAINS[kind]]
    elements = list[Element]()
    for number, (part, suffix) in enumerate(zip(names, CHAINS[kind], strict=True)):
        slides, is_middle = suffix in ("x", "y", "z"), suffix == "pitch"
        moves = "prismatic" if slides else "revolute" if is_middle else "continuous"
        step = Element("joint", name=part, type=moves)
        if number == 0:
            step.extend([*joint.findall("parent"), *joint.findall("origin")])
        else:
            SubElement(step, "parent", link=names[number - 1])
        if part == names[-1]:
            step.extend(joint.findall("child"))
        else:
            SubElement(step, "child", link=part)
            elements.append(Element("link", name=part))
        axis = axes[AXES[suffix]]
        SubElement(step, "axis", xyz=" ".join(repr(float(each)) for each in axis))
        most = repr(UNLIMITED if slides else float(np.radians(DRAWN_DEG)))
        if moves != "continuous":
            ends = {"lower": f"-{most}", "upper": most}
            SubElement(step, "limit", {**ends, "velocity": "0", "effort": "0"})
        elements += [step, Element("passive_joint", name=part)]
    notes = [f"joint {name} is {kind}: its coordinates are {', '.join(names)}"]
    if "pitch" in CHAINS[kind]:
        notes[0] += (
            f", where yaw turns about z, then pitch about y, then roll about x; {name}_pitch has"
            f" poles at +-90 degrees, and states have at most {DRAWN_DEG}"
        )
    if any(
        value.strip("-+0. ") for each in joint.findall("dynamics") for value in each.attrib.values()
    ):
        notes.append(f"dynamics of joint {name}, which is {kind}, are not used")
    return JointChain(elements, notes)


def _complete_axes(normal: np.ndarray) -> np.ndarray:
    """Unit vectors (3, 3) as rows: two in a plane, right-handed with its normal, which is the last.

    Of a coordinate axis they are the two that follow it, of z so x and y.
    """
    across = np.eye(3)[(int(np.abs(normal).argmax()) + 1) % 3]
    first = across - normal @ across * normal
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(normal, first), normal])
