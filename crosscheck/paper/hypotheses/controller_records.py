"""What is found of the controller's flutter, record by record."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from crosscheck.paper.hypotheses.feedback import Point
from crosscheck.paper.undefined import where_known, word

FLUTTER_RAD_PER_S2 = 1.0  # sustained vibration; ring-down from the impacts is below it by then
GROWTH_TOLERANCE = 0.1  # measured growth against the frozen eigenvalues' mean


@dataclass(frozen=True)
class Threshold:
    """Where a mesh mode turns unstable in contact.

    zeta: 0 if nowhere; frequency_Hz, growth_per_s: of the mode there; undamped_growth_per_s: of the
    least stable mode without damping.
    """

    point: Point
    zeta: float
    frequency_Hz: float
    undamped_growth_per_s: float
    growth_per_s: float

    @property
    def elbow_deg(self) -> float:
        """The pose."""
        return float(np.degrees(self.point.elbow_rad))

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        point = self.point
        name = "/".join(
            [
                point.arm,
                f"elbow {self.elbow_deg:g}",
                f"P {point.gains[0]:g} D {point.gains[1]:g}",
                f"k {point.stiffness:g}",
                point.sensed,
            ]
        )
        return {
            "id": f"controller/threshold/{name}",
            "arm": point.arm,
            "elbow_deg": self.elbow_deg,
            "P_N_m_per_rad": point.gains[0],
            "D_N_m_s_per_rad": point.gains[1],
            "stiffness_over_k_m": point.stiffness,
            "sensed": point.sensed,
            "zeta": self.zeta,
            "frequency_Hz": self.frequency_Hz,
            "undamped_growth_per_s": self.undamped_growth_per_s,
            "growth_at_threshold_per_s": self.growth_per_s,
        }


@dataclass(frozen=True)
class GrowthCheck:
    """A vibration's growth simulated and by the eigenvalues at its mean pose; None: not run."""

    zeta: float
    elbow_rad: float | None
    measured_per_s: float | None
    predicted_per_s: float | None
    frequency_Hz: float | None

    @property
    def elbow_deg(self) -> float | None:
        """The mean pose."""
        return None if self.elbow_rad is None else float(np.degrees(self.elbow_rad))

    @property
    def agrees(self) -> bool | None:
        """Whether it grows as predicted."""
        return growth_agrees(self.measured_per_s, self.predicted_per_s)

    @property
    def verdict(self) -> str:
        """In words."""
        return word(self.agrees, "agree", "differ")

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        return {
            "id": "controller/growth",
            "zeta": self.zeta,
            "elbow_deg": self.elbow_deg,
            "measured_per_s": self.measured_per_s,
            "predicted_per_s": self.predicted_per_s,
            "frequency_Hz": self.frequency_Hz,
            "verdict": self.verdict,
        }


@where_known
def growth_agrees(measured: float, predicted: float) -> bool:
    """Whether a simulated growth rate is the linear model's."""
    return abs(measured - predicted) <= GROWTH_TOLERANCE * abs(predicted)


@dataclass(frozen=True)
class Flutter:
    """The vibration that is left late in a simulated run: None where it ends before or diverges."""

    damping: str
    zeta: float
    tooth_error_m: float
    amplitude_rad_per_s2: float | None = None
    dominant_Hz: float | None = None
    diverged_s: float | None = None

    @property
    def flutters(self) -> bool | None:
        """Sustained vibration, or a run that did not survive it; None for one that ends before."""
        if self.diverged_s is not None:
            return True
        size = self.amplitude_rad_per_s2
        return None if size is None else size > FLUTTER_RAD_PER_S2

    @property
    def frequency_Hz(self) -> float | None:
        """Of a vibration that goes on."""
        return self.dominant_Hz if self.flutters else None

    def to_dict(self) -> dict[str, object]:
        """For JSON."""
        fields = asdict(self)
        del fields["dominant_Hz"]
        place = f"{self.damping}/zeta {self.zeta:g}/E {self.tooth_error_m:g}"
        return {
            "id": f"controller/flutter/{place}",
            **fields,
            "frequency_Hz": self.frequency_Hz,
            "flutters": self.flutters,
        }
