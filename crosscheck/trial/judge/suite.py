"""Every comparison of a trial: what the equations owe to themselves, then to the engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from crosscheck.checks.states import LOOSEST
from crosscheck.findings import About, Finding, Key, checked, measured_only
from crosscheck.planning.comparison import Comparison, Results
from crosscheck.planning.state_suite import Spot, balances
from crosscheck.trial.judge import own_checks
from crosscheck.trial.judge.bench import Bench
from crosscheck.trial.judge.places import EntryPlace, deviations, listed, wrong_entries
from crosscheck.trial.judge.questions import AGAIN, StateQuestion
from crosscheck.trial.judge.sizes import NaturalSizes, sizes_of

OWN, AGAINST = "trial-own", "trial-states"
MEANINGFUL = 1e-4  # engines further apart, at the end of what numbers can do, judge nobody
COMPARED = ("mass_matrix", "bias", "force", "acceleration")
Judged = tuple[Finding, list[EntryPlace]]
Judge = Callable[[About, Results], Finding]


def reference_of(bench: Bench, level: str) -> str:
    """The model that entries are held against one by one."""
    return bench.engines(level)[0]


def sizes_in(bench: Bench, results: Results, level: str) -> NaturalSizes:
    """Natural sizes by the reference's answers. Raises Unavailable."""
    model = reference_of(bench, level)
    mass = results.need(bench.ask(model, "mass_matrix"))
    force, acceleration = (results.settled(bench.ask(model, p)) for p in ("force", "acceleration"))
    table = bench.equations.table
    precision = table.precision if table else 0.0
    return sizes_of(bench.frame, bench.states, mass, force, acceleration, precision)


def sizing(bench: Bench, level: str) -> tuple[StateQuestion, ...]:
    """What sizes are taken from."""
    model = reference_of(bench, level)
    return tuple(bench.ask(model, part) for part in ("mass_matrix", "force", "acceleration"))


def own_comparisons(bench: Bench) -> Iterator[Comparison]:
    """Engine-free checks of the parts that are there; the reference lends its sizes alone."""
    level = bench.levels[-1] if bench.levels else ""
    for part in COMPARED:
        if part in bench.has and (part != "acceleration" or bench.equations.acceleration):
            asked = (part, f"{part}{AGAIN}")
            check = partial(_repeatable, part)
            yield _own(bench, f"repeatable-{part}", asked, level, check)
    if "mass_matrix" in bench.has:
        yield _own(bench, "symmetric", ("mass_matrix",), level, own_checks.symmetric)
        yield _own(bench, "positive-definite", ("mass_matrix",), level, _positive)
    if "bias" in bench.has:
        yield _own(bench, "bias-quadratic", ("bias", "other_speeds"), level, own_checks.quadratic)
    if {"mass_matrix", "bias"} <= bench.has:
        pair = "rate_terms", "christoffel"
        yield _own(bench, "bias-from-inertia", pair, level, own_checks.from_inertia)
    if bench.equations.inverse_dynamics is not None:
        whole = ("inverse_dynamics",)
        yield _own(bench, "inverse-dynamics", whole, level, own_checks.inverse_dynamics)
    if "force" in bench.has:
        yield _own(bench, "linear-in-torques", ("by_torques",), level, own_checks.linear_in_torques)
    if bench.equations.acceleration is not None and bench.has >= {*COMPARED}:
        yield _own(bench, "second-law", COMPARED, level, _second_law)


def _repeatable(part: str, about: About, one: Any, again: Any, sizes: NaturalSizes) -> Judged:
    return own_checks.repeatable(about, part, one, again, sizes)


def _positive(about: About, mass: Any, sizes: NaturalSizes) -> Judged:
    return own_checks.positive(about, mass), []


def _second_law(
    about: About, mass: Any, bias: Any, force: Any, acceleration: Any, sizes: NaturalSizes
) -> Judged:
    return own_checks.second_law(about, (mass, bias, force), acceleration, sizes)


def _own(
    bench: Bench, quantity: str, parts: Sequence[str], level: str, check: Callable[..., Judged]
) -> Comparison:
    questions = tuple(bench.yours(part) for part in parts)
    key = Key(OWN, bench.case.arm.name, quantity, bench.name)
    metric = f"largest relative deviation of an entry over {bench.count} random states"

    def judged(about: About, results: Results) -> Finding:
        answers = [results.need(question) for question in questions]
        finding, places = check(about, *answers, sizes_in(bench, results, level))
        return replace(finding, note=finding.note or listed(places, bench.frame.names))

    about = About(key, "1", metric, "first principles")
    return Comparison(about, (*questions, *sizing(bench, level)), judged)


def own_balances(bench: Bench) -> Iterator[Comparison]:
    """Power and momentum of geared equations that have everything.

    Not through a function's map, which need not reach every pose that these draw.
    """
    if bench.levels or bench.frame.matrix is None or not bench.has >= {*COMPARED}:
        return
    spot = Spot(bench.case.arm.name, bench.name, bench.case, bench.count, bench.seed)
    for found in balances(spot):
        judged = partial(_carried, bench, found.judge)
        yield Comparison(found.about, (*found.needs, *sizing(bench, "")), judged)


def _carried(bench: Bench, judge: Judge, about: About, results: Results) -> Finding:
    """A balance of accelerations that came through the map, and hold its rounding."""
    found, sizes = judge(about, results), sizes_in(bench, results, "")
    if found.measured is None or found.tolerance is None:
        return found
    looser = sizes.tolerance("acceleration") / LOOSEST
    return checked(
        about,
        measured=found.measured,
        tolerance=found.tolerance * looser,
        basis=f"{found.basis}; times {looser:.3g}: {sizes.basis('acceleration')}",
        relative=found.relative,
    )


def engine_comparisons(bench: Bench, level: str, *, binding: bool) -> Iterator[Comparison]:
    """Every part against every engine; measurements where a level is not what is claimed.

    binding: whether they must agree.
    """
    for part in COMPARED:
        for engine in bench.engines(level) if part in bench.has else ():
            yield _against(bench, engine, part, level, binding)


def _against(bench: Bench, engine: str, part: str, level: str, binding: bool) -> Comparison:
    yours, theirs = bench.yours(part), bench.ask(engine, part)
    reference = bench.ask(reference_of(bench, level), part)
    key = Key(AGAINST, bench.case.arm.name, part, bench.name, engine)
    metric = f"largest relative difference of an entry over {bench.count} random states"

    def judged(about: About, results: Results) -> Finding:
        one, other = results.need(yours), results.need(theirs)
        sizes = sizes_in(bench, results, level)
        measured = float(deviations(one, other, sizes.of(part)).max())
        if not binding:
            return measured_only(about, measured=measured)
        wrong = [each.place for each in wrong_entries(part, one, other, sizes)]
        among = float(deviations(results.need(reference), other, sizes.of(part)).max())
        tolerance = sizes.tolerance(part) + among
        return checked(
            about,
            measured=measured,
            tolerance=tolerance,
            basis=f"{sizes.basis(part)}; engines among themselves {among:.2g}",
            resolved=among <= MEANINGFUL,
            relative=measured,
            note=listed(wrong, bench.frame.names),
        )

    needs = dict.fromkeys((yours, theirs, reference, *sizing(bench, level)))
    return Comparison(About(key, "1", metric), tuple(needs), judged)
