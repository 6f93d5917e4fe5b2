"""What is wrong with the numbers of a cost: they are held against those of a second program."""

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

from crosscheck.analytic.robot import springs
from crosscheck.checks import robot_states
from crosscheck.cost import motion, shortcuts
from crosscheck.cost.shortcuts import QUICK, ShortcutCosts
from crosscheck.models.robot.robot import Robot
from crosscheck.recordings.record import Record
from tests.robots.chains import Solid, geared, joint, link, planetary, teeth, urdf
from tests.robots.recomputed import RobotFiles, SecondCost

EXTENT = replace(QUICK, states=2, instants=60, runs=3, steps=8, most_steps=60)
SAME = 1e-8  # of a size: rounding of slopes and of runs
UNLIKE = Solid(1.7, (0.11, -0.04, 0.07), (0.03, 0.004, -0.006, 0.05, 0.002, 0.06), (0.3, -0.2, 0.5))


def _limit(lower: float, upper: float, velocity: float, effort: float) -> str:
    return f'<limit lower="{lower}" upper="{upper}" velocity="{velocity}" effort="{effort}"/>'


OBLIQUE = RobotFiles(
    urdf(
        link("ground"),
        link("a", UNLIKE),
        link("b", UNLIKE._replace(mass=0.9, com=(0.05, 0.07, -0.02))),
        link("plate", UNLIKE._replace(mass=0.4)),
        link("c", UNLIKE._replace(com=(0.02, 0.09, -0.1))),
        link("d", UNLIKE._replace(mass=0.6)),
        link("finger"),
        link("tool"),
        joint(
            *("one", "ground", "a", "revolute", (0.2, 0.3, 0.9), (0.1, 0.2, 0.3), (0.1, 0.2, 0.4)),
            more=_limit(-0.6, 1.7, 1.1, 9),
        ),
        joint("two", "a", "b", "continuous", (1, 0.1, 0), (0.3, 0.0, 0.1), (0.5, -0.4, 0.7)),
        joint("fixed", "b", "plate", "fixed", at=(0.1, 0.1, 0.0), rpy=(0.2, 0.6, -0.3)),
        joint(
            *("three", "plate", "c", "prismatic", (0.6, 0, 0.8), (0.2, 0.1, 0.2), (1, 0.3, 0.2)),
            more=_limit(-0.1, 0.5, 0, 26) + '<dynamics friction="2"/>',
        ),
        joint(
            *("four", "c", "d", "revolute", (0, 1, 0), (0.1, 0.2, 0.1), (0.4, 0.2, 0.9)),
            more=_limit(-3, 3, 0, 0) + '<mimic joint="two" multiplier="-0.5" offset="0.3"/>',
        ),
        joint("held", "d", "finger", "fixed", at=(0.1, 0.0, 0.2), rpy=(0.0, 0.3, 0.0)),
        joint("flange", "d", "tool", "fixed", at=(0.0, 0.3, 0.1)),
    ),
    {
        "one": geared(9.0),
        "two": geared(
            -7.0, 0.02, stator="plate", rotor_axis=[0.5, 0.5, 0.2], mesh=teeth(0.1, 20.0, 1.0, 1e-3)
        ),
        "three": geared(30.0, 2e-3, mesh=teeth(0.06, 15.0, 0.5, 2e-3)),
        "four": geared(-12.0, 4e-4),
    },
    (1.0, 2.0, -9.0),
    "tool",
)
STAGED = RobotFiles(
    urdf(
        link("ground"),
        link("a", UNLIKE),
        link("b", UNLIKE._replace(mass=0.9)),
        joint("one", "ground", "a", "revolute", (0, 0.6, 0.8), more=_limit(-1, 2.5, 2.0, 0)),
        joint("two", "a", "b", "continuous", (1, 0.1, 0), (0.3, 0.0, 0.1), (0.5, -0.4, 0.7)),
    ),
    {"one": geared(12.0), "two": planetary(planet_teeth=30, ring_teeth=84, planet_count=4)},
    (0.5, 0.0, -9.8),
    "b",
)
FILES = {"oblique": OBLIQUE, "staged": STAGED}


@lru_cache
def robot(name: str) -> Robot:
    """As the program reads it."""
    return FILES[name].read()


def found_cost(name: str, runs: int = EXTENT.runs, engines: bool = False) -> ShortcutCosts:
    """The program's cost with so many runs; engines: whether they are compared, too."""
    with pytest.MonkeyPatch.context() as patch:
        if not engines:
            patch.setattr(shortcuts, "compare_engines", lambda robot, states: [])
        return shortcuts.compute_costs(
            robot(name), 3, replace(EXTENT, runs=runs), lambda *doing: None
        )


