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

from crosscheck.audit.experiments.question import Question, describe_inputs
from crosscheck.audit.experiments.variant import Variant, simulate_together
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.provenance import find_version
from crosscheck.registry import MODELS, get_entry
from crosscheck.runner.outcomes import Failure, failure_from_error
from crosscheck.runner.progress_update import CountCallback
from crosscheck.runner.sources import compute_code_hash
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
    progress: CountCallback = lambda what, done, total: None
    computed_count: int = field(default=0, init=False)
    cached_count: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.store = Store(self.folder)

    def run_variants(
        self, variants: Iterable[Variant], label: str = "runs", keep: Reduction | None = None
    ) -> dict[Variant, xr.Dataset]:
        """The trajectories, whole or what ``keep`` keeps of them. Raises Diverged if one diverges.

        ``keep``: a function of a module.
        """
        keys = {variant: run_key(variant, keep) for variant in dict.fromkeys(variants)}
        variant_by_key = {key: variant for variant, key in keys.items()}

        def plan_tasks(missing: Sequence[str]) -> list[AuditTask]:
            return plan_integrations(
                {key: variant_by_key[key] for key in missing}, keep, self.store, self.jobs
            )

        results = self._results(dict.fromkeys(variant_by_key, unpack_dataset), plan_tasks, label)
        return {variant: raise_if_diverged(results[key]) for variant, key in keys.items()}

    def answer_questions(self, questions: Sequence[Question[Value]], label: str) -> list[Value]:
        """The answer to each question, worked out once and kept."""
        keys = [question_key(question) for question in questions]
        question_by_key = dict(zip(keys, questions, strict=True))
        decoders = {
            key: partial(_decode_answer, question) for key, question in question_by_key.items()
        }

        def plan_tasks(missing: Sequence[str]) -> list[AuditTask]:
            tasks = []
            for key in missing:
                question = question_by_key[key]
                name, compute, encode = (
                    type(question).__name__,
                    partial(_answer_question, question),
                    partial(_encode_answer, question),
                )
                tasks.append(
                    AuditTask(key, name, question.cost, (key,), compute, encode, self.store)
                )
            return tasks

        results = self._results(decoders, plan_tasks, label)
        return [raise_if_diverged(results[key]) for key in keys]

    def answer_by_key(
        self, questions: Mapping[Key, Question[Value]], label: str
    ) -> dict[Key, Value]:
        """The answer to each question, by the question's key in the mapping."""
        return dict(
            zip(questions, self.answer_questions(list(questions.values()), label), strict=True)
        )

    def _results(
        self,
        decoders: Mapping[str, Callable[[bytes], Value]],
        plan_tasks: Callable[[Sequence[str]], list[AuditTask]],
        label: str,
    ) -> dict[str, Value | Diverged]:
        """Results by key, read by the key's function: kept already, or performed now as planned.

        Raises what went wrong, apart from a divergence.
        """
        results: dict[str, Value | Diverged] = {}
        for key, read in decoders.items():
            with suppress(KeyError):
                results[key] = self.store.get(key, read)
        self.cached_count += len(results)
        tasks = {
            task.key: task for task in plan_tasks([key for key in decoders if key not in results])
        }
        done, total = len(results), len(results) + sum(len(task.keys) for task in tasks.values())
        self.progress(label, done, total)

        def report_task(key: str) -> None:
            nonlocal done
            done += len(tasks[key].keys)
            self.computed_count += len(tasks[key].keys)
            self.progress(label, done, total)

        for task_key, outcome in perform_all(list(tasks.values()), self.jobs, report_task).items():
            task = tasks[task_key]
            if isinstance(outcome, Failure):  # its process died
                outcome = [ResultOutcome(key, outcome) for key in task.keys]
            for entry in outcome:
                if isinstance(entry.content, Failure):
                    raise Unfinished(f"{label}: {task.name}: {entry.content}")
                if isinstance(entry.content, InputError):
                    raise entry.content
                if entry.store_error is not None:
                    self.store.give_up(entry.store_error)
                diverged = isinstance(entry.content, Diverged)
                results[entry.key] = (
                    entry.content if diverged else decoders[entry.key](entry.content)
                )
        return results


def run_key(variant: Variant, keep: Reduction | None = None) -> str:
    """The key of a variant's trajectory, or of what ``keep`` (of a module) keeps of it."""
    modules = [Variant.__module__, MODELS[variant.model].module]
    inputs = [describe_inputs(variant.case(), variant.model)]
    if keep is not None:
        inputs.append(keep.__qualname__)
        modules.append(keep.__module__)
    return _key(inputs, modules, [MODELS[variant.model].versioned_packages])


def question_key(question: Question[object]) -> str:
    """The key of a question's answer."""
    kind = type(question)
    modules = [kind.__module__, *(MODELS[name].module for name in question.model_names)]
    anything = [entry.versioned_packages for entry in MODELS.values()]
    return _key([kind.__qualname__, question.inputs], modules, anything)


