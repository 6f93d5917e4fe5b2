"""What a robot's shortcuts cost, as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from crosscheck import __version__
from crosscheck.cost.agreement import QUANTITIES
from crosscheck.cost.cost import NEGLIGIBLE, Cost
from crosscheck.cost.meshes import RESOLVED, GearedCost
from crosscheck.cost.springs import with_rotors_alone
from crosscheck.models.robot.robot import LEVELS, Level
from crosscheck.report.records import document, plain

if TYPE_CHECKING:  # drawing libraries are slow to import, and most commands draw nothing
    from matplotlib.figure import Figure

SCHEMA_VERSION = 1
MOST_PAIRS = 6
MOST_DRAWN = 8  # joints of the picture, those that armature costs most
ALIKE = 0.9  # of the largest share, from which on a joint is named beside the worst one
SENTENCES: dict[Level, str] = {
    "links": "Leaving the rotors out of {}",
    "armature": "Counting them as armature only",
}
COLOURS: dict[Level, str] = {"coupled": "C0", "links": "C1", "armature": "C2"}
COUNTS = {2: "Two", 3: "Three", 4: "Four", 5: "Five"}
PREFIXES = {"k": 1e3, "": 1.0, "m": 1e-3, "\u00b5": 1e-6, "n": 1e-9}
LEAST_PERCENT = 0.001


def first_lines(found: Cost) -> Iterator[str]:
    """Lines that answer: what shortcuts cost, do programs agree, what carries it, which ratio.

    Where programs disagree nothing else is said: a cost by one of them might be wrong.
    """
    if not found.agrees:
        yield from _disagreements(found)
        return
    if not found.ratios:
        yield f"No joint of {found.robot.name} is geared: there is no shortcut to take."
        yield _agreement_line(found)
        return
    yield from _cost_lines(found)
    yield _agreement_line(found)
    if found.pairs:
        named = ", ".join(
            f"{pair.at} by {pair.by} ({percent(pair.share)})" for pair in found.pairs[:3]
        )
        yield f"What armature leaves out, rms, of the largest torque: {named}."
    limit = percent(NEGLIGIBLE)
    if found.factor == 0:
        yield f"At any ratio this coupling stays below {limit}, if the reflected inertia is kept."
    else:
        largest = max(each.share for each in found.by_joint if each.level == "armature")
        verb = "would still be" if largest < NEGLIGIBLE else "would be"
        yield (
            f"This coupling {verb} below {limit} of every joint's largest torque with all ratios"
            f" {plain_number(found.factor)} times as large, if the reflected inertias are kept."
        )
    if found.geared:
        yield from _mesh_lines(found.geared)


def _cost_lines(found: Cost) -> Iterator[str]:
    """A sentence for each shortcut: torques, and the end effector."""
    for level, head in SENTENCES.items():
        shares = [each for each in found.by_joint if each.level == level]
        most = max(each.share for each in shares)
        worst = [each.joint for each in shares if each.share >= ALIKE * most]
        torques = f"torque of {worst[0]} is"
        if len(worst) > 1:
            named = "every joint" if len(worst) == len(shares) else joined(worst)
            torques = f"torques of {named} are"
        (tip,) = (each for each in found.tips if each.level == level)
        yield (
            f"{head.format(found.robot.name)}: the {torques} wrong by up to"
            f" {percent(most)} of the largest, and after 1 s of feed-forward {found.robot.tip} is"
            f" {off_words(tip.distances)}."
        )


def _mesh_lines(geared: GearedCost) -> Iterator[str]:
    for mesh in geared.meshes:
        yield (
            f"The {mesh.name}, rigid at coupled, has a backlash of"
            f" {amount(mesh.backlash, mesh.unit)}, a wind-up of {amount(mesh.windup, mesh.unit)}"
            f" at most, and swings at {amount(mesh.slowest, 'Hz')} or more."
        )
    if geared.distances is None:
        most = amount(geared.steps * RESOLVED / (2 * np.pi), "Hz")
        yield f"No run of the level geared: {most} ask for {geared.steps} steps a second."
    else:
        off = off_words(geared.distances)
        yield f"With teeth that give way, under the torques of coupled, the end effector is {off}."


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


def _agreement_line(found: Cost) -> str:
    names = _engines(found)
    digits = digits_of(max(each.measured for each in found.agreement))
    count = COUNTS.get(len(names), str(len(names)))
    return (
        f"{count} programs agree on this robot to {digits} digits: {joined(names)}, on"
        f" {len(QUANTITIES)} quantities, {len(found.robot.levels)} levels and"
        f" {found.extent.states} states."
    )


def _disagreements(found: Cost) -> Iterator[str]:
    wrong = [each for each in found.agreement if not each.agrees]
    yield f"The programs do not agree on {found.robot.name}, so no cost is given."
    for failure in dict.fromkeys(each.failure for each in wrong if each.failure):
        yield f"engines: {failure}"
    for each in wrong:
        if not each.failure:
            yield (
                f"engines differ: {each.quantity} of {each.level}: {each.left} and {each.right} by"
                f" {each.measured:.1e} of its size, tolerance {each.tolerance:.1e}"
            )


def off_words(distances: np.ndarray) -> str:
    """How far the end effector is off: median and largest of the runs, or how many diverge."""
    lost = int(np.isinf(distances).sum())
    middle, runs = float(np.median(distances)), f"median of {distances.size} runs"
    if np.isinf(middle):
        return f"lost: {lost} of {distances.size} runs diverge"
    most = f"{lost} of them diverge" if lost else f"{length(float(distances.max()))} at most"
    return f"{length(middle)} off ({runs}, {most})"


def lines(found: Cost) -> Iterator[str]:
    """The first lines, then motion, joints, rotors, and what of the files is not used."""
    yield from first_lines(found)
    yield ""
    if found.agrees:
        yield from _details(found)
    for told in (*direct_joints(found), *found.robot.told):
        yield f"note: {told}"


def _details(found: Cost) -> Iterator[str]:
    yield motion_line(found)
    yield from found.beyond
    for each in found.by_joint if found.ratios else ():
        unit = unit_of(found, each.joint)
        yield (
            f"{each.level}, {each.joint}: {amount(each.largest, unit)} at most,"
            f" {amount(each.rms, unit)} rms, {percent(each.share)} of its largest torque"
        )
    for pair in found.pairs[:MOST_PAIRS]:
        rms = amount(pair.rms, unit_of(found, pair.at))
        yield f"{pair.at} by the acceleration of {pair.by}: {rms} rms, {percent(pair.share)}"
    for rotor in found.ratios:
        said = "its spin is coupled to no other joint"
        if rotor.share != 0:
            said = (
                f"its coupling alone is {percent(rotor.share)} in {rotor.at}; below"
                f" {percent(NEGLIGIBLE)} from a ratio of {plain_number(rotor.enough)} on"
            )
        yield f"rotor of {rotor.joint}, ratio {rotor.ratio:g}: {said}"


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


def unit_of(found: Cost, joint: str) -> str:
    """The unit of a joint's torque."""
    return found.units[found.names.index(joint)]


