"""Sentences on parts of a robot's equations that are put together wrongly, whatever the numbers.

Of a part what all of its terms have in common: a factor of one kind of terms of Kane's sum, a
coordinate that is another, rows that are exchanged, the bias as derivatives of M, accelerations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, multiply
from crosscheck.models.robot.robot import Level
from crosscheck.trial.changes.kane import KaneSum
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.problem import DynamicsTerms
from crosscheck.trial.changes.search import CauseSearch
from crosscheck.trial.changes.steps import FACTORS
from crosscheck.trial.robots.judge import RobotProblem
from crosscheck.trial.robots.rates import sample_bias_terms

RATIO_POWERS = ("multiplied ", "'s square", 2), ("multiplied ", "", 1), ("divided ", "", -1)
SIZABLE = 1e-9  # smallest piece that can be recognized, relative to an entry's size
CoordinateChange = tuple[str, np.ndarray, np.ndarray]  # words, q and v (states, n)


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
            which = "every one" if whole else " and ".join(names[n] for n in chosen)
            words = f"{part}, what {kind} of {which} makes: {_format_factor(1 + by)}"
            described.append((0 if whole else len(chosen), words))
        if described:
            break
    fewest = min((count for count, _ in described), default=0)
    yield from (words for count, words in described if count == fewest)


def _format_factor(factor: float) -> str:
    usual = [words for by, words in FACTORS.items() if abs(factor - by) < ALIKE]
    return usual[0] if usual else f"{factor:.6g} times as large"


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
    for j, k in zip(*np.triu_indices(len(names)), strict=True):
        rates = f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"
        forces[rates] = -products[:, :, j, k] * (states.v[:, j] * states.v[:, k])[:, None]
    return {name: np.einsum("sij,sj->si", inverse, each) for name, each in forces.items()}


def describe_friction(
    problem: RobotProblem, level: Level, part: str, difference: np.ndarray
) -> Iterator[tuple[str, list[int]]]:
    """Sentences on friction that a force or bias has wrong, and the rows that it makes wrong.

    difference (states, n): yours less right, at the first states.
    """
    first = slice(len(difference))
    where, v = problem.answers.sources[part], problem.states.v[first]
    size = np.broadcast_to(problem.sizes[level].entry_sizes(part, where), problem.states.v.shape)
    # What is right of a bias that seems to have none has none either.
    is_there = part == "force" or where == "inverse_dynamics" or problem.answers.friction_in_bias
    ratios = {each.joint: each.ratio for each in problem.robot.rotors}
    rows_by_factor: dict[str, list[int]] = {}
    for row, name in enumerate(problem.names):
        friction, wrong = problem.friction[first, row], difference[:, row]
        friction = -friction if part == "force" else friction
        least = SIZABLE * float(size[:, row].max())
        if np.abs(wrong).max() <= least or np.abs(friction).max() <= least:
            continue
        share = float(wrong @ friction / (friction @ friction))
        if np.abs(wrong - share * friction).max() <= ALIKE * np.abs(wrong).max():
            ratio = abs(ratios.get(problem.robot.coordinates[row], 1.0))
            near = [
                f", {how}by its ratio{power}"
                for how, power, by in RATIO_POWERS
                if ratio != 1 and abs((is_there + share) / ratio**by - 1) < ALIKE
            ]
            factor = f"{_format_factor(is_there + share)}{''.join(near)}"
            rows_by_factor.setdefault(factor, []).append(row)
            continue
        laws = np.stack([v[:, row], np.sign(v[:, row])], axis=1)
        kinds = laws * np.linalg.lstsq(laws, friction, rcond=None)[0]
        for kind, taken in zip(("viscous", "Coulomb"), kinds.T, strict=True):
            for other, other_name in enumerate(problem.names):
                rate = v[:, other] if kind == "viscous" else np.sign(v[:, other])
                share = float((wrong + taken) @ rate / (rate @ rate))
                left = np.abs(wrong + taken - share * rate).max()
                if other != row and left <= ALIKE * np.abs(wrong).max():
                    law = f"its {kind} friction goes by the rate of {other_name}"
                    yield f"{where}[{name}]: {law}", [row]
    for factor, rows in rows_by_factor.items():
        names = [problem.names[row] for row in rows]
        entry = f"{where}[{names[0]}]" if len(names) == 1 else where
        yield f"{entry}, the friction of {' and '.join(names)}: {factor}", rows


def describe_coordinates(problem: RobotProblem, level: Level, part: str) -> Iterator[str]:
    """Sentences on a coordinate, or its rate, that M, bias or gravity takes for another one."""
    changes = list(_list_coordinate_changes(problem, by_rates=part == "bias"))
    for words in _find_equals(problem, level, part, changes):
        yield f"{part}: {words}"
    if part == "gravity":
        yield from _describe_small_angles(problem, level)
    yield from _describe_exchanges(problem, level, part)


def _find_equals(
    problem: RobotProblem, level: Level, part: str, changes: Sequence[CoordinateChange]
) -> Iterator[str]:
    """Words on those changes of q and v that give the user's values of a part."""
    user_values, model = problem.answers.values[part], AnalyticRobot(problem.robot, level)
    least = ALIKE * np.abs(user_values - problem.reference_values[level][part]).max()
    kept = list(changes)
    for states in (slice(1), slice(None)):  # most differ at the first state
        if not kept:
            return
        q, v = (np.concatenate([each[k][states] for each in kept]) for k in (1, 2))
        values = model.bias(q, v) if part == "bias" else getattr(model, part)(q)
        left = values.reshape(len(kept), -1, *user_values.shape[1:]) - user_values[states]
        left += problem.spring_torques[states] if part == "gravity" else 0.0
        largest = np.abs(left).reshape(len(kept), -1).max(axis=1)
        kept = [each for each, by in zip(kept, largest, strict=True) if by <= least]
    yield from (words for words, *_ in kept)


