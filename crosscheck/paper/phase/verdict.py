"""What decides hypothesis H1: thresholds and the functions that apply them.

A decision about what is undefined is None; nan is a number that a run is too short for, an infinite
one that of a run that diverged.

H1: the part of the third fluctuation that depends on the tooth error exists only under `omega_t`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from crosscheck.paper.numbers import quotient
from crosscheck.paper.record import Record
from crosscheck.paper.undefined import UNDEFINED, all_of, any_of, known, where_known

PRESENT_RAD_PER_S2 = 30.0  # a tenth of the 300 rad/s^2 that the paper reports
NEAR = 3.0  # times or a part of it: another start may decide otherwise
ONSET_RAD_PER_S2 = 3.0  # a hundredth of them: where a growing vibration counts as begun
CLOCK_N = 1e-9  # rounding of mesh forces of some 1e3 N, with room
DEAD = 0.1  # of the vibration handed over
FAR = 5.0  # times the fastest speed
ONSET_PREDICTED = 0.05  # relative error of the predicted onset


@dataclass(frozen=True)
class Evidence:
    """One kind of evidence: its text, its numbers, and whether it speaks for H1."""

    html: str
    records: Sequence[Record] = ()
    supports: bool | None = None


def error_part(with_error: float, without: float) -> float:
    """What the tooth error adds to the third fluctuation's amplitude [rad/s^2].

    Undefined if one is, and if the run without diverged.
    """
    if math.isnan(with_error) or not known(without):
        return math.nan
    return max(0.0, with_error - without)


@where_known
def is_present(part: float) -> bool:
    """Whether the tooth error adds as much [rad/s^2] as counts."""
    return part >= PRESENT_RAD_PER_S2


def is_near(part: float) -> bool:
    """Whether a part [rad/s^2] lies so near to the threshold that several starts are asked."""
    return PRESENT_RAD_PER_S2 / NEAR <= part <= PRESENT_RAD_PER_S2 * NEAR


class Presence(StrEnum):
    """Under which phase law the tooth error excites the third fluctuation, in words."""

    PRINTED = "only with omega_t"
    INTEGRATED = "only with angle"
    BOTH = "with both"
    NEITHER = "with neither"
    UNKNOWN = UNDEFINED


def where_present(parts: Mapping[str, Sequence[float]]) -> Presence:
    """Under which phase law the tooth error's part [rad/s^2] is present in any cell.

    parts: of every cell, by phase law; the defined ones count. Unknown if a law has none.
    """
    if any(all(map(math.isnan, cells)) for cells in parts.values()):
        return Presence.UNKNOWN
    present = {law: any(p >= PRESENT_RAD_PER_S2 for p in cells) for law, cells in parts.items()}
    if present["omega_t"]:
        return Presence.BOTH if present["angle"] else Presence.PRINTED
    return Presence.INTEGRATED if present["angle"] else Presence.NEITHER


def knows_the_clock(largest_change_N: float) -> bool:
    """Whether a mesh force changes when the same motion happens at another time."""
    return largest_change_N > CLOCK_N


@where_known
def dies(before: float, after: float) -> bool:
    """Whether a vibration falls to a tenth of what was handed over."""
    return after <= DEAD * before


def is_far(resonance: float, fastest: float) -> bool:
    """Whether the slowest resonance lies far above the fastest speed, both in rad/s."""
    return bool(resonance > FAR * fastest)


def second_engine_supports(
    same: Sequence[bool | None],
    shown: Sequence[bool | None],
    under_angle: Sequence[float | None],
) -> bool | None:
    """Whether another engine shows the same fluctuation under `omega_t`, and none under `angle`.

    same: for every setting, whether no test tells its starts from those of the analytic model with
    free planets; shown: whether any start of it has a large one; under_angle: amplitudes [rad/s^2],
    None where undefined.
    """
    return all_of((any_of(shown), *same, *map(is_quiet, under_angle)))


@where_known
def is_quiet(amplitude: float) -> bool:
    """Whether a fluctuation [rad/s^2] is too small to be the paper's third."""
    return amplitude < PRESENT_RAD_PER_S2


def onset_is_predicted(predicted_s: float | None, simulated_s: float | None) -> bool:
    """Both never begin, or both begin at nearly the same time."""
    if predicted_s is None or simulated_s is None:
        return predicted_s is simulated_s
    return abs(quotient(predicted_s, simulated_s) - 1) <= ONSET_PREDICTED


def h1_verdict(maps: Presence, supports: Mapping[str, bool | None]) -> str:
    """`holds` if the simulations say so and no kind of evidence that was run speaks against it.

    maps: of ``where_present``; supports: the other kinds of evidence.
    """
    if maps == Presence.UNKNOWN:
        return UNDEFINED
    if maps != Presence.PRINTED:
        return "does not hold"
    for answer, but in ((False, "not"), (None, UNDEFINED)):
        names = [name for name, supported in supports.items() if supported is answer]
        if names:
            return f"holds in the simulations, but {but} in: {', '.join(names)}"
    return "holds"
