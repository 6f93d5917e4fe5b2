"""Arms as Hypothesis draws them: every kind of joint, mesh, stiffness law and link."""

from collections.abc import Callable
from math import pi
from typing import Any

from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
from crosscheck.models.arm.mesh import FROM_TEETH
from tests import arms
from tests.arms import Dice


def draw_dice(draw: st.DrawFn) -> Dice:
    """Numbers that Hypothesis chooses, in steps of a millionth: none is next to nothing."""
    return Dice(
        lambda least, most: least + (most - least) * draw(st.integers(0, 10**6)) / 10**6,
        lambda least, most: draw(st.integers(least, most)),
    )


@st.composite
def any_arms(draw: st.DrawFn, joints: int, unlike: bool = False) -> Arm:
    """Valid arms of so many joints, with weight or in free fall, some without any gears.

    unlike: planets of one stage differ from each other.
    """
    dice = draw_dice(draw)
    kinds = [dice.one_of((arms.direct_joint, arms.planetary_joint)) for _ in range(joints)]
    arm = arms.any_arm(dice, f"any-{joints}", kinds)
    if not unlike:
        return arm
    content = arm.model_dump()
    for joint in content["joints"]:
        if joint["kind"] == "planetary":
            part_planets(dice, joint)
    return Arm.model_validate(content)


@st.composite
def planetary_joints(draw: st.DrawFn, unlike: bool = False) -> dict[str, Any]:
    """A geared joint's fields; unlike: its planets differ."""
    dice = draw_dice(draw)
    joint = arms.planetary_joint(dice).model_dump()
    if unlike:
        part_planets(dice, joint)
    return joint


def part_planets(dice: Dice, joint: dict[str, Any]) -> None:
    """A number for each planet in every field of both meshes, and phases as the teeth allow."""
    planets, sun = joint["planet_count"], joint["sun_teeth"]
    turns = [-2 * pi * (sun * place % planets) / planets for place in range(planets)]
    for side in ("sun_mesh", "ring_mesh"):
        damping = "damping_ratio" if dice.chance(0.5) else "damping_N_s_per_m"
        fields: dict[str, Callable[[], Any]] = {
            "stiffness": lambda: arms.any_law(dice).model_dump(),
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


@st.composite
def direct_joints(draw: st.DrawFn) -> dict[str, Any]:
    """A direct joint's fields."""
    return arms.direct_joint(draw_dice(draw)).model_dump()


@st.composite
def any_links(draw: st.DrawFn) -> dict[str, Any]:
    """A rod's fields, or a body's."""
    dice = draw_dice(draw)
    return arms.any_link(dice, dice.near(0.8, 2)).model_dump()


@st.composite
def any_gears(draw: st.DrawFn) -> arms.GearSet:
    """Teeth of sun and planet, and a number of planets that assembles and clears."""
    return arms.any_gears(draw_dice(draw))