@lru_cache
def second_cost(
    name: str, angles: bytes, shape: tuple[int, int], period: float, runs: int
) -> SecondCost:
    """The second program's, of a motion by its angles."""
    time = period * np.arange(shape[0]) / shape[0]
    q = np.frombuffer(angles).reshape(shape)
    return SecondCost(FILES[name], time, q, runs, EXTENT.steps)


def second_of(name: str, found: ShortcutCosts) -> SecondCost:
    """The second program's cost along the motion of the first."""
    q = found.motion.at(found.time)[0]
    step = float(found.time[1] - found.time[0])
    return second_cost(
        name, np.ascontiguousarray(q).tobytes(), q.shape, step * len(found.time), found.extent.runs
    )


def _off(what: str, first: Any, second: Any, size: float | None = None) -> Iterator[str]:
    """A line if numbers are not alike, of the largest of the second's, or of a size."""
    one, other = np.asarray(first, float), np.asarray(second, float)
    if one.shape != other.shape:
        yield f"{what}: shapes {one.shape}, {other.shape}"
    elif one.size:
        scale = np.abs(other).max() if size is None else size
        if not np.abs(one - other).max() <= SAME * max(scale, 1e-12):
            yield f"{what}: {one} is {other}"


def wrong_numbers(robot_name: str, found: ShortcutCosts) -> Iterator[str]:
    """What of the record is not as the second program has it."""
    second = second_of(robot_name, found)
    kinds, size = second.files.kinds, second.largest.max()
    if found.names != tuple(kinds) or found.robot.tip != second.files.tip:
        yield f"names {found.names}, {found.robot.tip}"
    if found.units != tuple("N" if kind == "prismatic" else "N m" for kind in kinds.values()):
        yield f"units {found.units}"
    yield from _off("torques", found.torques, second.torques["coupled"])
    yield from _off("largest", found.largest, second.largest)
    report = {(each.level, each.joint): each for each in found.by_joint}
    for level in ("links", "armature"):
        error = second.error(level)
        yield from _off(f"errors of {level}", found.errors[level], error, size)
        for column, name in enumerate(kinds):
            each, most = report.pop((level, name)), np.abs(error[:, column]).max()
            rms = np.sqrt((error[:, column] ** 2).mean())
            right = most, rms, most / second.largest[column]
            yield from _off(f"{level}, {name}", (each.largest, each.rms, each.share), right)
    tips = {each.level: each.distances for each in found.tips if found.extent.runs}
    for level, distances in second.distances.items() if found.extent.runs else ():
        yield from _off(f"tip of {level}", tips.pop(level), distances, 0.1)
    yield from _off("by rates", found.by_rates, second.by_rates, size)
    yield from _wrong_pairs(found, second)
    yield from _wrong_ratios(found, second)
    yield from _wrong_meshes(found, second)
    if report or tips:
        yield f"also report: {report}, {tips}"


def _wrong_pairs(found: ShortcutCosts, second: SecondCost) -> Iterator[str]:
    free, torques = second.free, second.coupling * second.state[2][:, None, :]
    rms = np.sqrt((torques**2).mean(axis=0))
    right = {
        (at, by): (rms[i, j], rms[i, j] / second.largest[i])
        for i, at in enumerate(free)
        for j, by in enumerate(free)
        if i != j and rms[i, j] > 1e-9
    }
    shares = [each.share for each in found.pairs]
    if shares != sorted(shares, reverse=True):
        yield "pairs are not in order"
    report = {(each.at, each.by): (each.rms, each.share) for each in found.pairs if each.rms > 1e-9}
    if report.keys() != right.keys():
        yield f"pairs {report.keys()}"
        return
    for pair, numbers in right.items():
        yield from _off(f"pair {pair}", report[pair], numbers)


def _wrong_ratios(found: ShortcutCosts, second: SecondCost) -> Iterator[str]:
    """A factor on ratios is right if the coupling is 1 % there, and less beyond."""
    gears = list(second.files.joints)
    if [each.joint for each in found.ratios] != gears:
        yield f"ratios of {[each.joint for each in found.ratios]}"
        return
    for each in found.ratios:
        parts = second.gear_coupling([each.joint], 1.0).max(axis=0)
        joint = [line.name for line in second.robot.joints].index(each.joint)
        ratio = next(spin.ratio for spin in second.spins if spin.joint == joint)
        most = float(parts.max()) if parts.max() > 1e-10 else 0.0
        yield from _off(f"ratio of {each.joint}", (each.ratio, each.share), (ratio, most))
        if most and each.at != second.free[int(parts.argmax())]:
            yield f"ratio of {each.joint}: most at {each.at}"
        yield from _not_enough(second, [each.joint], each.enough / abs(ratio))
    yield from _not_enough(second, gears, found.factor)


