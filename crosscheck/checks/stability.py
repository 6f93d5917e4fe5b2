"""Experiments whose loop is unstable while teeth touch, of which little can be judged."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from crosscheck.checks.sampled import ExperimentPlan, Subjects
from crosscheck.findings import ComparisonKey, Finding, Subject, make_measurement
from crosscheck.planning.comparison import Comparison, Results, make_comparison


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Measurements of how fast a loop's vibration grows."""
    for experiment in subjects.experiments:
        growth = experiment.growth
        if growth is not None:
            reference = experiment.models.same[0]
            key = ComparisonKey("stability", experiment.name, "growth-rate", reference)
            metric = "fastest-growing vibration with every tooth in contact"
            judge = partial(make_measurement, measured=growth.rate_per_s, note=str(growth))
            yield make_comparison(Subject(key, "1/s", metric, "stability"), (), judge)


def relax_comparison(experiment: ExperimentPlan, comparison: Comparison) -> Comparison:
    """The comparison, said to mean nothing where an unstable loop alone may have changed it."""

    def judge_results(about: Subject, results: Results) -> Finding:
        finding = comparison.judge(about, results)
        if finding.verdict in ("failed", "unfinished"):
            return replace(finding, note=f"{finding.note}; {experiment.growth}")
        if finding.verdict not in ("differ", "unresolved") or finding.measured is None:
            return finding
        basis = f"not judged, for {experiment.growth}; else {finding.basis}"
        return make_measurement(
            about, measured=finding.measured, basis=basis, relative=finding.relative
        )

    return replace(comparison, judge=judge_results)
