"""Views of a cross-check: of an arm and of a robot, in which all agrees or every verdict occurs."""

import io
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
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
from crosscheck.mechanisms import supply
from crosscheck.models.loading import load_arm
from crosscheck.models.robot.file import load_robot
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.report import answers, html, junit, summary, terminal
from crosscheck.report.matrix import FAMILIES, FORMS
from crosscheck.run import CrossCheck
from tests.views.walker import WORDS, Fact, View

LEAD, PRINTED, GEARS, TREE, BODIES = (
    *("analytic:physical", "analytic:printed", "pinocchio:gears", "exudyn:tree", "exudyn:bodies"),
)
WORST = WORDS[:5]
UNITS = {"theta": "rad", "F_sp": "N", "tip": "m", "run": "rad", "energy": "J"}
LINKS = ("analytic:links", "pinocchio:links")
FORMS_OF = {"arm": (PRINTED, "analytic:energies"), "robot": ()}
TICK = WORDS[-1]
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


def list_facts(kind: str, agreement: Agreement) -> Iterator[Fact]:
    """Facts of the findings, of models, of levels and of entries."""
    yield from list_findings(agreement)
    outline = supply("outline", mechanism_of(kind).section)(mechanism_of(kind))
    yield from _list_models(agreement, outline)
    yield from _list_levels(agreement)
    yield from _list_entries(agreement)


def list_findings(agreement: Agreement) -> Iterator[Fact]:
    """Facts of each finding, of pairs of models, and counts."""
    for f in agreement.findings:
        unit = "" if f.unit == "1" else f.unit.replace(" s-1", "/s")
        own: dict[str, Any] = {"verdict": f.verdict, "joint": f.about.key.joint}
        own |= {name: getattr(f, name) for name in ("measured", "tolerance", "relative")}
        if f.tolerance is not None and f.measured is not None:
            own["share"] = f.measured / f.tolerance if f.tolerance else 0.0
        for name, value in own.items():
            if value is not None:
                yield Fact(value, name, (f.id,), unit if name in ("measured", "tolerance") else "")
        for listed in (agreement.disagreeing, agreement.disagreeing[:10]):
            same = [each for each in listed if (each.note, each.verdict) == (f.note, "failed")]
            yield Fact(len(same) - 1, "others", (f.id,))
    yield from _list_counts(agreement.findings, ())
    yield from _list_pairs(agreement.findings)
    if agreement.provenance:
        yield Fact(agreement.provenance.seed, "seed")


def _list_counts(findings: Sequence[Finding], owners: tuple[str, ...]) -> Iterator[Fact]:
    own, checks = Counter(f.verdict for f in findings), [f for f in findings if f.kind == "check"]
    shares = [f.measured / f.tolerance for f in checks if f.measured is not None and f.tolerance]
    yield from (Fact(count, verdict, owners) for verdict, count in own.items())
    if owners:
        yield Fact(max(shares, default=0.0), "most", owners)
        return
    between, red = sum(bool(f.about.key.right) for f in checks), len(checks) - own["agree"]
    counts = {"checks": len(checks), "tests": len(checks), "red": red, "agreeing": own["agree"]}
    counts |= {"between": between, "single": len(checks) - between, "findings": len(findings)}
    counts |= {"measurements": len(findings) - len(checks), "more": red - 3, "further": red - 10}
    counts |= {"errors": own["failed"] + own["unfinished"], "time": 0, "skipped": 0}
    counts |= {"failures": own["differ"] + own["unresolved"]}
    yield from (Fact(count, name) for name, count in counts.items())


def _list_pairs(findings: Sequence[Finding]) -> Iterator[Fact]:
    pairs: dict[tuple[str, ...], list[Finding]] = defaultdict(list)
    alone: Counter[str] = Counter()
    for f in findings:
        is_pair = bool(f.about.key.right)
        pairs[tuple(sorted((f.left, f.right))) if is_pair else (f.left, "alone")].append(f)
    for pair, found in pairs.items():
        is_pair, right = pair[1] != "alone", found[0].right
        yield from _list_counts(found, (" and ".join(pair) if is_pair else " ".join(pair),))
        checks = [f for f in found if f.kind == "check"]
        counted = checks + [f for f in found if f.about.key.family in FORMS]
        names = pair if is_pair else (pair[0], right)
        if counted:
            yield Fact(_worst(counted, findings), "verdict", names)
            yield Fact(len(checks), "checks of it", names)
        for words in dict.fromkeys(FAMILIES.values()):
            own = [f for f in counted if FAMILIES.get(f.about.key.family) == words]
            if sizes := [f.relative for f in own if f.relative]:
                yield Fact(min(16.0, -np.log10(max(sizes))), f"digits {words}", names, digits=0)
        if not is_pair:
            alone[right] += 1
            same = sum(f.right == right and not f.about.key.right for f in findings)
            yield Fact(same, "checks of it", ("models", right))
            yield Fact("agree", "verdict", ("models", right))
    yield from (Fact(count, "models alone") for count in alone.values())