def _key(inputs: Sequence[str], modules: Sequence[str], packages: Sequence[tuple[str, ...]]) -> str:
    """A hash of everything that a result depends on: inputs, versions and the code that runs."""
    computing = sorted({name for some in packages for name in some})
    text = "\n".join([*inputs, compute_code_hash(*modules), *_versions(*computing)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions(*packages: str) -> tuple[str, ...]:
    """Names and versions of Python and of the packages that compute; None for a missing engine."""
    python = f"python {platform.python_version()} {platform.machine()}"
    return (python, *(f"{name} {find_version(name)}" for name in packages))


def raise_if_diverged(result: Value | Diverged) -> Value:
    """The result itself. Raises it if it is Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result


class ResultOutcome(NamedTuple):
    """What became of a result's key: its content, or why there is none or why it is not kept.

    Errors that are the caller's come from another process as they are.
    """

    key: str
    content: bytes | Failure | InputError | Diverged
    store_error: OSError | None = None


@dataclass(frozen=True)
class AuditTask:
    """A task for another process, which keeps all its results by their keys.

    compute: gives a result for every key; encode: a result as it is kept.
    """

    key: str
    name: str
    cost: float
    keys: tuple[str, ...]
    compute: Callable[[], Sequence[Any]]
    encode: Callable[[Any], bytes]
    store: Store

    def perform(self) -> list[ResultOutcome]:
        """What became of every key, in their order."""
        try:
            results = self.compute()
        except Exception as error:
            return [ResultOutcome(key, _reason(error)) for key in self.keys]
        return [
            self._store_result(key, result) for key, result in zip(self.keys, results, strict=True)
        ]

    def _store_result(self, key: str, result: Any) -> ResultOutcome:
        try:
            content = self.encode(result)
        except Exception as error:
            return ResultOutcome(key, _reason(error))
        try:
            self.store.put(key, content)
        except OSError as error:
            return ResultOutcome(key, content, error)
        return ResultOutcome(key, content)


def _reason(error: Exception) -> Failure | InputError | Diverged:
    return error if isinstance(error, InputError | Diverged) else failure_from_error(error)


def plan_integrations(
    variant_by_key: Mapping[str, Variant], keep: Reduction | None, store: Store, jobs: int = 1
) -> list[AuditTask]:
    """Tasks for runs by their keys, as many side by side in one as memory and jobs ask for.

    jobs: processes that share the work.
    """
    keys_by_kind: dict[tuple[object, ...], list[str]] = {}  # by what a model may step side by side
    for key, variant in variant_by_key.items():
        _, scenario, chosen = variant.case()
        grid = scenario.step_s, scenario.steps, scenario.drive.kind
        keys_by_kind.setdefault((variant.model, chosen, *grid), []).append(key)
    batches = list[list[AuditTask]]()
    for keys in keys_by_kind.values():
        model, scenario = variant_by_key[keys[0]].model, variant_by_key[keys[0]].case().scenario
        entry = get_entry(model)
        fit = max(1, MOST_AT_ONCE * scenario.stride // scenario.steps)
        size = min(entry.abreast, fit, -(-len(keys) // jobs))
        batches.append([])
        for begin in range(0, len(keys), size):
            batch_keys = tuple(keys[begin : begin + size])
            compute = partial(simulate_together, [variant_by_key[key] for key in batch_keys])
            cost = len(batch_keys) * scenario.steps * entry.call_s
            task = AuditTask(
                batch_keys[0], model, cost, batch_keys, compute, partial(_encode_run, keep), store
            )
            batches[-1].append(task)
    # In turns, so that processes begin with unlike kernels and none compiles what another does.
    return [task for turn in zip_longest(*batches) for task in turn if task is not None]


def _encode_run(keep: Reduction | None, run: xr.Dataset | Diverged) -> bytes:
    """A run encoded as it is kept. Raises Diverged."""
    return pack_dataset(raise_if_diverged(run) if keep is None else keep(raise_if_diverged(run)))


def pack_dataset(dataset: xr.Dataset) -> bytes:
    """The content of an NPZ file: variables, and names, dimensions and attributes as JSON.

    A NetCDF file takes thirty times as long.
    """
    content = io.BytesIO()
    variables: dict[str, Any] = {
        str(name): variable.values for name, variable in dataset.variables.items()
    }
    np.savez(content, about=json.dumps(dataset.to_dict(data=False)), **variables)
    return content.getvalue()


def unpack_dataset(content: bytes) -> xr.Dataset:
    """The dataset from ``pack_dataset`` content.

    Raises ValueError or KeyError if the content is none.
    """
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        about = json.loads(str(file["about"]))
        for variables in (about["coords"], about["data_vars"]):
            for name, variable in variables.items():
                variable["data"] = file[name]
    return xr.Dataset.from_dict(about)


def _answer_question(question: Question[object]) -> list[object]:
    return [question.answer()]


def _encode_answer(question: Question[object], answer: object) -> bytes:
    return json.dumps(_adapter(question).dump_python(answer), allow_nan=False).encode()


def _decode_answer(question: Question[Value], content: bytes) -> Value:
    return _adapter(question).validate_python(json.loads(content))


def _adapter(question: Question[Value]) -> TypeAdapter[Value]:
    """The adapter by which the answers to a question are written and read."""
    return TypeAdapter(get_type_hints(type(question).answer)["return"])
