"""Equations of motion on trial in any test framework: a function that raises AssertionError."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from crosscheck.models.arm.arm import Arm
    from crosscheck.models.experiment.scenario import Scenario, Switches
    from crosscheck.trial.input.equations import Coordinates, Equations, Level
    from crosscheck.trial.input.symbolic import from_sympy
    from crosscheck.trial.trial import Trial

__all__ = ["Coordinates", "Equations", "assert_agrees", "from_sympy"]
_HOME = {
    "Coordinates": "crosscheck.trial.input.equations",
    "Equations": "crosscheck.trial.input.equations",
    "from_sympy": "crosscheck.trial.input.symbolic",
}


def __getattr__(name: str) -> Any:
    # Lazily, so that a test module starts without numpy, sympy or an engine.
    if name not in _HOME:
        raise AttributeError(f"module 'crosscheck.testing' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)


def assert_agrees(
    equations: Any,
    arm: Arm | str = "paper-labelled",
    *,
    scenarios: Sequence[Scenario | str] = (),
    switches: Switches | None = None,
    level: Level = "",
    quick: bool = True,
    jobs: int = 1,
    seed: int = 0,
    name: str = "yours",
) -> Trial:
    """Put equations on trial; returns the Trial, if all that was judged agrees.

    equations: Equations, a function of the arm that returns them, an object with functions called
    like theirs, or text as on the command line, ``file.py:name``. scenarios: to be run too. level:
    the rigid level that they must be, '' for whichever they are closest to. name: what reports call
    them. Everything runs in forked processes, with ``jobs=1`` in one.

    Raises AssertionError with what `crosscheck trial` prints, and InputError for what cannot be
    tried at all.
    """
    from crosscheck.models.loading import load_arm, load_scenario, require_fit
    from crosscheck.report.trial import trial_text
    from crosscheck.trial.input.loading import handed_over, made
    from crosscheck.trial.trial import Asked, tried

    chosen = load_arm(arm) if isinstance(arm, str) else arm
    loaded = tuple(load_scenario(s) if isinstance(s, str) else s for s in scenarios)
    for scenario in loaded:
        require_fit(scenario, chosen)
    first = loaded[0] if loaded else None
    if isinstance(equations, str):
        own = handed_over(equations, chosen, first)
    else:
        own = made(equations, chosen, first, name)
    own = _of_level(own, level) if level else own
    trial = tried(Asked(name, own, chosen, loaded, switches, quick=quick, seed=seed), jobs=jobs)
    if trial.exit_code:
        raise AssertionError(trial_text(trial))
    return trial


def _of_level(own: Equations, level: Level) -> Equations:
    """The equations, declared to be of a level, also whenever they are made anew."""
    again = own.rebuild
    if again is None:
        return replace(own, level=level)
    return replace(own, level=level, rebuild=lambda *of: _of_level(again(*of), level))
