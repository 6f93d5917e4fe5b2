"""Sentences on kinds of terms, friction, accelerations, mirror images and waves that are wrong."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, combinations_with_replacement, product

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot
from crosscheck.checks.robot_states import TOLERANCE
from crosscheck.models.robot.robot import BASE, Level, Robot
from crosscheck.report.formatting import join_words, list_first
from crosscheck.trial.changes.kane import FACTORS, KaneSum
from crosscheck.trial.changes.numbers import ALIKE, get_link_name
from crosscheck.trial.changes.problem import DynamicsTerms
from crosscheck.trial.changes.search import CauseSearch, measure_rest
from crosscheck.trial.judge.entries import PART_TITLES, format_rates
from crosscheck.trial.robots.consistency import sample_bias_terms
from crosscheck.trial.robots.judge import RobotProblem

MOST_ANGLES = 7  # largest number of angles whose sums are tried: 3^n of them
FITS = 1e-8  # largest residual of a fitted wave, relative to the difference
SIZABLE = 1e-9  # smallest piece that can be recognized, relative to an entry's size


def list_acceleration_pieces(problem: RobotProblem, level: Level) -> dict[str, np.ndarray]:
    """Contribution of each motor, the weights and each product of rates to the accelerations."""
    states, names = problem.states, problem.names
    model = AnalyticRobot(problem.robot, level)
    inverse = np.linalg.inv(model.mass_matrix(states.q))
    forces = {"the weights": -model.gravity(states.q), "the springs": -problem.spring_torques}
    for number, name in enumerate(names):
        torque = np.zeros_like(states.torques)
        torque[:, number] = states.torques[:, number]
        forces[f"the torque of {name}"] = torque
    products = sample_bias_terms(model.bias, states).products
    for j, k in combinations_with_replacement(range(len(names)), 2):
        rates = format_rates((j, k), names)
        forces[rates] = -products[:, :, j, k] * (states.v[:, j] * states.v[:, k])[:, None]
    return {name: np.einsum("sij,sj->si", inverse, each) for name, each in forces.items()}


def describe_friction(
    problem: RobotProblem, level: Level, part: str, difference: np.ndarray
) -> Iterator[tuple[str, list[int]]]:
    """Sentences on friction that a force or bias has wrong, and the rows that it makes wrong.

    difference (states, n): yours less right, at the first states.
    """
    first = slice(len(difference))
    where = problem.answers.sources[part]
    size = np.broadcast_to(problem.sizes[level].entry_sizes(part, where), problem.states.v.shape)
    # What is right of a bias that seems to have none has none either.
    is_there = part == "force" or where == "inverse_dynamics" or problem.answers.friction_in_bias
    rows_by_factor: dict[str, list[int]] = {}
    for row in range(len(problem.names)):
        friction, wrong = problem.friction[first, row], difference[:, row]
        friction = -friction if part == "force" else friction
        least = SIZABLE * float(size[:, row].max())
        if np.abs(wrong).max() <= least or np.abs(friction).max() <= least:
            continue
        share = float(wrong @ friction / (friction @ friction))
        if np.abs(wrong - share * friction).max() <= ALIKE * np.abs(wrong).max():
            rows_by_factor.setdefault(format_factor(is_there + share), []).append(row)
    for factor, rows in rows_by_factor.items():
        names = [problem.names[row] for row in rows]
        entry = f"{where}[{names[0]}]" if len(names) == 1 else where
        yield f"{entry}, the friction of {join_words(names)}: {factor}", rows


def describe_accelerations(
    problem: RobotProblem, level: Level, rows: Sequence[int]
) -> Iterator[str]:
    """Sentences on rows of an acceleration in which one or two pieces are wrong by a factor."""
    sides = problem.answers.values, problem.reference_values[level]
    user_values, right = (values["acceleration"] for values in sides)
    pieces, sizes = list_acceleration_pieces(problem, level), problem.sizes[level].acceleration
    described = False
    for row in rows:
        wrong, least = user_values[:, row] - right[:, row], SIZABLE * float(sizes[:, row].max())
        there = {name: each[:, row] for name, each in pieces.items()}
        there = {name: each for name, each in there.items() if np.abs(each).max() > least}
        for names in (*combinations(there, 1), *combinations(there, 2)):
            total = np.sum([there[name] for name in names], axis=0)
            share = float(total @ wrong / (total @ total)) if total.any() else 0.0
            if np.abs(wrong - share * total).max() <= ALIKE * np.abs(wrong).max():
                part = f"the part due to {join_words(names)}"
                yield f"acceleration[{problem.names[row]}], {part}: {format_factor(1 + share)}"
                described = True
                break
    ratios = user_values / right
    if not described and len(rows) > 1 and np.ptp(ratios, axis=1).max() <= ALIKE * ratios.max():
        yield (
            "acceleration: at each state all rows are wrong by the same factor, from"
            f" {ratios.min():.4g} to {ratios.max():.4g}: their common denominator, M's determinant"
        )


def describe_pieces(search: CauseSearch, part: str, *, are_usual: bool = True) -> Iterator[str]:
    """Sentences on kinds of terms of Kane's sum that are wrong by one factor in M, bias or gravity.

    Of an acceleration, in the bias that it comes from. All terms of a kind come first, then the
    kinds of which fewest are wrong. are_usual: whether by usual factors alone, since terms that do
    not depend on the rates are often equal by chance.
    """
    problem, table = search.problem, search.table
    term = "bias" if part == "acceleration" else part
    described: list[tuple[int, str]] = []
    for parts in table.part_lists:
        kinds = KaneSum(table.robot, *problem.states[:2], parts).list_pieces(term)
        for kind, pieces in kinds.items():
            stacked = np.array(list(pieces.values()))
            base = table.compute_base(search.level)._asdict()
            blank = {name: np.zeros((len(stacked), *each.shape)) for name, each in base.items()}
            rows = search.row(DynamicsTerms(**(blank | {term: stacked})))
            places = problem.select_part(part)
            chosen, by = search.choose_rows(rows[:, places], places, is_free=True)
            if not chosen or (are_usual and all(abs(1 + by - usual) > ALIKE for usual in FACTORS)):
                continue
            names, there = list(pieces), (np.abs(rows).max(axis=1) > SIZABLE).sum()
            whole = len(chosen) == there > 1
            of_links = f"{kind} of {join_words([names[n] for n in chosen])}"
            which = kind.replace("the", "every", 1) if whole else of_links
            words = f"{PART_TITLES.get(part, part)}: {which}: {format_factor(1 + by)}"
            described.append((0 if whole else len(chosen), words))
        if described:
            break
    fewest = min((count for count, _ in described), default=0)
    yield from (words for count, words in described if count == fewest)


def format_factor(factor: float) -> str:
    """How large what is wrong is beside what is right."""
    usual = (words for by, words in FACTORS.items() if abs(factor - by) < ALIKE)
    words = next(usual, f"{factor:.6g} times as large")
    return f"yours is {words}" if words.endswith("large") else words


def describe_asymmetry(problem: RobotProblem, level: Level) -> str:
    """The sentence on entries of M that differ from their mirror images; '' for none."""
    if "mass_matrix" not in problem.parts:
        return ""
    mass, size = problem.answers.values["mass_matrix"], problem.sizes[level].mass_matrix
    errors = np.abs(problem.relative_errors(level)["mass_matrix"]).max(axis=0)
    wrong: np.ndarray = ~(errors <= problem.sizes[level].tolerance("mass_matrix"))
    for which, half in (("below", np.tri(len(wrong), k=-1)), ("above", np.tri(len(wrong), k=-1).T)):
        if wrong.any() and not (mass * half).any() and not (wrong & (half == 0)).any():
            return (
                f"M is 0 {which} the diagonal, and right elsewhere: is one of its"
                " triangles alone filled?"
            )
    unequal = (np.abs(mass - mass.swapaxes(1, 2)) > TOLERANCE * size).any(axis=0)
    pairs = np.argwhere(np.triu(unequal & (wrong | wrong.T), 1)).tolist()
    if not pairs:
        return ""
    if len(pairs) == 1:
        place, mirror = sorted((pairs[0], pairs[0][::-1]), key=lambda each: not wrong[tuple(each)])
        name, mirror_name = (problem.entry_name("mass_matrix", each) for each in (place, mirror))
        also = "both are wrong" if wrong[tuple(mirror)] else f"{mirror_name} is right"
        return f"M is not symmetric: {name} differs from {mirror_name}; {also}"
    rows, columns = (np.array(~wrong.any(axis=axis)) for axis in (1, 0))
    lines, right = ("rows", rows) if rows.any() else ("columns", columns)
    names = [problem.entry_name("mass_matrix", each) for each in pairs]
    if not right.any():
        return f"M is not symmetric in {len(pairs)} pairs: {list_first(names)}"
    also = f"{_join_places(lines, right)} right, {_join_places(lines, ~right)} wrong"
    also += _describe_way(problem.robot, lines, right) if rows.any() != columns.any() else ""
    return f"M is not symmetric in {len(pairs)} pairs; {also}"


def _describe_way(robot: Robot, lines: str, right: np.ndarray) -> str:
    """State between which links the outward or inward recursion fails, by right rows or columns.

    A wrong row means wrong forces at a joint, a wrong column wrong accelerations: at one joint and
    at all before it, if the recursion fails between two links.
    """
    if len(right) != len(robot.joints):
        return ""  # rows of joints that others follow are sums
    steps = [(n, joint.parent) for n, joint in enumerate(robot.joints) if joint.parent != BASE]
    broken = [(after, before) for after, before in steps if right[after] != right[before]]
    if len(broken) != 1 or not right[broken[0][0]]:
        return ""
    after, before = (get_link_name(robot, number) for number in broken[0])
    if lines == "rows":
        return f": forces go wrong on their way back, from {after} to {before}"
    return f": accelerations go wrong on their way out, from {before} to {after}"


def _join_places(lines: str, chosen: np.ndarray) -> str:
    """The chosen rows or columns by numbers from 1, such as `rows 1 and 4 to 7 are`."""
    numbers, runs = np.flatnonzero(chosen) + 1, list[str]()
    for run in np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1):
        runs += [f"{run[0]} to {run[-1]}"] if len(run) > 2 else [str(each) for each in run]
    line, verb = (lines, "are") if len(numbers) > 1 else (lines[:-1], "is")
    return f"{line} {join_words(runs)} {verb}"


def describe_angle_sum(difference: np.ndarray, q: np.ndarray, robot: Robot) -> str:
    """The difference (states,) at q (states, n) in words, such as `-20.6 cos(j1)`; '' for no wave.

    A wave is of a sum of angles, each with a sign; its factor may be linear in one displacement.
    """
    joints = [robot.joints[number] for number in robot.coordinates]
    turning = [n for n, joint in enumerate(joints) if joint.kind == "revolute"]
    factors = {"": np.ones(len(q))}
    factors |= {f" {each.name}": q[:, n] for n, each in enumerate(joints) if n not in turning}
    size = float(np.abs(difference).max())
    if len(turning) > MOST_ANGLES or not size:
        return ""
    signs = _list_signs(len(turning))
    angles = signs @ q[:, turning].T
    waves = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    columns = np.stack([factor * waves for factor in factors.values()], axis=1)
    rest = measure_rest(difference, columns[..., 0, :], columns[..., 1, :])
    near = np.sqrt(len(q)) * 10 * FITS * size  # no wave further off fits, whatever the rounding
    for wave, place in np.argwhere(rest <= near).tolist():
        fit, *_ = np.linalg.lstsq(columns[wave, place].T, difference, rcond=1e-12)
        if np.abs(difference - fit @ columns[wave, place]).max() <= FITS * size:
            angle = _format_sum(signs[wave], [joints[n].name for n in turning])
            return _format_wave(fit, angle, list(factors)[place])
    for (wave, own), place in product(enumerate(waves), range(1, len(factors))):
        pair = np.concatenate([own, columns[wave, place]])
        fit, _, rank, _ = np.linalg.lstsq(pair.T, difference, rcond=1e-12)
        if len(q) >= 2 * rank and np.abs(difference - fit @ pair).max() <= FITS * size:
            angle = _format_sum(signs[wave], [joints[n].name for n in turning])
            by_place = _format_wave(fit[2:], angle, list(factors)[place])
            return f"{_format_wave(fit[:2], angle, '')} + {by_place}".replace("+ -", "- ")
    return ""


def _list_signs(count: int) -> np.ndarray:
    """Signs of angles in a sum, those of the fewest first; of two opposite ones there is one."""
    signs = np.array(list(product((0.0, 1.0, -1.0), repeat=count))).reshape(3**count, count)
    first = np.take_along_axis(signs, (signs != 0).argmax(axis=1)[:, None], 1) if count else signs
    signs = signs[(first >= 0).all(axis=1)]
    return signs[np.argsort(np.abs(signs).sum(axis=1), kind="stable")]


def _format_sum(signs: np.ndarray, names: Sequence[str]) -> str:
    pairs = [(sign, name) for sign, name in zip(signs, names, strict=True) if sign]
    text = "".join(f" {'+' if sign > 0 else '-'} {name}" for sign, name in pairs)
    return text.removeprefix(" + ")


def _format_wave(fit: np.ndarray, angle: str, factor: str) -> str:
    size = float(np.abs(fit).max())
    if not angle:
        return f"{fit[0]:.6g}{factor}"
    pairs = [(k, f"{name}({angle})") for k, name in zip(fit, ("cos", "sin"), strict=True)]
    kept = [(k, wave) for k, wave in pairs if abs(k) > FITS * size]
    first, *others = kept
    text = f"{first[0]:.6g}{factor} {first[1]}"
    return text + "".join(
        f" {'+' if k > 0 else '-'} {abs(k):.6g}{factor} {wave}" for k, wave in others
    )