def _not_enough(second: SecondCost, gears: list[str], factor: float) -> Iterator[str]:
    def most(factor: float) -> float:
        return float(second.gear_coupling(gears, factor).max())

    if factor and most(factor) != pytest.approx(0.01, rel=1e-6):
        yield f"factor {factor} of {gears}: {most(factor)}"
    beyond = [(factor or 1e-4) * by for by in (1.001, 1.5, 4.0, 20.0)]
    if any(most(each) >= 0.01 for each in beyond):
        yield f"factor {factor} of {gears} is not enough"


def _wrong_meshes(found: ShortcutCosts, second: SecondCost) -> Iterator[str]:
    assert found.geared
    report = {mesh.name: mesh for mesh in found.geared.meshes}
    forces, swings = second.forces(), second.swings()
    for number, tooth in enumerate(second.teeth):
        mesh, lever = report.pop(tooth.name), abs(tooth.lever)
        pressed = np.abs(forces[:, number]).max() / tooth.stiffness
        right = (
            *(2 * tooth.play / lever, pressed / lever),
            *(swings[:, number].min(), swings[:, number].max()),
        )
        numbers = mesh.backlash, mesh.windup, mesh.slowest, mesh.fastest
        for what, own, other in zip(
            ("play", "wind-up", "slow", "fast"), numbers, right, strict=True
        ):
            yield from _off(f"{tooth.name}, {what}", own, other)
        unit = "m" if second.files.kinds[tooth.joint] == "prismatic" else "rad"
        if (mesh.joint, mesh.unit) != (tooth.joint, unit):
            yield f"{tooth.name}: {mesh.joint}, {mesh.unit}"
    steps = second.geared_steps()
    if report or found.geared.steps != steps:
        yield f"{found.geared.steps} steps for {steps}; meshes too many: {report}"
    if steps > EXTENT.most_steps:
        if found.geared.distances is not None:
            yield "a run that asks for too many steps"
    elif found.extent.runs:
        yield from _off(
            "tip of geared", found.geared.distances, second.geared_distances(steps), 0.1
        )


def wrong_tip(name: str) -> Iterator[str]:
    """Whether a robot that is read anew has the end effector that its URDF gives."""
    report, right = FILES[name].read().tip, FILES[name].tip
    if report != right:
        yield f"tip {report}, not {right}"


def wrong_limits() -> Iterator[str]:
    """Whether a motion that reaches, or exceeds, each limit on each side is reported."""
    own = robot("oblique")
    still, names = np.zeros((2, 3)), [own.joints[number].name for number in own.coordinates]
    for column, number in enumerate(own.coordinates):
        limits = own.joints[number].limits
        middle = np.array([max(-9.0, limits.lower) + 0.1, min(9.0, limits.upper) - 0.1])
        for kind, size in (("velocity", limits.velocity), ("effort", limits.effort)):
            for part, sign in ((1.005, 1), (1.02, 1), (1.02, -1)):
                asked = still.copy()
                asked[1, column] = sign * part * min(size, 9e9)
                q = still + np.where(np.arange(3) == column, middle[:, None], 0.1)
                v, torques = (asked, still) if kind == "velocity" else (still, asked)
                report = motion.find_exceeded_limits(own, (q, v, still), torques)
                line = f"{names[column]}: {kind} of {part * size:.4g} is beyond its limit, {size:g}"
                if report != ([line] if part > 1.01 and np.isfinite(size) else []):
                    yield f"{names[column]}, {kind}, {part}: {report}"
        for row, limit, sign in ((0, limits.lower, -1), (1, limits.upper, 1)):
            q = still + 0.1
            q[row, column] = np.clip(limit, -9, 9) + 0.01 * sign
            report = motion.find_exceeded_limits(own, (q, still, still), still)
            if report != ([f"{names[column]}: leaves its range"] if np.isfinite(limit) else []):
                yield f"{names[column]} at {limit}: {report}"


