"""What a robot's shortcuts cost, as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crosscheck import __version__
from crosscheck.cost.agreement import QUANTITIES
from crosscheck.cost.cost import NEGLIGIBLE, SHORTCUTS, Cost
from crosscheck.cost.meshes import RESOLVED, GearedCost
from crosscheck.cost.springs import with_rotors_alone
from crosscheck.models.robot.robot import LEVELS, Level
from crosscheck.report.records import document, plain

SCHEMA_VERSION = 1
MOST_PAIRS = 6
MOST_DRAWN = 8  # joints of the picture, those that armature costs most


def first_lines(found: Cost) -> Iterator[str]:
    """Lines that answer: do engines agree, what shortcuts cost, what carries it, which ratio."""
    yield from _agreement_lines(found)
    if not found.ratios:
        yield "no joint is geared: there is no shortcut to take"
        return
    for level in reversed(SHORTCUTS):
        worst = max(
            (each for each in found.by_joint if each.level == level), key=lambda each: each.share
        )
        (tip,) = (each for each in found.tips if each.level == level)
        yield (
            f"{level}: torque off by {worst.largest:.3g} {_unit(found, worst.joint)} at most in"
            f" {worst.joint}, {_percent(worst.share)} of its largest; {_away_words(tip.distances)}"
        )
    if found.pairs:
        named = ", ".join(
            f"{pair.at} by {pair.by} ({_percent(pair.share)})" for pair in found.pairs[:3]
        )
        yield f"coupling that armature leaves out: {named} of the largest torque, rms"
    limit = _percent(NEGLIGIBLE)
    if found.factor == 0:
        yield f"ratios: the coupling stays below {limit} at any ratio, the reflected inertia kept"
    else:
        largest = max(each.share for each in found.by_joint if each.level == "armature")
        verb = "would still be" if largest < NEGLIGIBLE else "would be"
        yield (
            f"ratios: the coupling {verb} below {limit} of every joint's largest torque with all"
            f" ratios {found.factor:.3g} times as large, the reflected inertias kept"
        )
    if found.geared:
        yield from _mesh_lines(found.geared)


def _mesh_lines(geared: GearedCost) -> Iterator[str]:
    for mesh in geared.meshes:
        yield (
            f"{mesh.name}, rigid at coupled: backlash of {mesh.backlash:.3g} {mesh.unit},"
            f" wind-up of {mesh.windup:.3g} {mesh.unit} at most, swings at {mesh.slowest:.3g} Hz or"
            " more"
        )
    if geared.distances is None:
        most = geared.steps * RESOLVED / (2 * np.pi)
        yield f"geared: not run, {most:.3g} Hz ask for {geared.steps} steps a second"
    else:
        yield f"geared: under torques of coupled the {_away_words(geared.distances)}"


def _engines(found: Cost) -> list[str]:
    """The engines' names; one that lacks a level is followed by the levels that it has."""
    levels: dict[str, dict[Level, None]] = {}
    for each in found.agreement:
        for name in (each.left, each.right):
            levels.setdefault(name, {})[each.level] = None
    return [
        name if len(own) == len(found.robot.levels) else f"{name} ({', '.join(own)})"
        for name, own in levels.items()
    ]


def _agreement_lines(found: Cost) -> Iterator[str]:
    wrong = [each for each in found.agreement if not each.agrees]
    if not wrong:
        largest = max(each.measured for each in found.agreement)
        *others, last = _engines(found)
        yield (
            f"engines agree: {', '.join(others)} and {last} on {len(QUANTITIES)} quantities,"
            f" {len(found.robot.levels)} levels, {found.extent.states} states, to {largest:.1e} of"
            " each"
        )
    for failure in dict.fromkeys(each.failure for each in wrong if each.failure):
        yield f"engines: {failure}"
    for each in wrong:
        if not each.failure:
            yield (
                f"engines differ: {each.quantity} of {each.level}: {each.left} and {each.right} by"
                f" {each.measured:.1e} of its size, tolerance {each.tolerance:.1e}"
            )


def _away_words(distances: np.ndarray) -> str:
    lost = int(np.isinf(distances).sum())
    off = f"{_length(float(np.median(distances)))} in the median of {distances.size} runs"
    most = f"{lost} of them diverge" if lost else f"{_length(float(distances.max()))} at most"
    return f"end effector after a second of feed-forward off by {off}, {most}"


def lines(found: Cost) -> Iterator[str]:
    """The first lines, then motion, joints, rotors, and what of the files is not used."""
    yield from first_lines(found)
    yield ""
    yield motion_line(found)
    yield from found.beyond
    for each in found.by_joint if found.ratios else ():
        unit = _unit(found, each.joint)
        yield (
            f"{each.level}, {each.joint}: {each.largest:.3g} {unit} at most, {each.rms:.3g} {unit}"
            f" rms, {_percent(each.share)} of its largest torque"
        )
    for pair in found.pairs[:MOST_PAIRS]:
        yield (
            f"{pair.at} by the acceleration of {pair.by}: {pair.rms:.3g}"
            f" {_unit(found, pair.at)} rms, {_percent(pair.share)}"
        )
    for rotor in found.ratios:
        said = "its spin is coupled to no other joint"
        if rotor.share != 0:
            said = (
                f"its coupling alone is {_percent(rotor.share)} in {rotor.at}; below"
                f" {_percent(NEGLIGIBLE)} from a ratio of {rotor.enough:.3g} on"
            )
        yield f"rotor of {rotor.joint}, ratio {rotor.ratio:g}: {said}"
    for told in (*direct_joints(found), *found.robot.told):
        yield f"note: {told}"


