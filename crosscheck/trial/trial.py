"""The flow of a trial: ask, measure levels, explain, judge, find the edit of the source.

An arm and a robot each supply the steps that differ, as a ``TrialSubject``.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from crosscheck.findings import Agreement, Finding
from crosscheck.mechanisms import supply
from crosscheck.models.experiment.scenario import Switches
from crosscheck.planning.plan import CrossCheckRequest
from crosscheck.provenance import record_provenance
from crosscheck.registry import packages
from crosscheck.report.formatting import list_first
from crosscheck.run import CrossCheck
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.trial.input.arrays import is_single_precision
from crosscheck.trial.input.equations import Coordinates, Equations
from crosscheck.trial.judge.checks import AnswerSet, find_idle_motors, judge_answers
from crosscheck.trial.judge.entries import LevelDistance
from crosscheck.trial.request import TrialRequest
from crosscheck.trial.result import Trial, TrialDiagnosis
from crosscheck.trial.source.answer_key import AnswerKey
from crosscheck.trial.source.code import find_code
from crosscheck.trial.source.worker import SearchScope, find_source_answer

STATED = 'coordinates=Coordinates(links="absolute")'  # of absolute angles
MOST_UNUSED = 3  # functions beside the parts that are named
RunTrial = Callable[[TrialRequest], Trial]
_trial_lock = threading.Lock()


class TrialSubject(ABC):
    """Equations that have answered, as an arm or a robot supplies them to a trial.

    problem: the equations and what they are compared with; whole: parts without which equations
    are not complete.
    """

    problem: Any
    whole: tuple[str, ...] = ()
    explains_faults = False  # whether notes explain what wrong parts owe to themselves

    @classmethod
    @abstractmethod
    def ask(
        cls, request: TrialRequest, progress: ProgressCallback
    ) -> AbstractContextManager[TrialSubject]:
        """Ask the equations, which answer further questions within the context."""

    @staticmethod
    @abstractmethod
    def run_variants(request: TrialRequest, run: RunTrial) -> Trial:
        """The trial of the request, or of the variant of it that the user must mean."""

    @staticmethod
    @abstractmethod
    def make_answer_keys(trial: Trial) -> Iterator[AnswerKey]:
        """Right answers on the mechanism, and on one of its structure."""

    @staticmethod
    def select_laws(request: TrialRequest) -> Switches | None:
        """The laws of gears that the equations follow; None of a mechanism that has none."""
        return request.switches

    @abstractmethod
    def measure_levels(self) -> list[LevelDistance]:
        """How far the equations are from each level, the nearest first."""

    @abstractmethod
    def diagnose(self, distances: Sequence[LevelDistance]) -> TrialDiagnosis:
        """Find what is wrong, and what explains it."""

    @abstractmethod
    def collect_answers(self, level: str) -> AnswerSet:
        """The answers, to be judged by the sizes of a level."""

    @abstractmethod
    def judge_engines(self, answers: AnswerSet, level: str) -> Iterator[Finding]:
        """Compare the answers and runs with every engine."""

    @abstractmethod
    def measure_errors(self, level: str) -> tuple[dict[str, np.ndarray], dict[str, float]]:
        """Measure each part's entries relative to a level, beside what is allowed."""

    @abstractmethod
    def list_remarks(self) -> Iterator[str]:
        """Sentences on how the equations were read."""

    def list_notes(self, diagnosis: TrialDiagnosis) -> Sequence[str]:
        """Remarks that concern no error."""
        return ()

    def list_runs(self, level: str) -> tuple[dict[Any, Any], dict[Any, Any]]:
        """Cases and runs of scenarios, by key."""
        return {}, {}


def run_trial(request: TrialRequest, progress: ProgressCallback = ignore_progress) -> Trial:
    """Judge supplied equations; of several threads one after the other, for models have names.

    Raises InputError for what cannot be tried at all, and Unfinished where the models that they are
    compared with do not answer.
    """
    subjects = _get_subjects(request)
    run = partial(_run_once, subjects, progress)
    search = partial(_search_source, subjects, progress)
    with _trial_lock:
        trial = subjects.run_variants(request, run)
        if not trial.diagnosis.is_nearer_absolute:
            return search(trial)
        equations = trial.request.equations.read_in(Coordinates(links="absolute"))
        absolute = subjects.run_variants(replace(request, equations=equations), run)
        count, fewer = (len(each.diagnosis.entries) for each in (trial, absolute))
        if fewer >= count:
            return search(trial)
        trial, absolute = search(trial, "likely"), search(absolute)
    entries = f"{'1 entry is' if fewer == 1 else f'{fewer} entries are'} wrong, not {count}"
    if trial.change is None:
        note = f"judged in absolute angles, in which {entries}: state {STATED}"
        return replace(absolute, notes=(note, *absolute.notes))
    # The joint angles are what they are called, for one edit makes all right in these too.
    other = next((f": {each}" for each in absolute.search.sentences), "")
    note = f"in absolute angles ({STATED}), {entries}{other}"
    return replace(trial, notes=(note, *trial.notes))


