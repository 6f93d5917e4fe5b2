"""Which simulations stand behind which figure, and every choice that the paper leaves open."""

from __future__ import annotations

from crosscheck.paper.rigid import rigid_model
from crosscheck.studies.study import Variant

LAWS = {"omega_t": "omega_t, ring rate as Eq. 13", "angle": "angle"}
# The paper gives no damping. At the smaller value its third fluctuation shows under omega_t.
ZETA, LOW_ZETA = 0.05, 0.005
QUICK_LEVELS = ("links", "coupled")

BACKLASHES_UM = (5.0, 10.0, 25.0, 50.0, 500.0, 1000.0, 3000.0)  # Section 4.1
ERRORS_UM = (1.6, 3.2, 5.0, 6.3)  # Section 4.2
QUICK_BACKLASHES_UM = (50.0, 500.0)
DRIVEN_UM = (5.0, 50.0, 500.0, 3000.0)  # Fig. 15; the paper does not say which
PROPORTIONAL = (500, 1000, 2000)  # Fig. 10, with D = 400; only 1000 is the paper's
DERIVATIVE = (200, 400, 800)  # with P = 1000; only 400 is the paper's
GAINS = (1000, 400)  # Section 3.2
# As long as Fig. 14.
SHORT_S = 1.2
GAIN_STEP_S = 5e-5  # enough for angles that are drawn
SMOOTH_RECORD = 20  # 0.2 ms: for angles and speeds, which have nothing at mesh frequencies
FULL_RECORD = 1  # every step: no peak of a mesh force is cut


def torque_run(phase: str, zeta: float) -> Variant:
    """100 N m on both joints."""
    return Variant("constant-torque", phase=phase, zeta=zeta, record_every=FULL_RECORD)


def smooth_torque_run() -> Variant:
    """100 N m on both joints, for angles alone."""
    return Variant("constant-torque", zeta=ZETA, record_every=SMOOTH_RECORD)


def rigid_run(scenario: str, level: str, duration_s: float | None = None) -> Variant:
    """The rigid arm at a level, recorded on the grid of the smooth runs."""
    return Variant(
        scenario, model=rigid_model(level), duration_s=duration_s, record_every=SMOOTH_RECORD
    )


def control_run(phase: str) -> Variant:
    """The whole PD run."""
    return Variant(phase=phase, zeta=LOW_ZETA, record_every=FULL_RECORD)


def gain_run(proportional: float, derivative: float) -> Variant:
    """PD control with other gains, for angles alone."""
    settings = (
        f"scenario.step_s={GAIN_STEP_S!r}",
        f"scenario.drive.proportional_N_m_per_rad={float(proportional)!r}",
        f"scenario.drive.derivative_N_m_s_per_rad={float(derivative)!r}",
    )
    return Variant(zeta=ZETA, settings=settings, record_every=SMOOTH_RECORD)


def size_run(phase: str, backlash_um: float = 50.0, error_um: float = 5.0) -> Variant:
    """The PD run of Fig. 14's length with another backlash or tooth error [um]."""
    settings = (
        f"arm.joints.*.backlash_m={backlash_um}e-6",
        f"arm.joints.*.tooth_error_m={error_um}e-6",
    )
    return Variant(
        phase=phase,
        zeta=LOW_ZETA,
        duration_s=SHORT_S,
        meshes=settings,
        record_every=FULL_RECORD,
    )


def driven_run(backlash_um: float) -> Variant:
    """Back and forth, Section 4.1's torque as printed."""
    settings = (f"arm.joints.*.backlash_m={backlash_um}e-6",)
    return Variant("back-and-forth", zeta=ZETA, meshes=settings, record_every=SMOOTH_RECORD)


def backlash_run(phase: str, backlash_um: float) -> Variant:
    """A PD run of the backlash sweep."""
    return size_run(phase, backlash_um=backlash_um)


def error_run(phase: str, error_um: float) -> Variant:
    """A PD run of the tooth error sweep."""
    return size_run(phase, error_um=error_um)
