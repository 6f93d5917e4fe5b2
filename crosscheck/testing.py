"""Trials of equations of motion: in a notebook, and as an assertion in any test framework.

>>> from math import cos
>>> from crosscheck.testing import Equations, assert_agrees
>>> def two_link(arm):
...     a, b, p = *arm.links, arm.payload_mass_kg
...     def mass_matrix(q):
...         m22 = b.inertia + b.mass * b.com_m**2 + p * b.length_m**2
...         m12 = m22 + (b.mass * b.com_m + p * b.length_m) * a.length_m * cos(q[1])
...         m11 = a.inertia + a.mass * a.com_m**2 + (b.mass + p) * a.length_m**2
...         return [[m11 + 2 * m12 - m22, m12], [m12, m22]]
...     return Equations(mass_matrix=mass_matrix)
>>> assert_agrees(two_link, "paper-labelled").level
'links'
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, get_args

from crosscheck import LARGEST_SEED
from crosscheck.lazy import make_lazy_names

if TYPE_CHECKING:
    from crosscheck.models.experiment.scenario import Scenario, Switches
    from crosscheck.models.mechanism import Mechanism
    from crosscheck.trial.input.equations import Coordinates, Equations, Level
    from crosscheck.trial.input.symbolic import from_sympy
    from crosscheck.trial.result import Trial

__all__ = ["Coordinates", "Equations", "Trial", "assert_agrees", "from_sympy", "try_equations"]

if not TYPE_CHECKING:
    modules = {
        **dict.fromkeys(("Coordinates", "Equations"), "crosscheck.trial.input.equations"),
        **dict.fromkeys(("assert_agrees", "try_equations"), __name__),
        "Trial": "crosscheck.trial.result",
        "from_sympy": "crosscheck.trial.input.symbolic",
    }
    __getattr__, __dir__ = make_lazy_names(__name__, modules)

YOURS = "yours"  # the name of equations that have none
MOST_JOBS = 1024  # processes
ARM_ALLOWED = "must be an Arm or a Robot, or the name or file of one"


def try_equations(
    equations: Any,
    arm: Mechanism | str = "paper-labelled",
    *,
    scenarios: Sequence[Scenario | str] = (),
    switches: Switches | None = None,
    level: Level = "",
    quick: bool = True,
    jobs: int = 1,
    seed: int = 0,
    name: str = YOURS,
) -> Trial:
    """Judge supplied equations: which entry is wrong, and why.

    The result prints itself, and a notebook shows it with a heat map of each part; it has
    ``exit_code``, ``headline``, ``causes``, ``to_dataframe()`` and
    ``write_report(folder)``.

    Args:
        equations: Equations, a function of the arm that returns them, an object with functions
            called like theirs, or text as on the command line, ``file.py:name``.
        arm: An arm or a robot, or the built-in name or file of one.
        scenarios: Scenarios to be run too, or their names or files; none judges states alone, as
            must be of a robot.
        switches: Laws of the gear model; without them, the usual ones of the arm. A robot has none.
        level: The rigid level that the equations must be: ``links``, ``carriers``, ``armature`` or
            ``coupled``; '' for whichever they are closest to.
        quick: Whether to ask for fewer states.
        jobs: How many forked processes run models side by side, 1 to 1024.
        seed: Seed of the random states, 0 to 4294967295.
        name: What reports call the equations; of a function its own name, if none is given.

    Returns:
        The trial, with its findings in ``agreement``.

    Raises:
        InputError: The equations cannot be tried at all, or an argument cannot be used.
        Unfinished: The models that the equations are compared with do not answer.
    """
    from crosscheck.models.mechanism import adopt_mechanism
    from crosscheck.models.refusals import refuse
    from crosscheck.trial.request import TrialRequest, prepare_equations
    from crosscheck.trial.trial import run_trial

    _require_arguments(arm, scenarios, switches, level, quick, jobs, seed, name)
    chosen = adopt_mechanism(arm, scenarios)._replace(switches=switches)
    section = chosen.mechanism.section
    refuse(section, "try_equations", scenarios=chosen.scenarios, switches=switches)
    name = _name_equations(equations) if name == YOURS else name
    made = prepare_equations(equations, chosen, name)
    made = _declare_level(made, level) if level else made
    what = name, made, chosen.mechanism, chosen.scenarios, switches
    return run_trial(TrialRequest(*what, quick=quick, seed=seed, jobs=jobs))


def assert_agrees(
    equations: Any,
    arm: Mechanism | str = "paper-labelled",
    *,
    scenarios: Sequence[Scenario | str] = (),
    switches: Switches | None = None,
    level: Level = "",
    quick: bool = True,
    jobs: int = 1,
    seed: int = 0,
    name: str = YOURS,
) -> Trial:
    """Raise AssertionError with what `crosscheck trial` prints, unless all that was judged agrees.

    Takes the arguments of ``try_equations`` and returns what that returns.
    """
    from crosscheck.models.errors import InputError

    __tracebackhide__ = True
    try:
        trial = try_equations(
            equations,
            arm,
            scenarios=scenarios,
            switches=switches,
            level=level,
            quick=quick,
            jobs=jobs,
            seed=seed,
            name=name,
        )
    except InputError as error:  # which says where: pytest shows no source of ours
        raise error.with_traceback(None) from None
    if trial.exit_code:
        first = trial.first_error or trial.verdict.text
        headline, *lines = (line for line in trial.lines if line != first)
        if trial.change is not None and trial.wrong:  # a test's summary shows the beginning alone
            edits = trial.change.edits
            short = ", and ".join(f"{each.place}: {each.short_remedy}" for each in edits)
            is_shorter = any(each.short_remedy != each.remedy for each in edits)
            headline = f"{short}\n{first}\n{headline}" if is_shorter else f"{first}\n{headline}"
        elif not headline.endswith(first):
            entry = f"{trial.wrong[0].name}: " if trial.wrong else ""
            has_entry = first.startswith(tuple(each.name for each in trial.wrong))
            headline = f"{'' if has_entry else entry}{first}\n{headline}"
        raise AssertionError("\n".join((headline, *lines)))
    return trial


def _name_equations(equations: Any) -> str:
    """The own name of a function, also of ``file.py:name``; ``yours`` of others, or if taken."""
    from crosscheck.registry import MODELS, engine_of

    name = equations.rpartition(":")[2] if isinstance(equations, str) else ""
    name = name or getattr(equations, "__name__", "")
    engines = {engine_of(model) for model in MODELS}
    return name if name.isidentifier() and name not in engines else YOURS


def _require_arguments(*given: object) -> None:
    """Raise InputError, naming argument, value and what is allowed, for one of the wrong kind."""
    from crosscheck.models.errors import InputError
    from crosscheck.models.experiment.scenario import Scenario, Switches
    from crosscheck.models.mechanism import Mechanism
    from crosscheck.trial.input.equations import Level

    arm, scenarios, switches, level, quick, jobs, seed, name = given
    levels = get_args(Level)
    listed = isinstance(scenarios, list | tuple)
    for argument, value, is_allowed, allowed in (
        ("arm", arm, isinstance(arm, Mechanism | str), ARM_ALLOWED),
        ("scenarios", scenarios, listed, "must be a list of scenarios, or of their names"),
        ("switches", switches, isinstance(switches, Switches | None), "must be Switches, or None"),
        ("level", level, level in levels, f"must be one of {', '.join(levels[1:])}, or ''"),
        ("quick", quick, isinstance(quick, bool), "must be True or False"),
        ("jobs", jobs, _is_whole(jobs, 1, MOST_JOBS), f"must be a whole number, 1 to {MOST_JOBS}"),
        ("seed", seed, _is_whole(seed, 0, LARGEST_SEED), f"must be 0 to {LARGEST_SEED}"),
        ("name", name, isinstance(name, str) and name.strip() != "", "must be a text"),
    ):
        if not is_allowed:
            raise InputError(f"argument {argument}", "", value, allowed)
    assert isinstance(scenarios, list | tuple)  # as was required
    for place, scenario in enumerate(scenarios):
        if not isinstance(scenario, Scenario | str):
            allowed = "must be a Scenario, or the name or file of one"
            raise InputError(f"argument scenarios[{place}]", "", scenario, allowed)


def _is_whole(value: object, least: int, most: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most


def _declare_level(equations: Equations, level: Level) -> Equations:
    """The equations, declared to be of a level, also whenever they are made anew."""
    from crosscheck.models.errors import InputError

    if equations.coordinates.gearing != "rigid":
        reason = f"is of rigid models; coordinates.gearing is {equations.coordinates.gearing}"
        raise InputError("argument level", "", level, reason)
    again = equations.rebuild
    if again is None:
        return replace(equations, level=level)
    return replace(equations, level=level, rebuild=lambda *of: _declare_level(again(*of), level))
