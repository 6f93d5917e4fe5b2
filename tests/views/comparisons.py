"""Views of a record beside an arm's levels."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from crosscheck.findings import Agreement
from crosscheck.identification import output
from crosscheck.identification.compare import RecordComparison, SideResult
from crosscheck.identification.restrictions import FileJudgement
from crosscheck.identification.terms import TermEstimate
from tests.brief import perform_here
from tests.measured.guards import kept
from tests.views.agreements import list_findings
from tests.views.walker import Fact, View, vary


def make_comparison(seed: int) -> RecordComparison:
    """The comparison, with other numbers; its last run is shorter, so that no mean is right."""
    with pytest.MonkeyPatch.context() as patch:
        perform_here(patch)
        whole = kept().comparison
    window = whole.windows[0]
    rows = slice(2 * len(window.time) // 3)
    cut = type(window)(*(getattr(window, name)[rows] for name in vars(window)))
    return vary(replace(whole, windows=(*whole.windows, cut)), seed)


def list_facts(comparison: RecordComparison) -> Iterator[Fact]:
    """Facts of runs, sides and engines."""
    yield from list_findings(Agreement(comparison.engines))
    worst = max(comparison.engines, key=lambda f: f.measured or 0.0)
    yield Fact(worst.measured, "furthest", (worst.right,))
    yield Fact(worst.tolerance, "allowed", (worst.right,))
    for f in comparison.engines:
        yield Fact(f.measured, "difference", (f.left, f.right))
        yield Fact(f.tolerance, "tolerance", (f.left, f.right))
    rows = sum(len(each.time) for each in comparison.records)
    counts = {"recordings": len(comparison.records), "rows": rows}
    counts |= {"comparisons": len(comparison.engines), "runs": len(comparison.windows)}
    ranks = comparison.ranks
    counts |= {name: getattr(ranks, name) for name in ("links", "armature", "coupled")}
    counts |= {"armature_and_coupled": ranks.both}
    yield from (Fact(count, name) for name, count in counts.items())
    yield from (Fact(share, path) for path, share in comparison.tolerances.items())
    yield Fact(sum(each.time[-1] - each.time[0] for each in comparison.records), "length", (), "s")
    for joint in comparison.mechanism.robot.joints:
        yield Fact(joint.friction, "friction in the file", (f"viscous friction at {joint.name}",))
    for side in comparison.sides:
        yield from _list_side(side)
    for side in comparison.gravities:
        for fact in _list_side(side):
            yield fact._replace(owners=(*fact.owners, "sides_with_other_gravity"))
    windows = comparison.windows
    durations = np.array([float(w.time[-1] - w.time[0]) for w in windows])
    shares = np.array([w.stays_s for w in windows]) / durations
    middle = float(np.quantile(shares, 0.5, method="higher"))
    yield Fact(middle * float(np.median(durations)), "stays", (), "s")
    yield Fact(float(np.median([w.time[-1] - w.time[0] for w in windows])), "lasts", (), "s")
    yield Fact(float(np.mean([w.within for w in windows])), "share within")
    for window in windows:
        ends = {"last_E": window.error, "last_u_num": window.numerical, "last_u_D": window.data}
        ends |= {"last_u_input": window.inputs, "last_u_val": window.validation}
        numbers = {"from_s": window.time[0], "to_s": window.time[-1], "stays_s": window.stays_s}
        numbers |= {"within_2_u_val": window.within}
        yield from (Fact(float(value), name) for name, value in numbers.items())
        yield from (Fact(float(x), name) for name, values in ends.items() for x in values[-1])


def _list_side(side: SideResult) -> Iterator[Fact]:
    numbers = {"bandwidth_hz": side.bandwidth, "rows_apart_s": side.samples.step}
    numbers |= {"blocks": side.fit.blocks, "condition_number": side.fit.condition}
    yield from (Fact(value, name) for name, value in numbers.items())
    yield Fact(side.threshold, "t_of_a_rotor")
    for share in side.unexplained:
        yield Fact(float(share), "unexplained")
        yield Fact(100 * float(share), "unexplained [%]")
    for step in side.steps:
        own = {"parameters": step.parameters, "weighted_rms": step.weighted}
        own |= {"weighted_rms_predicted": step.predicted}
        yield from (Fact(value, name, (step.name,), digits=0) for name, value in own.items())
        yield from (Fact(float(value), "rms_N_m", (step.name,)) for value in step.rms)
        for name, value in zip(side.measured, step.rms, strict=True):
            yield Fact(float(value), f"{name}, rms", (step.name,))
    for each in side.estimates:
        yield from _list_estimate(each)
    for band in side.bands:
        yield Fact(band.bandwidth, "other band")
        yield Fact(band.bandwidth, "bandwidth_hz", ("other_bandwidths",))
        for each in band.estimates:
            yield from _list_estimate(each)
    if side.judgement is not None:
        yield from _list_judgement(side, side.judgement)


def _list_judgement(side: SideResult, judgement: FileJudgement) -> Iterator[Fact]:
    for each in (*judgement.levels, *judgement.changes):
        parameter = each.parameter
        names = (each.level, "nothing") if parameter is None else (each.level, parameter.phrase)
        keys = (each.level,) if parameter is None else (each.level, parameter.path)
        behind = judgement.compare(each, judgement.likeliest)
        yield Fact(behind, "times less likely than the best", names)
        yield Fact(behind, "likelihood_ratio_of_the_best", keys)
        yield Fact(each.chance, "chance", keys)
        for name, ratio in zip(side.measured, each.ratios, strict=True):
            yield Fact(float(ratio), name, names)
            yield Fact(float(ratio), "rms_over_that_of_any_links", keys)
            said = (f"{each.level}, the file",) if parameter is None else names
            yield Fact(float(ratio), "times", said)
        if parameter is None:
            yield Fact(float(each.ratios.max()), "most", (f"({each.level})",))
        elif each.estimate is not None:
            unit = each.estimate.term.unit
            yield Fact(parameter.value, "in the file", names, unit)
            yield Fact(each.estimate.value, "changed to", names, unit)
            yield Fact(each.estimate.half_width, "within", names, unit, digits=0)
            yield from _list_estimate(each.estimate, (parameter.phrase, each.level))
        for estimate in each.friction:
            yield from _list_estimate(estimate)


def _list_estimate(each: TermEstimate, owners: tuple[str, ...] = ()) -> Iterator[Fact]:
    numbers = {"estimate": each.value, "standard_error": each.error, "in_the_file": each.term.value}
    numbers |= {"half_of_95_percent_interval": each.half_width, "± (95 %)": each.half_width}
    numbers |= {"systematic_part_of_standard_error": each.systematic}
    numbers |= {"estimate_in_twice_the_band": each.doubled, "in the file": each.term.value}
    for name, value in numbers.items():
        if value is not None:
            digits = 0 if name in ("estimate", "± (95 %)", "estimate_in_twice_the_band") else 2
            for called in {each.term.name, each.term.words}:  # in JSON, and in sentences
                yield Fact(value, name, owners or (called,), digits=digits)
    yield Fact(each.systematic / each.error, "of its error", (each.term.words,), digits=0)


PHRASES = {
    "rad [(]file: {}": "friction in the file",
    "payload [(]file: {}": "in the file",
    "is {} times that": "most",
    "from {} recorded states": "runs",
    "(?:after|for) {} of {}": "stays, lasts",
    "{} of the rows": "share within",
    "{} recordings?": "recordings",
    "{} rows, {}$": "rows, length",
    "of {} comparisons": "comparisons",
    "all but {} %": "unexplained [%]",
    "leave {} %": "unexplained [%]",
    ": {} of the torques' terms apart, at most {}": "furthest, allowed",
    "to {}(?: are fitted, with|,) a row every {}": "bandwidth_hz, rows_apart_s",
    "condition number {}": "condition_number",
    "from {} blocks": "blocks",
    "fitted links: {} at [^,]+, {} at": "times, times",
    "{} ± {}": "estimate, ± (95 %)",
    "[)] is {} ± {}": "changed to, within",
    "{} \\(depends on the band: {}": "estimate, estimate_in_twice_the_band",
    ": {} parameters, residual {}, {} predicted; rms {} at [^,]+, {} at": (
        "parameters, weighted_rms, weighted_rms_predicted, rms_N_m, rms_N_m"
    ),
    "[Uu]p to {}:": "other band",
    ", {} of its error": "of its error",
}
HEADS = {"residual, weighted": "weighted_rms"}
HEADS |= {"residual of blocks, predicted from the others": "weighted_rms_predicted"}
HEADS |= {"from": "from_s", "to": "to_s", "stays within 3 u_val for": "stays_s"}
HEADS |= {"|E| at most 2 u_val at": "within_2_u_val", "E at the end": "last_E"}
HEADS |= {"u_val there": "last_u_val"}
WORDING = {
    r"At 1|± is 95 %|[(]?\d sigma[)]?|\d u_val|V 20|V&V 20|± \(95 %\)": "what an interval covers"
}


def render_page(comparison: RecordComparison) -> str:
    """The page, without what is drawn."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(output, "draw_joints", lambda *given, **more: "<svg></svg>")
        return output.comparison_page(comparison)


RENDER = {
    "terminal": lambda comparison: "\n".join(output.describe_comparison(comparison)),
    "JSON": output.comparison_json,
    "page": render_page,
}
VIEWS = {
    f"{name} of compare": View(
        make=make_comparison,
        render=render,
        facts=list_facts,
        heads=HEADS,
        phrases=PHRASES,
        wording=WORDING,
        sorted=(
            "estimate",
            "standard_error",
            "± (95 %)",
            "half_of_95_percent_interval",
            "in the file",
        ),
    )
    for name, render in RENDER.items()
}
