"""Steps of precise runs: beside SciPy's where no contact changes, and at its changes."""

from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp

from crosscheck.analytic.kernel import adaptive_kernel
from crosscheck.analytic.model import PhysicalModel, RigidLinks
from crosscheck.models.experiment.scenario import TableDrive
from crosscheck.models.loading import load_case
from tests.engines.scipy_runs import integrate_by_scipy

SMOOTH_RTOL = (1e-10, 1e-12)
# SciPy chooses its first step, and may lengthen one more; both are a few steps of a hundred.
FEWER, MORE = 0.9, 1.15


# How far from the right end a run may be under torques whose slopes jump, in tolerances: some 200.
KINKED_RTOL, OFF = 1e-9, 1000.0
IMPACTS_OFF = 100.0
# Differences of works from SciPy's over the largest: the rate of what is turned over has kinks,
# which error estimates do not see.
WORKS_OFF = 1e-8, 1e-4


def moving_arm(kinked: bool = False) -> RigidLinks:
    """A rigid arm for a second, of which the end alone is recorded: controlled, or by a table."""
    settings = ["scenario.duration_s=1.0", "scenario.step_s=1e-4", "scenario.record_every=10000"]
    arm, scenario, chosen = load_case("paper-labelled", "pd", {}, settings)
    if kinked:
        times = tuple(np.linspace(0.0, 1.0, 8))
        torques = np.random.default_rng(0).normal(scale=200.0, size=(2, 8))
        drive = TableDrive(kind="table", time_s=times, torque_N_m=tuple(map(tuple, torques)))
        scenario = scenario.model_copy(update={"drive": drive})
    return RigidLinks(arm, scenario, chosen)


@lru_cache
def scipys(rtol: float, kinked: bool = False) -> tuple[int, np.ndarray]:
    """Evaluations of SciPy's run at a tolerance, and the angles at its end."""
    model = moving_arm(kinked)
    n = len(model.layout)

    def rates(t: float, state: np.ndarray) -> np.ndarray:
        return np.concatenate([state[n:], model.acceleration(t, state[:n], state[n:])])

    start = np.concatenate(model.start())
    run = solve_ivp(rates, (0.0, 1.0), start, method="DOP853", rtol=rtol, atol=rtol)
    return int(run.nfev), run.y[:n, -1]


def wrong_steps() -> Iterator[str]:
    """A line for an end that is elsewhere, and for too many steps or too few."""
    for rtol in SMOOTH_RTOL:
        expected, end = scipys(rtol)
        found = adaptive_kernel.integrate_precisely(moving_arm(), rtol)
        if not np.allclose(found.records.q[-1], end, rtol=0, atol=10 * rtol):
            yield f"ends at {found.records.q[-1]}, must be {end}"
        if not FEWER * expected < found.evaluations < MORE * expected:
            yield f"{found.evaluations} evaluations where SciPy takes {expected}"
    found = adaptive_kernel.integrate_precisely(moving_arm(kinked=True), KINKED_RTOL)
    off = np.abs(found.records.q[-1] - scipys(1e-12, kinked=True)[1]).max() / KINKED_RTOL
    if not off < OFF:
        yield f"ends {off} tolerances off"


def wrong_impacts() -> Iterator[str]:
    """A line for a run through changes of contact that is off by more than its tolerance is for.

    A change found 1e-6 s too late puts displacements off by thousands of tolerances.
    """
    chosen = {"planets": "free", "mesh_work": "conservative"}
    settings = ["scenario.duration_s=0.02", "scenario.start.planet_ring_offset_m=-2e-5"]
    model = PhysicalModel(*load_case("planets-apart", "constant-torque", chosen, settings))
    found, best = (adaptive_kernel.integrate_precisely(model, rtol) for rtol in (1e-11, 1e-13))
    off = np.abs(found.records.q - best.records.q).max() / 50e-6 / 1e-11
    if best.changes < 5 or not off < IMPACTS_OFF:
        yield f"{best.changes} changes; {off} tolerances off"


def wrong_works() -> Iterator[str]:
    """A line for each work of a short reference run that is not SciPy's."""
    settings = ["scenario.duration_s=0.004", "scenario.start.planet_ring_offset_m=-2e-5"]
    model = PhysicalModel(*load_case("paper-labelled", "pd", {}, settings))
    run = adaptive_kernel.integrate_reference(model, model.term_equations, 1e-11)
    return compare_works(run.works, integrate_by_scipy(model, 1e-11)[1])


def compare_works(works: np.ndarray, expected: np.ndarray) -> Iterator[str]:
    """A line for each of the works (records, 2) of a run that is not as expected."""
    off = np.abs(works - expected).max(axis=0) / np.abs(expected).max(axis=0)
    for name, share, allowed in zip(("done", "turned over"), off, WORKS_OFF, strict=True):
        if not share <= allowed:
            yield f"work {name} is off by {share} of the largest"
