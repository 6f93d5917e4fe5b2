"""How often a planted error is found: the wrong entry, and the term that is wrong in it.

Run as ``python benchmarks/bench_trial.py`` from the project's folder; -v shows what is missed. Each
case takes the reference's own terms apart, plants one error in one entry of M, of the bias or of the
force, and hands the entry over as numbers at states; and again as symbols. An error that changes no
number on the arm counts apart: another arm must show it. ``entry``: that one is blamed, no other;
``first``: the error is what is told; ``among``: it is told, perhaps after others that the arm's
numbers cannot tell from it.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
import sympy as sp

from crosscheck.registry import build
from crosscheck.trial.coordinates.frame import LAYOUTS, Frame, frame_of
from crosscheck.trial.diagnose.candidates import Candidate
from crosscheck.trial.diagnose.difference import NotWaves, expression_of, symbolic_difference
from crosscheck.trial.diagnose.explain import Observed, explanations
from crosscheck.trial.diagnose.force_terms import States, rate_name, signal_columns
from crosscheck.trial.diagnose.keys import Entry, Key, Product
from crosscheck.trial.diagnose.polynomial import Monomial
from crosscheck.trial.diagnose.reference_terms import ReferenceTerms, reference_terms_of
from crosscheck.trial.diagnose.values import named, unrelated, values_of
from crosscheck.trial.diagnose.waves import Fitting, entry_values, states_wanted
from crosscheck.trial.diagnose.words import error_of, term_of, told, written
from crosscheck.trial.input.equations import Coordinates, Symbolic
from crosscheck.trial.input.naming import named as named_place
from crosscheck.trial.judge.places import Place, TermError
from models.arm.arm import Arm
from models.arm.planets import usual_switches
from models.experiment.drive import torques_along
from models.interface import Model
from models.loading import load_arm, load_scenario

SEED, MOST_OF_A_KIND, CORRECT = 1, 3, 200
ARMS = ("paper-labelled", "three-unlike", "direct-between", "planets-apart")
FEW = 8  # states of a correct model
BLAMED = 1e-10  # of an entry's natural size
KINDS = ("sign", "factor 2", "dropped", "radius swapped", "wrong teeth", "wrong angle")
CASES = (
    ("paper-labelled", Coordinates("rigid", "absolute")),
    ("paper-labelled", Coordinates("lumped")),
    ("paper-labelled", Coordinates("lumped", "absolute", "angles")),
    ("three-unlike", Coordinates("lumped", "absolute", "angles")),
    ("direct-between", Coordinates("free", "absolute", "angles")),
)
RADII = {"r_s": ("r_p", "r_cp"), "r_p": ("r_s",), "r_c": ("r_cp",), "r_cp": ("r_c", "r_p", "r_s")}
TEETH = {"r_s": ("r_p", "r_r"), "r_p": ("r_s", "r_r"), "n": ("n_p", "n_r", "n_0")}


class Planted(NamedTuple):
    """An error of a kind in an entry: what the entry then is."""

    kind: str
    place: Place
    yours: Entry


@dataclass(frozen=True)
class Case:
    """An arm described by coordinates, with reference values at random states."""

    name: str
    arm: Arm
    coordinates: Coordinates
    states_most: int = 10_000

    @cached_property
    def frame(self) -> Frame:
        """Of its coordinates."""
        return frame_of(self.coordinates, self.arm)

    @cached_property
    def model(self) -> Model:
        """The reference."""
        rigid = self.coordinates.gearing == "rigid"
        planets = {} if rigid else {"planets": self.coordinates.gearing}
        switches = usual_switches(self.arm, **planets)
        name = "analytic:coupled" if rigid else "analytic:physical"
        return build(name, self.arm, load_scenario("pd"), switches)

    @cached_property
    def terms(self) -> ReferenceTerms:
        """Its right terms."""
        return reference_terms_of(self.frame, self.arm, self.model.switches)

    @cached_property
    def values(self) -> dict[str, float]:
        """Of the arm, with the ratios that wrong teeth give."""
        return with_ratios(values_of(self.arm))

    @cached_property
    def states(self) -> tuple[States, np.ndarray, np.ndarray]:
        """At which all is evaluated; x and its rates (K, n)."""
        layout, generator = self.frame.layout, np.random.default_rng(SEED)
        count = min(states_wanted(self.terms), self.states_most)
        q, v = generator.uniform(-3, 3, (2, count, len(layout)))
        q[:, ~layout.angular] *= 3e-5
        v[:, ~layout.angular] *= 1e-2
        assert self.frame.matrix is not None
        inverse = np.linalg.inv(self.frame.matrix)
        x, rates = q @ inverse.T, v @ inverse.T
        q, v = x @ self.frame.matrix.T, rates @ self.frame.matrix.T
        time = generator.uniform(0, 2, count)
        torque = np.array([self._torques(*state) for state in zip(time, q, v, strict=True)])
        return States(time, q, v, torque), x, rates

    def _torques(self, t: float, q: np.ndarray, v: np.ndarray) -> list[float]:
        theta = self.model.layout.theta
        found = torques_along(self.model.drive, np.array([t]), q[None, theta], v[None, theta])
        return found[0].tolist()

    @cached_property
    def signals(self) -> dict[str, np.ndarray]:
        """Of the force."""
        states, _, rates = self.states
        own = signal_columns(self.arm, self.frame.layout, self.model.switches, states)
        names = self.frame.names
        return {**own, **{rate_name(name): rates[:, k] for k, name in enumerate(names)}}

    @cached_property
    def angles(self) -> np.ndarray:
        """Joint angles (K, joints)."""
        return self.states[0].q[:, self.frame.layout.theta]

    @cached_property
    def reference(self) -> dict[Place, np.ndarray]:
        """Every entry at all states (K,), by the compiled model through the frame."""
        states, J, model = self.states[0], self.frame.matrix, self.model
        assert J is not None
        n, found = len(self.frame.names), {}
        mass = np.array([J.T @ model.mass_matrix(q) @ J for q in states.q])
        found |= {Place("mass_matrix", i, j): mass[:, i, j] for i in range(n) for j in range(n)}
        unit = [np.array([J.T @ model.bias(q, own) for q in states.q]) for own in J.T]
        for j in range(n):
            for k in range(j, n):
                both = unit[j]
                if j != k:
                    whole = np.array([J.T @ model.bias(q, J[:, j] + J[:, k]) for q in states.q])
                    both = whole - unit[j] - unit[k]
                found |= {Place("bias", i, rates=(j, k)): both[:, i] for i in range(n)}
        each = zip(states.t, states.q, states.v, strict=True)
        force = np.array([J.T @ model.generalized_force(*state) for state in each])
        return found | {Place("force", i): force[:, i] for i in range(n)}

    @cached_property
    def scale(self) -> dict[Place, np.ndarray]:
        """Natural size of every entry at the states: of M by its diagonal, of a force its parts."""
        n, values = len(self.frame.names), self.values
        size = [np.sqrt(self.reference[Place("mass_matrix", i, i)]) for i in range(n)]
        found = {}
        for place in self.reference:
            if place.part == "mass_matrix" and place.column is not None:
                found[place] = size[place.row] * size[place.column]
            elif place.rates is not None:
                j, k = place.rates
                turning = np.abs(self.terms.angles).sum(axis=0)
                found[place] = sum(
                    turning[a] * size[b] * size[c]
                    for a, b, c in ((k, place.row, j), (j, place.row, k), (place.row, j, k))
                )
            else:
                parts = np.zeros(len(self.angles))
                for product in self.terms.entry(place):
                    one = entry_values((product,), values, self.angles, self.signals)
                    parts += np.abs(one)
                found[place] = parts
        return found

    @cached_property
    def waves(self) -> Fitting:
        """For M and bias."""
        return Fitting.of_waves(self.terms, self.angles)

    @cached_property
    def forces(self) -> Fitting:
        """For forces."""
        return Fitting.of_forces(self.terms, self.angles, self.signals)

    def given(self, entry: Entry) -> np.ndarray:
        """An entry of the user's at the states."""
        return entry_values(entry, self.values, self.angles, self.signals)

    def blamed(self, yours: Mapping[Place, np.ndarray]) -> set[Place]:
        """Entries that differ. To be replaced by the localisation proper."""
        return {
            place
            for place, values in yours.items()
            if (np.abs(values - self.reference[place]) > BLAMED * self.scale[place].max()).any()
        }

    @cached_property
    def right(self) -> dict[Place, np.ndarray]:
        """Every entry without an error, by the reference terms."""
        return {place: self.given(self.terms.entry(place)) for place in self.reference}

    def observed(self, place: Place, yours: np.ndarray) -> Observed:
        """What an entry's difference is made of."""
        fitting = self.forces if place.part == "force" else self.waves
        fit = fitting.fit(yours - self.reference[place], float(self.scale[place].max()))
        return Observed(values_of(self.arm), fit.coefficients, fit.noise, fit.left_over)


