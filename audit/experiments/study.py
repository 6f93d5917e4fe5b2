"""Simulations of the paper's study: run in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import io
import json
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import zip_longest
from pathlib import Path
from typing import Any, NamedTuple, TypeVar, get_type_hints

import numpy as np
import xarray as xr
from pydantic import TypeAdapter

from crosscheck.audit.experiments.question import Question, spelled_out
from crosscheck.audit.experiments.variant import Variant, simulate_together
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.provenance import version
from crosscheck.registry import MODELS, entry_of
from crosscheck.runner.outcomes import Failure, failure
from crosscheck.runner.sources import code_hash
from crosscheck.runner.store import Store
from crosscheck.runner.workers import perform_all

Key = TypeVar("Key")
Value = TypeVar("Value")
Reduction = Callable[[xr.Dataset], xr.Dataset]
MOST_AT_ONCE = 300_000  # records of runs in one task: about 200 MB


@dataclass
class Study:
    """The simulations of variants, remembered in a folder; tells how far it is.

    told(what, done, total) counts results, before and after every task of a request. What cannot
    be kept, or does not fit any more, is made again. A simulation that comes to no end raises
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
        """The trajectories, whole or what ``keep`` keeps of them. Raises Diverged if one diverges.

        ``keep``: a function of a module.
        """
        keys = {variant: run_key(variant, keep) for variant in dict.fromkeys(variants)}
        wanted = {key: variant for variant, key in keys.items()}

        def planned(missing: Sequence[str]) -> list[AuditTask]:
            return integrations({key: wanted[key] for key in missing}, keep, self.store, self.jobs)

        found = self._results(dict.fromkeys(wanted, unpacked), planned, what)
        return {variant: whole(found[key]) for variant, key in keys.items()}

    def answers(self, questions: Sequence[Question[Value]], what: str) -> list[Value]:
        """The answer to each question, worked out once and kept."""
        keys = [question_key(question) for question in questions]
        wanted = dict(zip(keys, questions, strict=True))
        decoders = {key: partial(_decoded, question) for key, question in wanted.items()}

        def planned(missing: Sequence[str]) -> list[AuditTask]:
            tasks = []
            for key in missing:
                one = wanted[key]
                name, made, encoded = (
                    type(one).__name__,
                    partial(_asked, one),
                    partial(_encoded, one),
                )
                tasks.append(AuditTask(key, name, one.cost, (key,), made, encoded, self.store))
            return tasks

        found = self._results(decoders, planned, what)
        return [whole(found[key]) for key in keys]

    def answered(self, questions: Mapping[Key, Question[Value]], what: str) -> dict[Key, Value]:
        """The answer to each question, by the question's key in the mapping."""
        return dict(zip(questions, self.answers(list(questions.values()), what), strict=True))

    def _results(
        self,
        wanted: Mapping[str, Callable[[bytes], Value]],
        planned: Callable[[Sequence[str]], list[AuditTask]],
        what: str,
    ) -> dict[str, Value | Diverged]:
        """Results by key, read by the key's function: kept already, or performed now as planned.

        Raises what went wrong, apart from a divergence.
        """
        results: dict[str, Value | Diverged] = {}
        for key, read in wanted.items():
            with suppress(KeyError):
                results[key] = self.store.get(key, read)
        self.found += len(results)
        tasks = {task.key: task for task in planned([key for key in wanted if key not in results])}
        done, total = len(results), len(results) + sum(len(task.keys) for task in tasks.values())
        self.told(what, done, total)

        def finished(key: str) -> None:
            nonlocal done
            done += len(tasks[key].keys)
            self.made += len(tasks[key].keys)
            self.told(what, done, total)

        for task_key, outcome in perform_all(list(tasks.values()), self.jobs, finished).items():
            task = tasks[task_key]
            if isinstance(outcome, Failure):  # its process died
                outcome = [Made(key, outcome) for key in task.keys]
            for made in outcome:
                if isinstance(made.content, Failure):
                    raise Unfinished(f"{what}: {task.name}: {made.content}")
                if isinstance(made.content, InputError):
                    raise made.content
                if made.not_kept is not None:
                    self.store.give_up(made.not_kept)
                diverged = isinstance(made.content, Diverged)
                results[made.key] = made.content if diverged else wanted[made.key](made.content)
        return results


def run_key(variant: Variant, keep: Reduction | None = None) -> str:
    """The key of a variant's trajectory, or of what ``keep`` (of a module) keeps of it."""
    modules = [Variant.__module__, MODELS[variant.model].module]
    inputs = [spelled_out(variant.case(), variant.model)]
    if keep is not None:
        inputs.append(keep.__qualname__)
        modules.append(keep.__module__)
    return _key(inputs, modules, [MODELS[variant.model].versioned])


def question_key(question: Question[object]) -> str:
    """The key of a question's answer."""
    kind = type(question)
    modules = [kind.__module__, *(MODELS[name].module for name in question.run_by)]
    anything = [entry.versioned for entry in MODELS.values()]
    return _key([kind.__qualname__, question.inputs], modules, anything)


