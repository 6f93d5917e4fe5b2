"""Costs of a robot's shortcuts, as lines for the terminal, as JSON and as a page."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crosscheck import __version__
from crosscheck.analytic.robot.springs import replace_stages_by_rotors
from crosscheck.checks.robot_states import SIZE_WORDS
from crosscheck.cost.meshes import RESOLVED, GearedCost
from crosscheck.cost.motion import describe_passive
from crosscheck.cost.shortcuts import NEGLIGIBLE, ShortcutCosts
from crosscheck.findings import Finding
from crosscheck.models.robot.identity import find_identity_joints
from crosscheck.models.robot.robot import LEVELS, Level, Robot
from crosscheck.registry import engine_of
from crosscheck.report.formatting import join_words
from crosscheck.report.records import format_json, to_json_value

if TYPE_CHECKING:  # drawing libraries are slow to import, and most commands draw nothing
    from matplotlib.figure import Figure

SCHEMA_VERSION = 1
MOST_PAIRS = 6
MOST_DRAWN = 8  # joints of the picture, those that armature costs most
NEARLY_WORST = 0.9  # share of the largest cost, at most a whole torque, from which to name joints
SENTENCES: dict[Level, str] = {
    "links": "Leaving the rotors out of {}",
    "armature": "Counting them as armature only",
}
SHORTCUT_LABELS: dict[Level, str] = {"links": "rotors left out", "armature": "armature only"}
COLOURS: dict[Level, str] = {"coupled": "C0", "links": "C1", "armature": "C2"}
COUNTS = {2: "Two", 3: "Three", 4: "Four", 5: "Five"}
PREFIXES = {"k": 1e3, "": 1.0, "m": 1e-3, "\u00b5": 1e-6, "n": 1e-9}
LEAST_PERCENT = 0.001


def describe_answers(costs: ShortcutCosts) -> Iterator[str]:
    """Lines that answer: shortcuts' cost, rotors, causes, negligible ratios, agreement of engines.

    If engines disagree, no cost is given, since each one of them might be wrong.
    """
    if not costs.agrees:
        yield from _describe_disagreements(costs)
        return
    if not costs.ratios:
        yield from _describe_lack(costs)
        yield _describe_agreement(costs)
        return
    yield from _describe_costs(costs)
    yield from _describe_rotors(costs)
    yield from _describe_coupling(costs)
    yield _describe_agreement(costs)


def _describe_coupling(costs: ShortcutCosts) -> Iterator[str]:
    """Lines on what armature omits: where it is largest, ratios that hide it, meshes."""
    if costs.pairs:
        named = ", ".join(
            f"{pair.at} by {pair.by} ({format_percent(pair.share)})" for pair in costs.pairs[:3]
        )
        yield f"Coupling that armature omits, rms, relative to the largest torque: {named}."
    limit = format_percent(NEGLIGIBLE)
    yield from _describe_identity(costs.robot)
    if costs.factor == 0:
        yield (
            f"At any ratio the peak of this coupling stays below {limit}, with the same reflected"
            " inertias."
        )
    else:
        largest = max(each.share for each in costs.by_joint if each.level == "armature")
        would = f"would fall below {limit} of every joint's largest torque"
        if largest < NEGLIGIBLE:
            would = f"would reach {limit} of a joint's largest torque only"
        yield (
            f"The peak of this coupling ({format_percent(largest)}) {would} if all ratios were"
            f" {format_number(costs.factor)} times as large, with the same reflected inertias."
        )
    if costs.geared:
        yield from _describe_meshes(costs.geared)


def _describe_identity(robot: Robot) -> Iterator[str]:
    """The note on joints where links identified with armature already absorb the coupling."""
    joints = find_identity_joints(robot)
    if not joints:
        return
    rotors = {robot.joints[rotor.joint].name for rotor in robot.rotors}
    named = "every joint" if len(joints) == len(rotors) else join_words(joints)
    yield (
        f"These costs assume link parameters from CAD. At {named} the stator is taken to be on the"
        " link before the joint, with its axis along the joint's. There, links identified with an"
        " armature model absorb this coupling already, and may be physically impossible."
    )


def _describe_lack(costs: ShortcutCosts) -> Iterator[str]:
    """Lines for a robot whose joints have an armature but no ratio."""
    joints = [joint.name for joint in costs.robot.joints if joint.armature]
    yield from _describe_costs(costs, ["links"])
    yield (
        f"The cost of armature depends on the ratio of {join_words(joints)}, the only number that"
        " is missing: --ratio gives it, or a robot file."
    )


def _describe_costs(
    costs: ShortcutCosts, levels: Sequence[Level] = tuple(SENTENCES)
) -> Iterator[str]:
    """A sentence for each shortcut: torques, and the end effector."""
    for level in levels:
        head = SENTENCES[level]
        shares = [each for each in costs.by_joint if each.level == level]
        most = max(each.share for each in shares)
        if not most:
            yield f"{head.format(costs.robot.name)} changes no torque."
            continue
        worst = [each.joint for each in shares if each.share >= NEARLY_WORST * min(most, 1.0)]
        torques, whose = f"torque of {worst[0]} is", "its largest value"
        if len(worst) > 1:
            named = "every joint" if len(worst) == len(shares) else join_words(worst)
            torques, whose = f"torques of {named} are", "their largest values"
        (tip,) = (each for each in costs.tips if each.level == level)
        yield (
            f"{head.format(costs.robot.name)}: the {torques} wrong by up to"
            f" {format_percent(most)} of {whose}, and after 1 s of feed-forward the end effector is"
            f" {describe_distances(tip.distances)}."
        )


def _describe_rotors(costs: ShortcutCosts) -> Iterator[str]:
    """The line of the rotors' ratios and inertias, those that are alike together."""
    alike: dict[str, list[str]] = {}
    for rotor in costs.robot.rotors:
        numbers = f"ratio {rotor.ratio:g}, {rotor.inertia:g} kg m^2"
        alike.setdefault(numbers, []).append(costs.robot.joints[rotor.joint].name)
    if alike:
        parts = [f"{numbers} at {join_words(names)}" for numbers, names in alike.items()]
        yield f"Rotors: {'; '.join(parts)}."


