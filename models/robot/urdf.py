"""A URDF's links and joints as they stand, each number checked; nothing is merged yet."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from xml.etree.ElementTree import Element, SubElement, TreeBuilder, tostring
from xml.parsers import expat

import numpy as np

from crosscheck.models.errors import InputError
from crosscheck.models.file_kind import describe_xml_kind
from crosscheck.models.files import EXPAND
from crosscheck.models.inputs import doubt_degrees
from crosscheck.models.robot.chains import CHAINS, build_chain
from crosscheck.models.robot.robot import JointLimits, Placement, RobotBody

DEEPEST = 50  # elements in each other; those of a URDF are four deep
JOINT_TYPES = ("revolute", "continuous", "prismatic", "fixed")  # each of one degree or none
XACRO = f"xacro is left in it; {EXPAND}"
# Elements that are read, those in them, and the numbers that Pinocchio needs in these.
READ_CHILDREN: dict[str, dict[str, tuple[str, ...]]] = {
    "link": {"inertial": ()},
    "joint": {
        **dict.fromkeys(("parent", "child", "origin", "axis", "mimic"), ()),
        "limit": ("effort", "velocity"),
        "dynamics": ("damping",),
    },
    "passive_joint": {},
}
LARGEST = 1e18  # largest limit, which some files state where there is none
HEAVIEST = 1e9  # largest mass [kg], as for an arm
LARGEST_INERTIA, FARTHEST = 1e15, 1e3  # [kg m^2], and of a component of a place, an angle, an axis
MOST_DAMPING = 1e12  # [N m s/rad], [N s/m], as of an arm's friction
LARGEST_MULTIPLIER = 1e6  # largest multiplier of a joint that follows another, as for a ratio
# Numbers as urdfdom, which many programs use, reads them: blanks before them alone.
NUMBER = re.compile(r"[ \t\n\v\f\r]*[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


@dataclass(frozen=True)
class UrdfLink:
    """A link of a URDF; body is None where it has no inertia.

    six: its numbers ixx, ixy, ixz, iyy, iyz, izz [kg m^2] as they stand; turn (3, 3): the rotation
    of the axes in which they stand, by their rpy.
    """

    name: str
    body: RobotBody | None
    six: tuple[float, ...] = ()
    turn: np.ndarray = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True)
class UrdfJoint:
    """A joint of a URDF; mimic: the name of another, multiplier and offset.

    damping [N m s/rad] or [N s/m]: of its dynamics, 0 where it is not asked for; armature [kg m^2]
    or [kg]: of the same element; has_motor: whether the file has no passive_joint of its name.
    """

    name: str
    kind: str
    parent: str
    child: str
    placement: Placement
    axis: np.ndarray
    limits: JointLimits
    mimic: tuple[str, float, float] | None
    damping: float = 0.0
    armature: float = 0.0
    has_motor: bool = True


@dataclass(frozen=True)
class Urdf:
    """Links and joints of a URDF in the file's order, chains in place of joints of several degrees.

    text: of these alone, without shapes and without elements of other programs; notes: what of the
    file is not used; gears: joints and what is stated of their gears besides, which a robot's own
    file may take.
    """

    links: tuple[UrdfLink, ...]
    joints: tuple[UrdfJoint, ...]
    text: str
    notes: tuple[str, ...]
    gears: tuple[tuple[str, str], ...] = ()


def read_urdf(
    text: str,
    where: str,
    masses: Mapping[str, float] | None = None,
    *,
    include_damping: bool = False,
    is_bounded: bool = True,
) -> Urdf:
    """The links and joints of a URDF; masses [kg]: in place of its own, by links' names.

    include_damping: whether the damping of joints is read; is_bounded: whether masses and inertias
    must be those of robots, which an arm with a locked joint exceeds. Raises InputError.
    """
    root = read_root(text, where)
    chain_notes = list(_expand_joints(root, where))
    for tag in ("link", "joint"):
        names = Counter(each.get("name", "") for each in root.findall(tag))
        for name, count in names.items():
            if not name.strip() or not name.isprintable() or count > 1:
                allowed = f"must have a printable name of its own; {count} have this one"
                raise InputError(where, tag, name, allowed)
    for link in root.findall("link"):
        mass = (masses or {}).get(link.get("name", ""))
        for element in link.findall("inertial/mass") if mass is not None else ():
            element.set("value", repr(mass))
    links = tuple(_Reader(where, each).link(is_bounded) for each in root.findall("link"))
    joints = tuple(_Reader(where, each).joint(include_damping) for each in root.findall("joint"))
    passive = [each.get("name", "") for each in root.findall("passive_joint")]
    for name in passive:
        if name not in [joint.name for joint in joints]:
            raise InputError(where, "passive_joint", name, "must be a joint of it")
    joints = tuple(replace(each, has_motor=each.name not in passive) for each in joints)
    notes = [
        *chain_notes,
        *_find_unused(root, ("friction",) if include_damping else ("friction", "damping")),
    ]
    notes += [each.get("text", "") for each in root.iterfind("mjcf/note")]
    gears = tuple(
        (each.get("joint", ""), f"gear {float(each.get('value', '')):g} of {each.get('of')}")
        for each in root.iterfind("mjcf/gear")
    )
    return Urdf(links, joints, _mechanism(root), tuple(notes), gears)


def _expand_joints(root: Element, where: str) -> Iterator[str]:
    """Put chains in place of joints of several degrees of freedom, in place; yields notes."""
    for joint in root.findall("joint"):
        if joint.get("type") in CHAINS:
            if joint.find("mimic") is not None:
                field = f"joint {joint.get('name')}: mimic"
                raise InputError(where, field, None, "must be of a joint that only turns or slides")
            place = list(root).index(joint)
            root[place : place + 1], notes = build_chain(joint, _Reader(where, joint).axis())
            yield from notes


def read_root(text: str, where: str) -> Element:
    """The outermost element of a URDF, robot. Raises InputError."""
    root = _Parser(where).root(text)
    if root.tag != "robot":
        allowed = f"is {describe_xml_kind(text)}; must be a URDF, whose outermost element is robot"
        raise InputError(where, root.tag, None, allowed)
    return root


class _Parser:
    """Parser of an XML text into elements; declarations of documents and entities are refused."""

    def __init__(self, where: str) -> None:
        self.where, self.depth, self.builder = where, 0, TreeBuilder()
        self.parser = expat.ParserCreate("utf-8")
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._doctype

    def root(self, text: str) -> Element:
        """The outermost element. Raises InputError."""
        try:
            self.parser.Parse(text.encode("utf-8"), True)
        except expat.ExpatError as error:
            raise InputError(self.where, "", None, f"is not XML: {error}") from None
        return self.builder.close()

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.depth += 1
        line = f"line {self.parser.CurrentLineNumber}"
        if self.depth > DEEPEST:
            allowed = f"elements must be at most {DEEPEST} deep in each other"
            raise InputError(self.where, line, None, allowed)
        if tag.startswith("xacro:"):
            raise InputError(self.where, f"{line}, {tag}", None, XACRO)
        if tag == "transmission":  # the only elements whose text is read
            self.parser.CharacterDataHandler = self.builder.data
        self.builder.start(tag, attributes)

    def _end(self, tag: str) -> None:
        self.depth -= 1
        if tag == "transmission":
            self.parser.CharacterDataHandler = None
        self.builder.end(tag)

    def _doctype(self, name: str, *identifiers: object) -> None:
        raise InputError(self.where, "DOCTYPE", name, "must not be there: a URDF needs no entities")


class _Reader:
    """Reader of the numbers of one link or joint; errors name it."""

    def __init__(self, where: str, element: Element) -> None:
        self.where, self.element = where, element
        self.name = element.get("name", "")

    def link(self, is_bounded: bool) -> UrdfLink:
        inertial = self.element.find("inertial")
        if inertial is None:
            return UrdfLink(self.name, None)
        placement = self._placement(inertial)
        mass_at, inertia_at = inertial.find("mass"), inertial.find("inertia")
        most, heaviest = (LARGEST, HEAVIEST) if is_bounded else (np.inf, np.inf)
        mass = self._number(mass_at, "mass.value", required=True, most=most)
        if not 0 <= mass <= heaviest:
            raise self._error("mass.value", mass, f"must be 0 to {HEAVIEST:g} kg")
        six = tuple(
            self._number(inertia_at, f"inertia.{key}", required=True, most=most)
            for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        if is_bounded and max(map(abs, six)) > LARGEST_INERTIA:
            allowed = f"must be of at most {LARGEST_INERTIA:g} kg m^2"
            raise self._error("inertia", None, allowed)
        ixx, ixy, ixz, iyy, iyz, izz = six
        tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        turned = placement.rotation @ tensor @ placement.rotation.T
        body = RobotBody(mass, placement.position, turned)
        there = body if mass or tensor.any() else None
        return UrdfLink(self.name, there, six, placement.rotation)

    def joint(self, include_damping: bool) -> UrdfJoint:
        kind = self.element.get("type")
        if kind not in JOINT_TYPES:
            kinds = ", ".join((*JOINT_TYPES, *CHAINS))
            raise self._error("type", kind, f"must be one of {kinds}")
        moves = kind != "fixed"
        return UrdfJoint(
            self.name,
            kind,
            self._read_name("parent", "link"),
            self._read_name("child", "link"),
            self._placement(self.element),
            self.axis() if moves else np.array([1.0, 0.0, 0.0]),
            self._limits(kind),
            self._mimic() if moves else None,
            self._dynamics("damping", MOST_DAMPING) if moves and include_damping else 0.0,
            self._dynamics("armature", LARGEST_INERTIA) if moves else 0.0,
        )

    def axis(self) -> np.ndarray:
        """Unit vector of the joint's axis; x where none is given."""
        axis = np.array(self._numbers(self.element.find("axis"), "axis.xyz", (1.0, 0.0, 0.0)))
        length = np.linalg.norm(axis)
        if not 1e-3 < length < 1e3:
            raise self._error("axis.xyz", axis.tolist(), "must have a length of 1e-3 to 1e3")
        return axis / length

    def _limits(self, kind: str) -> JointLimits:
        limit = self.element.find("limit")
        if limit is None and kind in ("revolute", "prismatic"):
            allowed = f"is missing; a {kind} joint needs one, with lower, upper, velocity, effort"
            other = ', or has type="continuous"' if kind == "revolute" else ""
            raise self._error("limit", None, f"{allowed}{other}")
        if limit is None:
            return JointLimits(-math.inf, math.inf, math.inf, math.inf)
        lower, upper = -math.inf, math.inf
        if kind != "continuous":
            lower, upper = self._number(limit, "limit.lower"), self._number(limit, "limit.upper")
            if lower > upper:
                raise self._error("limit.lower", lower, f"must be at most upper = {upper:g}")
        most = [self._number(limit, f"limit.{key}") for key in ("velocity", "effort")]
        for key, value in zip(("velocity", "effort"), most, strict=True):
            if value < 0:
                raise self._error(f"limit.{key}", value, "must not be negative")
        # Many files hold 0 where nothing is known.
        return JointLimits(lower, upper, *(each if each > 0 else math.inf for each in most))

    def _dynamics(self, key: str, most: float) -> float:
        number = self._number(self.element.find("dynamics"), f"dynamics.{key}", most=most)
        if number < 0:
            raise self._error(f"dynamics.{key}", number, "must not be negative")
        return number

    def _mimic(self) -> tuple[str, float, float] | None:
        mimic = self.element.find("mimic")
        if mimic is None:
            return None
        multiplier = self._number(mimic, "mimic.multiplier", 1.0, most=LARGEST_MULTIPLIER)
        offset = self._number(mimic, "mimic.offset", most=FARTHEST)
        return self._read_name("mimic", "joint"), multiplier, offset

    def _placement(self, element: Element) -> Placement:
        origin = element.find("origin")
        position = np.array(self._numbers(origin, "origin.xyz", (0.0, 0.0, 0.0)))
        rpy = roll, pitch, yaw = self._numbers(origin, "origin.rpy", (0.0, 0.0, 0.0))
        doubt_degrees(self.where, f"{self.element.tag} {self.name}: origin.rpy", rpy)
        return Placement(
            _axis_rotation(2, yaw) @ _axis_rotation(1, pitch) @ _axis_rotation(0, roll), position
        )

    def _read_name(self, tag: str, key: str) -> str:
        child = self.element.find(tag)
        name = None if child is None else child.get(key)
        if name is None:
            raise self._error(f"{tag}.{key}", None, "is missing; a name is required")
        return name

    def _number(
        self,
        element: Element | None,
        field: str,
        default: float = 0.0,
        required: bool = False,
        most: float = LARGEST,
    ) -> float:
        text = None if element is None else element.get(field.split(".")[1])
        if text is None and not required:
            return default
        (number,) = self._parse_numbers(text, field, 1, most)
        return number

    def _numbers(
        self, element: Element | None, field: str, default: tuple[float, float, float]
    ) -> tuple[float, ...]:
        text = None if element is None else element.get(field.split(".")[1])
        return default if text is None else self._parse_numbers(text, field, 3, FARTHEST)

    def _parse_numbers(
        self, text: str | None, field: str, count: int, most: float
    ) -> tuple[float, ...]:
        expected = "a number" if count == 1 else f"{count} numbers"
        if text is None:
            raise self._error(field, None, f"is missing; must be {expected}")
        words = [text] if count == 1 else [word for word in text.split(" ") if word]
        if not all(NUMBER.fullmatch(word) for word in words):
            allowed = XACRO if "${" in text else f"must be {expected}, such as 0.5 or 1e-3"
            raise self._error(field, text, allowed)
        numbers = tuple(map(float, words))
        if len(numbers) != count or not all(abs(each) <= most for each in numbers):
            raise self._error(field, text, f"must be {expected} of at most {most:g}")
        return numbers

    def _error(self, field: str, value: object, allowed: str) -> InputError:
        return InputError(self.where, f"{self.element.tag} {self.name}: {field}", value, allowed)


