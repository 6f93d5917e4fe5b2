"""Claims that follow from the arm's data: each is false of other data, or of an equation changed.

A world is an arm with another number in it, or an error planted into an equation that the measure
asks; the measure and the claim's function are those of the page.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from crosscheck.analytic.model import PhysicalModel
from crosscheck.analytic.paper.mesh_force import dead_zone
from crosscheck.analytic.paper.mesh_frequency import ring_mesh_rate, sun_mesh_rate
from crosscheck.analytic.paper.model import EnergiesModel, PrintedModel
from crosscheck.analytic.paper.stiffness import square_wave_series
from crosscheck.audit.claims.catalogue import BY_ID, CLAIMS
from crosscheck.audit.errata.printed_equations import detectable_share
from crosscheck.audit.experiments.experiments import PLANTED, STATIC
from crosscheck.audit.experiments.paper_conditions import PRINTED, Condition
from crosscheck.audit.experiments.variant import Numbers
from crosscheck.audit.judging.quantities import ConditionResults, Sample
from crosscheck.audit.judging.rule import VerdictKind, evaluate_claim, verdict
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.audit.statics import statics as statements
from crosscheck.audit.statics import teeth
from crosscheck.models.arm.arm import Arm
from crosscheck.models.loading import load_arm

CELL = Condition(PRINTED, 0.005)


class Changed(NamedTuple):
    """A world: a stage or arm changed, what is put in place of the audit's own, and the verdict."""

    claim: str
    verdict: VerdictKind
    measure: str  # of MEASURES
    stage: Callable[[PaperStage], PaperStage] = lambda stage: stage
    arm: Callable[[Arm], Arm] = lambda arm: arm
    put: Mapping[str, object] = {}


MEASURES: dict[str, Callable[[Arm, PaperStage], Numbers]] = {
    "gearing": lambda arm, stage: teeth.compute_gearing(stage),
    "clearance": lambda arm, stage: teeth.compute_clearance(stage),
    "wave": lambda arm, stage: teeth.compare_stiffness_wave(stage),
    "torques": statements.compute_neglected_torques,
    "data": statements.compute_data_numbers,
    "equations": lambda arm, stage: statements.compare_equations(arm),
    "base": lambda arm, stage: statements.compute_base_errors("paper-labelled"),
}


def _geometry(**fields: float) -> Callable[[PaperStage], PaperStage]:
    return lambda stage: replace(stage, geometry=stage.geometry._replace(**fields))


def _joint(**fields: float) -> Callable[[PaperStage], PaperStage]:
    return lambda stage: replace(stage, joint=stage.joint.model_copy(update=fields))


class SkewMass(PrintedModel):
    """M_12 is not M_21."""

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        mass = super().mass_matrix(q).copy()
        mass[0, 1] += 0.1
        return mass


class NegativeMass(PrintedModel):
    """M is not positive definite at some poses."""

    def mass_matrix(self, q: np.ndarray) -> np.ndarray:
        return super().mass_matrix(q) - np.eye(q.size) * (q[-1] > 0)