def joined(names: Sequence[str]) -> str:
    """Names as a sentence lists them."""
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last


def digits_of(difference: float) -> int:
    """How many digits are alike where values differ by a part of their size; 15 at most."""
    return 15 if difference < 1e-15 else int(-np.log10(difference))


def plain_number(value: float) -> str:
    """Three digits of a number, without an exponent."""
    return str(np.format_float_positional(float(f"{value:.3g}"), trim="-"))


def amount(value: float, unit: str) -> str:
    """A quantity as people write it: three digits, and a prefix that keeps them short."""
    rounded = float(f"{value:.3g}")
    for prefix, factor in PREFIXES.items():
        if abs(rounded) >= factor:
            return f"{plain_number(rounded / factor)} {prefix}{unit}"
    return f"{'below 1' if rounded else '0'} {prefix if rounded else ''}{unit}"


def length(metres: float) -> str:
    """A distance; infinite where a run diverged."""
    return "diverged" if np.isinf(metres) else amount(metres, "m")


def percent(share: float) -> str:
    """A share in per cent: two digits, three above 100."""
    value = 100 * share
    if 0 < value < LEAST_PERCENT:
        return f"below {LEAST_PERCENT:g} %"
    return f"{plain_number(float(f'{value:.2g}') if share < 0.995 else value)} %"


def cost_json(found: Cost) -> str:
    """JSON text of all but the time histories, units in the names; what is infinite is null.

    Where the programs disagree there are no costs.
    """
    data = {
        "schema_version": SCHEMA_VERSION,
        "robot": found.robot.name,
        "program": f"geararm-crosscheck {__version__}",
        "answers": list(first_lines(found)),
        "engines_agree": found.agrees,
        "engines": [{**plain(each), "size": QUANTITIES[each.quantity]} for each in found.agreement],
        "states": found.extent.states,
        "seed": found.seed,
        **(_costs(found) if found.agrees else {}),
        "negligible_share": NEGLIGIBLE,
        "notes": [*direct_joints(found), *found.robot.told],
    }
    return document(data)


def _costs(found: Cost) -> dict[str, object]:
    robot = found.robot
    names = zip(found.names, found.units, found.largest, found.by_rates, strict=True)
    return {
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
        "negligible_with_ratios_times": found.factor,
    }


def cost_page(found: Cost) -> str:
    """The page on a robot's costs: HTML text, figure inlined."""
    from crosscheck.report.plots.figures import to_svg
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
        amount=amount,
        unit_of=unit_of,
        percent=percent,
        length=length,
        plain_number=plain_number,
        negligible=percent(NEGLIGIBLE),
        drawing=to_svg(torque_figure(found)) if found.agrees else "",
    )


def torque_figure(found: Cost) -> Figure:
    """Torques on the left, what armature misses of them on the right; a colour for each level."""
    from matplotlib.figure import Figure

    costs = np.abs(found.errors["armature"]).max(axis=0) / np.maximum(found.largest, 1e-300)
    chosen = sorted(np.argsort(-costs, kind="stable")[:MOST_DRAWN])
    figure = Figure(figsize=(9, 1.9 * len(chosen) + 0.4), layout="constrained")
    axes = figure.subplots(len(chosen), 2, sharex=True, squeeze=False)
    for (left, right), joint in zip(axes, chosen, strict=True):
        torque = found.torques[:, joint]
        without = torque + found.errors["links"][:, joint]
        missed = found.errors["armature"][:, joint]
        left.plot(found.time, torque, COLOURS["coupled"], lw=1.2, label="coupled")
        left.plot(found.time, without, COLOURS["links"], lw=0.8, ls="--", label="links")
        right.plot(found.time, missed, COLOURS["armature"], lw=0.8, label="armature less coupled")
        named = f"{found.names[joint]}\n[{found.units[joint]}]"
        left.set_ylabel(named, parse_math=False)  # a name may hold a dollar
    for each, title in zip(axes[0], ("torque", "error of armature"), strict=True):
        each.legend(loc="upper right", fontsize="small")
        each.set_title(title, fontsize="medium")
    for each in axes[-1]:
        each.set_xlabel("time [s]")
    return figure