def with_ratios(values: Mapping[str, float]) -> dict[str, float]:
    """The values, and ratios n by wrong teeth as symbols ``n_p1``, ``n_r1``, ``n_01``."""
    found = dict(values)
    for name in values:
        own = named(name)
        if own.stem == "n":
            sun, planet, ring = (values[f"{z}{own.joint}"] for z in ("z_s", "z_p", "z_r"))
            found[f"n_p{own.joint}"] = ring / planet + 1
            found[f"n_r{own.joint}"] = 1 - ring / sun
            found[f"n_0{own.joint}"] = ring / sun
    return found


def planted(case: Case, most: int = MOST_OF_A_KIND) -> Iterator[Planted]:
    """At most so many of each kind in every entry, drawn by a seed."""
    chooser = random.Random(SEED)
    for place, entry in case.terms.entries.items():
        for kind, make in PLANTS.items():
            errors = list(dict.fromkeys(make(entry, case.terms)))
            for yours in chooser.sample(errors, min(most, len(errors))):
                yield Planted(kind, place, yours)


def _scaled(by: int) -> Callable[[Entry, ReferenceTerms], Iterator[Entry]]:
    """Each term, and the whole entry, by a factor."""

    def make(entry: Entry, terms: ReferenceTerms) -> Iterator[Entry]:
        for product in entry:
            yield tuple(_times(p, by) if p == product else p for p in entry)
        yield tuple(_times(p, by) for p in entry)

    return make


