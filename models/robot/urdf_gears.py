"""Gears where a URDF states them: in transmissions, in Drake's elements, and in dynamics.

In one that stands for an MJCF file, also those of actuators.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from crosscheck.models.errors import InputError
from crosscheck.models.robot.urdf import NUMBER, read_root

LARGEST_RATIO, LEAST_INERTIA, LARGEST_INERTIA = 1e6, 1e-24, 1e15
# Elements of a transmission that state numbers of its joint, for any program.
RATIO_TAGS = ("mechanicalReduction", "mechanical_reduction", "drake:gear_ratio")
INERTIA_TAGS = ("motorInertia", "motor_inertia", "drake:rotor_inertia")


@dataclass(frozen=True)
class StatedNumber:
    """A number of a URDF; element: where it stands; word: what it is called there, if not ratio."""

    value: float
    element: str
    word: str = ""


@dataclass(frozen=True)
class StatedGear:
    """The gear of a joint as a URDF states it; None where it states nothing.

    ratio: of the motor's rate over the joint's; inertia: of the rotor [kg m^2]; armature: the same
    times the ratio squared, as the joint feels it.
    """

    ratio: StatedNumber | None = None
    inertia: StatedNumber | None = None
    armature: StatedNumber | None = None

    @property
    def elements(self) -> str:
        """Elements that state gear numbers, with these numbers."""
        stated = (("ratio", self.ratio, ""), ("rotor", self.inertia, " kg m^2"))
        parts = [*stated, ("armature", self.armature, " kg m^2")]
        return ", ".join(
            f"{s.word or n} {s.value:g}{unit} of {s.element}" for n, s, unit in parts if s
        )

    @property
    def table(self) -> dict[str, object]:
        """The table of a rotor in a robot's file; empty if not enough is stated for one.

        The rotor's inertia follows from the armature where that alone is stated.
        """
        stated = self.inertia or self.armature
        if self.ratio is None or stated is None:
            return {}
        ratio = self.ratio.value
        inertia = stated.value if self.inertia else stated.value / ratio**2
        return {"kind": "geared", "ratio": ratio, "rotor_inertia_kg_m2": inertia}


def read_gears(text: str, where: str) -> tuple[dict[str, StatedGear], list[str]]:
    """The gears of a URDF by the names of joints, and lines on those left out.

    Numbers of 0 count as not stated, as of limits. Raises InputError.
    """
    root = read_root(text, where)
    joints = {each.get("name", ""): each for each in root.findall("joint")}
    stated: dict[str, dict[str, StatedNumber]] = {}
    left_out = []
    for transmission in root.iter("transmission"):
        name = f"transmission {transmission.get('name', '')}".rstrip()
        turned = dict.fromkeys(each.get("name", "") for each in transmission.findall("joint"))
        if len(turned) > 1:
            joined = ", ".join(turned)
            left_out.append(f"{name} left out: of {joined}, and a rotor here turns with one joint")
        if len(turned) != 1:
            continue
        (joint,) = turned
        if joint not in joints:
            raise InputError(where, f"{name}: joint", joint, "must be a joint of the URDF")
        for field, number in _transmission_numbers(transmission, name, where):
            _add_number(stated.setdefault(joint, {}), field, number, where)
    for gear in root.iterfind("mjcf/gear"):
        number = StatedNumber(float(gear.get("value", "")), gear.get("of", ""), "gear")
        _add_number(stated.setdefault(gear.get("joint", ""), {}), "ratio", number, where)
    is_mjcf = root.find("mjcf") is not None
    for joint, element in joints.items():
        for dynamics in element.findall("dynamics"):
            place = f"joint {joint}" if is_mjcf else f"joint {joint}: dynamics.armature"
            armature = _read_number(dynamics.get("armature"), place, where)
            if armature is not None:
                _add_number(stated.setdefault(joint, {}), "armature", armature, where)
    return {joint: StatedGear(**numbers) for joint, numbers in stated.items()}, left_out


def _transmission_numbers(
    transmission: Element, name: str, where: str
) -> Iterator[tuple[str, StatedNumber]]:
    """Numbers of a transmission of one joint, with the names of fields of StatedGear."""
    for field, tags in (("ratio", RATIO_TAGS), ("inertia", INERTIA_TAGS)):
        for tag in tags:
            for element in transmission.iter(tag):
                number = _read_number(element.get("value", element.text), f"{name}: {tag}", where)
                if number is not None:
                    yield field, number


def _read_number(text: str | None, place: str, where: str) -> StatedNumber | None:
    """The number of an element, None where there is none or it is 0. Raises InputError."""
    words = (text or "").strip()
    if not words:
        return None
    if not NUMBER.fullmatch(words):
        raise InputError(where, place, words, "must be a number, such as 100 or 1e-4")
    return StatedNumber(float(words), place) if float(words) else None


def _add_number(
    numbers: dict[str, StatedNumber], field: str, number: StatedNumber, where: str
) -> None:
    """Add a number that is stated once, or twice with one value. Raises InputError."""
    size = abs(number.value) if field == "ratio" else number.value
    least, most = (0.0, LARGEST_RATIO) if field == "ratio" else (LEAST_INERTIA, LARGEST_INERTIA)
    if not least <= size <= most:
        unit = "in size" if field == "ratio" else "kg m^2"
        allowed = f"must be {least:g} to {most:g} {unit}"
        raise InputError(where, number.element, number.value, allowed)
    other = numbers.setdefault(field, number)
    if other.value != number.value:
        allowed = f"must be the {other.value:g} of {other.element}, which is of the same joint"
        raise InputError(where, number.element, number.value, allowed)
