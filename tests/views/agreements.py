"""Views of a cross-check: of an arm and of a robot, in which all agrees or every verdict occurs."""

import io
from collections.abc import Callable, Iterator
from contextlib import redirect_stdout
from dataclasses import replace
from functools import lru_cache, partial
from itertools import product
from typing import Any

import numpy as np
import pytest

from crosscheck import findings as makers  # of which one may be planted
from crosscheck.findings import (
    Agreement,
    ComparisonKey,
    EntryDifferences,
    Finding,
    Subject,
    make_failed_check,
    make_measurement,
    make_unfinished_check,
)
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.report import answers, html, junit, summary, terminal
from crosscheck.run import CrossCheck
from tests.views.shown_numbers import View

LEAD, PRINTED, GEARS, TREE, BODIES = (
    *("analytic:physical", "analytic:printed", "pinocchio:gears", "exudyn:tree", "exudyn:bodies"),
)
WORST = ("failed", "differ", "unfinished", "unresolved", "agree")
UNITS = {"theta": "rad", "F_sp": "N", "tip": "m", "run": "rad", "energy": "J"}
LINKS = ("analytic:links", "pinocchio:links")
FORMS_OF = {"arm": (PRINTED, "analytic:energies"), "robot": ()}
# Of an arm and of a robot: pairs of models, quantities by families, levels.
ROBOTS = product(("links", "coupled"), ("pinocchio", "exudyn"))
PAIRS = {
    "arm": [(LEAD, GEARS), (LEAD, TREE), (TREE, GEARS), (BODIES, LEAD), LINKS],
    "robot": [(f"analytic:{level}", f"{engine}:{level}") for level, engine in ROBOTS],
}
QUANTITIES = {
    "arm": {"mass_matrix": "states", "acceleration": "states", "theta": "same-step"},
    "robot": {"mass_matrix": "states", "forward_dynamics": "states", "run": "same-step"},
}
QUANTITIES["arm"]["F_sp"] = "refined"
LEVELS = {"arm": ("links", "carriers", "coupled"), "robot": ("links", "armature", "coupled")}
BASIS = "one rounding of each of the operations that a number is made of"
COORDINATES = ("theta_1", "theta_2", "x_sp1")


@lru_cache
def mechanism_of(kind: str) -> Any:
    """The arm, or the robot."""
    return load_arm("paper-labelled") if kind == "arm" else load_robot("sliding")


def about(*key: Any, metric: str = "largest", against: str = "") -> Subject:
    """The subject of a comparison, by the fields of its key."""
    return Subject(ComparisonKey(*key), UNITS.get(key[2], "1"), metric, against)


def make_agreement(kind: str, is_green: bool, seed: int) -> Agreement:
    """Findings of every sort, whose numbers are drawn."""
    rng, mechanism = np.random.default_rng(seed), mechanism_of(kind)
    case, is_arm = f"{mechanism.name}/geared", kind == "arm"
    found = []
    for pair, (quantity, family) in product(PAIRS[kind], QUANTITIES[kind].items()):
        verdict = "agree" if is_green else str(rng.choice(WORST))
        where = case if family == "states" else "pd"
        found.append(_draw(about(family, where, quantity, *pair), verdict, rng))
    for model, where in product((TREE, GEARS, LEAD), ("pd", "drop")):
        own = about("energy", where, "energy", model, against="its work")
        found.append(_draw(own, "agree", rng))
    rng.shuffle(found)  # type: ignore[arg-type]
    found = found[int(rng.integers(0, 4)) :]
    for model, quantity in product(FORMS_OF[kind], ("mass_matrix", "acceleration")):
        size = 10 ** rng.uniform(-2, 0)
        own = about("form-states", case, quantity, model, GEARS)
        found.append(make_measurement(own, measured=size, relative=size))
    deviations = list(_draw_deviations(kind, rng))
    sizes = rng.permutation(len(COORDINATES) ** 2)
    values = np.where(sizes % 3 > 0, 10 ** rng.uniform(-4, 0, sizes.shape), 1e-15).reshape(3, 3)
    forms = {PRINTED: values, LEAD: 1e-14 * values} if is_arm else {"exudyn:links": values}
    entries = tuple(
        EntryDifferences("mass_matrix", model, (TREE,), COORDINATES, tuple(map(tuple, own)), 1e-10)
        for model, own in forms.items()
    )
    record = record_provenance(mechanism, 0, True)
    return Agreement([*found, *deviations], record, entries=() if is_green else entries)