def _describe_meshes(geared: GearedCost) -> Iterator[str]:
    for mesh in geared.meshes:
        yield (
            f"The {mesh.name}, rigid at coupled, has a backlash of"
            f" {format_quantity(mesh.backlash, mesh.unit)}, a wind-up of"
            f" {format_quantity(mesh.windup, mesh.unit)}"
            f" at most, and swings at {format_quantity(mesh.slowest, 'Hz')} or more."
        )
    if geared.distances is None:
        most = format_quantity(geared.steps * RESOLVED / (2 * np.pi), "Hz")
        yield f"No run of the level geared: {most} ask for {geared.steps} steps a second."
    else:
        off = describe_distances(geared.distances)
        yield f"With teeth that give way, under the torques of coupled, the end effector is {off}."


def _describe_engines(costs: ShortcutCosts) -> list[str]:
    """The engines' names; one that lacks a level is followed by the levels that it has."""
    levels: dict[str, dict[str, None]] = {}
    for each in costs.agreement:
        for model in (each.left, each.right):
            levels.setdefault(engine_of(model), {})[level_of(each)] = None
    return [
        name
        if len(engine_levels) == len(costs.robot.levels)
        else f"{name} ({', '.join(engine_levels)})"
        for name, engine_levels in levels.items()
    ]


def _describe_digits(costs: ShortcutCosts) -> str:
    count = len(_describe_engines(costs))
    digits = digits_of(max(each.measured or 0.0 for each in costs.agreement))
    return f"{COUNTS.get(count, str(count))} programs agree on this robot to {digits} digits"


def _describe_agreement(costs: ShortcutCosts) -> str:
    return (
        f"{_describe_digits(costs)}: {join_words(_describe_engines(costs))}, on"
        f" {len(SIZE_WORDS)} quantities, {len(costs.robot.levels)} levels and"
        f" {costs.extent.states} states."
    )


def _describe_disagreements(costs: ShortcutCosts) -> Iterator[str]:
    wrong = [each for each in costs.agreement if each.verdict != "agree"]
    yield f"The programs do not agree on {costs.robot.name}, so no cost is given."
    for failure in dict.fromkeys(each.note for each in wrong if each.measured is None):
        yield f"engines: {failure}"
    for each in wrong:
        if each.measured is not None:
            names = " and ".join(map(engine_of, (each.left, each.right)))
            yield (
                f"engines differ: {quantity_of(each)} of {level_of(each)}: {names} by"
                f" {each.measured:.1e} of its size, tolerance {each.tolerance:.1e}"
            )


def level_of(finding: Finding) -> str:
    """The level of which a finding compares two models."""
    return finding.left.partition(":")[2]


def quantity_of(finding: Finding) -> str:
    """A finding's quantity in words."""
    return finding.quantity.replace("_", " ")


def describe_distances(distances: np.ndarray) -> str:
    """The distance of the end effector: median and largest of the runs, or how many diverge."""
    lost = int(np.isinf(distances).sum())
    middle, runs = float(np.median(distances)), f"median of {distances.size} runs"
    if np.isinf(middle):
        return f"lost: {lost} of {distances.size} runs diverge"
    most = f"{lost} of them diverge" if lost else f"{format_length(float(distances.max()))} at most"
    return f"{format_length(middle)} off ({runs}, {most})"


