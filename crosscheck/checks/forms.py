"""The paper's own forms: what they are in symbols, and how far they are from the engines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from crosscheck.checks.answers import EQUATIONS
from crosscheck.checks.engines import plan_pair
from crosscheck.checks.sampled import DIFFERENCE, Subjects, find_usual
from crosscheck.checks.states import compare_answers, measure_answers
from crosscheck.checks.trajectories import make_subject, measure_deviation
from crosscheck.findings import ComparisonKey, Subject
from crosscheck.planning.comparison import Comparison, make_comparison

QUANTITIES = ("theta", "x_sp", "F_sp", "F_pr")


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each form with its symbols, and measurements of it beside engines."""
    for form in (each for each in subjects.arms if each.group == "form"):
        judge = partial(compare_answers, setting=form.setting)
        for symbols in form.symbols:
            question = symbols.question
            key = ComparisonKey("form-symbols", form.where, question.__name__, form.model)
            about = Subject(key, "1", form.over(DIFFERENCE), "its equations in symbols")
            yield make_comparison(about, (symbols, form.ask(question)), judge)
        group = (each for each in subjects.arms if each.where == form.where)
        _, *engines = (each for each in group if each.group != "form")
        metric = form.over("largest relative difference")
        for engine in engines:
            right = replace(engine, setting=form.setting)
            for question in EQUATIONS:
                yield plan_pair("form-states", question, form, right, measure_answers, metric)
    for experiment in find_usual(subjects):
        other = experiment.models.same[1]
        for name in experiment.models.forms:
            runs = experiment.run(name), experiment.run(other)
            for quantity in QUANTITIES:
                about = make_subject("form", experiment, quantity, name, other)
                yield make_comparison(about, runs, measure_deviation)
