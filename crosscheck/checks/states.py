"""State by state: do two models give the same M, bias, force and acceleration?"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from crosscheck.checks.answers import Setting
from crosscheck.checks.scales import (
    EPS,
    PLACE_ROUNDINGS,
    ReasonedLimit,
    arm_reach,
    check_share,
    gear_arc,
    largest_stiffness,
)
from crosscheck.findings import Finding, Subject, make_failed_check, make_measurement

# Rounding of a few hundred operations, times how badly conditioned they are; but never looser
# than a tenth of a billionth.
ROUNDINGS = 1000
LOOSEST = 1e-10
TERM_ROUNDINGS = 5  # of each of the terms that cancel in a component: a product of some factors
# Quantities whose larger terms cancel, and the least rounding error of these terms.
CANCELLING = {
    "bias": f"{TERM_ROUNDINGS} eps of M (sum of w)^2 of the whole arm, moments that cancel",
    "generalized_force": "rounding of the forces of teeth, by the bodies' places and their moments",
    "acceleration": f"{TERM_ROUNDINGS} eps |M^-1| |M| |a|, and |M^-1| times the forces' rounding",
}


Judge = Callable[[Subject, np.ndarray, np.ndarray, np.ndarray | None, Setting], Finding]


def compare_values(
    about: Subject, left: np.ndarray, right: np.ndarray, masses: np.ndarray | None, setting: Setting
) -> Finding:
    """Check two models' values of a quantity at the same states, (count, n) or (count, n, n).

    Each component is measured against its own root mean square over the states, so that small
    components count as much as large ones. masses (count, n, n): usable mass matrices of either
    model at these states.
    """
    if masses is None:
        return make_failed_check(
            about, "no size to measure against: neither model has a usable mass matrix"
        )
    compared = relative_differences(about.key.quantity, left, right, masses, setting)
    return check_share(about, float(compared.values.max()), *compared.limit)


class RelativeDifferences(NamedTuple):
    """Differences of two models' values over their sizes, shaped as the values; what is allowed."""

    values: np.ndarray
    limit: ReasonedLimit


def relative_differences(
    quantity: str,
    left: np.ndarray,
    right: np.ndarray,
    masses: np.ndarray,
    setting: Setting,
    typical: np.ndarray | None = None,
) -> RelativeDifferences:
    """The differences that ``compare_values`` judges by the largest of them.

    Where a size is 0 they are not finite. typical: the values that have the sizes, if not left.
    """
    limit, typical = _tolerance(quantity, masses[0], setting), left if typical is None else typical
    size = _sizes(quantity, typical, masses[0], setting)
    if quantity in CANCELLING:
        least = _rounding(quantity, typical, masses, setting) / limit.value
        if (least > size).any():
            reason = f"{limit.basis}; or, where more, {CANCELLING[quantity]}"
            limit = limit._replace(basis=reason)
        size = np.maximum(size, least)
    with np.errstate(divide="ignore", invalid="ignore"):  # a size of 0 gives no number, so no check
        return RelativeDifferences(np.abs(left - right) / size, limit)


def measure_values(
    about: Subject, left: np.ndarray, right: np.ndarray, masses: np.ndarray | None, setting: Setting
) -> Finding:
    """Measure the difference that ``compare_values`` checks, for models known to differ."""
    finding = compare_values(about, left, right, masses, setting)
    if finding.measured is None:
        return finding
    return make_measurement(about, measured=finding.measured, relative=finding.relative)


def is_usable(mass: np.ndarray) -> bool:
    """Whether sizes can be taken from a mass matrix (n, n): its diagonal is positive."""
    return bool((np.diag(mass) > 0).all())


def component_sizes(values: np.ndarray, natural: np.ndarray) -> np.ndarray:
    """Root mean square of each component, (n,), of values (count, n).

    A component that vanishes at all states (no centrifugal force on a mesh, none at all on an arm
    of one joint) has no size of its own: it gets its natural one.
    """
    rms = np.sqrt((values**2).mean(axis=0))
    return np.where(rms > ROUNDINGS * EPS * natural, rms, natural)


def natural_sizes(
    quantity: str, values: np.ndarray, inertia: np.ndarray, setting: Setting
) -> np.ndarray:
    """Sizes that the arm's inertia and motion give to each component, (n,).

    With m the diagonal of M and w the joint rates: a centrifugal force is of size sqrt(m_i m) w^2,
    m the largest of the joints'; a force of size sqrt(m_i) and an acceleration of 1 / sqrt(m_i)
    times what the model's other components share.
    """
    diagonal = np.diag(inertia)
    angular = setting.layout.angular
    if quantity == "bias":
        rates = setting.states.v[:, angular]
        return np.sqrt(diagonal * diagonal[angular].max()) * float((rates**2).mean())
    weight = np.sqrt(diagonal) if quantity == "generalized_force" else 1 / np.sqrt(diagonal)
    shared = float(np.sqrt(((values / weight) ** 2).mean()))
    return weight * (shared or 1.0)


