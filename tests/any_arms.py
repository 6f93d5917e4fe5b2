"""Arms as Hypothesis draws them: every kind of joint, mesh, stiffness law and link."""

from typing import Any

from hypothesis import strategies as st

from crosscheck.models.arm.arm import Arm
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
            arms.part_planets(dice, joint)
    return Arm.model_validate(content)


@st.composite
def planetary_joints(draw: st.DrawFn, unlike: bool = False) -> dict[str, Any]:
    """A geared joint's fields; unlike: its planets differ."""
    dice = draw_dice(draw)
    joint = arms.planetary_joint(dice).model_dump()
    if unlike:
        arms.part_planets(dice, joint)
    return joint


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
