"""Simulations of the paper's study: run in parallel, kept on disk by all their inputs."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path

import xarray as xr

from crosscheck.audit.experiments.packed import unpacked
from crosscheck.audit.experiments.variant import Variant, company, spelled_out
from crosscheck.audit.experiments.work import (
    AuditTask,
    Made,
    Question,
    Reduction,
    Value,
    decoded,
    inquiry,
    integrations,
    made_by,
    whole,
)
from crosscheck.models.errors import Diverged, InputError, Unfinished
from crosscheck.provenance import version
from crosscheck.registry import MODELS
from crosscheck.runner.outcomes import Failure
from crosscheck.runner.sources import code_hash
from crosscheck.runner.store import Store
from crosscheck.runner.workers import perform_all


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
    models = getattr(question, "run_by", ())
    modules = [kind.__module__, *(MODELS[name].module for name in models)]
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
