"""What Figs. 11 to 14 and 16 to 20 are about, measured in one run."""

from __future__ import annotations

from dataclasses import dataclass

import xarray as xr

from crosscheck.paper.figures import control, measures, motion
from crosscheck.paper.figures.measures import Line
from crosscheck.paper.numbers import finite
from crosscheck.paper.reading import first_mesh
from crosscheck.paper.rigid import beside_coupled
from crosscheck.studies.study import Comparison, Numbers


@dataclass(frozen=True)
class Seen:
    """Numbers of a run, see the figures' own measures; of meshes: the shoulder's first planet.

    None where undefined, all but ``diverged_s`` in a run that diverged.
    """

    ripple_1_N_m: float | None = None
    ripple_2_N_m: float | None = None
    largest_1_N_m: float | None = None
    largest_2_N_m: float | None = None
    side_s: float | None = None
    back_s: float | None = None
    contact_s: float | None = None
    peak_N: float | None = None
    bouncing_s: float | None = None
    first_rad_per_s2: float | None = None
    second_rad_per_s2: float | None = None
    third_rad_per_s2: float | None = None
    force_swing_N: float | None = None
    line_Hz: float | None = None
    line_rad_per_s2: float | None = None
    prominence: float | None = None
    elbow_Hz: float | None = None
    elbow_rad_per_s2: float | None = None
    elbow_prominence: float | None = None
    diverged_s: float | None = None

    @classmethod
    def of(cls, numbers: Numbers) -> Seen:
        """From what the measure gave. Raises TypeError for a number of another name."""
        return cls(**numbers)

    @property
    def lines(self) -> list[Line]:
        """Of shoulder and elbow; nan where there is none."""
        shoulder = (self.line_Hz, self.line_rad_per_s2, self.prominence)
        elbow = (self.elbow_Hz, self.elbow_rad_per_s2, self.elbow_prominence)
        return [_line(shoulder), _line(elbow)]


def _line(numbers: tuple[float | None, ...]) -> Line:
    return Line(*(float("nan") if value is None else value for value in numbers))


def seen(run: xr.Dataset, others: tuple[xr.Dataset, ...]) -> Numbers:
    """The fields of ``Seen`` for a run; others: the rigid arm."""
    (rigid,) = others
    torques, sides = control.torques(run), control.sides(run)
    time, force = run["time"].values, first_mesh(run, "F_sp")
    impact, size = measures.impact(time, force), motion.fluctuations(run, rigid)
    shoulder, elbow = (measures.line(run, joint) for joint in (0, 1))
    return finite(
        {
            "ripple_1_N_m": torques.ripple_N_m[0],
            "ripple_2_N_m": torques.ripple_N_m[1],
            "largest_1_N_m": torques.largest_N_m[0],
            "largest_2_N_m": torques.largest_N_m[1],
            "side_s": sides.first_s,
            "back_s": sides.back_s,
            "contact_s": impact.contact_s,
            "peak_N": impact.peak_N,
            "bouncing_s": impact.bouncing_s,
            "first_rad_per_s2": size.first_rad_per_s2,
            "second_rad_per_s2": size.second_rad_per_s2,
            "third_rad_per_s2": size.third_rad_per_s2,
            "force_swing_N": measures.force_swing(run),
            "line_Hz": shoulder.frequency_Hz,
            "line_rad_per_s2": shoulder.size_rad_per_s2,
            "prominence": shoulder.prominence,
            "elbow_Hz": elbow.frequency_Hz,
            "elbow_rad_per_s2": elbow.size_rad_per_s2,
            "elbow_prominence": elbow.prominence,
        }
    )


SEEN = Comparison(seen, beside_coupled)