def _worst(found: Sequence[Finding], findings: Sequence[Finding]) -> str:
    """The worst verdict of checks; of measurements alone, whether one is beyond a tolerance."""
    checks = [f.verdict for f in found if f.kind == "check"]
    beyond = any(_is_beyond(f, findings) for f in found)
    return min(checks, key=WORST.index, default="differ" if beyond else "agree")


def _is_beyond(finding: Finding, findings: Sequence[Finding]) -> bool:
    """Whether a measurement is beyond what the reference model is allowed at the same states."""
    like = (finding.about.key.case, finding.quantity)
    own = [f for f in findings if f.tolerance and (f.about.key.case, f.quantity) == like]
    allowed = [f.tolerance for f in own if LEAD in (f.left, f.right)]
    return bool(allowed) and (finding.measured or 0.0) > max(allowed)


def _list_models(agreement: Agreement, outline: Any) -> Iterator[Fact]:
    verdicts, digits = [], []
    pairs = [
        f for f in agreement.findings if f.about.key.right and f.about.key.family != "deviation"
    ]
    pairs = [f for f in pairs if f.left.partition(":")[0] != f.right.partition(":")[0]]
    for model, title in outline.models.items():
        beside = [f for f in pairs if model in (f.left, f.right)]
        # Sentences on printed equations name them by their titles.
        owners = (model, title[0].upper() + title[1:])[: 1 + (model in outline.forms)]
        for quantity, words in outline.quantities.items():
            own = [f for f in beside if f.quantity == quantity]
            sizes = [np.inf if f.measured is None else f.measured for f in own]
            if own and np.isfinite(max(sizes)):
                unit = "" if own[0].unit == "1" else own[0].unit
                yield from (Fact(max(sizes), words, (owner,), unit, 1) for owner in owners)
        if beside:
            verdicts.append(_worst(beside, agreement.findings))
            yield Fact(verdicts[-1], "verdict", (model,))
        if model not in outline.forms:
            states = [f for f in beside if f.about.key.family == "states"]
            digits += [-np.log10(f.relative) for f in states if f.relative]
    yield Fact(len(verdicts), "models")
    yield Fact(len(verdicts) - verdicts.count("agree"), "differing")
    yield Fact(int(min(digits, default=0.0)), "digits")


def _list_levels(agreement: Agreement) -> Iterator[Fact]:
    off = [f for f in agreement.findings if f.about.key.family == "deviation"]
    for f in off:
        key, level = f.about.key, f.left.partition(":")[2]
        name = {"theta": "angle", "theta_dot": "speed"}.get(f.quantity, f.quantity)
        head = f"joint {key.joint} {name}" if key.joint else name
        yield Fact(f.measured, head, (key.case, f.left), f.unit)
        if key.joint is None:
            if level in ("links", "coupled"):
                yield Fact(f.measured, "off", (key.case, level), "m")
            yield Fact(f.measured, "tip at level", (f"level {level}",), "m")
        if f.quantity == "torque":
            same = [each for each in off if (each.left, each.quantity) == (f.left, "torque")]
            yield Fact(max(e.relative or 0.0 for e in same), "torque at level", (f"level {level}",))
    tips = [f for f in off if f.quantity == "tip" and f.about.key.case == off[-1].about.key.case]
    yield Fact(tips[0].measured, "card", (), "m")


def _list_entries(agreement: Agreement) -> Iterator[Fact]:
    wrong: dict[str, float] = {}
    for each in agreement.entries:
        title = "mass matrix" + {PRINTED: ", as printed", LEAD: ", corrected"}.get(each.model, "")
        cells = np.array(each.relative)
        for (row, column), value in np.ndenumerate(cells):
            names = [each.coordinates[place] for place in (row, column)]
            shown = TICK if value <= each.tolerance else value
            yield Fact(shown, names[1], (title, names[0]))
            yield Fact(value, "relative", (each.model,))
            both = max(value, cells[column, row])
            if row <= column and both > each.tolerance and each.model == PRINTED:
                names = names if value > each.tolerance else names[::-1]
                wrong[f"M[{', '.join(names)}]"] = both
        yield Fact(each.tolerance, "tolerance", (each.model,))
        yield Fact(int((cells > each.tolerance).sum()), "cells that differ", (title,))
        yield Fact(cells.size, "cells", (title,))
    if agreement.entries:
        yield Fact(agreement.entries[0].tolerance, "allowed of cells")
    yield Fact(len(wrong), "wrong entries")
    for name, value in sorted(wrong.items(), key=lambda item: -item[1]):
        yield Fact(value, "wrong", (name,))
        yield Fact(value, "relative", (name,))
    yield Fact(max(wrong.values(), default=0.0), "largest")


