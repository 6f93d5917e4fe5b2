"""Running a study batch by batch: kept batches are reused, the others are run and kept."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crosscheck.output import convert_os_errors, draft, remove_abandoned, require_file
from crosscheck.runner.interruption import advice, finish_before_interrupt
from crosscheck.runner.progress_update import ProgressCallback, ignore_progress
from crosscheck.runner.workers import Workers
from crosscheck.studies.batches.batch import Numbers
from crosscheck.studies.batches.batch_store import (
    BatchStore,
    clear_batches,
    is_complete,
    open_batches,
    require_room,
)
from crosscheck.studies.batches.batches import (
    BatchTask,
    compute_fingerprint,
    make_batch_tasks,
    make_check_tasks,
    perform_tasks,
)
from crosscheck.studies.batches.result_file import ResultFile, expected_bytes, require_unique_names
from crosscheck.studies.measures.columns import DIVERGED, Column, list_columns
from crosscheck.studies.members.members import PreparedStudy, require_members

RESUME = "the same with --resume goes on where it stopped"


@dataclass(frozen=True)
class ExecutionSettings:
    """Settings of a run; jobs: how many processes run members."""

    jobs: int = 1
    resume: bool = False
    progress: ProgressCallback = ignore_progress


def run_study(study: PreparedStudy, out: Path, settings: ExecutionSettings) -> int:
    """Make the result of a study, a file; returns how many members were run for it.

    Raises InputError, Unfinished, and OSError where the disk is full.
    """
    target = require_file(out, option="--out")
    result_columns, version = list_columns(study), compute_fingerprint()
    require_unique_names(study, result_columns)
    if is_complete(target, study, version, settings.resume):
        clear_batches(target, study, result_columns)
        return 0
    remove_abandoned(target.parent)
    require_room(target, expected_bytes(study, result_columns), study.count)
    with (
        Workers(settings.jobs) as workers,
        draft(target.parent) as new,
        open_batches(target, study, result_columns, settings.resume) as store,
    ):
        require_members(study)
        check_tasks = make_check_tasks(study, version)
        with convert_os_errors(target):
            places = [task.arguments[1] for task in check_tasks]
            result = ResultFile(new, study, result_columns, places, version)
        with _show_resume_advice():
            study_run = _StudyRun(study, result, store, settings.progress, workers)
            run_count = study_run.run(make_batch_tasks(study, version))
            study_run.check(check_tasks, result_columns)
            os.fsync(new.handle)
        new.publish(target)
    return run_count


@contextmanager
def _show_resume_advice() -> Iterator[None]:
    """Tell whoever interrupts the work how to go on."""
    advice.append(RESUME)
    try:
        yield
        advice.remove(RESUME)
    except Exception:
        advice.remove(RESUME)
        raise


@dataclass
class _StudyRun:
    """A study's result while it is made."""

    study: PreparedStudy
    result: ResultFile
    store: BatchStore
    progress: ProgressCallback
    workers: Workers

    def run(self, tasks: Sequence[BatchTask]) -> int:
        """Run all members, reusing kept batches; returns how many were run."""
        begins = {task.key: task.arguments[1] for task in tasks}
        work = {task: task.arguments[2] - task.arguments[1] for task in tasks}
        return self._gather(
            self.study.definition.name, work, lambda key, n: self.result.write(begins[key], n)
        )

    def check(self, tasks: Sequence[BatchTask], checked_columns: Sequence[Column]) -> None:
        """Run the members that a second engine checks, and write how far it is from them."""
        if not tasks:
            return
        numbers_by_key: dict[str, Numbers] = {}
        self._gather(
            f"spot checks by {self.study.base.second_model}",
            dict.fromkeys(tasks, 1),
            numbers_by_key.__setitem__,
        )
        for column in checked_columns:
            self._compare(column, [numbers_by_key[task.key] for task in tasks])

    def _gather(
        self, what: str, work: Mapping[BatchTask, int], take: Callable[[str, Numbers], None]
    ) -> int:
        """Reuse kept results of tasks, run and keep the others; returns how many members were run.

        work: the members of each task; take: receives a task's key and its numbers.
        """
        done, missing = 0, []
        for task, members in work.items():
            numbers = self.store.get(task.key, members)
            if numbers is None:
                missing.append(task)
            else:
                take(task.key, numbers)
                done += members
        all_members, run_count, began = sum(work.values()), 0, time.monotonic()
        self.progress(what, done, all_members)
        for task, numbers in perform_tasks(self.workers, missing):
            with finish_before_interrupt():
                self.store.put(task.key, numbers)
                take(task.key, numbers)
            run_count += work[task]
            left = all_members - done - run_count
            left_s = left * (time.monotonic() - began) / run_count
            self.progress(what, done + run_count, all_members, left_s)
        return run_count

    def _compare(self, column: Column, engine_numbers: Sequence[Numbers]) -> None:
        """Write a second engine's values of a column, and the differences."""
        name = column.name
        engine_values = np.stack([numbers[name][0] for numbers in engine_numbers])
        reference_values = np.concatenate(
            [self.result.numbers(name, place, 1) for place in self.result.checks]
        )
        difference = np.abs(engine_values - reference_values)
        if "time" in column.dims:
            is_finite = np.isfinite(difference)
            worst = np.where(is_finite, difference, -np.inf).max(axis=1)
            difference = np.where(is_finite.any(axis=1), worst, np.nan)
        else:
            self.result.add(f"{name}_checked", engine_values)
        self.result.add(f"{name}_difference", difference)
        if "time" in column.dims or name == DIVERGED:
            return
        spread = self.result.spread(name)
        over = np.divide(
            difference, spread, where=spread > 0, out=np.full_like(engine_values, np.nan)
        )
        self.result.add(f"{name}_difference_over_spread", over)
