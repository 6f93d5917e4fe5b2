"""Arms of one to seven joints of every kind, for what holds of all of them.

Their numbers are rolled by a seed, or drawn by Hypothesis (``tests.any_arms``).
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from math import pi
from typing import Any, NamedTuple, TypeVar

import numpy as np

from crosscheck.models.arm.arm import Arm, Direct, Link, Planetary
from crosscheck.models.arm.mesh import FROM_TEETH, Mesh
from crosscheck.models.arm.stiffness import (
    FourierStiffness,
    SineStiffness,
    SquareStiffness,
    StiffnessLaw,
    TableStiffness,
)
from crosscheck.models.loading import load_arm

PAPER = load_arm("paper-labelled")
GRAVITY = (1.7, -9.66)  # as on a tilted base
Choice = TypeVar("Choice")


def arm_of(joints: int, scale: float = 1.0, direct: Collection[int] = ()) -> Arm:
    """An arm under gravity of joints and links unlike each other, from a seed of its own.

    scale: of its links' lengths; direct: which joints, counted from 0, have no gears.
    """
    dice = roll_dice(joints)
    kinds = [direct_joint if n in direct else planetary_joint for n in range(joints)]
    lengths = [scale * (1 - 0.11 * number) for number in range(joints)]
    return Arm(
        schema_version=2,
        name=f"{joints}-joint",
        payload_mass_kg=10.0,
        gravity_m_per_s2=GRAVITY,
        joints=tuple(kind(dice) for kind in kinds),
        links=tuple(any_link(dice, length) for length in lengths),
    )


def random_arm(seed: int, most_joints: int = 7, all_geared: bool = False) -> Arm:
    """A valid arm of joints unlike one another, each number within a factor of the paper's arm.

    Gravity, friction and direct joints, none geared among them, come and go with the seed.
    """
    dice = roll_dice(seed)
    joints = dice.whole(1, most_joints)
    directness = 0.0 if all_geared else dice.one_of((0.0, 0.0, 0.4, 0.4, 1.0))
    kinds = [direct_joint if dice.chance(directness) else planetary_joint for _ in range(joints)]
    return any_arm(dice, f"random-{seed}", kinds)


def any_arm(dice: "Dice", name: str, kinds: Sequence["Kind"]) -> Arm:
    """An arm of these kinds of joints."""
    return Arm(
        schema_version=2,
        name=name,
        payload_mass_kg=dice.near(10),
        gravity_m_per_s2=dice.one_of(((0.0, 0.0), (0.0, -9.81), GRAVITY)),
        joints=tuple(kind(dice) for kind in kinds),
        links=tuple(any_link(dice, dice.near(0.8, 2)) for _ in kinds),
    )


def gear_stages(*names: str) -> list[Planetary]:
    """The joints with gears of these arms."""
    joints = (joint for name in names for joint in load_arm(name).joints)
    return [joint for joint in joints if isinstance(joint, Planetary)]


@dataclass(frozen=True)
class Dice:
    """Random numbers about those of the paper's arm.

    between: anywhere from one to another; whole: a whole number, both ends among them.
    """

    between: Callable[[float, float], float]
    whole: Callable[[int, int], int]

    def near(self, value: float, factor: float = 3.0) -> float:
        """Within a factor of a value."""
        return value * factor ** self.between(-1, 1)

    def chance(self, probability: float) -> bool:
        """True as often as that."""
        return self.between(0, 1) < probability

    def one_of(self, choices: tuple[Choice, ...]) -> Choice:
        """Any of them alike."""
        return choices[self.whole(0, len(choices) - 1)]


Kind = Callable[[Dice], Planetary | Direct]


def roll_dice(seed: int) -> Dice:
    """Of a seed."""
    generator = np.random.default_rng(seed)
    return Dice(
        lambda least, most: float(generator.uniform(least, most)),
        lambda least, most: int(generator.integers(least, most + 1)),
    )


def planetary_joint(dice: Dice) -> Planetary:
    """Of any gears, its inertias as masses or as they are."""
    teeth = any_gears(dice)
    module, angle = dice.near(0.003, 2), dice.between(14.5, 28)
    sun, planet, carrier = dice.near(0.5), dice.near(0.66), dice.near(5.8)
    pitches = [module * count / 2 for count in (teeth.sun, teeth.planet, teeth.sun + teeth.planet)]
    r_s, r_p, r_cp = (pitch * float(np.cos(np.radians(angle))) for pitch in pitches)
    as_mass = dice.chance(0.5)
    return Planetary(
        kind="planetary",
        sun_teeth=teeth.sun,
        planet_teeth=teeth.planet,
        ring_teeth=teeth.sun + 2 * teeth.planet,
        planet_count=teeth.planets,
        module_m=module,
        pressure_angle_deg=angle,
        sun_equivalent_mass_kg=sun if as_mass else None,
        sun_inertia_kg_m2=None if as_mass else sun * r_s**2,
        planet_equivalent_mass_kg=planet if as_mass else None,
        planet_inertia_kg_m2=None if as_mass else planet * r_p**2,
        carrier_equivalent_mass_kg=carrier if as_mass else None,
        carrier_inertia_kg_m2=None if as_mass else carrier * r_cp**2,
        sun_mass_kg=dice.near(0.4),
        planet_mass_kg=dice.near(0.6),
        carrier_mass_kg=dice.near(6.3),
        ring_mass_kg=dice.near(10),
        ring_inertia_kg_m2=dice.near(0.18) * dice.whole(0, 1),
        friction_N_m_s_per_rad=dice.near(4.0) * dice.whole(0, 1),
        sun_mesh=_mesh(dice),
        ring_mesh=_mesh(dice),
    )


def part_planets(dice: Dice, joint: dict[str, Any]) -> None:
    """A number for each planet in every field of both meshes, and phases as the teeth allow."""
    planets, sun = joint["planet_count"], joint["sun_teeth"]
    turns = [-2 * pi * (sun * place % planets) / planets for place in range(planets)]
    for side in ("sun_mesh", "ring_mesh"):
        damping = "damping_ratio" if dice.chance(0.5) else "damping_N_s_per_m"
        fields: dict[str, Callable[[], Any]] = {
            "stiffness": lambda: any_law(dice).model_dump(),
            "backlash_m": lambda: dice.near(5e-5) * dice.chance(0.9),
            "tooth_error_m": lambda: dice.near(5e-6) * dice.chance(0.9),
            "tooth_error_phase_rad": lambda: dice.between(-3, 3),
            "static_error_m": lambda: dice.between(-5e-6, 5e-6),
            damping: lambda size=0.05 if damping == "damping_ratio" else 1500.0: dice.near(size),
        }
        first = dice.between(-3, 3)
        phases = FROM_TEETH, first, [first + turn for turn in turns]
        own = {field: [roll() for _ in range(planets)] for field, roll in fields.items()}
        joint[side] = {"phase_rad": dice.one_of(phases), **own}


def direct_joint(dice: Dice) -> Direct:
    """Of any motor."""
    return Direct(
        kind="direct",
        motor_mass_kg=dice.near(6.0),
        rotor_inertia_kg_m2=dice.near(0.02),
        friction_N_m_s_per_rad=dice.near(2.0) * dice.whole(0, 1),
    )


def _mesh(dice: Dice) -> Mesh:
    as_ratio = dice.chance(0.6)
    return Mesh(
        stiffness=any_law(dice),
        backlash_m=dice.near(5e-5) * dice.chance(0.9),
        tooth_error_m=dice.near(5e-6),
        phase_rad=dice.between(-3, 3),
        damping_ratio=dice.near(0.05, 2) if as_ratio else None,
        damping_N_s_per_m=None if as_ratio else dice.near(1500),
        tanh_sharpness_per_m=dice.near(3e4),
    )


def _sine(dice: Dice, mean: float) -> SineStiffness:
    amplitude = mean * dice.between(0, 0.4)
    return SineStiffness(law="sine", mean_N_per_m=mean, amplitude_N_per_m=amplitude)


def _fourier(dice: Dice, mean: float) -> FourierStiffness:
    """Up to four cosines and sines, not as many of each."""
    cosines, sines = (
        tuple(mean * dice.between(-0.1, 0.1) for _ in range(dice.whole(0, 4))) for _ in range(2)
    )
    return FourierStiffness(
        law="fourier", mean_N_per_m=mean, cosine_N_per_m=cosines, sine_N_per_m=sines
    )


def _square(dice: Dice, mean: float) -> SquareStiffness:
    return SquareStiffness(
        law="square",
        contact_ratio=dice.between(1.1, 1.9),
        least_N_per_m=mean,
        largest_N_per_m=mean * dice.between(1, 1.6),
        harmonics=dice.whole(1, 8),
    )


def _table(dice: Dice, mean: float) -> TableStiffness:
    """Five to thirteen rows at unequal distances."""
    widths = [dice.between(0.6, 1.4) for _ in range(dice.whole(4, 12))]
    ends = np.cumsum(widths) / sum(widths)
    values = [mean * dice.between(0.8, 1.2) for _ in widths]
    return TableStiffness(
        law="table",
        phase_cycles=(0.0, *map(float, ends[:-1]), 1.0),
        stiffness_N_per_m=(*values, values[0]),
    )


def any_law(dice: Dice) -> StiffnessLaw:
    """One of the four."""
    return dice.one_of(LAWS)(dice, dice.near(1e8))


LAWS: tuple[Callable[[Dice, float], StiffnessLaw], ...] = (_sine, _fourier, _square, _table)


def any_link(dice: Dice, length: float) -> Link:
    """A rod, or a body as from a CAD model."""
    com, rod = length * dice.between(0.3, 0.7), dice.chance(0.5)
    section, density = dice.near(0.01, 2), dice.near(2700, 2)
    mass = section * density * length
    return Link(
        length_m=length,
        com_m=com,
        cross_section_m2=section if rod else None,
        density_kg_per_m3=density if rod else None,
        mass_kg=None if rod else mass,
        inertia_kg_m2=None if rod else mass * length**2 * dice.between(0.05, 0.15),
    )


class GearSet(NamedTuple):
    """Teeth of sun and planet, and the number of planets."""

    sun: int
    planet: int
    planets: int


def any_gears(dice: Dice, fewest: int = 15, most: int = 44, most_planets: int = 5) -> GearSet:
    """One that assembles and whose planets clear each other; of so many teeth each."""
    while True:
        sun, planet, count = (
            dice.whole(*ends) for ends in ((fewest, most), (fewest, most), (2, most_planets))
        )
        clear = (sun + planet) * np.sin(np.pi / count) > planet + 2
        if clear and (2 * sun + 2 * planet) % count == 0:
            return GearSet(sun, planet, count)
