"""The work of a study: tasks for other processes, each of which makes and keeps results."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import zip_longest
from typing import NamedTuple, Protocol, TypeVar, get_type_hints

import xarray as xr
from pydantic import TypeAdapter

from crosscheck.audit.experiments.packed import packed
from crosscheck.audit.experiments.variant import Company, Variant, company, simulate_together
from crosscheck.models.errors import Diverged, InputError
from crosscheck.registry import entry_of
from crosscheck.runner.outcomes import Failure, failure
from crosscheck.runner.store import Store

Value = TypeVar("Value")
Answer = TypeVar("Answer", covariant=True)
Reduction = Callable[[xr.Dataset], xr.Dataset]
Run = xr.Dataset | Diverged
MOST_AT_ONCE = 300_000  # records of runs in one task: about 200 MB


class Question(Protocol[Answer]):
    """Work that is not one variant's run: a frozen dataclass of a module.

    inputs: all that its answer depends on besides code; cost: rough seconds; it may have run_by:
    names of models that it runs and its module does not import. The answer, of the type that
    ``answer`` is annotated with (records, numbers, lists of them), is kept as JSON.
    """

    @property
    def inputs(self) -> str: ...

    @property
    def cost(self) -> float: ...

    def answer(self) -> Answer: ...


def whole(result: Value | Diverged) -> Value:
    """The result. Raises Diverged."""
    if isinstance(result, Diverged):
        raise result
    return result


Content = bytes | Failure | InputError | Diverged


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
