"""What the paper leaves open, as one setting: phase law, reading, damping, planets, equations."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

from crosscheck.audit.experiments.variant import GEARED_MODELS, Equations, Planets, Variant

LABELLED, SWAPPED = "paper-labelled", "paper-swapped"
# What the paper leaves open, as verdicts name it; printed equations have lumped planets.
LAW, PLANETS = "phase law", "planets and equations"
READING, DAMPING = "reading of Table I", "damping"
READINGS = {LABELLED: "labelled", SWAPPED: "swapped"}


class Law(NamedTuple):
    """The law of a mesh's phase, the rate of the ring's phase, and whether springs push theta.

    See crosscheck.models.experiment.scenario.
    """

    phase: Literal["omega_t", "angle"]
    ring_rate: Literal["eq13", "corrected"]
    mesh_work: Literal["paper", "conservative"] = "paper"

    @property
    def id(self) -> str:
        """The name of the law in claims.json."""
        work = "" if self.mesh_work == "paper" else f"/{self.mesh_work}"
        return f"{self.phase}/{self.ring_rate}{work}"


# As the paper has it; its ring rate repaired; its clock repaired as well.
PRINTED, REPAIRED_RATE, INTEGRAL = LAWS = (
    Law("omega_t", "eq13"),
    Law("omega_t", "corrected"),
    Law("angle", "corrected"),
)
CONSERVATIVE = Law("angle", "corrected", "conservative")
# From where the controller flutters by itself to twice the default.
ZETAS = (0.003, 0.004, 0.005, 0.006, 0.007, 0.008, 0.01, 0.015, 0.02, 0.03, 0.05, 0.1)


class GearModel(NamedTuple):
    """The model of the gears that moves the arm: its meshes' law, planets, equations of motion."""

    law: Law
    planets: Planets
    equations: Equations = "corrected"

    @property
    def id(self) -> str:
        """The name of the model in claims.json."""
        printed = "/printed" if self.equations == "printed" else ""
        return f"{self.law.id}/{self.planets}{printed}"


# Eqs. 8, 13, 14, and Eqs. 21-22 entry for entry, which count three planets as one.
AS_MODELLED = GearModel(PRINTED, "lumped", "printed")
AS_GEARS = GearModel(INTEGRAL, "free")  # the phase that a mesh has, every planet by itself
INTERMEDIATE_MODELS = (GearModel(PRINTED, "free"), GearModel(REPAIRED_RATE, "free"))
MODELS = (AS_MODELLED, AS_GEARS, *INTERMEDIATE_MODELS)  # that every claim is asked of
# Asked of claims that need no more than the PD run, each beside one of MODELS.
VARIANTS = {
    GearModel(PRINTED, "lumped"): AS_MODELLED,
    GearModel(REPAIRED_RATE, "lumped"): GearModel(REPAIRED_RATE, "free"),
    GearModel(INTEGRAL, "lumped"): AS_GEARS,
    GearModel(CONSERVATIVE, "free"): AS_GEARS,
}


@dataclass(frozen=True)
class Condition:
    """One setting of the study. arm: reading of Table I; zeta: damping ratio of all meshes."""

    law: Law
    zeta: float
    arm: str = LABELLED
    planets: Planets = "free"
    equations: Equations = "corrected"

    @property
    def model(self) -> GearModel:
        """The setting's model of the gears."""
        return GearModel(self.law, self.planets, self.equations)

    @property
    def conditions(self) -> Mapping[str, Hashable]:
        """The conditions that answers depend on, by their names."""
        return {
            LAW: self.law,
            PLANETS: (self.planets, self.equations),
            READING: self.arm,
            DAMPING: self.zeta,
        }

    @property
    def static_conditions(self) -> Mapping[str, Hashable]:
        """The conditions that the arm's data depend on."""
        return {READING: self.arm}

    @property
    def id(self) -> str:
        """The name of the setting in claims.json."""
        printed = "printed/" if self.equations == "printed" else ""
        return f"{self.law.id}/{self.arm}/{self.planets}/{printed}{self.zeta:g}"

    def variant(self, scenario: str = "pd") -> Variant:
        """The variant that runs a scenario in this setting."""
        return Variant(
            scenario,
            arm=self.arm,
            phase=self.law.phase,
            ring_rate=self.law.ring_rate,
            mesh_work=self.law.mesh_work,
            zeta=self.zeta,
            model=GEARED_MODELS[self.equations],
            planets=self.planets,
        )


# Where every start with the law's ring rate, or some with the paper's, is severe.
DECISIVE = (Condition(PRINTED, 0.005), Condition(REPAIRED_RATE, 0.02))
