"""Steps of an arm's derivation done otherwise: a body's motion, or how a bias is made of M.

Numbers at states, and no sums of waves: such a step changes every entry at once, by waves that
belong to none.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from itertools import product as choices
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body
from crosscheck.trial.changes.arms.comparison import QUANTITIES, EntryComparison
from crosscheck.trial.changes.arms.letters import Values
from crosscheck.trial.changes.arms.polynomial import as_polynomial
from crosscheck.trial.changes.arms.segments import build_letter_bodies
from crosscheck.trial.changes.arms.term_changes import FACTORS
from crosscheck.trial.changes.arms.term_words import format_monomial, format_row
from crosscheck.trial.coordinates.differences import fold_rate_pairs
from crosscheck.trial.judge.entries import ErrorKind, Part, Term, TermError

FITS = 1e-9  # largest residual of a step, relative to an entry's size or difference
FEW = slice(0, 4)  # states at which every step is tried
MOST_MATCHES = 12
BATCH = 400  # bodies whose effects are computed at once
TIMES = (0.0, -1.0, *FACTORS)  # how often a term may be there
HALF_TURN, QUARTER = np.pi, np.pi / 2
RIGHT_PHASES = np.array([[QUARTER], [0.0]])  # -sin along x, cos along y
SAME_ROW = 1e-9


class MovingBody(NamedTuple):
    """A body at the end of a chain of levers, one along each link, as a derivation has it.

    Its centre goes along axis a by levers[l] cos(places[l] x + phases[a, l]) rates[l] x', added
    up over the links l; it weighs by its mass times the same with ``pulls`` for ``rates``.

    Args:
        mass: In kg.
        inertia: About its centre [kg m^2].
        turn: Row of its angular velocity over the rates x' (n,).
        levers: Of each link [m], (links,).
        phases: Of each lever's velocity along x and y [rad], (2, links).
        axes: How often the velocity along x and y counts in its kinetic energy, (2,).
        places: Rows of the levers' angles over x (links, n).
        rates: Rows of their angular velocities (links, n).
        pulls: Rows of what weight turns (links, n).
        gravity: What pulls it [m/s^2], (2,).
    """

    mass: float
    inertia: float
    turn: np.ndarray
    levers: np.ndarray
    phases: np.ndarray
    axes: np.ndarray
    places: np.ndarray
    rates: np.ndarray
    pulls: np.ndarray
    gravity: np.ndarray


class Effects(NamedTuple):
    """What bodies add to M (B, K, n, n), dM/dx (B, K, n, n, n) and weight (B, K, n)."""

    mass: np.ndarray
    slopes: np.ndarray
    weight: np.ndarray


def compute_effects(bodies: Sequence[MovingBody], x: np.ndarray) -> Effects:
    """The effects of each body at states x (K, n)."""
    fields = (np.array(each) for each in zip(*bodies, strict=True))
    mass, inertia, turn, levers, phases, axes, places, rates, pulls, gravity = fields
    angles = np.einsum("bln,kn->bkl", places, x)[:, :, None] + phases[:, None]
    moving = levers[:, None, None] * np.cos(angles)
    weights = (mass[:, None] * axes)[:, None, :, None]
    jacobian = moving @ rates[:, None]
    total = np.swapaxes(jacobian, 2, 3) @ (weights * jacobian)
    total = total + (inertia[:, None, None] * turn[:, :, None] * turn[:, None, :])[:, None]
    bent = -levers[:, None, None] * np.sin(angles)
    turned = np.einsum("bli,blj->blij", rates, places)
    bent_jacobian = np.einsum("bkal,blij->bkaij", bent, turned, optimize=True)
    half = np.einsum("bkai,bkajm->bkijm", weights * jacobian, bent_jacobian, optimize=True)
    pulled = (moving * (mass[:, None] * gravity)[:, None, :, None]).sum(axis=2)
    return Effects(total, half + np.swapaxes(half, 2, 3), pulled @ pulls)


def derive_rate_terms(slopes: np.ndarray) -> np.ndarray:
    """The bias's coefficients (..., n, n, n), j <= k, of dM/dx (..., n, n, n)."""
    return fold_rate_pairs(slopes - np.moveaxis(slopes, -1, -3) / 2)


