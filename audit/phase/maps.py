"""Evidence 2: the third fluctuation over damping, tooth error, backlash, readings and laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product

from crosscheck.audit.claims.rule import State
from crosscheck.audit.claims.settings import plan_of
from crosscheck.audit.experiments.cells import CONSERVATIVE, INTEGRAL, LAWS, Cell, Law
from crosscheck.audit.experiments.experiments import (
    BACKLASH,
    BACKLASH_NO_ERROR,
    DEFAULT_B_UM,
    DEFAULT_E_UM,
    ERROR,
    NO_ERROR,
    PD,
    Source,
)
from crosscheck.audit.experiments.pool import Wanted
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.twosamples import WithAndWithout
from crosscheck.audit.page.material import Material

# The integral with Eq. 13's ring rate: the one combination that no claim is judged with.
FOUR = (*LAWS, Law("angle", "eq13"))
PHASES = ("omega_t", "angle")
ERRORS_UM = (1.6, DEFAULT_E_UM, 6.3)  # of Fig. 19
BACKLASH_ZETAS = (0.005, 0.02)
BACKLASHES_UM = (5.0, 25.0, DEFAULT_B_UM, 500.0)  # of Figs. 16-17


@dataclass(frozen=True)
class MapSetting:
    """A setting at one tooth error and one backlash [um]."""

    cell: Cell
    error_um: float = DEFAULT_E_UM
    backlash_um: float = DEFAULT_B_UM

    @property
    def is_paper(self) -> bool:
        """Whether tooth error and backlash are Table I's."""
        return (self.error_um, self.backlash_um) == (DEFAULT_E_UM, DEFAULT_B_UM)

    @property
    def sources(self) -> tuple[Source, Source]:
        """The experiment of the setting, and the same without tooth error."""
        if self.backlash_um != DEFAULT_B_UM:
            return BACKLASH(self.backlash_um), BACKLASH_NO_ERROR(self.backlash_um)
        return (PD if self.error_um == DEFAULT_E_UM else ERROR(self.error_um)), NO_ERROR


@dataclass(frozen=True)
class Mapped(WithAndWithout):
    """The third fluctuation with and without tooth error in a setting of the maps."""

    setting: MapSetting


class Presence(StrEnum):
    """The phase laws under which the tooth error makes a third fluctuation."""

    PRINTED = "only with omega_t"
    INTEGRATED = "only with angle"
    BOTH = "with both"
    NEITHER = "with neither"
    UNKNOWN = "undefined"


def where_present(states: Mapping[str, Sequence[State]]) -> Presence:
    """The laws under which the fluctuation is present, from all settings' states by phase law.

    Present where one setting says yes or that the start decides; unknown if a law has no setting
    that says anything.
    """
    if any(all(one == State.UNDEFINED for one in said) for said in states.values()):
        return Presence.UNKNOWN
    present = {phase: {State.YES, State.BISTABLE} & set(said) for phase, said in states.items()}
    if present["omega_t"]:
        return Presence.BOTH if present["angle"] else Presence.PRINTED
    return Presence.INTEGRATED if present["angle"] else Presence.NEITHER


@dataclass(frozen=True)
class Maps:
    """The settings with free planets, those with lumped ones, those of the conservative law."""

    settings: Sequence[Mapped]
    lumped: Sequence[Mapped]
    conservative: Sequence[Mapped]

    def of(self, *phases: str) -> list[Mapped]:
        """The settings under these phase laws."""
        return [one for one in self.settings if one.setting.cell.law.phase in phases]

    @property
    def visible(self) -> Presence:
        """The laws under which the tooth error makes any fluctuation that counts: H1 itself."""
        return _presence([(one, one.made_visible.state) for one in self.settings])

    @property
    def severe(self) -> Presence:
        """The laws under which the tooth error makes a severe fluctuation."""
        return _presence([(one, one.made.state) for one in self.settings])

    @property
    def severe_alike(self) -> Presence:
        """The laws under which the tooth error makes a severe fluctuation with lumped planets."""
        return _presence([(one, one.made.state) for one in self.lumped])

    @property
    def repairs(self) -> list[RepairedSetting]:
        """What the conservative law changes, by setting."""
        plain = {one.setting: one for one in self.settings}
        return [
            RepairedSetting(plain[integral], one)
            for one in self.conservative
            if (integral := integral_of(one.setting)) in plain
        ]


def _presence(said: Sequence[tuple[Mapped, State]]) -> Presence:
    """The laws under which the fluctuation is present, from settings with their states."""
    return where_present(
        {p: [state for one, state in said if one.setting.cell.law.phase == p] for p in PHASES}
    )


@dataclass(frozen=True)
class RepairedSetting:
    """A setting under `angle` without and with the virtual work of k(theta) and e(theta)."""

    plain: Mapped
    conservative: Mapped


def integral_of(setting: MapSetting) -> MapSetting:
    """The same setting under `angle` with the corrected ring rate."""
    return replace(setting, cell=replace(setting.cell, law=INTEGRAL))


def maps(material: Material) -> Maps:
    """The maps from every start of every setting; few settings if quick."""
    plan = plan_of(material.scale)
    over_zeta = [
        MapSetting(Cell(law, zeta, arm))
        for arm, law, zeta in product(plan.readings, FOUR, plan.zetas)
    ]
    if material.scale.quick:
        return Maps(mapped(material, over_zeta), [], [])
    over_error = [
        MapSetting(Cell(law, zeta), error_um)
        for law, zeta, error_um in product(FOUR, plan.zetas, ERRORS_UM)
    ]
    over_backlash = [
        MapSetting(Cell(law, zeta), backlash_um=b)
        for law, zeta, b in product(FOUR, BACKLASH_ZETAS, BACKLASHES_UM)
    ]
    asked = list(dict.fromkeys([*over_zeta, *over_error, *over_backlash]))
    lumped = [MapSetting(replace(one.cell, planets="lumped")) for one in over_zeta]
    conservative = [
        MapSetting(replace(one.cell, law=CONSERVATIVE))
        for one in over_zeta
        if one.cell.law == INTEGRAL
    ]
    found = {one.setting: one for one in mapped(material, [*asked, *lumped, *conservative])}
    return Maps(*([found[one] for one in part] for part in (asked, lumped, conservative)))


def mapped(material: Material, settings: Sequence[MapSetting]) -> list[Mapped]:
    """The settings with their samples; experiments that claims have asked for are only read."""
    wanted: list[Wanted] = [(one.cell, source) for one in settings for source in one.sources]
    found = material.samples(wanted, "phase: maps")
    made = []
    for one in settings:
        third, without = (Third.of(found[one.cell, source]) for source in one.sources)
        made.append(Mapped(one, third=third, without=without))
    return made