def wrong_states() -> Iterator[str]:
    """Whether drawn states fill each joint's range and rates, and are within them."""
    own, count = robot("oblique"), 400
    drawn = robot_states.sample_states(own, count, 1)
    for column, number in enumerate(own.coordinates):
        joint, limits = own.joints[number], own.joints[number].limits
        most = min(limits.velocity, 2.0)
        half = np.pi if joint.kind == "revolute" else 1.0
        lower, upper = limits.lower, limits.upper
        if np.isfinite([lower, upper]).all():
            half = min(half, (upper - lower) / 2)
            lower, upper = (lower + upper) / 2 - half, (lower + upper) / 2 + half
        else:
            lower, upper = -half, half
        for what, values, ends in (
            ("angles", drawn.q[:, column], (lower, upper)),
            ("rates", drawn.v[:, column], (-most, most)),
            ("accelerations", drawn.a[:, column], (-5.0, 5.0)),
            ("torques", drawn.torques[:, column], (-10.0, 10.0)),
        ):
            reached, whole = (values.min(), values.max()), ends[1] - ends[0]
            if not (ends[0] <= reached[0] and reached[1] <= ends[1]):
                yield f"{joint.name}: {what} {reached} beyond {ends}"
            if np.abs(np.subtract(reached, ends)).max() > 0.03 * whole:
                yield f"{joint.name}: {what} {reached} do not fill {ends}"


def wrong_given() -> Iterator[str]:
    """Whether a motion from a file is that of its rows, and runs end where it does."""
    time = np.linspace(5.0, 7.5, 1251)
    rate, size = np.array([2.0, 3.1]), np.array([0.4, -0.7])
    rows = Record("file", time, size * np.sin(time[:, None] * rate), None, None)
    found = motion.fit_motion(rows)
    for before in (0.0, 1.0):
        right = 5.0 + (2.5 - before) * np.arange(7) / 6
        yield from _off(f"instants up to {before} s before", found.instants(7, before), right, 1)
    at = np.linspace(5.1, 7.4, 50)
    angles = at[:, None] * rate
    right_motion = (
        size * np.sin(angles),
        size * rate * np.cos(angles),
        -size * rate**2 * np.sin(angles),
    )
    for order, (said, right) in enumerate(zip(found.at(at), right_motion, strict=True)):
        if not np.allclose(said, right, atol=1e-3):
            yield f"slope {order} of a given motion"


def wrong_steps() -> Iterator[str]:
    """Steps of a robot whose dampers die out faster than its teeth swing."""
    damping = 1.0, 300.0
    joints = {
        **OBLIQUE.joints,
        "three": geared(30.0, 2e-3, mesh=teeth(0.06, 15.0, damping[1], 2e-3)),
    }
    own = replace(OBLIQUE, joints=joints).read()
    model = shortcuts.build_robot_model("analytic", own, "geared")
    masses = model.mass_matrix(np.full((1, len(own.coordinates) + 2), 0.2))
    inverse = np.linalg.inv(masses[0])[-2:, -2:]
    right = np.linalg.eigvals(inverse * damping).real.max()
    yield from _off("fastest of swings and dampers", springs.mesh_rates(own, masses).fastest, right)


def wrong_motion(own: Robot, seed: int) -> Iterator[str]:
    """What of a drawn motion is not as promised: ranges, rates, and the efforts that slow it.

    The joint that is named needs its whole effort; no other that can bear its weight needs more.
    """
    exact = shortcuts.build_robot_model("analytic", own, "coupled")
    drawn = motion.make_excitation(exact, seed)
    q, v, a = drawn.at(drawn.instants(motion.GRID))
    torques, held = np.abs(exact.inverse_dynamics(q, v, a)), np.abs(exact.gravity(q))
    used = {}
    for column, number in enumerate(own.coordinates):
        joint, limits = own.joints[number], own.joints[number].limits
        half = np.pi if joint.kind == "revolute" else 1.0
        lower, upper = max(limits.lower, -1e9), min(limits.upper, 1e9)
        middle = (lower + upper) / 2
        half = min(half, (upper - lower) / 2)
        swept = np.ptp(q[:, column]) / (0.8 * 2 * half)
        limit = limits.velocity if np.isfinite(limits.velocity) else 1.0
        rate = np.abs(v[:, column]).max() * drawn.period / 4.0 / limit
        yield from _off(f"{joint.name}: rate or range", max(swept, rate), 1.0)
        yield from _off(
            f"{joint.name}: middle", (q[:, column].max() + q[:, column].min()) / 2, middle, 1
        )
        if held[:, column].max() < limits.effort < np.inf:
            used[joint.name] = torques[:, column].max() / limits.effort
    named = drawn.limited_by
    if named:
        yield from _off(f"effort of {named}", used.pop(named), 1.0)
    if (drawn.period == 4.0) != (not named) or any(each > 1 + SAME for each in used.values()):
        yield f"period {drawn.period}, limited by {named!r}, efforts {used}"
