"""Evidence 2: the third fluctuation over damping, tooth error, backlash, readings and laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product

from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.study_plan import plan_of
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    BACKLASH_NO_ERROR,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NO_ERROR,
    PD,
    PaperExperiment,
)
from crosscheck.audit.experiments.paper_conditions import (
    CONSERVATIVE,
    INTEGRAL,
    LAWS,
    Condition,
    Law,
)
from crosscheck.audit.experiments.samples import SampleRequest
from crosscheck.audit.measures.third_fluctuation import ThirdFluctuation
from crosscheck.audit.measures.twosamples import ToothErrorComparison
from crosscheck.audit.page.context import AuditContext

# The integral with Eq. 13's ring rate: the one combination that no claim is judged with.
FOUR = (*LAWS, Law("angle", "eq13"))
PHASES = ("omega_t", "angle")
ERRORS_UM = (1.6, DEFAULT_E_UM, 6.3)  # of Fig. 19
BACKLASH_ZETAS = (0.005, 0.02)
BACKLASHES_UM = (5.0, 25.0, DEFAULT_B_UM, 500.0)  # of Figs. 16-17


@dataclass(frozen=True)
class MapSetting:
    """A setting at one tooth error and one backlash [um]."""

    cell: Condition
    error_um: float = DEFAULT_E_UM
    backlash_um: float = DEFAULT_B_UM

    @property
    def is_paper(self) -> bool:
        """Whether tooth error and backlash are Table I's."""
        return (self.error_um, self.backlash_um) == (DEFAULT_E_UM, DEFAULT_B_UM)

    @property
    def sources(self) -> tuple[PaperExperiment, PaperExperiment]:
        """The experiment of the setting, and the same without tooth error."""
        if self.backlash_um != DEFAULT_B_UM:
            return BACKLASH(self.backlash_um), BACKLASH_NO_ERROR(self.backlash_um)
        return (PD if self.error_um == DEFAULT_E_UM else ERROR(self.error_um)), NO_ERROR


@dataclass(frozen=True)
class MapPoint(ToothErrorComparison):
    """The third fluctuation with and without tooth error in a setting of the maps."""

    setting: MapSetting


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


@dataclass(frozen=True)
class Maps:
    """The settings with free planets, those with lumped ones, those of the conservative law."""

    settings: Sequence[MapPoint]
    lumped: Sequence[MapPoint]
    conservative: Sequence[MapPoint]

    def select(self, *phases: str) -> list[MapPoint]:
        """The settings under these phase laws."""
        return [point for point in self.settings if point.setting.cell.law.phase in phases]

    @property
    def visible(self) -> Presence:
        """The laws under which the tooth error makes any fluctuation that counts: H1 itself."""
        return _presence([(point, point.made_visible.state) for point in self.settings])

    @property
    def severe(self) -> Presence:
        """The laws under which the tooth error makes a severe fluctuation."""
        return _presence([(point, point.made.state) for point in self.settings])

    @property
    def severe_alike(self) -> Presence:
        """The laws under which the tooth error makes a severe fluctuation with lumped planets."""
        return _presence([(point, point.made.state) for point in self.lumped])

    @property
    def repairs(self) -> list[RepairedSetting]:
        """What the conservative law changes, by setting."""
        plain = {point.setting: point for point in self.settings}
        return [
            RepairedSetting(plain[integral], point)
            for point in self.conservative
            if (integral := integral_of(point.setting)) in plain
        ]


def _presence(point_states: Sequence[tuple[MapPoint, State]]) -> Presence:
    """The laws under which the fluctuation is present, from settings with their states."""
    return find_presence(
        {
            p: [state for point, state in point_states if point.setting.cell.law.phase == p]
            for p in PHASES
        }
    )


@dataclass(frozen=True)
class RepairedSetting:
    """A setting under `angle` without and with the virtual work of k(theta) and e(theta)."""

    plain: MapPoint
    conservative: MapPoint


def integral_of(setting: MapSetting) -> MapSetting:
    """The same setting under `angle` with the corrected ring rate."""
    return replace(setting, cell=replace(setting.cell, law=INTEGRAL))


def build_maps(context: AuditContext) -> Maps:
    """The maps from every start of every setting; few settings if quick."""
    plan = plan_of(context.scale)
    over_zeta = [
        MapSetting(Condition(law, zeta, arm))
        for arm, law, zeta in product(plan.readings, FOUR, plan.zetas)
    ]
    if context.scale.quick:
        return Maps(sample_settings(context, over_zeta), [], [])
    over_error = [
        MapSetting(Condition(law, zeta), error_um)
        for law, zeta, error_um in product(FOUR, plan.zetas, ERRORS_UM)
    ]
    over_backlash = [
        MapSetting(Condition(law, zeta), backlash_um=b)
        for law, zeta, b in product(FOUR, BACKLASH_ZETAS, BACKLASHES_UM)
    ]
    settings = list(dict.fromkeys([*over_zeta, *over_error, *over_backlash]))
    lumped = [MapSetting(replace(item.cell, planets="lumped")) for item in over_zeta]
    conservative = [
        MapSetting(replace(item.cell, law=CONSERVATIVE))
        for item in over_zeta
        if item.cell.law == INTEGRAL
    ]
    points = {
        item.setting: item for item in sample_settings(context, [*settings, *lumped, *conservative])
    }
    return Maps(*([points[item] for item in part] for part in (settings, lumped, conservative)))


def sample_settings(context: AuditContext, settings: Sequence[MapSetting]) -> list[MapPoint]:
    """The settings with their samples; experiments that claims have asked for are only read."""
    requests: list[SampleRequest] = [
        (setting.cell, source) for setting in settings for source in setting.sources
    ]
    samples = context.samples(requests, "phase: maps")
    made = []
    for setting in settings:
        third, without = (
            ThirdFluctuation.from_samples(samples[setting.cell, source])
            for source in setting.sources
        )
        made.append(MapPoint(setting, third=third, without=without))
    return made
