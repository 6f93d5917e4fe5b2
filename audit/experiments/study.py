"""Simulations of the paper's study: run in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache, partial
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple, TypeVar, get_type_hints

import xarray as xr
from pydantic import TypeAdapter

from crosscheck.audit.experiments.packed import packed, unpacked
from crosscheck.audit.experiments.question import Question, spelled_out
from crosscheck.audit.experiments.variant import Company, Variant, company, simulate_together
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
Run = xr.Dataset | Diverged
MOST_AT_ONCE = 300_000  # records of runs in one task: about 200 MB
Content = bytes | Failure | InputError | Diverged


@dataclass
class Study:
    """Runs variants and remembers them in a folder; tells how far it is.

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
        """Trajectories, whole or what ``keep`` keeps of them. Raises Diverged if one diverges.

        ``keep``: a function of a module.
        """
        keys = {variant: run_key(variant, keep) for variant in dict.fromkeys(variants)}
        wanted = {key: variant for variant, key in keys.items()}

        def planned(missing: Sequence[str]) -> list[AuditTask]:
            left = {key: wanted[key] for key in missing}
            return integrations(left, keep, self.store, self.jobs)

        found = self._results(dict.fromkeys(wanted, unpacked), planned, what)
        return {variant: whole(found[key]) for variant, key in keys.items()}

    def answers(self, questions: Sequence[Question[Value]], what: str) -> list[Value]:
        """Of each question, worked out once and kept."""
        keyed = [(question_key(question), question) for question in questions]
        wanted = dict(keyed)

        def planned(missing: Sequence[str]) -> list[AuditTask]:
            return [inquiry(key, wanted[key], self.store) for key in missing]

        decoders = {key: partial(decoded, question) for key, question in wanted.items()}
        found = self._results(decoders, planned, what)
        return [whole(found[key]) for key, _ in keyed]

    def answered(self, questions: Mapping[Key, Question[Value]], what: str) -> dict[Key, Value]:
        """The same, each answer by what its question stands under."""
        return dict(zip(questions, self.answers(list(questions.values()), what), strict=True))

    def _results(
        self,
        wanted: Mapping[str, Callable[[bytes], Value]],
        planned: Callable[[Sequence[str]], list[AuditTask]],
        what: str,
    ) -> dict[str, Value | Diverged]:
        """By key, each with how it is read: kept already, or performed now as planned."""
        results: dict[str, Value | Diverged] = {}
        for key, read in wanted.items():
            with suppress(KeyError):
                results[key] = self.store.get(key, read)
        self.found += len(results)
        tasks = planned([key for key in wanted if key not in results])
        for made in self._perform(tasks, len(results), what):
            content, read = self._content(made, what), wanted[made.key]
            results[made.key] = content if isinstance(content, Diverged) else read(content)
        return results

    def _perform(self, tasks: Sequence[AuditTask], done: int, what: str) -> list[Made]:
        """What all tasks made."""
        total = done + sum(len(task.keys) for task in tasks)
        by_key = {task.key: task for task in tasks}
        self.told(what, done, total)

        def finished(key: str) -> None:
            nonlocal done
            done += len(by_key[key].keys)
            self.made += len(by_key[key].keys)
            self.told(what, done, total)

        outcomes = perform_all(tasks, self.jobs, finished)
        return [made for task in tasks for made in made_by(task, outcomes[task.key])]

    def _content(self, made: Made, what: str) -> bytes | Diverged:
        """What was made. Raises what went wrong, apart from a divergence."""
        if isinstance(made.content, Failure):
            raise Unfinished(f"{what}: {made.name}: {made.content}")
        if isinstance(made.content, InputError):
            raise made.content
        if made.not_kept is not None:
            self.store.give_up(made.not_kept)
        return made.content


def run_key(variant: Variant, keep: Reduction | None = None) -> str:
    """Of a variant's trajectory, or of what a function of a module keeps of it."""
    modules = [company.__module__, MODELS[variant.model].module]
    inputs = [spelled_out(variant.case(), variant.model)]
    if keep is not None:
        inputs.append(keep.__qualname__)
        modules.append(keep.__module__)
    return _key(inputs, modules, [MODELS[variant.model].versioned])


def question_key(question: Question[object]) -> str:
    """Of its answer."""
    kind = type(question)
    modules = [kind.__module__, *(MODELS[name].module for name in question.run_by)]
    anything = [entry.versioned for entry in MODELS.values()]
    return _key([kind.__qualname__, question.inputs], modules, anything)


def _key(inputs: Sequence[str], modules: Sequence[str], packages: Sequence[tuple[str, ...]]) -> str:
    """Of everything that a result depends on: inputs, versions and the code that runs."""
    computing = sorted({name for some in packages for name in some})
    text = "\n".join([*inputs, code_hash(*modules), *_versions(*computing)])
    return hashlib.sha256(text.encode()).hexdigest()[:32]