class Step(NamedTuple):
    """A step done otherwise: what it makes, and in the place of what; a term if of nothing.

    bodies: pairs (factor, body) whose effects, added up, are the change; rule: or what a bias has
    more by it, of states.
    """

    term: str
    yours: str = ""
    right: str = ""
    bodies: tuple[tuple[float, MovingBody], ...] = ()
    rule: Callable[[np.ndarray], np.ndarray] | None = None

    @property
    def words(self) -> tuple[str, str, str]:
        """Words that are the same on every arm."""
        return self[:3]

    def make_error(self, by: float) -> TermError:
        """The step as it is reported; by: how often a term is there, 1 if it is right."""
        if self.right:
            return TermError("swapped", Term(self.term), self.yours, self.right)
        kinds: Mapping[float, ErrorKind] = {0.0: "dropped", -1.0: "sign"}
        return TermError(kinds.get(by, "factor"), Term(self.term), by=by)


@dataclass(frozen=True, eq=False)
class Derivation:
    """The derivation of an arm in linear coordinates, and steps of it that may be wrong."""

    comparison: EntryComparison

    @cached_property
    def columns(self) -> np.ndarray:
        """dq/dx (n, n)."""
        return np.asarray(self.comparison.frame.matrix, dtype=float)

    @cached_property
    def _model(self) -> tuple[Any, list[Body]]:
        problem = self.comparison.problem
        return build_letter_bodies(
            self.comparison.frame.layout, problem.case.arm, self.comparison.level
        )

    @cached_property
    def links(self) -> np.ndarray:
        """Rows of the links' angles over x, (links, n)."""
        rows: np.ndarray = np.array(self._model[0].angles[1:], dtype=float) @ self.columns
        return rows

    @cached_property
    def joints(self) -> np.ndarray:
        """Rows of the joints' angles over x, (links, n)."""
        return np.diff(self.links, axis=0, prepend=np.zeros((1, self.links.shape[1])))

    @cached_property
    def pairs(self) -> list[tuple[Body, MovingBody]]:
        """The bodies in letters, and as they move."""
        return [(body, self._move(body)) for body in self._model[1]]

    def _move(self, body: Body) -> MovingBody:
        values, count = self.comparison.values, len(self.links)
        levers = np.zeros(count)
        levers[: len(body.centre)] = [_evaluate(each, values) for each in body.centre]
        turn = np.array([_evaluate(each, values) for each in body.angle]) @ self.columns
        mass, inertia = (_evaluate(each, values) for each in (body.mass, body.inertia))
        phases, gravity = np.tile(RIGHT_PHASES, count), self.comparison.problem.case.arm
        pull = np.array(gravity.gravity_m_per_s2)
        rows = self.links
        return MovingBody(mass, inertia, turn, levers, phases, np.ones(2), rows, rows, rows, pull)

    @cached_property
    def groups(self) -> list[tuple[str, list[MovingBody]]]:
        """Bodies that a step may concern, by whose they are: each; all of them; all links."""
        single = [(_name_owner(body), [motion]) for body, motion in self.pairs]
        every = [motion for _, motion in self.pairs]
        links = [motion for body, motion in self.pairs if body.name.startswith("link ")]
        return [*single, ("every body", every), ("every link", links)]

    @cached_property
    def steps(self) -> dict[tuple[str, str, str], Step]:
        """All steps by their words, the likeliest first."""
        steps: dict[tuple[str, str, str], Step] = {}
        for generate in (
            self._generate_rules,
            self._generate_centripetal,
            self._generate_energies,
            self._generate_rows,
            self._generate_joint_rows,
            self._generate_functions,
        ):
            for step in generate():
                steps.setdefault(step.words, step)
        return steps

    def _generate_energies(self) -> Iterator[Step]:
        """Energies of translation along each axis; gravity along the other axis."""
        for number, (owner, motions) in enumerate(self.groups):
            mass = _format_first(self.pairs[number][0].mass) if len(motions) == 1 else ""
            for axis, along in enumerate("xy"):
                words = f"of {owner}'s velocity along {along}, in its kinetic energy"
                parts = [m._replace(axes=np.eye(2)[axis], inertia=0.0) for m in motions]
                term = f"1/2 {mass or 'm'} {along}'^2 {words}"
                yield Step(term, bodies=tuple((1.0, each) for each in parts))
        for sign, by in (("", 1.0), ("-", -1.0)):
            changed = [(m._replace(gravity=by * m.gravity[::-1]), m) for _, m in self.pairs]
            if any(motion.gravity.any() for _, motion in self.pairs):
                yield _change(("every weight", f"{sign}g along the other axis", "g"), changed)

    def _generate_rows(self) -> Iterator[Step]:
        """Another angle or rate of one lever or link, in one body or in all."""
        names = self.comparison.frame.names
        for (place, right), row in choices(enumerate(self.links), self._other_rows):
            if _is_same(row, right):
                continue
            every = defaultdict[str, list[tuple[MovingBody, MovingBody]]](list)
            steps = []
            for body, motion in self.pairs:
                lever = _format_first(body.centre[place]) if place < len(body.centre) else ""
                for what, wrong in _turn_link(motion, place, row, right).items():
                    every[what].append((wrong, motion))
                    steps.append((what, what.format(lever, _name_owner(body)), every[what][-1:]))
            link = f"link {place + 1} in every body", "every body"
            steps += [(what, what.format(*link), changed) for what, changed in every.items()]
            for what, where, changed in steps:
                rate = "velocity" in what
                yours, belongs = (format_row(each, names, rate=rate) for each in (row, right))
                yield _change((where, yours, belongs), changed)

    @cached_property
    def _other_rows(self) -> list[np.ndarray]:
        """Sums of joints' angles, neighbours or all but one; one reversed; coordinates."""
        absolute = np.vstack([np.zeros_like(self.links[:1]), self.links])
        rows = [b - a for a, b in combinations(absolute, 2)]
        rows += [2 * before - motion for before, motion in zip(absolute, self.links, strict=False)]
        rows += [link - joint for link in self.links for joint in self.joints]
        rows += [*np.eye(self.links.shape[1]), *(2 * self.links), absolute[0]]
        return list({tuple(row.round(9) + 0.0): row for row in rows}.values())

    def _generate_joint_rows(self) -> Iterator[Step]:
        """Each joint's own rates, or angles, or both, where the sums of them belong."""
        for (owner, motions), (words, where, fields) in choices(
            self.groups,
            (
                ("rate", "the velocity of {}", ("rates",)),
                ("angle", "the place of {}, not in its rates", ("places",)),
                ("angle and rate", "the place and velocity of {}", ("places", "rates", "pulls")),
                ("angle and rate", "the motion of {}", ("places", "rates", "pulls", "turn")),
                ("rate", "the angular velocity of {}", ("turn",)),
            ),
        ):
            changed = []
            for motion in motions:
                rows = dict.fromkeys(fields, self.joints)
                rows |= {"turn": self._joint_turn(motion)} if "turn" in fields else {}
                changed.append((motion._replace(**rows), motion))
            texts = f"each joint's own {words}", f"the sum of {words}s"
            yield _change((where.format(owner), *texts), changed)

    def _joint_turn(self, motion: MovingBody) -> np.ndarray:
        """The row of a link's own joint for the row of the link, of what turns with it."""
        for link, joint in zip(self.links, self.joints, strict=True):
            if _is_same(motion.turn, link):
                return joint
        return motion.turn

    def _generate_functions(self) -> Iterator[Step]:
        """The other function, or sign, in a body's velocity along an axis."""
        waves = {"x": ("-sin", ("sin", "cos", "-cos")), "y": ("cos", ("-cos", "sin", "-sin"))}
        for body, motion in self.pairs:
            places = np.flatnonzero(motion.levers).tolist()
            for chosen in (*([place] for place in places), *([places] * (len(places) > 1))):
                levers = " and ".join(_format_first(body.centre[place]) for place in chosen)
                for axis, (along, (right, others)) in enumerate(waves.items()):
                    for turn, yours in zip((HALF_TURN, -QUARTER, QUARTER), others, strict=True):
                        phases = motion.phases.copy()
                        phases[axis, chosen] += turn
                        words = f"{along}' of {_name_owner(body)}, before {levers}", yours, right
                        yield _change(words, [(motion._replace(phases=phases), motion)])

    def _generate_rules(self) -> Iterator[Step]:
        """Mistakes in deriving a bias from M: its two terms, by row and rate."""
        n, names, slopes = len(self.columns), self.comparison.frame.names, self._compute_slopes

        def fold(first: Any, second: Any) -> Callable[[np.ndarray], np.ndarray]:
            return lambda x: fold_rate_pairs(
                first * slopes(x) - second * np.moveaxis(slopes(x), -1, -3) / 2
            )

        yield Step("dM_ij/dx_k v_j v_k", rule=fold(1, 0))
        yield Step("-1/2 dM_jk/dx_i v_j v_k", rule=fold(0, 1))
        for row, name in zip(np.eye(n), names, strict=True):
            yield Step(f"dM_ij/d{name} v_j {name}'", rule=fold(row, 0))
            yield Step(
                f"-1/2 dM_jk/d{name} v_j v_k, in row {name}", rule=fold(0, row[:, None, None])
            )
            yield Step(f"every derivative of M by {name}", rule=fold(row, row[:, None, None]))

    def _generate_centripetal(self) -> Iterator[Step]:
        """Centripetal accelerations in a recursion from link to link, of all levers or the last."""
        names, count = self.comparison.frame.names, len(self.links)
        rates = {"": None, "each joint's own rate": self.joints}
        for row in self.links:
            rates[format_row(row, names, rate=True)] = np.array([row] * count)
        for owner, motions in self.groups:
            centres = [(m, int(np.flatnonzero(m.levers).max())) for m in motions if m.levers.any()]
            centre = "the centripetal acceleration of the centre about its joint"
            for what, chosen in (
                ("every centripetal acceleration", [*choices(motions, range(count))]),
                (centre, centres),
            ):
                for yours, rows in rates.items():
                    right = "the sum of rates" if yours else ""
                    rule = self._swing(chosen, rows)
                    yield Step(f"{what} of {owner}", yours, right, rule=rule)

    def _swing(
        self, swings: Sequence[tuple[MovingBody, int]], rows: np.ndarray | None
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Bias of levers that turn with these rates less that with the right ones; that alone."""

        def add_up(x: np.ndarray) -> np.ndarray:
            total = np.zeros((len(x), *(x.shape[1],) * 3))
            for motion, place in swings:
                right = np.outer(self.links[place], self.links[place])
                rates = right if rows is None else np.outer(rows[place], rows[place]) - right
                if rates.any() and motion.mass and motion.levers[place]:
                    angles = (x @ motion.places.T)[:, None] + motion.phases
                    jacobian = (motion.levers * np.cos(angles)) @ motion.rates
                    angle = x @ motion.places[place]
                    inwards = -motion.mass * motion.levers[place]
                    inwards = inwards * np.array((np.cos(angle), np.sin(angle)))
                    force = np.einsum("ak,kan->kn", inwards, jacobian)
                    total += force[:, :, None, None] * rates
            return fold_rate_pairs(total)

        return add_up

    def _compute_slopes(self, x: np.ndarray) -> np.ndarray:
        """dM/dx of the right bodies, (K, n, n, n)."""
        slopes: np.ndarray = compute_effects([motion for _, motion in self.pairs], x).slopes
        return slopes.sum(axis=0)

    def predict(self, steps: Sequence[Step], x: np.ndarray, part: Part) -> np.ndarray:
        """Changes of a part by steps (steps, K, ...) at states x (K, n)."""
        changes = []
        for start in range(0, len(steps), BATCH):
            chosen = steps[start : start + BATCH]
            bodies = [body for step in chosen for _, body in step.bodies]
            effects = compute_effects(bodies, x) if bodies else None
            first = 0
            for step in chosen:
                if step.rule is not None:
                    n = x.shape[1]
                    made = step.rule(x) if part == "bias" else np.zeros((len(x), *(n,) * 3))
                else:
                    assert effects is not None  # as the step has bodies
                    last = first + len(step.bodies)
                    factors = [by for by, _ in step.bodies]
                    of_part = {"mass_matrix": 0, "bias": 1, "force": 2}[part]
                    made = np.tensordot(factors, effects[of_part][first:last], 1)
                    made, first = derive_rate_terms(made) if part == "bias" else made, last
                changes.append(made)
        return np.array(changes)


def find_steps(arms: Sequence[EntryComparison], part: Part) -> list[TermError]:
    """Steps that make all that is wrong in a part, on every arm."""
    derivations = [Derivation(arm) for arm in arms]
    derived: Part = "force" if part == "gravity" else part
    words = [
        each
        for each, step in derivations[0].steps.items()
        if step.bodies or derived == "bias"
        if all(each in other.steps for other in derivations[1:])
    ]
    matching: dict[tuple[str, str, str], float] = {}
    for number, derivation in enumerate(derivations):
        states = FEW if number == 0 else slice(None)
        matching = _select_matching(derivation, words, matching if number else None, states, part)
        words = [*matching][:MOST_MATCHES]
        matching = {each: matching[each] for each in words}
    return [derivations[0].steps[each].make_error(by) for each, by in matching.items()]


def _select_matching(
    derivation: Derivation,
    words: Sequence[tuple[str, str, str]],
    factors: Mapping[tuple[str, str, str], float] | None,
    states: slice,
    part: Part,
) -> dict[tuple[str, str, str], float]:
    """The steps that make the differences of a part, and how often a term is there by them."""
    arm, quantity = derivation.comparison, QUANTITIES[part]
    steps = [derivation.steps[each] for each in words]
    if not steps:
        return {}
    derived: Part = "force" if part == "gravity" else part
    x = np.array([state.x for state in arm.states[states]])
    sizes = arm.sizes.entry_sizes(quantity)
    units = np.where(sizes > 0, sizes, 1.0)
    sign = -1.0 if part == "gravity" else 1.0  # of the force that the weights are
    difference = sign * (arm.user_values[quantity] - arm.reference_values[quantity])[states] / units
    changes = derivation.predict(steps, x, derived) / units
    allowed = max(FITS, arm.sizes.tolerance(quantity)) * np.maximum(
        np.abs(difference).max(axis=0), 1
    )
    matching = {}
    for word, step, change in zip(words, steps, changes, strict=True):
        every = (2.0,) if step.right else TIMES if factors is None else (factors[word],)
        for by in every:
            if change.any() and (np.abs(difference - (by - 1) * change) <= allowed).all():
                matching[word] = by
                break
    return matching


def _change(words: tuple[str, str, str], pairs: Sequence[tuple[MovingBody, MovingBody]]) -> Step:
    """A step with wrong bodies where right ones belong."""
    signed = tuple(each for wrong, right in pairs for each in ((1.0, wrong), (-1.0, right)))
    return Step(*words, bodies=signed)


def _turn_link(
    motion: MovingBody, place: int, row: np.ndarray, right: np.ndarray
) -> dict[str, MovingBody]:
    """A body with another row of a link, by what of it, in words of the lever and of the body."""
    changed = {}
    turns = bool(motion.inertia) and _is_same(motion.turn, right)
    if turns:
        changed["the angular velocity of {1}"] = motion._replace(turn=row)
    if motion.levers[place]:
        rows = motion.rates.copy()
        rows[place] = row
        both = motion._replace(places=rows, rates=rows, pulls=rows)
        changed["the velocity of {0} of {1}"] = motion._replace(rates=rows)
        changed["the direction of {0} of {1}, not its rate"] = motion._replace(places=rows)
        changed["the direction of {0} of {1}, and its rate"] = both
        if turns:
            changed["the angle of {1}"] = both._replace(turn=row)
    return changed


def _is_same(row: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(row - other).max() <= SAME_ROW)


def _name_owner(body: Body) -> str:
    return body.name if body.name[-1].isdigit() else f"the {body.name}"


def _evaluate(quantity: Any, values: Values) -> float:
    """A number or polynomial of the arm's letters."""
    return float(sum(each.value(values) for each in as_polynomial(quantity).monomials))


def _format_first(quantity: Any) -> str:
    """A quantity of the arm's letters by its first term; empty of a number."""
    monomial = next(as_polynomial(quantity).monomials, None)
    return format_monomial(monomial) if monomial is not None and monomial.powers else ""