def motion_line(found: Cost) -> str:
    """The line that says how the robot is moved."""
    return f"motion: {found.motion}; end effector: {found.robot.tip}"


def direct_joints(found: Cost) -> Iterator[str]:
    """Lines on the joints without gears and on those that follow others, if there are any."""
    geared = {rotor.joint for rotor in with_rotors_alone(found.robot).rotors}
    joints = found.robot.joints
    direct = [joint.name for number, joint in enumerate(joints) if number not in geared]
    if direct:
        yield f"without gears: {', '.join(direct)}"
    follow = [joint.name for joint in joints if joint.mimic is not None]
    if follow:
        yield f"follow other joints: {', '.join(follow)}"


def _unit(found: Cost, joint: str) -> str:
    return found.units[found.names.index(joint)]


def _percent(share: float) -> str:
    return f"{100 * share:.{2 if share < 0.995 else 3}g} %"


def _length(metres: float) -> str:
    return f"{1000 * metres:.3g} mm" if metres < 1 else f"{metres:.3g} m"


def cost_json(found: Cost) -> str:
    """JSON text of all but the time histories, units in the names; what is infinite is null."""
    robot = found.robot
    names = zip(found.names, found.units, found.largest, found.by_rates, strict=True)
    return document(
        {
            "schema_version": SCHEMA_VERSION,
            "robot": robot.name,
            "program": f"geararm-crosscheck {__version__}",
            "engines_agree": found.agrees,
            "engines": [
                {**plain(each), "size": QUANTITIES[each.quantity]} for each in found.agreement
            ],
            "states": found.extent.states,
            "seed": found.seed,
            "motion": {
                "from": str(found.motion),
                "beyond_limits": found.beyond,
                "instants": found.extent.instants,
            },
            "tip": robot.tip,
            "joints": [
                {
                    "joint": name,
                    "unit": unit,
                    "largest_torque": largest,
                    "coupling_by_rates_rms": by_rates,
                    "limits": robot.joints[number].limits,
                }
                for number, (name, unit, largest, by_rates) in zip(
                    robot.coordinates, names, strict=True
                )
            ],
            "shortcuts": plain(
                found.by_joint,
                largest="largest_error",
                rms="rms_error",
                share="share_of_largest_torque",
            ),
            "feed_forward": plain(found.tips, distances="distances_m"),
            "pairs": plain(found.pairs, at="joint"),
            "ratios": plain(found.ratios, joint="rotor_of", at="most_in", enough="negligible_from"),
            "geared": plain(
                found.geared,
                name="mesh",
                slowest="slowest_Hz",
                fastest="fastest_Hz",
                distances="distances_m",
            ),
            "negligible_share": NEGLIGIBLE,
            "negligible_with_ratios_times": found.factor,
            "notes": [*direct_joints(found), *robot.told],
        }
    )


def cost_page(found: Cost) -> str:
    """The page on a robot's costs: HTML text, figure inlined."""
    from crosscheck.report.rendering import page

    return page(
        "cost",
        found=found,
        answers=list(first_lines(found)),
        motion=motion_line(found),
        notes=[*direct_joints(found), *found.robot.told],
        levels={level: LEVELS[level] for level in found.robot.levels},
        engines=_engines(found),
        quantities=QUANTITIES,
        pairs=found.pairs[:MOST_PAIRS],
        percent=_percent,
        length=_length,
        negligible=_percent(NEGLIGIBLE),
        drawing=_drawing(found),
    )


def _drawing(found: Cost) -> str:
    """SVG text: torques on the left, what armature misses of them on the right."""
    from matplotlib.figure import Figure

    from crosscheck.report.plots.figures import to_svg

    costs = np.abs(found.errors["armature"]).max(axis=0) / np.maximum(found.largest, 1e-300)
    chosen = sorted(np.argsort(-costs, kind="stable")[:MOST_DRAWN])
    figure = Figure(figsize=(9, 1.9 * len(chosen) + 0.4), layout="constrained")
    axes = figure.subplots(len(chosen), 2, sharex=True, squeeze=False)
    for (left, right), joint in zip(axes, chosen, strict=True):
        torque = found.torques[:, joint]
        left.plot(found.time, torque, lw=1.2, label="coupled")
        without = torque + found.errors["links"][:, joint]
        left.plot(found.time, without, lw=0.8, ls="--", label="links")
        right.plot(found.time, found.errors["armature"][:, joint], "C1", lw=0.8)
        named = f"{found.names[joint]}\n[{found.units[joint]}]"
        left.set_ylabel(named, parse_math=False)  # a name may hold a dollar
    axes[0][0].legend(loc="upper right", fontsize="small")
    axes[0][0].set_title("torque", fontsize="medium")
    axes[0][1].set_title("error of armature", fontsize="medium")
    for each in axes[-1]:
        each.set_xlabel("time [s]")
    return to_svg(figure)