COUNTED = {f"{{}} {verdict}(?!ment)": verdict for verdict in WORDS[:6]}
PHRASES = {
    **COUNTED,
    "at most {}(?: times)? of a tolerance": "most",
    "{} of {} checks?": "red, checks",
    "{} of {} checks agree": "agreeing, checks",
    "[(]{} of {} checks?[)]": "agreeing, checks",
    "[Cc]hecks {} of {} agree": "agreeing, checks",
    "Equations \\w+ {} of {} models": "differing, models",
    "Engines \\w+ {} of {} models": "differing, models",
    "{} compare two models": "between",
    "{} compare one model": "single",
    "{} more numbers": "measurements",
    "{} differences? measured": "measurements",
    "All {} findings": "findings",
    "and so in {} more": "others",
    "measured {}": "measured",
    "allowed {}": "tolerance",
    "uncertainty itself, {}": "tolerance",
    "to {} digits": "digits",
    "in {} entr": "wrong entries",
    "largest M\\[[^]]*\\], {}": "largest",
    "\\]: {}": "wrong",
    "all {} models": "models",
    "{} of {} entries": "cells that differ, cells",
    "{} without ": "off",
    "{} tip error": "card",
    "the tip is {}": "tip at level",
    "by up to {} of its largest": "torque at level",
    "within {}, which": "allowed of cells",
    "{} (mass matrix|accel|joint|mesh)": "no number",
    **{
        f"{{}} in {words}": words
        for words in ("mass matrix", "acceleration", "joint angle", "mesh force")
    },
    **{f"{{}} digits {words}": f"digits {words}" for words in FAMILIES.values()},
    "{} checks?$": "checks of it",
    "^{} models$": "models alone",
    "and {} more$": "more",
    "and {} more on the page": "further",
    **{f"{{}} {words}": f"digits {words}" for words in FAMILIES.values()},
}
HEADS = {**{f"{words} in runs": words for words in ("joint angle", "mesh force")}}
HEADS |= {"checks": "checks of it", "value": "measured"}
WORDING = {
    r" 1$": "the unit of a plain number",
    r"\b[123]\. (?=[A-Z])": "numbers of sections",
    r"after 0.1 s": "of a finding's metric",
    r"joint ?[12]\b": "counts joints",
    r"counted from 1\b": "joints",
    r"of planet 1": "names a planet",
    r"Eqs?\. [-\d]+": "names an equation",
    r"(With --quick|Preliminary\.).*": "limits of a quick run",
    r"order 8 are right to 3e-12|ε = 2\.2e-16|1e-10 of|1000 ε|200 ε|50 ε|10 √N": "tolerances",
    r"Robotica, 2014": "a year",
    r"(?:one|1) \(.*\)": "a joint",
}


def render_page(kind: str, agreement: Agreement) -> str:
    """The page, without pictures."""
    request = CrossCheckRequest(mechanism_of(kind), quick=True)
    return html.render_report_page(CrossCheck(request, agreement, {}, {}))


COLUMNS = "300"  # of a wide terminal, on which no line is wrapped


def print_with(show: Callable[..., None], *given: Any) -> str:
    """What a function prints on a terminal of so many columns."""
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(io.StringIO()) as out:
        patch.setenv("COLUMNS", COLUMNS)
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
DIGITS = tuple(f"digits {words}" for words in dict.fromkeys(FAMILIES.values()))
NUMBERS = ("measured", "tolerance", "share", "verdict")
SORTED = (*NUMBERS, *WORDS, "relative", "most", "checks of it", *DIGITS)
QUANTITY_WORDS = ("mass matrix", "acceleration", "joint angle", "mesh force", "coordinates in runs")
SHOWN = {"page": (*NUMBERS, *QUANTITY_WORDS), "JSON": NUMBERS[:2]}
VIEWS = {
    f"{name} of {kind}{', all green' * is_green}": View(
        make=partial(make_agreement, kind, is_green),
        render=partial(render, kind),
        facts=partial(list_facts, kind),
        heads=HEADS,
        phrases=PHRASES,
        wording=WORDING,
        shown=SHOWN.get(name, ()),
        given=partial(lambda kind, made: (mechanism_of(kind), mechanism_of(kind).described), kind),
        sorted=SORTED,
    )
    for (name, render), kind, is_green in product(RENDER.items(), ("arm", "robot"), (False, True))
}