@lru_cache
def _versions(*packages: str) -> tuple[str, ...]:
    """Of what computes; None for an engine that is missing."""
    python = f"python {platform.python_version()} {platform.machine()}"
    return (python, *(f"{name} {version(name)}" for name in packages))


def whole(result: Value | Diverged) -> Value:
    """The result. Raises Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result


class Made(NamedTuple):
    """Of a result's key and its task's name: its content, or why there is none or it is not kept.

    Errors that are the caller's come from another process as they are.
    """

    key: str
    name: str
    content: Content
    not_kept: OSError | None = None


@dataclass(frozen=True)
class AuditTask:
    """Work for another process, which keeps all its results by their keys."""

    key: str
    name: str
    cost: float
    keys: tuple[str, ...]
    make: Callable[[], list[Callable[[], bytes]]]
    store: Store

    def perform(self) -> list[Made]:
        try:
            results = self.make()
        except Exception as error:
            return [Made(key, self.name, _reason(error)) for key in self.keys]
        return [self._made(key, make) for key, make in zip(self.keys, results, strict=True)]

    def _made(self, key: str, make: Callable[[], bytes]) -> Made:
        try:
            content = make()
        except Exception as error:
            return Made(key, self.name, _reason(error))
        try:
            self.store.put(key, content)
        except OSError as error:
            return Made(key, self.name, content, error)
        return Made(key, self.name, content)


def _reason(error: Exception) -> Failure | InputError | Diverged:
    return error if isinstance(error, InputError | Diverged) else failure(error)


def made_by(task: AuditTask, outcome: list[Made] | Failure) -> list[Made]:
    """What a task made; its failure for every result if its process died."""
    if isinstance(outcome, Failure):
        return [Made(key, task.name, outcome) for key in task.keys]
    return outcome


def integrations(
    wanted: Mapping[str, Variant], keep: Reduction | None, store: Store, jobs: int = 1
) -> list[AuditTask]:
    """Tasks for runs by their keys, as many side by side in one as fit.

    jobs: processes that share the work.
    """
    alike: dict[Company, list[str]] = {}
    for key, variant in wanted.items():
        alike.setdefault(company(variant), []).append(key)
    batches = [
        [_batch({key: wanted[key] for key in some}, keep, store) for some in shared]
        for shared in (_shared_out(keys, wanted[keys[0]], jobs) for keys in alike.values())
    ]
    # In turns, so that processes begin with unlike kernels and none compiles what another does.
    return [task for turn in zip_longest(*batches) for task in turn if task is not None]


def _shared_out(keys: Sequence[str], first: Variant, jobs: int) -> Iterator[Sequence[str]]:
    """Runs that could all be made side by side, in as many tasks as memory and jobs ask for."""
    scenario = first.case().scenario
    fit = max(1, MOST_AT_ONCE * scenario.stride // scenario.steps)
    size = min(entry_of(first.model).abreast, fit, -(-len(keys) // jobs))
    for begin in range(0, len(keys), size):
        yield keys[begin : begin + size]


def _batch(wanted: Mapping[str, Variant], keep: Reduction | None, store: Store) -> AuditTask:
    """One task for runs that are made side by side."""
    keys, variants = tuple(wanted), tuple(wanted.values())
    cost = sum(v.case().scenario.steps * entry_of(v.model).call_s for v in variants)
    return AuditTask(
        keys[0], variants[0].model, cost, keys, partial(_integrated, variants, keep), store
    )


def _integrated(variants: Sequence[Variant], keep: Reduction | None) -> list[Callable[[], bytes]]:
    return [partial(_kept, keep, run) for run in simulate_together(variants)]


def _kept(keep: Reduction | None, run: Run) -> bytes:
    """A run as it is kept. Raises Diverged."""
    this = whole(run)
    return packed(this if keep is None else keep(this))


def inquiry(key: str, question: Question[object], store: Store) -> AuditTask:
    """The task that answers a question."""
    name = type(question).__name__
    return AuditTask(key, name, question.cost, (key,), partial(_asked, question), store)


def _asked(question: Question[object]) -> list[Callable[[], bytes]]:
    return [partial(_encoded, question)]


def _encoded(question: Question[object]) -> bytes:
    answer = _adapter(question).dump_python(question.answer())
    return json.dumps(answer, allow_nan=False).encode()


def decoded(question: Question[Value], content: bytes) -> Value:
    return _adapter(question).validate_python(json.loads(content))


def _adapter(question: Question[Value]) -> TypeAdapter[Value]:
    """How the answers to a question are written and read."""
    return TypeAdapter(get_type_hints(type(question).answer)["return"])