def _axis_rotation(axis: int, angle: float) -> np.ndarray:
    """Rotation (3, 3) about a coordinate axis."""
    c, s = math.cos(angle), math.sin(angle)
    following, last = (axis + 1) % 3, (axis + 2) % 3
    turned = np.eye(3)
    turned[following, following] = turned[last, last] = c
    turned[last, following], turned[following, last] = s, -s
    return turned


def roll_pitch_yaw(rotation: np.ndarray) -> np.ndarray:
    """The rpy (3,) [rad] of a rotation (3, 3), as URDFs state it.

    Yaw is that of the rotation with its roll undone: so where the pitch is a right angle, and only
    a sum of roll and yaw counts, whatever rounding makes of the roll is made up for.
    """
    roll = math.atan2(rotation[2, 1], rotation[2, 2])
    pitch = math.atan2(-rotation[2, 0], math.hypot(rotation[2, 1], rotation[2, 2]))
    (_, x, y), (_, u, w) = rotation[0], rotation[1]
    c, s = math.cos(roll), math.sin(roll)
    return np.array([roll, pitch, math.atan2(s * y - c * x, c * u - s * w)])


def _mechanism(root: Element) -> str:
    """Text of a URDF's links and joints alone, with what is read of each.

    So a program that reads it meets no number that is not checked here, and no line break inside
    of an attribute, which XML takes for a blank. Pinocchio's parser refuses limits and dynamics
    that lack one of their numbers; here they are 0 then.
    """
    kept = Element("robot", name=root.get("name", "robot"))
    for element in root:
        if element.tag in READ_CHILDREN:
            copy = SubElement(kept, element.tag, element.attrib)
            for tag, numbers in READ_CHILDREN[element.tag].items():
                for child in element.findall(tag)[:1]:
                    child.attrib.update({key: child.get(key, "0") for key in numbers})
                    copy.append(child)
    return tostring(kept, encoding="unicode")


def _is_zero(text: str) -> bool:
    """Whether a number, or nothing, is written and is zero."""
    return not text.strip() or (bool(NUMBER.fullmatch(text)) and float(text) == 0)


def _find_unused(root: Element, dynamics_keys: Sequence[str]) -> Iterator[str]:
    """Lines about what of the file is not used; dynamics_keys: what of joints' dynamics."""
    for key in dynamics_keys:
        names = [
            each.get("name", "")
            for each in root.findall("joint")
            for dynamics in each.findall("dynamics")
            if not _is_zero(dynamics.get(key, "0"))
        ]
        if names:
            remedy = "" if key == "friction" else '; friction = "from-urdf" in a robot file uses it'
            yield f"{key} of {', '.join(names)} is not used{remedy}"
    meshes = sum(1 for _ in root.iter("mesh"))
    if meshes:
        yield f"mesh files ({meshes}) are neither needed nor read"
    others = sorted(
        {each.tag for each in root} - {"link", "joint", "material", "mjcf", "passive_joint"}
    )
    if others:
        yield f"elements not used: {', '.join(others)}"