def _list_coordinate_changes(
    problem: RobotProblem, *, by_rates: bool
) -> Iterator[CoordinateChange]:
    """Sentences' ends on one coordinate that is another, or two, with q and v (states, n) so."""
    robot, names, (q, v) = problem.robot, problem.names, problem.states[:2]
    turning = [robot.joints[number].kind == "revolute" for number in robot.coordinates]
    quarter = np.pi / 2

    def put(values: np.ndarray, places: Sequence[int], others: np.ndarray) -> np.ndarray:
        changed = values.copy()
        changed[:, places] = others
        return changed

    for j, name in enumerate(names):
        old = q[:, [j]]
        others = {"is left out in it": 0 * old, "is with the opposite sign in it": -old}
        others |= {"is twice in it": 2 * old, "is half in it": old / 2}
        if turning[j]:
            others |= {
                "is in degrees in it, read as radians": np.degrees(old),
                "is taken for degrees in it": np.radians(old),
                "is a quarter turn more in it": old + quarter,
                "is a quarter turn less in it": old - quarter,
                "is the opposite of itself, and a quarter turn more": quarter - old,
                "is the opposite of itself, and a quarter turn less": -quarter - old,
                "is half a turn more in it": old + 2 * quarter,
            }
        for k, other in enumerate(names):
            if k != j and turning[k] == turning[j]:
                others[f"has {other} added in it"] = old + q[:, [k]]
                others[f"has {other} taken from it in it"] = old - q[:, [k]]
                others[f"is taken for {other} in it"] = q[:, [k]]
        for words, values in others.items():
            yield f"{name} {words}", put(q, [j], values), v
        rates = {"in degrees": 180 / np.pi, "taken for degrees": np.pi / 180}
        for words, by in rates.items() if by_rates and turning[j] else ():
            yield f"the rate of {name} is {words} in it", q, put(v, [j], by * v[:, [j]])
    for i, j in combinations(range(len(names)), 2):
        pair = f"of {names[i]} and {names[j]} are exchanged in it"
        yield f"the coordinates {pair}", put(q, [i, j], q[:, [j, i]]), v
        if by_rates:
            yield f"the rates {pair}", q, put(v, [i, j], v[:, [j, i]])


