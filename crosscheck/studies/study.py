"""Simulations of the paper's study: run in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import xarray as xr

from crosscheck.provenance import version
from crosscheck.registry import home
from crosscheck.studies.sources import code_hash
from crosscheck.studies.store import Store
from crosscheck.studies.variant import Measure, Numbers, Variant, measured, simulate
from crosscheck.tasks import Failure, failure
from crosscheck.workers import perform_all
from models.errors import Diverged, InputError, Unfinished
from models.places import cache_folder
from models.trajectory import from_netcdf, netcdf

__all__ = ["Measure", "Numbers", "Question", "Reduction", "Study", "Variant", "cache_folder"]
PACKAGES = ("numpy", "scipy", "numba", "pin", "exudyn", "xarray", "h5netcdf", "h5py", "sympy")

Json = Any  # what json.dumps takes
Reduction = Callable[[xr.Dataset], xr.Dataset]


class Question(Protocol):
    """Work that is not one variant's run: a frozen dataclass of a module.

    inputs: all that its answer depends on besides code; cost: rough seconds.
    """

    @property
    def inputs(self) -> str: ...

    @property
    def cost(self) -> float: ...

    def answer(self) -> Json: ...


@dataclass
class Study:
    """Runs variants and remembers them in a folder; tells how far it is.

    told(what, done, total) is called before and after every simulation of a request. What cannot be
    kept, or does not fit any more, is made again. A simulation that comes to no end raises
    Unfinished, after all others of the request.
    """

    folder: Path
    jobs: int = 1
    told: Callable[[str, int, int], None] = lambda what, done, total: None
    made: int = field(default=0, init=False)
    found: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.store = Store(self.folder)

    def runs(
        self, variants: Iterable[Variant], what: str = "runs", keep: Reduction | None = None
    ) -> dict[Variant, xr.Dataset]:
        """Trajectories, whole or what ``keep`` keeps of them. Raises Diverged if one diverges.

        ``keep``: a function of a module.
        """
        wanted = list(dict.fromkeys(variants))
        tasks = [
            _Task(run_key(v, keep), v.model, _cost(v), partial(_run, v, keep), self.store)
            for v in wanted
        ]
        return dict(zip(wanted, self._results(tasks, from_netcdf, what), strict=True))

    def measures(
        self, variants: Sequence[Variant], measure: Measure, what: str = "measures"
    ) -> list[Numbers]:
        """Numbers of each variant's trajectory, worked out where it ran; only they are kept.

        ``measure``: a function of a module. A run that diverges gives {"diverged_s": time}.
        """
        tasks = [
            _Task(run_key(v, measure), v.model, _cost(v), partial(_numbers, v, measure), self.store)
            for v in variants
        ]
        return self._results(tasks, json.loads, what)

    def answers(self, questions: Sequence[Question], what: str) -> list[Json]:
        """Of each question, worked out once and kept."""
        tasks = [
            _Task(question_key(q), type(q).__name__, q.cost, partial(_answer, q), self.store)
            for q in questions
        ]
        return self._results(tasks, json.loads, what)

    def _results(
        self, tasks: Sequence[_Task], decoded: Callable[[bytes], Any], what: str
    ) -> list[Any]:
        """Of every task: kept already, or performed now."""
        results: dict[str, Any] = {}
        missing: dict[str, _Task] = {}
        for task in {task.key: task for task in tasks}.values():
            try:
                results[task.key] = self.store.get(task.key, decoded)
            except KeyError:
                missing[task.key] = task
        self.found += len(results)
        for key, outcome in self._perform(list(missing.values()), len(results), what).items():
            results[key] = decoded(self._content(outcome, what, missing[key].name))
        return [results[task.key] for task in tasks]

    def _perform(self, tasks: Sequence[_Task], done: int, what: str) -> dict[str, Any]:
        """Outcomes by key."""
        total = done + len(tasks)
        self.told(what, done, total)

        def finished(_: str) -> None:
            nonlocal done
            done += 1
            self.made += 1
            self.told(what, done, total)

        return perform_all(tasks, self.jobs, finished)

    def _content(self, outcome: Any, what: str, name: str) -> bytes:
        """What was made. Raises what went wrong."""
        if isinstance(outcome, Failure):
            raise Unfinished(f"{what}: {name}: {outcome}")
        if isinstance(outcome, Exception):
            raise outcome
        if outcome.not_kept is not None:
            self.store.give_up(outcome.not_kept)
        return outcome.content


class _Made(NamedTuple):
    """What a task made, as it is kept, and why it could not be."""

    content: bytes
    not_kept: OSError | None = None


@dataclass(frozen=True)
class _Task:
    """Work for another process, which keeps the result."""

    key: str
    name: str
    cost: float
    make: Callable[[], bytes]
    store: Store

    def perform(self) -> _Made | Failure | InputError | Diverged:
        try:
            content = self.make()
        except (InputError, Diverged) as error:  # handed to the caller's process
            return error
        except Exception as error:
            return failure(error)
        try:
            self.store.put(self.key, content)
        except OSError as error:
            return _Made(content, error)
        return _Made(content)


def _run(variant: Variant, keep: Reduction | None) -> bytes:
    run = simulate(variant)
    return netcdf(run if keep is None else keep(run))


def _numbers(variant: Variant, measure: Measure) -> bytes:
    return _json(measured(variant, measure))


def _answer(question: Question) -> bytes:
    return _json(question.answer())


def _json(value: Json) -> bytes:
    return json.dumps(value, allow_nan=False).encode()


def _cost(variant: Variant) -> float:
    return (variant.duration_s or 3.0) * (12 if variant.model.startswith("exudyn") else 0.5)


def run_key(variant: Variant, made_of_it: Measure | Reduction | None = None) -> str:
    """Of a variant's trajectory, or of what a function of a module makes of it."""
    inputs = [variant.model, *(record.model_dump_json() for record in variant.case())]
    names = [(simulate.__module__, name) for name in ("Variant", "simulate", "measured")]
    names.append(home(variant.model))
    if made_of_it is not None:
        inputs.append(made_of_it.__qualname__)
        names.append((made_of_it.__module__, made_of_it.__qualname__.partition(".")[0]))
    return _key(inputs, names)


def question_key(question: Question) -> str:
    """Of its answer."""
    kind = type(question)
    name = (kind.__module__, kind.__qualname__.partition(".")[0])
    return _key([kind.__qualname__, question.inputs], [name])


def _key(inputs: Sequence[str], names: Sequence[tuple[str, str]]) -> str:
    """Of everything that a result depends on: inputs, versions and the code that runs."""
    text = "\n".join([*inputs, code_hash(*names), *_versions()])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions() -> tuple[str, ...]:
    """Of all that computes; None for an engine that is missing."""
    python = f"python {platform.python_version()} {platform.machine()}"
    return (python, *(f"{name} {version(name)}" for name in PACKAGES))
