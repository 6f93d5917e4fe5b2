"""The findings that the page begins with, as numbers: each is another chapter's own record."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

from crosscheck.audit.claims.rule import State
from crosscheck.audit.experiments.cells import INTEGRAL, LABELLED, LAWS, PRINTED, Cell, Law
from crosscheck.audit.experiments.experiments import PD
from crosscheck.audit.experiments.variant import Planets
from crosscheck.audit.figures.shelf import LOW_ZETA
from crosscheck.audit.hypotheses.damping_fit import reversals
from crosscheck.audit.hypotheses.evidence.attribution import LadderVerdict, RigidResidual
from crosscheck.audit.hypotheses.ladder import Climbed
from crosscheck.audit.measures.shares import Share
from crosscheck.audit.measures.third import Third
from crosscheck.audit.measures.undefined import JsonObject, defined
from crosscheck.audit.page.material import Material

MODELS: tuple[Planets, ...] = ("lumped", "free")  # the paper's own first


@dataclass(frozen=True)
class StartsStrip:
    """The third fluctuation of every start in one setting."""

    cell: Cell
    third: Third

    def to_dict(self) -> JsonObject:
        """For JSON."""
        return {
            "id": f"finding/third/{self.cell.id}",
            "starts": self.third.size.size,
            "run": self.third.size.size - self.third.not_run,
            "undefined": self.third.size.size - self.third.sizes.size,
            "severe": int(self.third.of_branch(severe=True).sum()),
            "quantiles": list(map(defined, self.third.quantiles)),
        }


@dataclass(frozen=True)
class Thirds:
    """By law and model, planets lumped and free, at one damping."""

    zeta: float
    strips: tuple[StartsStrip, ...]

    def share(self, law: Law, planets: Planets) -> Share | None:
        """Of severe starts."""
        return self._by_place[law, planets].share

    @property
    def as_modelled(self) -> Share | None:
        """In the paper's own model: planets lumped, its law and its ring rate."""
        return self.share(PRINTED, "lumped")

    @property
    def as_gears(self) -> Share | None:
        """As the gears are: planets free, teeth counted."""
        return self.share(INTEGRAL, "free")

    @property
    def _by_place(self) -> dict[tuple[Law, Planets], Third]:
        return {(one.cell.law, one.cell.planets): one.third for one in self.strips}

    @property
    def needs_clock(self) -> bool:
        """Whether some starts are severe with the clock, and in no setting without it."""
        severe = (State.YES, State.BISTABLE)
        return {s.cell.law.phase for s in self.strips if s.third.state in severe} == {"omega_t"}


def third_finding(material: Material, zeta: float = LOW_ZETA) -> Thirds:
    """From all starts."""
    cells = [Cell(law, zeta, planets=planets) for planets, law in product(MODELS, LAWS)]
    found = material.samples([(cell, PD) for cell in cells], "the third fluctuation")
    return Thirds(zeta, tuple(StartsStrip(cell, Third.of(found[cell, PD])) for cell in cells))


@dataclass(frozen=True)
class Baselines:
    """What every rigid arm leaves under constant torque (H2's), and when its teeth return.

    left: of the labelled reading; return_s: of the rigid arm with all inertia of its gears, under
    PD control.
    """

    left: tuple[RigidResidual, ...]
    verdict: LadderVerdict
    return_s: float | None

    @property
    def nearest(self) -> RigidResidual | None:
        """The one that leaves the paper's theta_2, if one does."""
        return next((one for one in self.left if one.fits["theta_2"]), None)

    @property
    def gives_all(self) -> bool:
        """Whether one baseline leaves all of the paper's numbers."""
        return any(all(one.fits.values()) for one in self.left)


def baseline_finding(climbed: Climbed, material: Material) -> Baselines:
    """From the ladder of H2."""
    left = tuple(one for one in climbed.left if one.arm == LABELLED)
    rigid = {one.level: one for one in reversals(material.study, material.scale)}
    return Baselines(left, climbed.verdict, rigid["coupled"].return_s)
