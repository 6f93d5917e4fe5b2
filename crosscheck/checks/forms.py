"""The paper's own forms: what they are in symbols, and how far they are from the engines."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from crosscheck.checks import states
from crosscheck.checks.answers import EQUATIONS, Setting, mass_matrix
from crosscheck.checks.engines import plan_arm_pair
from crosscheck.checks.sampled import DIFFERENCE, Subjects, find_usual
from crosscheck.checks.trajectories import make_subject, measure_deviation
from crosscheck.findings import ComparisonKey, Finding, Subject
from crosscheck.planning.comparison import Comparison, make_comparison

QUANTITIES = ("theta", "x_sp", "F_sp", "F_pr")


def plan(subjects: Subjects) -> Iterator[Comparison]:
    """Comparisons of each form with its symbols, and measurements of it beside engines."""
    for form in (each for each in subjects.arms if each.group == "form"):
        judge = partial(_compare_symbols, setting=form.setting)
        for symbols in form.symbols:
            question = symbols.question
            key = ComparisonKey("form-symbols", form.where, question.__name__, form.model)
            about = Subject(key, "1", form.over(DIFFERENCE), "its equations in symbols")
            tasks = form.ask(question), symbols, form.ask(mass_matrix)
            yield make_comparison(about, tasks, judge)
        _, *engines = (
            each for each in subjects.arms if each.where == form.where and each.group != "form"
        )
        for engine in engines:
            right = replace(engine, setting=form.setting)
            for question in EQUATIONS:
                yield plan_arm_pair("form-states", question, form, right, states.measure_values)
    for experiment in find_usual(subjects):
        other = experiment.models.same[1]
        for name in experiment.models.forms:
            runs = experiment.run(name), experiment.run(other)
            for quantity in QUANTITIES:
                about = make_subject("form", experiment, quantity, name, other)
                yield make_comparison(about, runs, measure_deviation)


def _compare_symbols(
    about: Subject,
    values: np.ndarray,
    stated: np.ndarray,
    mass: np.ndarray,
    setting: Setting,
) -> Finding:
    return states.compare_values(about, stated, values, mass, setting)