def _draw(subject: Subject, verdict: str, rng: np.random.Generator) -> Finding:
    tolerance, share = 10 ** rng.uniform(-13, -8), rng.uniform(0.01, 0.99)
    if verdict in ("failed", "unfinished"):
        make = make_failed_check if verdict == "failed" else make_unfinished_check
        return make(subject, str(rng.choice(["no answer", "stopped"])))
    share = share if verdict != "differ" else 10 ** rng.uniform(0.1, 3)
    relative = 10 ** (rng.uniform(-14, -9) - 3 * subject.key.left.endswith(":links"))
    own = {"measured": share * tolerance, "tolerance": tolerance, "relative": relative}
    return makers.make_check(subject, **own, basis=BASIS, resolved=verdict != "unresolved")


def _draw_deviations(kind: str, rng: np.random.Generator) -> Iterator[Finding]:
    quantity, finest = ("theta", LEAD) if kind == "arm" else ("torque", "analytic:geared")
    for where, level in product(("constant", "drop"), LEVELS[kind]):
        size = 10 ** (rng.uniform(-7, -5.1) if level == "coupled" else rng.uniform(-5, 0.5))
        pair, tip = (f"pinocchio:{level}", finest), "largest distance of the tip after 0.1 s"
        yield make_measurement(about("deviation", where, "tip", *pair, metric=tip), measured=size)
        for joint in (1, 2):
            metric = f"largest difference of the torque of joint{joint} over states"
            own = about("deviation", where, quantity, *pair, joint, metric=metric)
            size, share = 10 ** rng.uniform(-4, 0), rng.uniform(1e-3, 0.9)
            yield make_measurement(own, measured=size, relative=share)


def derive_numbers(agreement: Agreement) -> Iterator[tuple[str, float]]:
    """The share of its tolerance that a finding has, and to how many digits it agrees."""
    for number, f in enumerate(agreement.findings):
        if f.tolerance and f.measured is not None:
            yield f"share of findings[{number}]", f.measured / f.tolerance
        if f.relative:
            yield f"digits of findings[{number}]", min(16.0, -np.log10(f.relative))


def render_page(kind: str, agreement: Agreement) -> str:
    """The page, without pictures."""
    request = CrossCheckRequest(mechanism_of(kind), quick=True)
    return html.render_report_page(CrossCheck(request, agreement, {}, {}))


def print_with(show: Callable[..., None], *given: Any) -> str:
    """What a function prints on a terminal of 80 columns."""
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as out:
        patch.setenv("COLUMNS", "80")
        show(*given)
    return out.getvalue()


RENDER: dict[str, Callable[[str, Agreement], str]] = {
    "page": render_page,
    "run": lambda kind, made: print_with(terminal.print_report_summary, made, mechanism_of(kind)),
    "validate": lambda kind, made: print_with(terminal.print_answers, made, mechanism_of(kind)),
    "JSON": lambda kind, made: answers.format_agreement_json(made, mechanism_of(kind)),
    "JUnit": lambda kind, made: junit.format_junit(replace(made, provenance=None)),
    "notebook": lambda kind, made: summary.CheckResult(**vars(made))._repr_html_(),
    "repr": lambda kind, made: "\n".join(summary.summarize_agreement(made)),
}
VIEWS = {
    f"{name} of {kind}{', all green' * is_green}": View(
        make=partial(make_agreement, kind, is_green, 1),
        render=partial(render, kind),
        derive=derive_numbers,
    )
    for (name, render), kind, is_green in product(RENDER.items(), ("arm", "robot"), (False, True))
}