def describe_result(costs: ShortcutCosts) -> Iterator[str]:
    """The answers, then the motion, its excesses, and unused elements of the files."""
    yield from describe_answers(costs)
    yield ""
    if costs.agrees:
        yield describe_motion(costs)
        yield from costs.beyond
    for note in (*describe_direct_joints(costs), *costs.robot.notes):
        yield f"note: {note}"


def describe_motion(costs: ShortcutCosts) -> str:
    """The line that names the robot's motion."""
    free = ", ".join(describe_passive(costs.robot, costs.motion.at(costs.time)[0]))
    moving = f"; moving freely: {free}" if free else ""
    return f"motion: {costs.motion}{moving}; end effector: {costs.robot.tip}"


def describe_direct_joints(costs: ShortcutCosts) -> Iterator[str]:
    """Lines on the joints without any rotor and on those that follow others, if there are any."""
    geared = {rotor.joint for rotor in replace_stages_by_rotors(costs.robot).rotors}
    joints = costs.robot.joints
    direct = [
        joint.name
        for number, joint in enumerate(joints)
        if number not in geared and not joint.armature and joint.has_motor
    ]
    if direct:
        yield f"without gears: {', '.join(direct)}"
    single = [joints[stage.joint].name for stage in costs.robot.stages if stage.has_free_planets]
    if single:
        yield f"not at the level geared: planets share a load by their teeth in {', '.join(single)}"
    follow = [joint.name for joint in joints if joint.mimic is not None]
    if follow:
        yield f"follow other joints: {', '.join(follow)}"


def unit_of(costs: ShortcutCosts, joint: str) -> str:
    """The unit of a joint's torque."""
    return costs.units[costs.names.index(joint)]


def digits_of(difference: float) -> int:
    """The number of digits that agree where values differ by a share of their size; 15 at most."""
    return 15 if difference < 1e-15 else int(-np.log10(difference))


def format_number(value: float) -> str:
    """Three digits of a number, without an exponent."""
    return str(np.format_float_positional(float(f"{value:.3g}"), trim="-"))


def format_quantity(value: float, unit: str) -> str:
    """A quantity as people write it: three digits, and a prefix that keeps them short."""
    rounded = float(f"{value:.3g}")
    for prefix, factor in PREFIXES.items():
        if abs(rounded) >= factor:
            return f"{format_number(rounded / factor)} {prefix}{unit}"
    return f"{'below 1' if rounded else '0'} {prefix if rounded else ''}{unit}"


def format_length(metres: float) -> str:
    """A distance; infinite where a run diverged."""
    return "diverged" if np.isinf(metres) else format_quantity(metres, "m")


def format_percent(share: float) -> str:
    """A share in per cent: two digits, three above 100."""
    value = 100 * share
    if 0 < value < LEAST_PERCENT:
        return f"below {LEAST_PERCENT:g} %"
    return f"{format_number(float(f'{value:.2g}') if share < 0.995 else value)} %"


def cost_json(costs: ShortcutCosts) -> str:
    """JSON text of all but the time histories, units in the names; infinite numbers are null.

    If the engines disagree, there are no costs.
    """
    data = {
        "schema_version": SCHEMA_VERSION,
        "robot": costs.robot.name,
        "program": f"geararm-crosscheck {__version__}",
        "answers": list(describe_answers(costs)),
        "engines_agree": costs.agrees,
        "engines": [
            {
                "quantity": quantity_of(each),
                "level": level_of(each),
                "left": engine_of(each.left),
                "right": engine_of(each.right),
                "measured": each.measured,
                "tolerance": each.tolerance,
                "failure": each.note,
                "size": SIZE_WORDS[each.quantity],
            }
            for each in costs.agreement
        ],
        "states": costs.extent.states,
        "seed": costs.seed,
        **(_costs(costs) if costs.agrees else {}),
        "negligible_share": NEGLIGIBLE,
        "notes": [*describe_direct_joints(costs), *costs.robot.notes],
    }
    return format_json(data)


def _costs(costs: ShortcutCosts) -> dict[str, object]:
    robot = costs.robot
    names = zip(costs.names, costs.units, costs.largest, costs.by_rates, strict=True)
    return {
        "motion": {
            "from": str(costs.motion),
            "beyond_limits": costs.beyond,
            "instants": costs.extent.instants,
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
            for number, (name, unit, largest, by_rates) in zip(costs.joints, names, strict=True)
        ],
        "shortcuts": to_json_value(
            costs.by_joint,
            largest="largest_error",
            rms="rms_error",
            share="share_of_largest_torque",
        ),
        "feed_forward": to_json_value(costs.tips, distances="distances_m"),
        "pairs": to_json_value(costs.pairs, at="joint"),
        "ratios": to_json_value(
            costs.ratios, joint="rotor_of", at="most_in", enough="negligible_from"
        ),
        "geared": to_json_value(
            costs.geared,
            name="mesh",
            slowest="slowest_Hz",
            fastest="fastest_Hz",
            distances="distances_m",
        ),
        "negligible_with_ratios_times": costs.factor,
    }