def _times(product: Product, by: int) -> Product:
    monomial = product.monomial
    return Product(product.key, Monomial(by * monomial.number, monomial.powers))


def _swapped(
    table: Mapping[str, tuple[str, ...]],
) -> Callable[[Entry, ReferenceTerms], Iterator[Entry]]:
    """A symbol by another throughout the entry."""

    def make(entry: Entry, terms: ReferenceTerms) -> Iterator[Entry]:
        for symbol in sorted({symbol for product in entry for symbol in product.symbols}):
            stem, joint, _ = named(symbol)
            for other in table.get(stem, ()):
                yield tuple(_replaced(product, symbol, f"{other}{joint}") for product in entry)

    return make


def _replaced(product: Product, symbol: str, other: str) -> Product:
    powers = dict(product.monomial.powers)
    moved = powers.pop(symbol, 0)
    if moved:
        powers[other] = powers.get(other, 0) + moved
    kept = tuple(sorted((name, power) for name, power in powers.items() if power))
    return Product(product.key, Monomial(product.monomial.number, kept))


def _turned(entry: Entry, terms: ReferenceTerms) -> Iterator[Entry]:
    """Another angle sum in all terms of one wave: a sum for a difference, one angle alone, none."""
    for key in dict.fromkeys(product.key for product in entry):
        if not any(key.wave):
            continue
        places = [place for place, entry_ in enumerate(key.wave) if entry_]
        others = {tuple(int(k == place) for k in range(len(key.wave))) for place in places}
        last = np.zeros(len(key.wave), dtype=int)
        last[places[0]] = 2
        others.add(tuple(int(e) for e in last + (np.array(key.wave) - last // 2)))
        for other in sorted(others - {key.wave}):
            turned = key._replace(wave=other)
            yield tuple(p._replace(key=turned) if p.key == key else p for p in entry)


PLANTS: dict[str, Callable[[Entry, ReferenceTerms], Iterator[Entry]]] = {
    "sign": _scaled(-1),
    "factor 2": _scaled(2),
    "dropped": lambda entry, terms: (tuple(p for p in entry if p != product) for product in entry),
    "radius swapped": _swapped(RADII),
    "wrong teeth": _swapped(TEETH),
    "wrong angle": _turned,
}


class Missed(NamedTuple):
    """An error planted whose term was not told first, and what was told."""

    error: Planted
    told: list[list[TermError]]


@dataclass
class Score:
    """Counts by kind of error."""

    planted: Counter[str] = field(default_factory=Counter)
    unseen: Counter[str] = field(default_factory=Counter)
    entry: Counter[str] = field(default_factory=Counter)
    first: Counter[str] = field(default_factory=Counter)
    among: Counter[str] = field(default_factory=Counter)
    symbolic: Counter[str] = field(default_factory=Counter)
    tried: Counter[str] = field(default_factory=Counter)
    missed: list[Missed] = field(default_factory=list)


def mark(case: Case, place: Place, yours: Entry) -> dict[Key, float]:
    """What an error does with numbers that have nothing to do with each other."""
    numbers = with_ratios(unrelated(values_of(case.arm)))
    total: Counter[Key] = Counter()
    for entry, sign in ((yours, 1), (case.terms.entry(place), -1)):
        for key, monomial in entry:
            total[key] += sign * monomial.value(numbers)
    return {key: value for key, value in total.items() if abs(value) > 1e-9}


def same(found: tuple[Candidate, ...], wanted: Mapping[Key, float]) -> bool:
    """Whether candidates do that."""
    total: Counter[Key] = Counter()
    for candidate in found:
        for key, change in candidate.change.items():
            total[key] += float(change[-1])
    keys = {*total, *wanted}
    return all(abs(total[k] - wanted.get(k, 0.0)) <= 1e-7 * (1 + abs(total[k])) for k in keys)


def score(case: Case) -> Score:
    """Of every error planted in it."""
    total = Score()
    for error in planted(case):
        kind, place = error.kind, error.place
        total.planted[kind] += 1
        values = case.given(error.yours)
        right = case.right[place]
        if (np.abs(values - right) <= 2 * BLAMED * case.scale[place].max()).all():
            total.unseen[kind] += 1
            continue
        if case.blamed({**case.right, place: values}) == {place}:
            total.entry[kind] += 1
        wanted = mark(case, place, error.yours)
        found = explanations(place, [case.observed(place, values)], case.terms)
        hits = [same(each, wanted) for each in found]
        total.first[kind] += bool(hits and hits[0])
        total.among[kind] += any(hits)
        if not (hits and hits[0]):
            guesses = [[error_of(one, case.terms) for one in each] for each in found[:3]]
            total.missed.append(Missed(error, guesses))
    return total


def symbols_of(case: Case, error: Planted) -> Symbolic:
    """The entry alone, with the error, of a sympy user."""
    names, joints = case.frame.names, len(case.arm.joints)
    x = sp.symbols(names)
    v = sp.symbols([rate_name(name) for name in names])
    torque = sp.symbols([f"T_{j + 1}" for j in range(joints)])
    turns = np.round(case.terms.angles).astype(int)
    place, rates = error.place, [v[k] for k in error.place.rates or ()]

    def whole(entry: Entry) -> sp.Expr:
        total = sp.S.Zero
        for key, monomial in entry:
            angle = sum(int(w) * own for w, own in zip(np.array(key.wave) @ turns, x, strict=True))
            wave = sp.sin(angle) if key.function == "sin" else sp.cos(angle)
            signal = sp.Symbol(key.signal) if key.signal else 1
            total += expression_of(monomial) * wave * signal * sp.prod(rates)
        return total.subs(by_teeth(joints))

    matrix = sp.zeros(len(x), len(x) if place.column is not None else 1)
    for row in range(len(x)) if place.part == "force" else ():
        matrix[row, 0] = whole(case.terms.entry(Place("force", row)))
    matrix[place.row, place.column or 0] = whole(error.yours)
    return Symbolic(tuple(x), tuple(v), tuple(torque), **{place.part: matrix})


def by_teeth(joints: int) -> dict[sp.Symbol, sp.Expr]:
    """The symbols of ``with_ratios`` as one writes them."""
    found = {}
    for joint in range(1, joints + 1):
        sun, planet, ring = sp.symbols([f"{z}{joint}" for z in ("z_s", "z_p", "z_r")])
        found[sp.Symbol(f"n_p{joint}")] = ring / planet + 1
        found[sp.Symbol(f"n_r{joint}")] = 1 - ring / sun
        found[sp.Symbol(f"n_0{joint}")] = ring / sun
    return found


def score_symbolic(case: Case) -> Score:
    """Of one error of each kind in every entry, in symbols."""
    total = Score()
    for error in planted(case, 1):
        total.planted[error.kind] += 1
        wanted = mark(case, error.place, error.yours)
        found: list[tuple[Candidate, ...]] = []
        try:
            off = symbolic_difference(error.place, symbols_of(case, error), case.terms, case.values)
        except NotWaves:  # a force of which every mesh force was dropped
            off = None
        if off is not None:
            total.entry[error.kind] += 1
            found = explanations(error.place, off.observed, case.terms)
        hits = [same(each, wanted) for each in found]
        total.first[error.kind] += bool(hits and hits[0])
        total.among[error.kind] += any(hits)
        if not (hits and hits[0]):
            guesses = [[error_of(one, case.terms) for one in each] for each in found[:3]]
            total.missed.append(Missed(error, guesses))
    return total


def drawn_arm(chooser: random.Random) -> Arm:
    """A built-in arm with links and payload of other sizes."""
    arm = load_arm(chooser.choice(ARMS))
    links = tuple(
        link.model_copy(update={"length_m": long, "com_m": long * chooser.uniform(0.2, 0.8)})
        for link in arm.links
        for long in (link.length_m * chooser.uniform(0.5, 2.0),)
    )
    payload = chooser.choice((0.0, chooser.uniform(1.0, 20.0)))
    return arm.model_copy(update={"links": links, "payload_mass_kg": payload})


def blamed_though_right() -> int:
    """Of random arms in random coordinates, how many are blamed without an error."""
    chooser, count = random.Random(SEED), 0
    for _ in range(CORRECT):
        arm = drawn_arm(chooser)
        planets = usual_switches(arm).planets
        gearing = chooser.choice(("rigid", "free") if planets == "free" else tuple(LAYOUTS))
        links, gears = chooser.choice(("relative", "absolute")), "displacements"
        if gearing != "rigid":
            gears = chooser.choice(("displacements", "angles"))
        case = Case("drawn", arm, Coordinates(gearing, links, gears), FEW)
        count += bool(case.blamed(case.right))
    return count


def report(name: str, total: Score) -> None:
    """A row for each kind."""
    for kind in KINDS:
        shown = total.planted[kind] - total.unseen[kind]
        counts = (total.entry, total.first, total.among)
        shares = "".join(f"{100 * c[kind] / shown:9.1f}%" if shown else f"{'':>10}" for c in counts)
        print(f"{name:<34}{kind:<16}{total.planted[kind]:>6}{total.unseen[kind]:>7}{shares}")


def main() -> None:
    """All tables."""
    print(f"{'arm':<34}{'error':<16}{'all':>6}{'unseen':>7}{'entry':>10}{'first':>10}{'among':>10}")
    for arm_name, coordinates in CASES:
        case = Case(arm_name, load_arm(arm_name), coordinates)
        for told_as, score_of in (("", score), (" symbols", score_symbolic)):
            total = score_of(case)
            report(f"{arm_name} {coordinates.gearing} {coordinates.gears[:6]}{told_as}", total)
            for missed in total.missed if "-v" in sys.argv else ():
                show(missed, case)
    print(f"{blamed_though_right()} of {CORRECT} correct models blamed")


def show(missed: Missed, case: Case) -> None:
    """What was told in place of an error."""
    print("   ", missed.error.kind, named_place(missed.error.place, case.frame.names))
    terms = [written(term_of((p,), case.terms)) for p in missed.error.yours]
    print("        yours ", " + ".join(terms))
    for errors in missed.told:
        print("        told  ", "; ".join(map(told, errors)))


if __name__ == "__main__":
    main()
