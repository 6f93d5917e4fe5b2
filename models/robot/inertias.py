"""Links of a URDF that are no possible bodies: which, why, and the likeliest repair."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from crosscheck.models.robot.robot import BASE, Joint, LinkFrame, RobotBody, Rotor
from crosscheck.models.robot.urdf import UrdfLink

# Share of the largest principal inertia that rounding of printed digits explains.
ROUNDED = 1e-6
# A body whose radius of gyration is so many times the robot's size, and which is lighter than air
# would be that filled a cube of it [kg/m^3], is none: mass or inertia is in another unit.
FARTHEST_OUT, THINNEST = 10.0, 1.0
# Mass over the median of the others', and a rotor's inertia at its joint over that of all links
# stretched out, at which another unit is likely.
HEAVIER = 1000.0
MEASURED = 1.25  # a last principal inertia that exceeds the others' sum by less is no slip
SLOTS, DIAGONAL = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), [0, 3, 5]
# Orders in which the six numbers may have been written, by what then stands in each slot.
ORDERS = {
    "ixx, iyy, izz, ixy, ixz, iyz": (0, 3, 4, 1, 5, 2),
    "ixx, iyy, izz, ixy, iyz, ixz": (0, 3, 5, 1, 4, 2),
    "ixx, ixy, iyy, ixz, iyz, izz": (0, 1, 3, 2, 4, 5),
}
DECADES = (-1, 1, -2, 2, -3, 3)  # powers of ten by which one number may be off
UNITS = {1e-3: "g m^2", 1e-4: "kg cm^2", 1e-6: "kg mm^2", 1e-7: "g cm^2", 1e-9: "g mm^2"}
MACHINE = 3e4  # mass over its radius of gyration cubed [kg/m^3], of a solid cube of 2000 kg/m^3
SIDES = (("left", "right"), ("Left", "Right"), ("LEFT", "RIGHT"), ("l", "r"), ("L", "R"))


@dataclass(frozen=True)
class InertiaDoubt:
    """A link whose mass or inertia no body has; repair: the likeliest one, in words; or none.

    is_fatal: whether no model can be made of it.
    """

    link: str
    reason: str
    repair: str = ""
    is_fatal: bool = False


def remove_dust(links: Sequence[UrdfLink], size: float) -> tuple[UrdfLink, ...]:
    """The links, with inertias set to zero that are rounding beside their masses.

    size [m]: of the robot.
    """
    return tuple(
        replace(link, body=replace(link.body, inertia=np.zeros((3, 3))))
        if link.body is not None and _is_dust(link.body, size)
        else link
        for link in links
    )


def _is_dust(body: RobotBody, size: float) -> bool:
    largest = np.abs(body.inertia).max()
    return bool(0 < largest < np.finfo(float).eps * body.mass * size**2)


def find_inertia_doubts(
    links: Sequence[UrdfLink],
    frames: dict[str, LinkFrame],
    joints: Sequence[Joint],
    bodies: Sequence[RobotBody],
) -> Iterator[InertiaDoubt]:
    """A doubt for every moving link whose mass or inertia no body has, in the file's order."""
    size = measure_reach(joints, bodies)
    moving = [link for link in links if link.body is not None and frames[link.name].body != BASE]
    yield from _find_heavy_links(moving)
    for link in moving:
        assert link.body is not None  # as is chosen
        if _is_dust(link.body, size):
            reason = f"an inertia of {format_values(link.six)} kg m^2 is rounding; used as zero"
            yield InertiaDoubt(link.name, reason)
            continue
        values = np.linalg.eigvalsh(link.body.inertia)
        if link.body.mass == 0 and values[-1] > 0:
            yield InertiaDoubt(link.name, "an inertia without mass; used as given")
        if is_negative(values):
            reason = (
                f"must not be negative; its principal values are {format_values(values)} kg m^2"
            )
            yield InertiaDoubt(link.name, reason, _find_repair(link, links), is_fatal=True)
        elif not is_possible(values):
            reason = (
                f"no body has principal inertias {format_values(values)} kg m^2, of which the last"
                " exceeds the others' sum; used as given"
            )
            yield InertiaDoubt(link.name, reason, _find_repair(link, links))
        if link.body.mass > 0 and _is_thin(link.body, bodies[frames[link.name].body], size):
            radii = np.sqrt(np.maximum(values, 0.0) / link.body.mass)
            reason = (
                f"radii of gyration of {format_values(radii, 2)} m on a robot of {size:.2g} m: mass"
                " and inertia do not belong together; used as given"
            )
            yield InertiaDoubt(link.name, reason, _find_unit(link.body.mass, radii[-1]))


def _find_heavy_links(links: Sequence[UrdfLink]) -> Iterator[InertiaDoubt]:
    """A doubt for every link that is far heavier than the others, of three at least."""
    masses = {link.name: link.body.mass for link in links if link.body and link.body.mass}
    for name, mass in masses.items() if len(masses) > 2 else ():
        median = float(np.median([other for link, other in masses.items() if link != name]))
        if mass > HEAVIER * median:
            reason = (
                f"{mass:.4g} kg is {mass / median:.2g} times the median of the others,"
                f" {median:.3g} kg; used as given"
            )
            yield InertiaDoubt(name, reason)


