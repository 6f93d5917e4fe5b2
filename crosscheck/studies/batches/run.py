"""Running a study: what is kept already is taken over, the rest is run and kept, batch by batch."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from crosscheck.output import draft, in_one_line, remove_abandoned, require_file
from crosscheck.registry import second_engine
from crosscheck.runner.interruption import advice, finished_first
from crosscheck.studies.batches.batch import Numbers
from crosscheck.studies.batches.batches import MemberBatch, batches, checks, task_of
from crosscheck.studies.batches.kept import (
    KeptBatches,
    batches_of,
    clear_batches,
    is_complete,
    require_room,
)
from crosscheck.studies.batches.result_file import ResultFile, expected_bytes, require_apart
from crosscheck.studies.batches.schedule import FunctionTask, Place, cluster, fingerprint, here
from crosscheck.studies.measures.columns import DIVERGED, Column, columns
from crosscheck.studies.members.members import PreparedStudy, require_members

Told = Callable[[str, int, int], None]
RESUME = "the same with --resume goes on where it stopped"


@dataclass(frozen=True)
class How:
    """How a study is run. scheduler: address of Dask's, else ``jobs`` processes of this machine."""

    jobs: int = 1
    scheduler: str | None = None
    resume: bool = False
    told: Told = lambda what, done, total: None

    def place(self) -> AbstractContextManager[Place]:
        """The place where the study's batches are run."""
        return cluster(self.scheduler) if self.scheduler is not None else here(self.jobs)


def run_study(study: PreparedStudy, out: Path, how: How) -> int:
    """Make the result of a study, a file; returns how many members were run for it.

    Raises InputError, Unfinished, and OSError where the disk is full.
    """
    target = require_file(out, option="--out")
    wanted, version = columns(study), fingerprint()
    require_apart(study, wanted)
    if is_complete(target, study, version, how.resume):
        clear_batches(target, study, wanted)
        return 0
    remove_abandoned(target.parent)
    require_room(target, expected_bytes(study, wanted), study.count)
    with (
        how.place() as place,
        batches_of(target, study, wanted, how.resume) as kept,
        draft(target.parent) as new,
    ):
        require_members(study)
        also = checks(study, version)
        with in_one_line(target):
            places = [task.arguments[1] for task in also]
            result = ResultFile(new, study, wanted, places, version)
        with _advised():
            making = _Making(study, result, kept, how.told, place)
            ran = making.run(list(batches(study, version)))
            making.check(also, wanted)
            os.fsync(new.handle)
        new.publish(target)
    return ran


@contextmanager
def _advised() -> Iterator[None]:
    """Tell whoever interrupts the work how to go on."""
    advice.append(RESUME)
    try:
        yield
        advice.remove(RESUME)
    except Exception:
        advice.remove(RESUME)
        raise


@dataclass
class _Making:
    """A study's result while it is made."""

    study: PreparedStudy
    result: ResultFile
    kept: KeptBatches
    told: Told
    place: Place

    def run(self, all_batches: Sequence[MemberBatch]) -> int:
        """Run all members, or take what is kept of them; returns how many were run."""
        begins = {batch.key: batch.begin for batch in all_batches}
        work = {task_of(self.study, each): each.end - each.begin for each in all_batches}
        return self._gather(
            self.study.definition.name, work, lambda key, n: self.result.write(begins[key], n)
        )

    def check(self, tasks: Sequence[FunctionTask], wanted: Sequence[Column]) -> None:
        """Run the members that a second engine checks, and write how far it is from them."""
        if not tasks:
            return
        found: dict[str, Numbers] = {}
        self._gather(
            f"spot checks by {second_engine()}", dict.fromkeys(tasks, 1), found.__setitem__
        )
        for column in wanted:
            self._compare(column, [found[task.key] for task in tasks])

    def _gather(
        self, what: str, work: Mapping[FunctionTask, int], take: Callable[[str, Numbers], None]
    ) -> int:
        """Take what is kept of tasks, run and keep the rest; returns how many members were run.

        work: the members of each task; take: what is done with numbers, and the key of their task.
        """
        done, missing = 0, []
        for task, members in work.items():
            numbers = self.kept.get(task.key, members)
            if numbers is None:
                missing.append(task)
            else:
                take(task.key, numbers)
                done += members
        all_members, ran = sum(work.values()), 0
        self.told(what, done, all_members)
        for task, numbers in self.place(missing):
            with finished_first():
                self.kept.put(task.key, numbers)
                take(task.key, numbers)
            ran += work[task]
            self.told(what, done + ran, all_members)
        return ran

    def _compare(self, column: Column, theirs: Sequence[Numbers]) -> None:
        """Write a second engine's values of a column, and the differences."""
        name = column.name
        said = np.stack([numbers[name][0] for numbers in theirs])
        ours = np.stack([self.result.values_at(name, place) for place in self.result.checks])
        difference = np.abs(said - ours)
        if "time" in column.dims:
            known = np.isfinite(difference)
            worst = np.where(known, difference, -np.inf).max(axis=1)
            difference = np.where(known.any(axis=1), worst, np.nan)
        else:
            self.result.add(f"{name}_checked", said)
        self.result.add(f"{name}_difference", difference)
        if "time" in column.dims or name == DIVERGED:
            return
        spread = self.result.spread(name)
        over = np.divide(difference, spread, where=spread > 0, out=np.full_like(said, np.nan))
        self.result.add(f"{name}_difference_over_spread", over)
