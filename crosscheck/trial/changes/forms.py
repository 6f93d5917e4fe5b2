"""Parts of equations that are put together wrongly, whatever the numbers.

Rows that are others, a coordinate that is another, sines of small angles, the solution for the
accelerations; and one factor of one kind of terms of Kane's sum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, permutations

import numpy as np

from crosscheck.analytic.robot.model import AnalyticRobot, multiply
from crosscheck.report.formatting import join_words
from crosscheck.trial.changes.kane import FACTORS, KaneSum
from crosscheck.trial.changes.numbers import ALIKE
from crosscheck.trial.changes.problem import ACCELERATION, ChangeProblem, DynamicsTerms
from crosscheck.trial.changes.search import CauseSearch

SIZABLE = 1e-9  # smallest piece that can be recognized, relative to an entry's size
Form = tuple[str, np.ndarray]  # words, and the change of a part's values
FormKind = Callable[[ChangeProblem, str], Iterator[Form]]
AT_ONCE = 300  # states at which a model is asked together; all at once would take gigabytes
CoordinateChange = tuple[str, np.ndarray, np.ndarray]  # words, q and v (states, n)


def find_forms(problem: ChangeProblem, part: str, kinds: Sequence[FormKind] = ()) -> Iterator[str]:
    """Words on each other form of a part that gives the user's values; kinds: of these, or all."""
    wrong = problem.differences[part]
    least = ALIKE * np.abs(wrong).max()
    for generate in kinds or KINDS:
        for words, change in generate(problem, part):
            if np.abs(wrong - change).max() <= least:
                yield words


def scale_part(problem: ChangeProblem, part: str) -> Iterator[Form]:
    """All of a part by a usual factor."""
    for factor, words in FACTORS.items():
        yield f"all of it {words}", (factor - 1) * problem.right[part]


def exchange_rows(problem: ChangeProblem, part: str) -> Iterator[Form]:
    """Rows of two coordinates exchanged, or one in the place of the other; of M columns too."""
    right, names, count = problem.right[part], problem.coordinate_names, len(problem.right[part][0])
    for i, j in permutations(range(count), 2):
        order = list(range(count))
        order[i], order[j] = j, i
        pair, copied = f"of {names[i]} and {names[j]} are exchanged in it", list(range(count))
        copied[i] = j
        yield f"the row of {names[i]} is that of {names[j]}", right[:, copied] - right
        if i < j:
            yield f"the rows {pair}", right[:, order] - right
        if i < j and part == "mass_matrix":
            yield f"the columns {pair}", right[:, :, order] - right
            yield f"the rows and columns {pair}", right[:, order][:, :, order] - right


def change_coordinates(problem: ChangeProblem, part: str) -> Iterator[Form]:
    """One coordinate, or its rate, that is another one in M, bias or gravity; two exchanged."""
    if part not in DynamicsTerms._fields:
        return
    model, (q, v) = AnalyticRobot(problem.robot, problem.level), problem.states[:2]

    def compute(q: np.ndarray, v: np.ndarray) -> np.ndarray:
        rows = [slice(begin, begin + AT_ONCE) for begin in range(0, len(q), AT_ONCE)]
        if part == "bias":
            return np.concatenate([model.bias(q[some], v[some]) for some in rows])
        return np.concatenate([getattr(model, part)(q[some]) for some in rows])

    wrong, base = problem.differences[part], compute(q, v)
    least = ALIKE * np.abs(wrong).max()
    kept = list(_list_coordinate_changes(problem, by_rates=part == "bias"))
    for states in (slice(1), slice(None)):  # most differ at the first state
        if not kept:
            return
        moved = (np.concatenate([each[k][states] for each in kept]) for k in (1, 2))
        values = compute(*moved).reshape(len(kept), -1, *base.shape[1:]) - base[states]
        changes = problem.carry(part, values)
        left = np.abs(changes - wrong[states]).reshape(len(kept), -1).max(axis=1)
        kept = [each for each, by in zip(kept, left, strict=True) if by <= least]
        changes = changes[left <= least]
    yield from ((words, change) for (words, *_), change in zip(kept, changes, strict=True))


def _list_coordinate_changes(
    problem: ChangeProblem, *, by_rates: bool
) -> Iterator[CoordinateChange]:
    """Sentences' ends on one coordinate that is another, or two, with q and v (states, n) so."""
    robot, (q, v) = problem.robot, problem.states[:2]
    names = robot.coordinate_names
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


def take_small_angles(problem: ChangeProblem, part: str) -> Iterator[Form]:
    """Gravity in which the sine of one angle, or of all, is the angle."""
    if part != "gravity":
        return
    robot, q = problem.robot, problem.states.q
    gravity = AnalyticRobot(robot, problem.level).gravity
    right = gravity(q)
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
        angle, name = q[:, [j]], robot.coordinate_names[j]
        linear = linear + slope / 2 * angle
        for words, near in (("1", 1.0), ("1 - x^2/2", 1 - angle**2 / 2)):
            small = middle + cosine / 2 * near + sine / 2 * angle
            words = f"the sine of {name} is {name} and its cosine {words}"
            yield words, problem.carry(part, small - right)
    yield "linear in the angles, as it is near 0 alone", problem.carry(part, linear - right)


def solve_otherwise(problem: ChangeProblem, part: str) -> Iterator[Form]:
    """Accelerations of the right M, bias and gravity that are put together wrongly."""
    if part != ACCELERATION:
        return
    q, v, _, torques = problem.states
    terms = AnalyticRobot(problem.robot, problem.level).terms(q, v)
    named = zip(("mass_matrix", "bias", "gravity", "torques"), (*terms, torques), strict=True)
    mass, bias, gravity, torques = (problem.carry(*each) for each in named)
    if mass.shape[1] > q.shape[1]:  # displacements of gears, which have no inertia in this robot
        return
    load, diagonal = torques - bias - gravity, np.einsum("sii->si", mass)
    with np.errstate(divide="ignore", invalid="ignore"):
        entries = multiply(np.where(mass, 1 / mass, 0.0), load)
    inverse = np.linalg.inv(mass)
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
        sentence = f"M^-1 (torques - bias - gravity); yours is {words}"
        yield sentence, values - multiply(inverse, load)


KINDS = (change_coordinates, take_small_angles, exchange_rows, solve_otherwise)


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
            words = f"{part}: {which}: {format_factor(1 + by)}"
            described.append((0 if whole else len(chosen), words))
        if described:
            break
    fewest = min((count for count, _ in described), default=0)
    yield from (words for count, words in described if count == fewest)


def format_factor(factor: float) -> str:
    """How large what is wrong is beside what is right."""
    usual = [words for by, words in FACTORS.items() if abs(factor - by) < ALIKE]
    return usual[0] if usual else f"{factor:.6g} times as large"