def _get_subjects(request: TrialRequest) -> type[TrialSubject]:
    subjects: Any = supply("trial_subject", request.mechanism.section)
    return subjects


def _run_once(
    subjects: type[TrialSubject], progress: ProgressCallback, request: TrialRequest
) -> Trial:
    # Answers may be as large as numbers get: what overflows, or is divided by 0, fits nothing.
    with subjects.ask(request, progress) as subject, np.errstate(all="ignore"):
        return _judge_subject(subject, request)


def _search_source(
    subjects: type[TrialSubject],
    progress: ProgressCallback,
    trial: Trial,
    scope: SearchScope = "all",
) -> Trial:
    """The trial with what must change in the source, within a scope or a narrower one."""
    code = find_code(trial.problem.equations) if trial.exit_code else None
    if code is None:
        return trial
    make_keys, diagnosis = partial(subjects.make_answer_keys, trial), trial.diagnosis
    # What one number explains is no error of two lines, and none that one line mends in part.
    scope = "whole" if diagnosis.explanations else scope
    scope = "likely" if diagnosis.readings else scope
    return replace(trial, search=find_source_answer(code, make_keys, progress, scope))


def _judge_subject(subject: TrialSubject, request: TrialRequest) -> Trial:
    problem = subject.problem
    names, motors = problem.mechanism.coordinate_names, problem.motors
    distances = subject.measure_levels()
    diagnosis = subject.diagnose(distances)
    level = diagnosis.level
    answers = subject.collect_answers(level)
    self_checks = list(judge_answers(answers))
    findings = [check.finding for check in self_checks]
    findings += subject.judge_engines(answers, level)
    check = make_cross_check_request(request)
    settings = check.mechanism, check.seed, check.quick, check.scenarios, check.chosen
    record = record_provenance(*settings, packages=packages(), model=check.model)
    notes = [*subject.list_notes(diagnosis)]
    if problem.equations.drive is None:
        idle = find_idle_motors(answers, motors)
        notes += _describe_idle_motors(names, motors, idle, problem.equations)
    wrong = {entry.part for entry in diagnosis.entries if subject.explains_faults or entry.notes}
    self_checks = [
        each for each in self_checks if each.part not in wrong or each.finding.verdict == "failed"
    ]
    relative_errors, allowed = subject.measure_errors(level)
    remarks = [*subject.list_remarks(), *_describe_motors(names, motors)]
    missing = [part for part in subject.whole if part not in answers.values]
    reasons = dict.fromkeys(missing, "not supplied")
    reasons |= {part: why.kind for part, why in answers.failures.items()}
    if unused := problem.equations.unused:
        remarks.append(f"{list_first(unused, MOST_UNUSED)}: no part of equations, so not judged")
    if reasons:
        listed = ", ".join(f"{part} ({reason})" for part, reason in reasons.items())
        remarks.append(f"not judged: {listed}")
    return Trial(
        request=request,
        problem=problem,
        cross_check=CrossCheck(check, Agreement(findings, record), *subject.list_runs(level)),
        distances=tuple(distances),
        diagnosis=diagnosis,
        relative_errors=relative_errors,
        allowed=allowed,
        failures=answers.failures,
        self_checks=tuple(self_checks),
        scope=tuple(remarks),
        notes=tuple(notes),
        is_single_precision=any(map(is_single_precision, answers.values.values())),
    )


def make_cross_check_request(request: TrialRequest) -> CrossCheckRequest:
    """The request of a cross-check behind a trial, with the laws that the equations follow."""
    laws = _get_subjects(request).select_laws(request)
    return CrossCheckRequest(
        request.mechanism, request.quick, request.seed, request.scenarios, laws, request.name
    )


def _describe_motors(names: Sequence[str], motors: Sequence[int]) -> Iterator[str]:
    """The sentence on the joints that have a motor, unless all do."""
    if len(motors) < len(names):
        joints = ", ".join(names[number] for number in motors)
        none = "no torque of a motor is in the equations, so motors are not judged"
        yield f"motors: at {joints} alone" if motors else none


def _describe_idle_motors(
    names: Sequence[str], motors: Sequence[int], idle: Sequence[int], equations: Equations
) -> Iterator[str]:
    """The sentence that torques of some joints are nowhere in the equations."""
    if idle:
        driven = [names[number] for number in motors if number not in idle]
        joints = ", ".join(names[number] for number in idle)
        remedy = (
            f"state drive = {driven}" if equations.table is None else "answer gravity for force"
        )
        yield f"missing: the torque of {joints}; where there is no motor, {remedy}"
