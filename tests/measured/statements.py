"""What is true of recordings that were made wrong in one way, and what would be false of them."""

from collections.abc import Callable
from dataclasses import dataclass

from crosscheck.identification import messages
from crosscheck.identification.compare import SideResult
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings.record import Record
from tests.measured.robots import RATIO, ROTOR, STEP, arm, behind, both_sides, recording

REFLECTED = RATIO**2 * ROTOR
SECONDS = 10.0
ENCODER = 4e-4  # [rad]
GAIN = 1.05


@dataclass(frozen=True)
class Kind:
    """A kind of recording: how one is made of a seed, and whether a comparison says what is true.

    rotors: names of those that may be named; has_delay, has_factors: whether saying these is true.
    """

    make: Callable[[Robot, int], Record]
    is_true: Callable[[SideResult, SideResult], bool]
    rotors: frozenset[str] = frozenset({"armature of j3"})
    has_delay: bool = False
    has_factors: bool = False
    robot: Callable[[], Robot] = arm


def has_rotor(side: SideResult, reflected: float = REFLECTED) -> bool:
    """Whether the rotor is named, within twice its interval of what it is."""
    return any(
        each.term.name == "armature of j3" and abs(each.value - reflected) < 2 * each.half_width
        for each in side.seen
    )


def heavier_arm() -> Robot:
    """The arm whose file has another inertia of the second link, across the axis of its joint."""
    given = arm()
    text = given.urdf.replace('iyz="0.0" izz="0.1"', 'iyz="0.0" izz="0.25"')
    assert text != given.urdf
    return arm(text=text)


def make_with(level: str, **more: float) -> Callable[[Robot, int], Record]:
    """A maker of recordings of the arm itself, whatever robot the file has."""
    return lambda robot, seed: recording(arm(), level, seed, seconds=SECONDS, **more)


KINDS = {
    "coarse encoder": Kind(
        make_with("armature", encoder=ENCODER), lambda side, scaled: has_rotor(side)
    ),
    "Coulomb friction": Kind(
        make_with("links"),
        lambda side, scaled: (
            not side.seen
            and side.steps[1].weighted < side.steps[0].weighted / 2
            and all(each.t > 10 for each in side.estimates if each.term.kind == "coulomb")
        ),
        rotors=frozenset(),
    ),
    "delay of a sample": Kind(
        make_with("armature", delay=STEP),
        lambda side, scaled: (
            has_rotor(side)
            and side.delay is not None
            and abs(side.delay.value - STEP) < 2 * side.delay.half_width
            and any("torques lag behind" in each for each in messages._describe_side(side))
        ),
        has_delay=True,
    ),
    "drive gain 5 % off": Kind(
        make_with("armature", gain=GAIN),
        lambda side, scaled: (
            {each.term.name[-2:] for each in scaled.wrong_factors} >= {"j1", "j2"}
            and all(abs(each.value - GAIN) < 0.05 for each in scaled.wrong_factors)
        ),
        has_factors=True,
    ),
    "wrong link inertia": Kind(
        make_with("armature"),
        lambda side, scaled: bool(scaled.find_worse_joints(side)) and has_rotor(side),
        has_factors=True,
        robot=heavier_arm,
    ),
    "motor side taken for joint side": Kind(
        lambda robot, seed: behind(recording(arm(), "armature", seed, seconds=SECONDS)),
        lambda side, scaled: side.side == "joint" and has_rotor(side),
    ),
}


def judge(kind: Kind, seed: int) -> tuple[bool, bool, bool]:
    """Whether what is true is said, something false, and whether the rotor's interval covers it."""
    robot = kind.robot()
    side, scaled = both_sides(robot, kind.make(robot, seed))
    is_false = (
        not {each.term.name for each in side.seen} <= kind.rotors
        or bool(side.impossible)
        or (side.delay is not None and not kind.has_delay)
        or (bool(scaled.wrong_factors) and not kind.has_factors)
        or (bool(scaled.find_worse_joints(side)) and kind.robot is arm)
    )
    return kind.is_true(side, scaled), is_false, covers(side, kind)


def covers(side: SideResult, kind: Kind) -> bool:
    """Whether the 95 % interval of the rotor holds its reflected inertia, 0 where there is none."""
    (rotor,) = (each for each in side.rotors if each.term.name == "armature of j3")
    gain = GAIN if kind is KINDS["drive gain 5 % off"] else 1.0
    true = gain * REFLECTED if kind.rotors else 0.0
    return abs(rotor.value - true) < rotor.half_width