def _key(inputs: Sequence[str], modules: Sequence[str], packages: Sequence[tuple[str, ...]]) -> str:
    """A hash of everything that a result depends on: inputs, versions and the code that runs."""
    computing = sorted({name for some in packages for name in some})
    text = "\n".join([*inputs, code_hash(*modules), *_versions(*computing)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions(*packages: str) -> tuple[str, ...]:
    """Names and versions of Python and of the packages that compute; None for a missing engine."""
    python = f"python {platform.python_version()} {platform.machine()}"
    return (python, *(f"{name} {version(name)}" for name in packages))


def whole(result: Value | Diverged) -> Value:
    """The result itself. Raises it if it is Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result


class Made(NamedTuple):
    """What became of a result's key: its content, or why there is none or why it is not kept.

    Errors that are the caller's come from another process as they are.
    """

    key: str
    content: bytes | Failure | InputError | Diverged
    not_kept: OSError | None = None


@dataclass(frozen=True)
class AuditTask:
    """A task for another process, which keeps all its results by their keys.

    made: gives a result for every key; encoded: a result as it is kept.
    """

    key: str
    name: str
    cost: float
    keys: tuple[str, ...]
    made: Callable[[], Sequence[Any]]
    encoded: Callable[[Any], bytes]
    store: Store

    def perform(self) -> list[Made]:
        """What became of every key, in their order."""
        try:
            results = self.made()
        except Exception as error:
            return [Made(key, _reason(error)) for key in self.keys]
        return [self._kept(key, result) for key, result in zip(self.keys, results, strict=True)]

    def _kept(self, key: str, result: Any) -> Made:
        try:
            content = self.encoded(result)
        except Exception as error:
            return Made(key, _reason(error))
        try:
            self.store.put(key, content)
        except OSError as error:
            return Made(key, content, error)
        return Made(key, content)


def _reason(error: Exception) -> Failure | InputError | Diverged:
    return error if isinstance(error, InputError | Diverged) else failure(error)


def integrations(
    wanted: Mapping[str, Variant], keep: Reduction | None, store: Store, jobs: int = 1
) -> list[AuditTask]:
    """Tasks for runs by their keys, as many side by side in one as memory and jobs ask for.

    jobs: processes that share the work.
    """
    alike: dict[tuple[object, ...], list[str]] = {}  # by what a model may step side by side
    for key, variant in wanted.items():
        _, scenario, chosen = variant.case()
        grid = scenario.step_s, scenario.steps, scenario.drive.kind
        alike.setdefault((variant.model, chosen, *grid), []).append(key)
    batches = list[list[AuditTask]]()
    for keys in alike.values():
        model, scenario = wanted[keys[0]].model, wanted[keys[0]].case().scenario
        entry = entry_of(model)
        fit = max(1, MOST_AT_ONCE * scenario.stride // scenario.steps)
        size = min(entry.abreast, fit, -(-len(keys) // jobs))
        batches.append([])
        for begin in range(0, len(keys), size):
            some = tuple(keys[begin : begin + size])
            made = partial(simulate_together, [wanted[key] for key in some])
            cost = len(some) * scenario.steps * entry.call_s
            task = AuditTask(some[0], model, cost, some, made, partial(_encoded_run, keep), store)
            batches[-1].append(task)
    # In turns, so that processes begin with unlike kernels and none compiles what another does.
    return [task for turn in zip_longest(*batches) for task in turn if task is not None]


def _encoded_run(keep: Reduction | None, run: xr.Dataset | Diverged) -> bytes:
    """A run encoded as it is kept. Raises Diverged."""
    return packed(whole(run) if keep is None else keep(whole(run)))


def packed(dataset: xr.Dataset) -> bytes:
    """The content of an NPZ file: variables, and names, dimensions and attributes as JSON.

    A NetCDF file takes thirty times as long.
    """
    content = io.BytesIO()
    variables: dict[str, Any] = {
        str(name): variable.values for name, variable in dataset.variables.items()
    }
    np.savez(content, about=json.dumps(dataset.to_dict(data=False)), **variables)
    return content.getvalue()


def unpacked(content: bytes) -> xr.Dataset:
    """The dataset from ``packed`` content. Raises ValueError or KeyError if the content is none."""
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        about = json.loads(str(file["about"]))
        for variables in (about["coords"], about["data_vars"]):
            for name, variable in variables.items():
                variable["data"] = file[name]
    return xr.Dataset.from_dict(about)


def _asked(question: Question[object]) -> list[object]:
    return [question.answer()]


def _encoded(question: Question[object], answer: object) -> bytes:
    return json.dumps(_adapter(question).dump_python(answer), allow_nan=False).encode()


def _decoded(question: Question[Value], content: bytes) -> Value:
    return _adapter(question).validate_python(json.loads(content))


def _adapter(question: Question[Value]) -> TypeAdapter[Value]:
    """The adapter by which the answers to a question are written and read."""
    return TypeAdapter(get_type_hints(type(question).answer)["return"])