def _describe_small_angles(problem: RobotProblem, level: Level) -> Iterator[str]:
    """Sentences on a gravity in which the sine of one angle, or of all, is the angle."""
    robot, q = problem.robot, problem.states.q
    gravity = AnalyticRobot(robot, level).gravity
    user_values = problem.answers.values["gravity"] - problem.spring_torques
    least = ALIKE * np.abs(user_values - gravity(q)).max()
    turning = [n for n, c in enumerate(robot.coordinates) if robot.joints[c].kind == "revolute"]
    still = q.copy()
    still[:, turning] = 0.0
    linear = gravity(still)
    for j in turning:  # gravity is a sum of waves of each angle, so that four angles determine it
        waves = []
        for base in (q, still):
            turned = np.repeat(base[None], 4, axis=0)
            turned[:, :, j] = np.array([0.0, 0.5, 1.0, -0.5])[:, None] * np.pi
            values = gravity(turned.reshape(-1, q.shape[1])).reshape(4, *q.shape)
            waves.append(
                ((values[0] + values[2]) / 2, values[0] - values[2], values[1] - values[3])
            )
        (middle, cosine, sine), (*_, slope) = waves
        angle, name = q[:, [j]], problem.names[j]
        linear = linear + slope / 2 * angle
        for words, near in (("1", 1.0), ("1 - x^2/2", 1 - angle**2 / 2)):
            small = middle + cosine / 2 * near + sine / 2 * angle
            if np.abs(small - user_values).max() <= least:
                yield f"gravity: the sine of {name} is {name} and its cosine {words}"
    if np.abs(linear - user_values).max() <= least:
        yield "gravity: linear in the angles, as it is near 0 alone"


def _describe_exchanges(problem: RobotProblem, level: Level, part: str) -> Iterator[str]:
    """Sentences on two coordinates whose rows a part has exchanged."""
    right, user_values = problem.reference_values[level][part], problem.answers.values[part]
    least = ALIKE * np.abs(user_values - right).max()
    for i, j in combinations(range(len(problem.names)), 2):
        order = list(range(len(problem.names)))
        order[i], order[j] = j, i
        exchanged = {"rows": right[:, order]}
        if part == "mass_matrix":
            exchanged["columns"] = right[:, :, order]
            exchanged["rows and columns"] = right[:, order][:, :, order]
        for what, values in exchanged.items():
            if np.abs(values - user_values).max() <= least:
                pair = f"{problem.names[i]} and {problem.names[j]}"
                yield f"{part}: the {what} of {pair} are exchanged in it"


def describe_solution(problem: RobotProblem, level: Level) -> Iterator[str]:
    """Sentences on accelerations of the right M, bias and gravity that are put together wrongly."""
    q, v, _, torques = problem.states
    model, user_values = AnalyticRobot(problem.robot, level), problem.answers.values["acceleration"]
    mass, bias, gravity = model.terms(q, v)
    gravity = gravity + problem.spring_torques
    load = torques - bias - gravity
    diagonal = np.einsum("sii->si", mass)
    with np.errstate(divide="ignore", invalid="ignore"):
        entries = multiply(np.where(mass, 1 / mass, 0.0), load)
    inverse = np.linalg.inv(mass)
    least = ALIKE * np.abs(user_values - problem.reference_values[level]["acceleration"]).max()
    for words, values in (
        ("by M's diagonal alone, without coupling", load / diagonal),
        ("by the diagonal of M^-1 alone", np.einsum("sii->si", inverse) * load),
        ("by the inverse of each entry of M", entries),
        ("without M^-1", load),
        ("by M where M^-1 belongs", multiply(mass, load)),
        ("with M's lower triangle alone", multiply(np.linalg.inv(np.tril(mass)), load)),
        ("with M's upper triangle alone", multiply(np.linalg.inv(np.triu(mass)), load)),
        ("with gravity outside M^-1", multiply(inverse, load + gravity) - gravity),
        ("with the bias outside M^-1", multiply(inverse, load + bias) - bias),
        ("with the torques outside M^-1", multiply(inverse, load - torques) + torques),
        ("with the opposite sign", -multiply(inverse, load)),
    ):
        if np.abs(values - user_values).max() <= least:
            yield f"acceleration is M^-1 (torques - bias - gravity); yours is {words}"


def describe_accelerations(
    problem: RobotProblem, level: Level, rows: Sequence[int]
) -> Iterator[str]:
    """Sentences on rows of an acceleration in which one or two pieces are wrong by a factor."""
    user_values, right = (
        values["acceleration"]
        for values in (problem.answers.values, problem.reference_values[level])
    )
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
                makes = f"what {' and '.join(names)} make{'s' * (len(names) == 1)}"
                yield f"acceleration[{problem.names[row]}], {makes}: {_format_factor(1 + share)}"
                described = True
                break
    ratios = user_values / right
    if not described and len(rows) > 1 and np.ptp(ratios, axis=1).max() <= ALIKE * ratios.max():
        yield (
            "acceleration: at each state all rows are wrong by the same factor, from"
            f" {ratios.min():.4g} to {ratios.max():.4g}: their common denominator, M's determinant"
        )
