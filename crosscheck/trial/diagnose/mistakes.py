"""Mistakes of a planar arm's derivation: one step of it done otherwise, and all that follows.

Every step is gone through: a body's numbers, place, velocity, kinetic energy and weight, and how
Lagrange's equations take M apart; at each of them all that people write in its place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial, reduce
from itertools import chain, combinations, combinations_with_replacement, permutations
from typing import Any

import numpy as np

from crosscheck.analytic.derivation.bodies import Body
from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.differences import fold_rate_pairs
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.diagnose.derivation import (
    MovingBody,
    compute_effects,
    compute_jacobians,
    derive_rate_terms,
    move_body,
)
from crosscheck.trial.diagnose.terms.messages import (
    format_monomial,
    format_monomial_latex,
    format_row,
)
from crosscheck.trial.diagnose.terms.polynomial import as_polynomial
from crosscheck.trial.diagnose.terms.reference_terms import build_reference_bodies
from crosscheck.trial.diagnose.terms.values import (
    RADII,
    generate_alternatives,
    parse_symbol,
)
from crosscheck.trial.judge.entries import ErrorKind, Part, Term, TermError

Rule = Callable[[np.ndarray], np.ndarray]  # of x (K, n): what a bias has of v_j v_k (K, n, n, n)
Pair = tuple[Body, MovingBody]
Words = tuple[str, str, str, float | None]
Number = tuple[str, float, float | None]  # as text, or how often it is there; its value
Swing = tuple[MovingBody, int]  # a body, and the link along which its lever is
Signed = tuple[tuple[float, MovingBody], ...]
ENERGY: tuple[Part, ...] = ("mass_matrix", "bias")
ALL: tuple[Part, ...] = (*ENERGY, "force")
EVERY = "every body"
SIGNS = (("", 1.0), ("-", -1.0))
HALF_TURN, QUARTER = np.pi, np.pi / 2
SAME_ROW = 1e-9
# What has another angle or rate, in words of a lever and of its body.
ROWS = {
    "turn": "the angular velocity of {1}",
    "rates": "the velocity of {0}",
    "places": "the direction of {0}, not its rate",
    "both": "the direction of {0}, and its rate",
    "all": "the angle of {0}",
}


@dataclass(frozen=True, eq=False)
class Mistake:
    """One mistake: a step of the derivation replaced by a wrong one, or a term counted wrongly.

    Args:
        term: What the step makes.
        yours, right: What stands there, and what belongs; empty of a term.
        bodies: Pairs (factor, body) whose contributions, summed, are the error.
        parts: Parts of the equations in which the error shows.
        gravity: Vector used in place of gravity, (2,); None if gravity is right.
        rule: Contribution to the bias, for a mistake in the bias alone.
        by: Factor of the term (0 left out, -1 opposite sign, 2 twice); None if it may be any.
        kind: Kind of error under which it is reported.
    """

    term: Term
    yours: str = ""
    right: str = ""
    bodies: Signed = ()
    parts: tuple[Part, ...] = ALL
    gravity: np.ndarray | None = None
    rule: Rule | None = None
    by: float | None = None
    kind: ErrorKind = "swapped"

    @property
    def is_term(self) -> bool:
        """Whether this is a term with any factor, in place of a wrong step."""
        return self.by is None and not self.right

    @property
    def words(self) -> Words:
        """Coefficient, texts and factor that distinguish this mistake from others."""
        return self.term.coefficient, self.yours, self.right, self.by

    def make_error(self, by: float) -> TermError:
        """The mistake as it is reported; by: how often a term is there, 1 if it is right."""
        if self.right:
            return TermError(self.kind, self.term, self.yours, self.right)
        times = by if self.by is None else self.by
        kinds: Mapping[float, ErrorKind] = {0.0: "dropped", -1.0: "sign"}
        return TermError(kinds.get(times, "factor"), self.term, by=times)


@dataclass(frozen=True, eq=False)
class Derivation:
    """The derivation of an arm in linear coordinates, and its mistakes.

    x (K, n): states; values: of the arm's symbols.
    """

    frame: Frame
    arm: Arm
    level: str
    values: Mapping[str, float]
    x: np.ndarray
    _kept: dict[bytes, np.ndarray] = field(default_factory=dict)  # dM/dx by states

    @cached_property
    def _reference(self) -> tuple[Any, list[Body]]:
        return build_reference_bodies(self.frame, self.arm, self.level)

    @cached_property
    def columns(self) -> np.ndarray:
        """dq/dx (n, n)."""
        return np.asarray(self.frame.matrix, dtype=float)

    @cached_property
    def links(self) -> np.ndarray:
        """Rows of the links' angles over x, (links, n)."""
        rows: np.ndarray = np.array(self._reference[0].angles[1:], dtype=float) @ self.columns
        return rows

    @cached_property
    def joints(self) -> np.ndarray:
        """Rows of the joints' angles over x, (links, n)."""
        return np.diff(self.links, axis=0, prepend=np.zeros((1, self.links.shape[1])))

    @cached_property
    def pairs(self) -> list[Pair]:
        """The bodies in polynomials, and as they move."""
        return [(body, self._move(body)) for body in self._reference[1]]

    def _move(self, body: Body, **replaced: float) -> MovingBody:
        return move_body(body, self.links, self.columns, {**self.values, **replaced})

    @cached_property
    def groups(self) -> list[tuple[str, list[Pair]]]:
        """Bodies that a mistake may concern, by whose they are: each; all of them; all links."""
        links = [pair for pair in self.pairs if pair[0].name.startswith("link ")]
        single = [(_name_owner(pair[0]), [pair]) for pair in self.pairs]
        return [*single, (EVERY, self.pairs), ("every link", links)]

    @cached_property
    def mistakes(self) -> dict[Words, Mistake]:
        """All mistakes by their words, which are the same on every arm; the likeliest first."""
        kinds = (
            self._list_rules(),
            self._list_centripetal(),
            self._list_gravities(),
            self._list_exchanges(),
            self._list_numbers(self._generate_numbers),
            self._list_terms(),
            self._list_numbers(self._generate_multiples),
            self._list_rows(),
            self._list_relative_rows(),
            self._list_functions(),
        )
        mistakes: dict[Words, Mistake] = {}
        for mistake in chain.from_iterable(kinds):
            mistakes.setdefault(mistake.words, mistake)
        return mistakes

    def _list_exchanges(self) -> Iterator[Mistake]:
        """Two numbers of a kind exchanged in all bodies."""
        for first, second in combinations(self._symbols, 2):
            if _are_exchangeable(first, second):
                exchanged = {first: self.values[second], second: self.values[first]}
                mistake = Mistake(Term(""), first, second, kind="exchanged")
                yield self._replace_numbers(mistake, self.pairs, exchanged)
        reflecting = {
            joint: [
                (body, motion)
                for body, motion in self.pairs
                if _find_reflecting_joint(body) == joint
            ]
            for joint in range(1, len(self.links) + 1)
        }
        for a, b in permutations([joint for joint, motion in reflecting.items() if motion], 2):
            right, yours = (f"the reflected inertia of joint {j}" for j in (a, b))
            mistakes = (
                Mistake(Term("M"), yours, right),
                Mistake(Term(""), right, yours, kind="exchanged"),
            )
            for mistake, joints in zip(mistakes, ((a,), (a, b)), strict=True):
                other = {a: b, b: a}
                changed = [
                    (self._move(body, **self._rename(body, other[joint])), motion)
                    for joint in joints
                    for body, motion in reflecting[joint]
                ]
                yield _change(mistake, changed)

    def _rename(self, body: Body, joint: int) -> dict[str, float]:
        """The numbers of a body's symbols at another joint."""
        stems = {symbol: parse_symbol(symbol).stem for symbol in _list_symbols(body)}
        return {symbol: self.values[f"{stem}{joint}"] for symbol, stem in stems.items()}

    def _list_numbers(self, generate: Callable[[str], Iterator[Number]]) -> Iterator[Mistake]:
        """One number by another in all bodies; in one of them."""
        for owner, pairs in (self.groups[-2], *self.groups[:-2]):
            for symbol in self._symbols:
                concerned = [pair for pair in pairs if symbol in self._symbols_of[id(pair[0])]]
                if not concerned or (owner == EVERY and len(concerned) == 1):
                    continue
                for text, value, by in generate(symbol):
                    mistake = Mistake(Term(owner), text, symbol)
                    if not text:
                        mistake = Mistake(Term(f"{symbol} of {owner}"), by=by)
                    yield self._replace_numbers(mistake, concerned, {symbol: value})

    @cached_property
    def _symbols(self) -> list[str]:
        return [*dict.fromkeys(name for each in self._symbols_of.values() for name in each)]

    @cached_property
    def _symbols_of(self) -> dict[int, dict[str, None]]:
        """Symbols of each body's numbers, by its identity."""
        return {id(body): _list_symbols(body) for body, _ in self.pairs}

    def _replace_numbers(
        self, mistake: Mistake, pairs: Iterable[Pair], numbers: Mapping[str, float]
    ) -> Mistake:
        concerned = [p for p in pairs if not numbers.keys().isdisjoint(self._symbols_of[id(p[0])])]
        return _change(
            mistake, [(self._move(body, **numbers), motion) for body, motion in concerned]
        )

    def _generate_numbers(self, symbol: str) -> Iterator[Number]:
        """Possible replacements of a symbol: others of its kind, an inertia about its end."""
        for other in generate_alternatives(symbol, self.values):
            yield other.text, float(other.value), None
        stem, joint, _ = parse_symbol(symbol)
        if stem == "I_l":
            square = self.values[f"m{joint}"] * self.values[f"d{joint}"] ** 2
            for sign, by in (("+", 1.0), ("-", -1.0)):
                text = f"{symbol} {sign} m{joint} d{joint}^2"
                yield text, self.values[symbol] + by * square, None

    def _generate_multiples(self, symbol: str) -> Iterator[Number]:
        """A symbol that is not there, or there as a multiple."""
        for by in (2.0, 0.5, -1.0, 0.0):
            if by or parse_symbol(symbol).stem not in RADII:  # which others are divided by
                yield "", by * self.values[symbol], by

    def _list_terms(self) -> Iterator[Mistake]:
        """Energies of translation, along each axis and together, of rotation; weights; products."""
        for body, motion in self.pairs:
            for first, second in combinations(np.flatnonzero(motion.levers).tolist(), 2):
                rates = (self.links[place] for place in (first, second))
                rows = (format_row(row, self.frame.names, rate=True) for row in rates)
                angle = format_row(self.links[second] - self.links[first], self.frame.names)
                levers = f"{_name_lever(body, first)} {_name_lever(body, second)}"
                factors = " ".join(f"({row})" if " " in row else row for row in rows)
                term = Term(f"2 {levers} {factors} cos({angle}) in v^2 of {_name_owner(body)}")
                yield Mistake(term, bodies=_multiply_levers(motion, (first, second)), parts=ENERGY)
        spinning = [pair for pair in self.pairs if _find_reflecting_joint(pair[0])]
        reflected = [("all suns and planets, their reflected inertia", spinning)]
        for owner, pairs in (*self.groups, *reflected * (len(spinning) > 1)):
            moving = [motion._replace(inertia=0.0) for _, motion in pairs]
            turning = _add(motion._replace(mass=0.0) for _, motion in pairs)
            mass = inertia = ("", "")
            if len(pairs) == 1:
                ((body, motion),) = pairs
                mass, inertia = _format_first(body.mass), _format_first(body.inertia)
            for axis, along in enumerate("xy"):
                latex = rf"\frac{{1}}{{2}}{mass[1]}\,\dot{{{along}}}^{{2}}" if mass[1] else ""
                energy = f"1/2 {mass[0] or 'm'} {along}'^2"
                words = f"of {owner}'s velocity along {along}, in its kinetic energy"
                pieces = _add(motion._replace(axes=np.eye(2)[axis]) for motion in moving)
                yield Mistake(Term(f"{energy} {words}", latex=latex), bodies=pieces, parts=ENERGY)
            whole = f"1/2 {mass[0]} v^2 of {owner}, in its kinetic energy"
            turn = f"the kinetic energy of rotation of {owner}"
            if inertia[0]:
                rate = format_row(motion.turn, self.frame.names, rate=True)
                turn = f"1/2 {inertia[0]} ({rate})^2 of {owner}, in its kinetic energy"
            if not mass[0]:
                whole = f"the kinetic energy of translation of {owner}"
            every = range(len(self.links))
            mixed = chain.from_iterable(_multiply_levers(motion, every) for motion in moving)
            words = f"the products of two links' rates in v^2 of {owner}"
            yield Mistake(Term(words), bodies=tuple(mixed), parts=ENERGY)
            yield Mistake(Term(whole), bodies=_add(moving), parts=ENERGY)
            yield Mistake(Term(turn), bodies=turning, parts=ENERGY)
            yield Mistake(Term(f"the weight of {owner}"), bodies=_add(moving), parts=("force",))

    def _list_relative_rows(self) -> Iterator[Mistake]:
        """Each joint's own rates, or angles, or both, where the sums of them belong."""
        joints = self.joints
        for owner, pairs in self.groups:
            rates = [(motion._replace(rates=joints), motion) for _, motion in pairs]
            places = [(motion._replace(places=joints), motion) for _, motion in pairs]
            both = [(_set_rows(motion, joints), motion) for _, motion in pairs]
            of_all = [
                (wrong._replace(turn=self._joint_turn(motion)), motion) for wrong, motion in both
            ]
            turns = [
                (motion._replace(turn=self._joint_turn(motion)), motion) for _, motion in pairs
            ]
            for words, where, changed in (
                ("rate", f"the velocity of {owner}", rates),
                ("angle", f"the place of {owner}, not in its rates", places),
                ("angle and rate", f"the place and velocity of {owner}", both),
                ("angle and rate", f"the motion of {owner}", of_all),
                ("rate", f"the angular velocity of {owner}", turns),
            ):
                mistake = Mistake(Term(where), f"each joint's own {words}", f"the sum of {words}s")
                yield _change(mistake, changed)

        for body, motion in self.pairs:
            if motion.inertia and not any(_is_same(motion.turn, link) for link in self.links):
                for link in self.links:
                    text = format_row(link, self.frame.names, rate=True)
                    term = Term(f"{text} in the angular velocity of {_name_owner(body)}")
                    for by in (0.0, -1.0):
                        turned = motion._replace(turn=motion.turn - (1 - by) * link)
                        yield _change(Mistake(term, by=by), [(turned, motion)])

    def _joint_turn(self, motion: MovingBody) -> np.ndarray:
        """The row of a link's own joint for the row of the link, of what turns with it."""
        for link, joint in zip(self.links, self.joints, strict=True):
            if _is_same(motion.turn, link):
                return joint
        return motion.turn

    def _list_rows(self) -> Iterator[Mistake]:
        """Another angle or rate of one lever or link, in one body or in all."""
        names, owners = self.frame.names, [_name_owner(body) for body, _ in self.pairs]
        for place, right in enumerate(self.links):
            levers = [
                f"{_name_lever(body, place)} of {owner}"
                for (body, _), owner in zip(self.pairs, owners, strict=True)
            ]
            turning = [motion.inertia and _is_same(motion.turn, right) for _, motion in self.pairs]
            for row in self._other_rows:
                if _is_same(row, right):
                    continue
                wrong = [
                    _change_row(motion, place, row, turns=bool(turns))
                    for (_, motion), turns in zip(self.pairs, turning, strict=True)
                ]
                for what, words in ROWS.items():
                    yours, belongs = (
                        format_row(each, names, rate=what in ("turn", "rates"))
                        for each in (row, right)
                    )
                    every = []
                    for (_, motion), changed, lever, owner in zip(
                        self.pairs, wrong, levers, owners, strict=True
                    ):
                        if what not in changed:
                            continue
                        every.append((changed[what], motion))
                        where = words.format(lever, owner)
                        if what != "all":
                            yield _change(Mistake(Term(where), yours, belongs), every[-1:])
                    if len(every) > 1:
                        where = words.format(f"link {place + 1} in {EVERY}", EVERY)
                        yield _change(Mistake(Term(where), yours, belongs), every)

    @cached_property
    def _other_rows(self) -> list[np.ndarray]:
        """Sums of joints' angles, neighbours or all but one; one reversed; coordinates."""
        absolute = np.vstack([np.zeros_like(self.links[:1]), self.links])
        rows = [b - a for a, b in combinations(absolute, 2)]
        rows += [2 * before - motion for before, motion in zip(absolute, self.links, strict=False)]
        rows += [link - joint for link in self.links for joint in self.joints]
        rows += [*np.eye(self.links.shape[1]), *(2 * self.links), absolute[0]]
        return list({tuple(row.round(9) + 0.0): row for row in rows}.values())

    def _list_functions(self) -> Iterator[Mistake]:
        """The other function, or sign, in a body's velocity along an axis."""
        for body, motion in self.pairs:
            places = np.flatnonzero(motion.levers).tolist()
            for chosen in (*([place] for place in places), *([places] * (len(places) > 1))):
                levers = " and ".join(_name_lever(body, place) for place in chosen)
                for axis, (along, right) in enumerate((("x", "-sin"), ("y", "cos"))):
                    term = Term(f"{along}' of {_name_owner(body)}, before {levers}")
                    turns = {HALF_TURN: "sin", -QUARTER: "cos", QUARTER: "-cos"}
                    if axis:
                        turns = {HALF_TURN: "-cos", -QUARTER: "sin", QUARTER: "-sin"}
                    for turn, yours in turns.items():
                        phases = motion.phases.copy()
                        phases[axis, chosen] += turn
                        mistake = Mistake(term, yours, right)
                        yield _change(mistake, [(motion._replace(phases=phases), motion)])

    def _list_gravities(self) -> Iterator[Mistake]:
        """A component of gravity the other way, or all of it along the other axis."""
        x, y = gravity = np.array(self.arm.gravity_m_per_s2)
        others = {("-g_x", "g_x"): (-x, y), ("-g_y", "g_y"): (x, -y)} if x and y else {}
        others |= {(f"{sign}g along the other axis", "g"): (by * y, by * x) for sign, by in SIGNS}
        for words, other in others.items() if gravity.any() else ():
            bodies = _add(motion for _, motion in self.pairs)
            added = np.array(other) - gravity
            yield Mistake(Term("every weight"), *words, bodies, ("force",), added)

    def _list_rules(self) -> Iterator[Mistake]:
        """Mistakes in deriving a bias from M: its two terms, by row and rate; products of rates."""
        n, names = len(self.columns), self.frame.names

        first = self._compute_slopes

        def second(x: np.ndarray) -> np.ndarray:
            return -np.moveaxis(first(x), -1, -3) / 2

        def both(x: np.ndarray) -> np.ndarray:
            return fold_rate_pairs(first(x) + second(x))

        def add_rule(text: str, *rules: Rule) -> Mistake:
            def combine(x: np.ndarray) -> np.ndarray:
                return reduce(lambda made, rule: rule(made), reversed(rules), x)

            return Mistake(Term(text), parts=("bias",), rule=combine)

        bias = "(dM_ij/dx_k - 1/2 dM_jk/dx_i) v_j v_k, the whole bias"
        yield add_rule(bias, both)
        yield add_rule("dM_ij/dx_k v_j v_k", first)
        yield add_rule("-1/2 dM_jk/dx_i v_j v_k", second)
        for words, where in self._list_rate_products():
            yield add_rule(f"all of {words} in the bias", partial(np.multiply, where), both)
        for row, name in zip(np.eye(n), names, strict=True):
            yield add_rule(f"dM_ij/d{name} v_j {name}'", partial(np.multiply, row), first)
            only = partial(np.multiply, row[:, None, None])
            yield add_rule(f"-1/2 dM_jk/d{name} v_j v_k, in row {name}", only, second)
            along = partial(self._derive_along, row)
            yield add_rule(f"every derivative of M by {name}", along)
        for yours, right, rows in self._list_rate_rows():
            for words, left in (("the bias", rows), ("one of its two rates", np.eye(n))):

                def replace_rates(
                    x: np.ndarray, left: np.ndarray = left, rows: np.ndarray = rows
                ) -> np.ndarray:
                    folded = both(x)
                    even = (folded + np.swapaxes(folded, -1, -2)) / 2
                    return left.T @ even @ rows - even

                term = Term(words if left is rows else f"C(x, v) v, of {words}")
                yield Mistake(term, yours, right, parts=("bias",), rule=replace_rates)

    def _derive_along(self, row: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Contribution of the slopes of M along one coordinate to a bias."""
        slopes = self._compute_slopes(x) * row
        return slopes - np.moveaxis(slopes, -1, -3) / 2

    def _list_centripetal(self) -> Iterator[Mistake]:
        """Centripetal accelerations in a recursion from link to link: of one lever, or of many."""
        names, rows = self.frame.names, self._other_rows
        for owner, pairs in self.groups:
            swings = _list_swings(pairs)
            for place, right in enumerate(self.links):
                there = [swing for swing in swings if swing[1] == place]
                if not there:
                    continue
                lever = _name_lever(pairs[0][0], place) if len(pairs) == 1 else f"link {place + 1}"
                term = Term(f"the centripetal acceleration of {lever} in {owner}")
                rule = partial(self._add_centripetal, there, {place: right}, 0.0)
                yield Mistake(term, parts=("bias",), rule=rule)
                for row in (row for row in rows if not _is_same(row, right)):
                    rule = partial(self._add_centripetal, there, {place: row}, 1.0)
                    yours, belongs = (
                        f"({format_row(each, names, rate=True)})^2" for each in (row, right)
                    )
                    yield Mistake(term, yours, belongs, parts=("bias",), rule=rule)
        centre_levers = [
            (motion, max(np.flatnonzero(motion.levers).tolist()))
            for _, motion in self.groups[-1][1]
            if motion.mass and motion.levers.any()
        ]
        single = [(format_row(r, names, rate=True), [r] * len(self.links)) for r in self.links]
        for words, swings in (
            ("every centripetal acceleration", _list_swings(self.pairs)),
            ("every link's centripetal acceleration", _list_swings(self.groups[-1][1])),
            ("the centripetal acceleration of every link's centre about its joint", centre_levers),
        ):
            rule = partial(self._add_centripetal, swings, dict(enumerate(self.links)), 0.0)
            yield Mistake(Term(words), parts=("bias",), rule=rule)
            for yours, used in (("each joint's own rate", [*self.joints]), *single):
                rule = partial(self._add_centripetal, swings, dict(enumerate(used)), 1.0)
                yield Mistake(Term(words), yours, "the sum of rates", parts=("bias",), rule=rule)

    def _add_centripetal(
        self,
        swings: Sequence[Swing],
        rows: Mapping[int, np.ndarray],
        less: float,
        x: np.ndarray,
    ) -> np.ndarray:
        """Bias of levers that turn with these rates, minus their bias with the right rates."""
        total = np.zeros((len(x), *(x.shape[1],) * 3))
        for motion, place in swings:
            right = self.links[place]
            rates = np.outer(rows[place], rows[place]) - less * np.outer(right, right)
            if rates.any():
                total += self._compute_centripetal(motion, place, x)[:, :, None, None] * rates
        return total

    def _list_rate_products(self) -> Iterator[tuple[str, np.ndarray]]:
        """Products of two rates and squares, all and each, and where they are (n, n)."""
        names, squares = self.frame.names, np.eye(len(self.columns))
        yield "the products of two rates", 1 - squares
        yield "the squares of rates", squares
        for j, k in combinations_with_replacement(range(len(squares)), 2):
            words = f"{names[j]}'^2" if j == k else f"{names[j]}' {names[k]}'"
            yield words, np.outer(squares[j], squares[k])

    def _list_rate_rows(self) -> Iterator[tuple[str, str, np.ndarray]]:
        """Other rates in the place of x': sums of them, their differences, one by another."""
        names, unit = self.frame.names, np.eye(len(self.columns))
        sums = np.tril(np.ones_like(unit))
        yield "the sum of rates", "each rate", sums
        yield "the difference of rates", "each rate", np.linalg.inv(sums)
        for j, k in ((j, k) for j in range(len(unit)) for k in range(len(unit)) if j != k):
            rows = unit.copy()
            rows[j] = unit[k]
            yield f"{names[k]}'", f"{names[j]}'", rows

    def predict(
        self, chosen: Sequence[Words], states: slice, parts: Sequence[Part]
    ) -> dict[Part, np.ndarray]:
        """Changes by chosen mistakes of M (mistakes, K, n, n), bias (.., n, n, n) and force."""
        mistakes, x = [self.mistakes[words] for words in chosen], self.x[states]
        count, n = x.shape
        shapes: dict[Part, tuple[int, ...]] = {
            "mass_matrix": (n, n),
            "bias": (n, n, n),
            "force": (n,),
        }
        changes = {part: np.zeros((len(mistakes), count, *shapes[part])) for part in parts}
        moved = [place for place, mistake in enumerate(mistakes) if mistake.bodies]
        if moved:
            signed = [each for place in moved for each in mistakes[place].bodies]
            sizes = [len(mistakes[place].bodies) for place in moved]
            usual = np.array(self.arm.gravity_m_per_s2)
            gravity = np.repeat(
                [usual if mistakes[p].gravity is None else mistakes[p].gravity for p in moved],
                sizes,
                axis=0,
            )
            bodies = [body for _, body in signed]
            effects = compute_effects(bodies, x, gravity, with_slopes="bias" in parts)
            factors = np.array([factor for factor, _ in signed])
            starts = np.cumsum([0, *sizes[:-1]])
            for part, values in zip(ALL, effects, strict=True):
                if part in parts:
                    by = factors.reshape(-1, *(1,) * (values.ndim - 1))
                    total = np.add.reduceat(by * values, starts, axis=0)
                    total = derive_rate_terms(total) if part == "bias" else total
                    there = [part in mistakes[place].parts for place in moved]
                    changes[part][np.array(moved)[there]] = total[there]
        if "bias" in parts:
            for place, mistake in enumerate(mistakes):
                if mistake.rule is not None:
                    changes["bias"][place] = fold_rate_pairs(mistake.rule(x))
        return changes

    def _compute_slopes(self, x: np.ndarray) -> np.ndarray:
        """dM/dx of the right bodies, (K, n, n, n)."""
        key = x.tobytes()
        if key not in self._kept:
            bodies = [motion for _, motion in self.pairs]
            effects = compute_effects(bodies, x, np.zeros((len(bodies), 2)), with_slopes=True)
            self._kept[key] = effects.slopes.sum(axis=0)
        return self._kept[key]

    def _compute_centripetal(self, motion: MovingBody, place: int, x: np.ndarray) -> np.ndarray:
        """The force -m J^T c e(angle) (K, n) of a lever's turning with rate 1, of a body."""
        jacobian = compute_jacobians(motion, x)
        angle = x @ motion.places[place]
        inwards = -motion.mass * motion.levers[place] * np.array((np.cos(angle), np.sin(angle)))
        force: np.ndarray = np.einsum("ak,kan->kn", inwards, jacobian)
        return force


def _list_swings(pairs: Sequence[Pair]) -> list[Swing]:
    """The levers of bodies with mass."""
    moving = [motion for _, motion in pairs if motion.mass]
    return [
        (motion, place) for motion in moving for place in np.flatnonzero(motion.levers).tolist()
    ]


def _change(mistake: Mistake, pairs: Iterable[tuple[MovingBody, MovingBody]]) -> Mistake:
    """A mistake of wrong bodies where right ones belong."""
    signed = tuple(each for wrong, motion in pairs for each in ((1.0, wrong), (-1.0, motion)))
    return replace(mistake, bodies=signed)


def _add(bodies: Iterable[MovingBody]) -> Signed:
    return tuple((1.0, body) for body in bodies)


def _multiply_levers(motion: MovingBody, places: Iterable[int]) -> Signed:
    """Contribution of the products of two different levers: that of all less that of each alone."""
    chosen = np.zeros_like(motion.levers)
    chosen[list(places)] = 1.0
    there = np.diag(chosen)
    bare = motion._replace(inertia=0.0)
    alone = [(-1.0, bare._replace(levers=motion.levers * only)) for only in there if only.any()]
    return ((1.0, bare._replace(levers=motion.levers * chosen)), *alone)


def _set_rows(motion: MovingBody, rows: np.ndarray) -> MovingBody:
    return motion._replace(places=rows, rates=rows, pulls=rows)


def _change_row(
    motion: MovingBody, place: int, row: np.ndarray, *, turns: bool
) -> dict[str, MovingBody]:
    """A body with another row of a link by what of it, ``ROWS``, that has to do with the link.

    turns: whether the body turns with the link.
    """
    changed = {"turn": motion._replace(turn=row)} if turns else {}
    if motion.levers[place]:
        rows = motion.rates.copy()
        rows[place] = row
        both = _set_rows(motion, rows)
        changed |= {"rates": motion._replace(rates=rows), "places": motion._replace(places=rows)}
        changed |= {"both": both, "all": both}
    if turns:
        changed["all"] = changed.get("all", motion)._replace(turn=row)
    return changed


def _is_same(row: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(row - other).max() <= SAME_ROW)


def _list_symbols(body: Body) -> dict[str, None]:
    """Symbols of a body's numbers."""
    quantities = (body.mass, body.inertia, *body.centre, *body.angle)
    return {
        name: None
        for quantity in quantities
        for monomial in as_polynomial(quantity).monomials
        for name, _ in monomial.powers
    }


def _find_reflecting_joint(body: Body) -> int:
    """The joint whose sun or planets a body is, as they spin or are reflected; 0 of others."""
    symbols = map(parse_symbol, _list_symbols(body))
    return next((symbol.joint for symbol in symbols if symbol.stem in ("M_s", "M_p")), 0)


def _are_exchangeable(first: str, second: str) -> bool:
    stems = {parse_symbol(first).stem, parse_symbol(second).stem}
    return len(stems) == 1 or stems <= {"L", "d"} or stems == {"m", "m_payload"}


def _name_owner(body: Body) -> str:
    return body.name if body.name[-1].isdigit() else f"the {body.name}"


def _name_lever(body: Body, place: int) -> str:
    return _format_first(body.centre[place])[0] if place < len(body.centre) else ""


def _format_first(quantity: Any) -> tuple[str, str]:
    """A quantity of the arm's symbols as text and TeX, by its first term; empty of a number."""
    monomial = next(as_polynomial(quantity).monomials, None)
    if monomial is None or not monomial.powers:
        return "", ""
    return format_monomial(monomial), format_monomial_latex(monomial)