class OtherForces(PrintedModel):
    """C q' and F are a hundredth larger."""

    def bias(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return 1.01 * super().bias(q, v)

    def generalized_force(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return 1.01 * super().generalized_force(t, q, v)


def _short_links(arm: Arm) -> Arm:
    links = tuple(link.model_copy(update={"length_m": 0.1}) for link in arm.links)
    return arm.model_copy(update={"links": links})


FAILS, HOLDS = VerdictKind.FAILS, VerdictKind.HOLDS
TEETH, EQUATIONS = "statics.teeth", "statics.statics"
FEW_WAVES = {f"{TEETH}.HARMONICS": 10}  # where the series' own error is not the claim
SINGLE = {f"{TEETH}.{mesh}_contact_ratio": lambda joint: 1.5 for mesh in ("sun", "ring")}
TWICE = {f"{TEETH}.square_wave_series": lambda *a: 2 * square_wave_series(*a)}
FASTER = {f"{TEETH}.sun_mesh_rate": lambda *a: 1.01 * sun_mesh_rate(*a)}
REPAIRED = {f"{TEETH}.ring_mesh_rate": lambda j, g, _: ring_mesh_rate(j, g, "corrected")}
CONSTANT = {f"{TEETH}.mesh_force": lambda *a: 200.0 * np.ones_like(a[2])}
WORLDS = [
    Changed("2-01", HOLDS, "base", put={"statics.statics._tip_errors_m": lambda _: [1e-3] * 4}),
    Changed("2-02", FAILS, "gearing", _geometry(n=11 / 3)),
    Changed("2-03", FAILS, "torques", put={"statics.statics.ORBIT_M": 1e5}),
    Changed(
        "2.1-06", FAILS, "clearance", put={f"{TEETH}.dead_zone": lambda x, b: dead_zone(x, b / 2)}
    ),
    Changed("2.1-07", HOLDS, "clearance", put={f"{TEETH}._eq6_operations": lambda: 1}),
    Changed("2.1-09", FAILS, "clearance", put={f"{TEETH}.dead_zone_tanh": lambda x, b, s: x}),
    Changed(
        "2.1-10",
        HOLDS,
        "clearance",
        put={f"{TEETH}.dead_zone_tanh": lambda x, b, s: dead_zone(x, b)},
    ),
    Changed("2.1-11", FAILS, "gearing", _geometry(r_p=0.1)),
    Changed("2.2-03", FAILS, "wave", put=TWICE),
    Changed("2.2-05", HOLDS, "wave", put=SINGLE | FEW_WAVES),
    Changed("2.2-06", FAILS, "gearing", _joint(ring_teeth=98)),
    Changed("2.2-09", FAILS, "gearing", put=FASTER),
    Changed("2.2-10", HOLDS, "gearing", put=REPAIRED),
    Changed("2.2-11", FAILS, "gearing", put={f"{TEETH}.ADDENDUM": 2.0}),
    Changed("2.2-15", FAILS, "wave", put=CONSTANT | FEW_WAVES),
    Changed("2.2-16", FAILS, "gearing", put={f"{TEETH}.sun_mesh_frequency": lambda *a: 1.0}),
    Changed("2.3-03", HOLDS, "clearance", lambda stage: replace(stage, backlash_m=1e-12)),
    Changed("2.4-01", HOLDS, "equations", put={f"{EQUATIONS}.EnergiesModel": PhysicalModel}),
    *(
        Changed(claim, said, "equations", put={f"{EQUATIONS}.PrintedModel": model})
        for claim, said, model in (
            ("2.4-02", HOLDS, EnergiesModel),
            ("2.4-03", FAILS, OtherForces),
            ("2.4-04", FAILS, OtherForces),
            ("2.4-05", FAILS, SkewMass),
            ("2.4-06", FAILS, NegativeMass),
        )
    ),
    Changed("2.4-08", FAILS, "torques", lambda stage: replace(stage, tooth_error_m=5e-4)),
    Changed("3-03", HOLDS, "data", put={f"{EQUATIONS}.INITIAL_VALUES": ("0",) * 12}),
    Changed("3-04", HOLDS, "data", lambda stage: replace(stage, sun_equivalent_mass_kg=0.3)),
    Changed("3.1-03", FAILS, "data", arm=_short_links),
    Changed("4.1-03", HOLDS, "data", _joint(module_m=0.01146)),
    Changed("4.2-03", FAILS, "data", lambda stage: replace(stage, tooth_error_m=5e-5)),
]


@cache
def _unchanged(measure: str) -> Numbers:
    arm = load_arm("paper-labelled")
    return MEASURES[measure](arm, paper_stage(arm))


def _verdict(claim_id: str, numbers: Numbers) -> VerdictKind:
    claim = BY_ID[claim_id]
    values = {name: np.array([value], float) for name, value in numbers.items()}
    known = ConditionResults(
        {source: Sample(values, np.zeros(1, bool)) for source in (STATIC, PLANTED)}
    )
    return verdict(evaluate_claim(claim, [(CELL, known)]), claim.free).kind


@pytest.mark.parametrize("world", WORLDS, ids=lambda world: world.claim)
def test_a_claim_from_data_has_another_verdict_in_a_planted_world(world, labelled, monkeypatch):
    stage = paper_stage(labelled)
    if world.measure != "base":  # whose flights take seconds; 2-01 is `depends` on the page
        assert _verdict(world.claim, _unchanged(world.measure)) != world.verdict
    for name, value in world.put.items():
        monkeypatch.setattr(f"crosscheck.audit.{name}", value)
    numbers = MEASURES[world.measure](world.arm(labelled), world.stage(stage))
    assert _verdict(world.claim, numbers) == world.verdict


def test_an_agreement_that_shows_every_planted_error_validates_and_none_does_not():
    for size, said in ((0.5, HOLDS), (1e-3, FAILS)):
        assert _verdict("3.1-18", {"planted_shown": detectable_share([size, size])}) == said


def test_every_claim_from_data_has_a_planted_world():
    static = {claim.id for claim in CLAIMS if claim.static}
    assert {world.claim for world in WORLDS} | {"3.1-18"} == static