def _sizes(quantity: str, values: np.ndarray, inertia: np.ndarray, setting: Setting) -> np.ndarray:
    """Sizes that differences of values are measured against, (n,); of M_ij sqrt(M_ii M_jj)."""
    if quantity == "mass_matrix":
        diagonal = np.sqrt(np.abs(np.einsum("kii->ki", values)))
        return diagonal[:, :, None] * diagonal[:, None, :]
    return component_sizes(values, natural_sizes(quantity, values, inertia, setting))


def _rounding(
    quantity: str, values: np.ndarray, masses: np.ndarray, setting: Setting
) -> np.ndarray:
    """Rounding error of each component, (n,), whose terms cancel, however small their sum.

    If links have similar lengths, that is less than the tolerance of the sum, and is not counted.

    An acceleration is solved for, which rounds |M^-1| |M| |a| and |M^-1| times what the force does
    (Skeel's bound). Of the others see ``bias_rounding`` and ``_force_rounding``.
    """
    if quantity == "bias":
        return bias_rounding(masses[0], setting)
    if quantity == "generalized_force":
        return _force_rounding(values, setting)
    scale = 1 / np.sqrt(np.abs(np.einsum("kii->ki", masses)))
    inverses = np.abs(np.linalg.pinv(scale_mass_matrix(masses)))
    inverses *= scale[:, :, None] * scale[:, None, :]
    summed = TERM_ROUNDINGS * setting.rounding * np.abs(masses) @ np.abs(values)[:, :, None]
    felt = np.where(setting.layout.angular, 0.0, inverses @ _position_rounding(setting))
    # No position does work on the angles; of the pose in which M is worst conditioned.
    return np.asarray(((inverses @ summed)[:, :, 0] + felt).max(axis=0))


def bias_rounding(inertia: np.ndarray, setting: Setting) -> np.ndarray:
    """Rounding error of each component of a bias, (n,).

    Centrifugal forces point at a joint for the most part, and a body's momentum along its velocity:
    moments of the size of the whole arm's kinetic energy cancel about every joint, however little
    is left of them about a light outer link. Christoffel's symbols difference all of M as well.
    Bodies turn with the sum of the joints' rates w.
    """
    diagonal, angular = np.diag(inertia), setting.layout.angular
    turning = np.abs(setting.states.v[:, angular]).sum(axis=1)
    largest = diagonal[angular].max()
    inertias = np.where(angular, largest, np.sqrt(diagonal * largest))
    return TERM_ROUNDINGS * setting.rounding * inertias * float((turning**2).mean())


def _force_rounding(values: np.ndarray, setting: Setting) -> np.ndarray:
    """Rounding error of each component of a force, (n,).

    Mesh forces do no work on the joint angles. In a model that lets them act on bodies their
    moments cancel there, and leave roundings of their size, however small the motors' torques.
    """
    angular = setting.layout.angular
    forces = np.sqrt((values[:, ~angular] ** 2).mean(axis=0)).max(initial=0.0)
    cancelling = np.where(angular, forces * gear_arc(setting.arm), 0.0)
    return np.maximum(ROUNDINGS * EPS * cancelling, _position_rounding(setting))


def _position_rounding(setting: Setting) -> np.ndarray:
    """Error of tooth forces [N] by rounding of bodies' positions, (n,), 0 on the angles.

    A mesh that is found from places on the ground is known to a rounding of the arm's reach.
    """
    together = max((joint.planet_count for joint in setting.arm.joints), default=0)
    stiffest = together * largest_stiffness(setting.arm)
    placed = PLACE_ROUNDINGS * setting.rounding * arm_reach(setting.arm)
    return np.where(setting.layout.angular, 0.0, placed * stiffest)


def _tolerance(quantity: str, inertia: np.ndarray, setting: Setting) -> ReasonedLimit:
    """Relative tolerance of a quantity: rounding times how badly conditioned it is."""
    conditioning, reason, angular = 1.0, "1", setting.layout.angular
    if quantity in ("generalized_force", "acceleration"):
        if not angular.all():
            # A mesh displacement is a small difference of large arcs, in a model that turns gears.
            q = setting.states.q
            arcs = gear_arc(setting.arm) * np.abs(q[:, angular]).max()
            conditioning = float(arcs / np.sqrt((q[:, ~angular] ** 2).mean()))
        reason = f"{conditioning:.0f} (arcs of the gears against the play between their teeth)"
    if quantity == "acceleration":
        inverse = float(np.linalg.cond(scale_mass_matrix(inertia)))
        conditioning *= inverse
        reason += f" x {inverse:.0f} (scaled mass matrix)"
    basis = f"{ROUNDINGS} eps x conditioning {reason}, at most {LOOSEST:g}"
    return ReasonedLimit(min(LOOSEST, ROUNDINGS * EPS * conditioning), basis)


def scale_mass_matrix(inertia: np.ndarray) -> np.ndarray:
    """Mass matrices (..., n, n) with ones on their diagonals."""
    scale = 1 / np.sqrt(np.abs(np.einsum("...ii->...i", inertia)))
    return inertia * (scale[..., :, None] * scale[..., None, :])
