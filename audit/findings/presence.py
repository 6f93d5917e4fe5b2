"""Under which laws of the mesh phase the tooth error makes a third fluctuation at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import StrEnum

from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.study_plan import ResultsByCondition
from crosscheck.audit.experiments.experiments import NO_ERROR, PD
from crosscheck.audit.measures.third_fluctuation import LARGE, VISIBLE, ThirdFluctuation
from crosscheck.audit.measures.twosamples import compute_error_effect

PHASES = ("omega_t", "angle")
LEVELS = {"visible": VISIBLE, "severe": LARGE}


class Presence(StrEnum):
    """The phase laws under which the tooth error makes a third fluctuation."""

    PRINTED = "only with omega_t"
    INTEGRATED = "only with angle"
    BOTH = "with both"
    NEITHER = "with neither"
    UNKNOWN = "undefined"


def find_presence(states: Mapping[str, Sequence[State]]) -> Presence:
    """The laws under which the fluctuation is present, from all settings' states by phase law.

    Present where one setting says yes or that the start decides; unknown if a law has no setting
    that says anything.
    """
    if any(all(state == State.UNDEFINED for state in law_states) for law_states in states.values()):
        return Presence.UNKNOWN
    present = {
        phase: {State.YES, State.BISTABLE} & set(law_states) for phase, law_states in states.items()
    }
    if present["omega_t"]:
        return Presence.BOTH if present["angle"] else Presence.PRINTED
    return Presence.INTEGRATED if present["angle"] else Presence.NEITHER


def find_presence_by_level(settings: ResultsByCondition) -> dict[str, Presence]:
    """The laws under which the fluctuation exceeds each of LEVELS, from settings that claims use.

    Start i with the tooth error is compared with start i without it.
    """
    presence_by_level = {}
    for name, level in LEVELS.items():
        states: dict[str, list[State]] = {phase: [] for phase in PHASES}
        for condition, results in settings:
            thirds = (ThirdFluctuation.from_samples(results[each]) for each in (PD, NO_ERROR))
            states[condition.law.phase].append(compute_error_effect(*thirds, level).state)
        presence_by_level[name] = find_presence(states)
    return presence_by_level