def describe_heavy_rotors(
    rotors: Sequence[Rotor], joints: Sequence[Joint], bodies: Sequence[RobotBody]
) -> Iterator[str]:
    """A line on rotors with far more inertia at their joints than all links stretched out."""
    mass, size = sum(body.mass for body in bodies), measure_reach(joints, bodies)
    whole = mass * size**2 + sum(float(np.linalg.eigvalsh(body.inertia)[-1]) for body in bodies)
    heavy = dict[tuple[float, str], list[tuple[str, str, str]]]()
    for rotor in rotors:
        joint, reflected = joints[rotor.joint], rotor.ratio**2 * rotor.inertia
        links, unit = (mass, "kg") if joint.kind == "prismatic" else (whole, "kg m^2")
        if reflected > HEAVIER * links:
            row = joint.name, f"{rotor.inertia:.4g}", f"{reflected:.2g}"
            heavy.setdefault((links, unit), []).append(row)
    for (links, unit), rows in heavy.items():
        names, own, at_joints = (", ".join(dict.fromkeys(each)) for each in zip(*rows, strict=True))
        words = ("joints", "their rotors", "are") if rows[1:] else ("joint", "its rotor", "is")
        place, its, verb = words
        yield (
            f"{place} {names}: {its} of {own} kg m^2 {verb} {at_joints} {unit} at the {place},"
            f" beside at most {links:.2g} {unit} of all links; used as given"
        )


def is_negative(values: np.ndarray) -> bool:
    """Whether a principal inertia is below zero, by more than rounding; zero may be."""
    return bool(values[0] < -ROUNDED * abs(values[-1]))


def is_possible(values: np.ndarray) -> bool:
    """Whether a body has such principal inertias, the smallest first."""
    return not is_negative(values) and bool(values[0] + values[1] >= values[2] * (1 - ROUNDED))


def format_values(values: Sequence[float] | np.ndarray, digits: int = 3) -> str:
    """Numbers in a list."""
    return ", ".join(f"{each:.{digits}g}" for each in values)


def _is_body(six: Sequence[float] | np.ndarray) -> bool:
    """Whether a body has the inertia of these six numbers."""
    ixx, ixy, ixz, iyy, iyz, izz = six
    return is_possible(np.linalg.eigvalsh([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]))


def _find_repair(link: UrdfLink, links: Sequence[UrdfLink]) -> str:
    """The first that makes a body: the twin's numbers, another order, a power of ten, a sign."""
    six = np.array(link.six)
    values = np.linalg.eigvalsh(link.body.inertia) if link.body else np.zeros(3)
    if values[0] > 0 and values[2] < MEASURED * (values[0] + values[1]):
        beyond = 100 * (values[2] / (values[0] + values[1]) - 1)
        return f"probably measured or rounded: {beyond:.2g} % too large"
    by_name = {each.name: each for each in links}
    for name in _find_twins(link.name):
        twin = by_name.get(name)
        if twin is not None and twin.body is not None and _is_body(twin.six):
            six_of_twin = (f"{slot} {value:g}" for slot, value in zip(SLOTS, twin.six, strict=True))
            return f"its twin {name} has {', '.join(six_of_twin)}, which is possible"
    for order, slots in ORDERS.items():
        if any(six[[1, 2, 4]]) and _is_body(six[list(slots)]):
            return f"possible if they are {order}"
    for decade, slot in product(DECADES, range(len(SLOTS))):
        changed = six.copy()
        changed[slot] *= 10.0**decade
        if six[slot] and _is_body(changed):
            return f"possible if {SLOTS[slot]} is {changed[slot]:g}"
    without_signs = six.copy()
    without_signs[DIAGONAL] = np.abs(six[DIAGONAL])
    if _is_body(without_signs):
        return "possible without the signs of ixx, iyy and izz"
    return ""


def _find_twins(name: str) -> Iterator[str]:
    """Names that the link on the other side may have."""
    for pair in SIDES:
        for side, other in (pair, pair[::-1]):
            pattern = side if len(side) > 1 else rf"(?<![A-Za-z]){side}(?![A-Za-z])"
            twin = re.sub(pattern, other, name)
            if twin != name:
                yield twin


def _find_unit(mass: float, radius: float) -> str:
    """The unit in which a solid body's inertia comes closest to a machine's."""

    def distance(factor: float) -> float:
        return abs(float(np.log(mass / (radius * factor**0.5) ** 3 / MACHINE)))

    factor = min(UNITS, key=distance)
    return f"the inertia may be in {UNITS[factor]}: times {factor:g}"


def _is_thin(body: RobotBody, whole: RobotBody, size: float) -> bool:
    """Whether a link's inertia is most of its body's and far too large for its mass."""
    radius = np.sqrt(max(np.linalg.eigvalsh(body.inertia)[-1], 0.0) / body.mass)
    matters = np.trace(body.inertia) > np.trace(whole.inertia) / 2
    return bool(matters and radius > FARTHEST_OUT * size and body.mass < THINNEST * radius**3)


def measure_reach(joints: Sequence[Joint], bodies: Sequence[RobotBody]) -> float:
    """The largest distance of a mass centre from the base [m], chains stretched, slides at zero."""
    lengths: list[float] = []
    for joint in joints:
        under = 0.0 if joint.parent == BASE else lengths[joint.parent]
        lengths.append(under + float(np.linalg.norm(joint.placement.position)))
    ends = zip(lengths, bodies, strict=True)
    return max(length + float(np.linalg.norm(body.com)) for length, body in ends)