def cost_page(costs: ShortcutCosts) -> str:
    """The page on a robot's costs: HTML text, figure inlined."""
    from crosscheck.report.plots.figures import to_svg
    from crosscheck.report.plots.scheme import draw_robot
    from crosscheck.report.rendering import render_page

    has_costs = bool(costs.agrees and costs.ratios)
    return render_page(
        "cost",
        found=costs,
        has_costs=has_costs,
        answers=list(_describe_costs(costs) if has_costs else describe_answers(costs)),
        rotors=list(_describe_rotors(costs)),
        agreement=_describe_agreement(costs) if has_costs else "",
        coupling=list(_describe_coupling(costs)) if has_costs else [],
        digits=_describe_digits(costs),
        motion=describe_motion(costs),
        notes=[*describe_direct_joints(costs), *costs.robot.notes],
        levels={level: LEVELS[level] for level in costs.robot.levels},
        engines=_describe_engines(costs),
        rows=list(_tabulate_agreement(costs)),
        pairs=costs.pairs[:MOST_PAIRS],
        amount=format_quantity,
        unit_of=unit_of,
        percent=format_percent,
        length=format_length,
        plain_number=format_number,
        negligible=format_percent(NEGLIGIBLE),
        scheme=draw_robot(costs.robot),
        shares=to_svg(draw_shares(costs)) if has_costs else "",
        drawing=to_svg(draw_torques(costs)) if costs.agrees else "",
    )


class AgreementRow(NamedTuple):
    """A quantity on the page: its largest difference at each level, and the relative tolerance."""

    quantity: str
    cells: tuple[str, ...]
    tolerance: str
    size: str


def _tabulate_agreement(costs: ShortcutCosts) -> Iterator[AgreementRow]:
    for quantity, size in SIZE_WORDS.items():
        findings = [each for each in costs.agreement if each.quantity == quantity]
        cells = []
        for level in costs.robot.levels:
            at_level = [each for each in findings if level_of(each) == level]
            largest = max(np.inf if f.measured is None else f.measured for f in at_level)
            agrees = all(each.verdict == "agree" for each in at_level)
            cells.append(f"{largest:.1e}{'' if agrees else ' differs'}")
        tolerance = max(each.tolerance or 0.0 for each in findings)
        yield AgreementRow(quantity.replace("_", " "), tuple(cells), f"{tolerance:.1e}", size)


def draw_shares(costs: ShortcutCosts) -> Figure:
    """Dots at each joint's largest error in per cent of its largest torque."""
    from crosscheck.report.plots.dots import draw_dots

    shares = {
        label: [100 * each.share for each in costs.by_joint if each.level == level]
        for level, label in SHORTCUT_LABELS.items()
    }
    colours = [COLOURS[level] for level in SHORTCUT_LABELS]
    axis_label = "largest torque error [% of the joint's largest torque]"
    return draw_dots(costs.names, shares, colours, axis_label)


def draw_torques(costs: ShortcutCosts) -> Figure:
    """Draw torques on the left and the error of armature on the right, a colour for each level."""
    from matplotlib.figure import Figure

    from crosscheck.report.plots.figures import draw_legend

    error_shares = np.abs(costs.errors["armature"]).max(axis=0) / np.maximum(costs.largest, 1e-300)
    chosen = sorted(np.argsort(-error_shares, kind="stable")[:MOST_DRAWN])
    figure = Figure(figsize=(9, 1.9 * len(chosen) + 0.4), layout="constrained")
    axes = figure.subplots(len(chosen), 2, sharex=True, squeeze=False)
    for (left, right), joint in zip(axes, chosen, strict=True):
        torque = costs.torques[:, joint]
        without = torque + costs.errors["links"][:, joint]
        missed = costs.errors["armature"][:, joint]
        left.plot(costs.time, torque, COLOURS["coupled"], lw=1.2, label="coupled")
        left.plot(costs.time, without, COLOURS["links"], lw=0.8, ls="--", label="links")
        right.plot(costs.time, missed, COLOURS["armature"], lw=0.8, label="armature minus coupled")
        named = f"{costs.names[joint]}\n[{costs.units[joint]}]"
        left.set_ylabel(named, parse_math=False)  # a name may hold a dollar
    for each, title in zip(axes[0], ("torque", "error of armature"), strict=True):
        each.set_title(title, fontsize="medium")
    for each in axes[-1]:
        each.set_xlabel("time [s]")
    draw_legend(figure, *axes[0])
    return figure
