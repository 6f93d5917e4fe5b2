"""The settings of the maps, and what is measured in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from crosscheck.paper.phase.verdict import error_part
from crosscheck.paper.record import JsonObject, Record
from crosscheck.studies.study import Variant

LABELLED, SWAPPED = "paper-labelled", "paper-swapped"
READINGS = {LABELLED: "labelled", SWAPPED: "swapped"}
PAPER_E_UM, PAPER_B_UM = 5.0, 50.0
DURATION_S = 1.2


@dataclass(frozen=True)
class Cell:
    """One setting of the maps; lengths in micrometres; seeds: how many starts (0: the paper's)."""

    law: str
    ring: str
    zeta: float
    error_um: float = PAPER_E_UM
    backlash_um: float = PAPER_B_UM
    arm: str = LABELLED
    seeds: int = 0

    def variants(self) -> list[Variant]:
        """A run for every start."""
        meshes = (
            f"arm.joints.*.tooth_error_m={1e-6 * self.error_um!r}",
            f"arm.joints.*.backlash_m={1e-6 * self.backlash_um!r}",
        )
        one = Variant(
            arm=self.arm,
            phase=self.law,
            ring_rate=self.ring,
            zeta=self.zeta,
            duration_s=DURATION_S,
            meshes=meshes,
        )
        return [replace(one, seed=seed) for seed in range(1, self.seeds + 1)] or [one]

    @property
    def reading(self) -> str:
        """Of Table I."""
        return READINGS[self.arm]

    @property
    def without_error(self) -> Cell:
        """The same without tooth error."""
        return replace(self, error_um=0.0)


Amplitudes = dict[Cell, list[float]]  # rad/s^2, one for every start


@dataclass(frozen=True)
class CellRecord(Record):
    """The third fluctuation's amplitude in a cell [rad/s^2], over its starts; None: undefined."""

    cell: Cell
    starts: int
    median: float | None
    smallest: float | None
    largest: float | None
    median_without_error: float | None
    error_part: float | None
    present: bool | None
    diverged: bool

    @property
    def id(self) -> str:
        cell = self.cell
        seeds = f"/{cell.seeds} seeds" if cell.seeds else ""
        return (
            f"map/{cell.arm}/{cell.law}/{cell.ring}/zeta {cell.zeta:g}/E {cell.error_um:g} um"
            f"/b {cell.backlash_um:g} um{seeds}"
        )

    def to_dict(self) -> JsonObject:
        cell = self.cell
        return {
            "id": self.id,
            "arm": cell.arm,
            "phase": cell.law,
            "ring_rate": cell.ring,
            "zeta": cell.zeta,
            "E_um": cell.error_um,
            "b_um": cell.backlash_um,
            "starts": self.starts,
            "median_rad_per_s2": self.median,
            "smallest_rad_per_s2": self.smallest,
            "largest_rad_per_s2": self.largest,
            "median_without_error_rad_per_s2": self.median_without_error,
            "error_part_rad_per_s2": self.error_part,
            "present": self.present,
            "diverged": self.diverged,
        }


def part_of(cell: Cell, found: Amplitudes) -> float:
    """What the tooth error adds to the median [rad/s^2]."""
    return error_part(median_of(found[cell]), median_of(found[cell.without_error]))


def median_of(runs: Sequence[float]) -> float:
    """Over the starts; infinite ones count."""
    return float(np.median(runs))
