"""What the paper leaves open, as one setting: phase law, reading of Table I, damping, planets."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from crosscheck.audit.experiments.variant import Planets, Variant

LABELLED, SWAPPED = "paper-labelled", "paper-swapped"
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
    """The model of the gears that moves the arm: the law of its meshes, and how planets count."""

    law: Law
    planets: Planets

    @property
    def id(self) -> str:
        """The name of the model in claims.json."""
        return f"{self.law.id}/{self.planets}"


AS_MODELLED = GearModel(PRINTED, "lumped")  # Eqs. 8, 13, 14 and three planets counted as one
AS_GEARS = GearModel(INTEGRAL, "free")  # the phase that a mesh has, every planet by itself
INTERMEDIATE_MODELS = (GearModel(PRINTED, "free"), GearModel(REPAIRED_RATE, "free"))
MODELS = (AS_MODELLED, AS_GEARS, *INTERMEDIATE_MODELS)  # that every claim is asked of
# Asked of claims that need no more than the PD run, each beside one of MODELS.
VARIANTS = {
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

    @property
    def model(self) -> GearModel:
        """The setting's model of the gears."""
        return GearModel(self.law, self.planets)

    @property
    def reading(self) -> str:
        """The setting's reading of Table I, in a word."""
        return READINGS[self.arm]

    @property
    def id(self) -> str:
        """The name of the setting in claims.json."""
        return f"{self.law.id}/{self.arm}/{self.planets}/{self.zeta:g}"

    def variant(self, scenario: str = "pd") -> Variant:
        """The variant that runs a scenario in this setting."""
        return Variant(
            scenario,
            arm=self.arm,
            phase=self.law.phase,
            ring_rate=self.law.ring_rate,
            mesh_work=self.law.mesh_work,
            zeta=self.zeta,
            planets=self.planets,
        )
