"""The paper's text, table, figures and symbols against themselves and first principles.

As in ``auxiliary``: each function yields an Erratum only where the two differ.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import xarray as xr

from crosscheck.analytic.derivation.symbols import geared_variables
from crosscheck.analytic.model import RigidCoupled
from crosscheck.analytic.paper.energies import JOINTS
from crosscheck.audit.errata import transcript
from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.measures.rigid import RIGID_STEP_S
from crosscheck.audit.measures.stage import PaperStage, paper_stage, thickness_share, tip_shift
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import PdDrive
from crosscheck.models.loading import load_scenario

CONSIDERABLE = 0.05  # overshoot of a step; a well damped loop (damping ratio 0.7) has 4.6 %
NEARLY_ALWAYS = 0.95


def find_statement_errata(arm: Arm) -> Iterator[Erratum]:
    """Every erratum outside the equations, for this arm."""
    stage = paper_stage(arm)
    yield from find_initial_value_errata()
    yield from find_mass_errata(stage)
    if "m_r2" in transcript.MADE_OF["m_j"]:  # Table I gives the ring under M, m_j asks for m
        yield Erratum("table-ring", size=1.0)
    link = arm.links[0]
    if link.cross_section_m2:  # I_i of a slender rod against that of a square bar
        share = link.cross_section_m2 / link.length_m**2
        yield Erratum("rod-or-bar", size=share, quoted={"percent": 100 * share})
    share = thickness_share(stage)
    if not math.isclose(share, transcript.THICKNESS_SHARE, rel_tol=0.1):
        size = share - transcript.THICKNESS_SHARE
        yield Erratum("six-millimetres", size=size, quoted={"share": share})
    yield from find_tip_errata(arm)
    yield from find_speed_errata(arm)
    yield from find_overshoot_errata(arm)
    # Damping ends vibrations: times of decay to a tenth at two damping ratios.
    slow, quick = (decay_s(stage, zeta) for zeta in (0.005, 0.05))
    if slow > quick:
        numbers = {"slow": 1e3 * slow, "quick": 1e3 * quick}
        yield Erratum("damping-converges", size=slow - quick, quoted=numbers)
    yield from find_extrapolation_errata()
    yield from find_unused_abbreviations()
    yield from find_ambiguous_symbols()


def find_initial_value_errata() -> Iterator[Erratum]:
    """Erratum if the paper does not give as many initial values as there are first-order states."""
    printed = len(transcript.INITIAL_VALUES)
    derived = 2 * len(geared_variables(JOINTS).q)
    if printed != derived:
        numbers = {"printed": printed, "derived": derived}
        yield Erratum("initial-values", size=float(derived - printed), quoted=numbers)


def find_mass_errata(stage: PaperStage) -> Iterator[Erratum]:
    """Errata of Table I: no gear's mass can lie, on average, beyond its pitch circle."""
    joint, geometry = stage.joint, stage.geometry
    sun = stage.sun_equivalent_mass_kg, joint.sun_mass_kg, geometry.r_s, joint.sun_teeth
    planet_masses = stage.planet_equivalent_mass_kg, joint.planet_mass_kg
    planet = *planet_masses, geometry.r_p, joint.planet_teeth
    for name, (equivalent, mass, base, teeth) in {"sun": sun, "planet": planet}.items():
        pitch = joint.module_m * teeth / 2
        gyration = base * math.sqrt(equivalent / mass) if mass > 0 else math.inf
        if gyration > pitch:
            numbers = {"M": equivalent, "m": mass, "gyration": 1e3 * gyration, "pitch": 1e3 * pitch}
            yield Erratum(f"table-{name}", size=float(gyration - pitch), quoted=numbers)


def find_overshoot_errata(arm: Arm) -> Iterator[Erratum]:
    """Erratum if the gains of Section 3.2 carry the shoulder far past its goal, gears rigid."""
    run = _run_rigid_arm(arm, "pd")
    drive = load_scenario("pd").drive
    assert isinstance(drive, PdDrive)
    beyond = float(run["theta"].values[:, 0].max() / np.max(drive.target_rad) - 1)
    if beyond > CONSIDERABLE:
        yield Erratum("overshoot", size=beyond, quoted={"percent": 100 * beyond})


def find_speed_errata(arm: Arm) -> Iterator[Erratum]:
    """Erratum if the shoulder gets faster in too small a share of the constant torque's run."""
    speed = np.abs(_run_rigid_arm(arm, "constant-torque")["theta_dot"].values[:, 0])
    share = float((np.diff(speed) > 0).mean())
    if share < NEARLY_ALWAYS:
        yield Erratum("speeding-up", size=share, quoted={"percent": 100 * share})


def _run_rigid_arm(arm: Arm, scenario: str) -> xr.Dataset:
    """Run of the rigid arm with all inertia of its gears, which shakes nowhere: theta is smooth."""
    update = {"step_s": RIGID_STEP_S, "record_every": 1}
    smooth_scenario = load_scenario(scenario).model_copy(update=update)
    return RigidCoupled(arm, smooth_scenario).simulate()


def find_tip_errata(arm: Arm) -> Iterator[Erratum]:
    """Erratum if 0.02 and 0.01 rad, carried to the tip of the straight arm, are not 0.03 m."""
    inner, outer = (link.length_m for link in arm.links)
    first, second = transcript.DEVIATIONS_RAD
    straight, bent = (tip_shift(arm, bend_deg) for bend_deg in (0.0, 90.0))
    if not math.isclose(straight, transcript.TIP_M, rel_tol=0.1):
        own = 1e3 * (first * inner + second * outer)
        numbers = {"straight": 1e3 * straight, "bent": 1e3 * bent, "own": own}
        yield Erratum("thirty-millimetres", size=straight - transcript.TIP_M, quoted=numbers)


def decay_s(stage: PaperStage, zeta: float) -> float:
    """Time [s] in which the slowest mode of a stage, its carrier held, falls to a tenth."""
    count, k = stage.joint.planet_count, stage.mesh_stiffness_N_per_m
    sun, planets = stage.sun_equivalent_mass_kg, count * stage.planet_equivalent_mass_kg
    mass = np.array([[sun, sun], [sun, sun + planets]])
    stiffness = np.diag([count * k, count * k])
    damping = np.diag([2 * zeta * math.sqrt(count * k * m) for m in (sun, planets)])
    still, identity = np.zeros((2, 2)), np.eye(2)
    states = np.block(
        [[still, identity], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]
    )
    return float(math.log(10) / -np.linalg.eigvals(states).real.max())


def find_extrapolation_errata() -> Iterator[Erratum]:
    """Errata of sizes that are called suitable or harmless and have none near that was run."""
    sizes = transcript.BACKLASHES_UM
    widest = max(larger / smaller for smaller, larger in pairwise(sizes))
    if widest > 2:
        yield Erratum("between-50-and-500", size=widest)
    least = min(transcript.TOOTH_ERRORS_UM)
    if least > transcript.QUIET_UM:
        yield Erratum("below-1-um", size=least - transcript.QUIET_UM, quoted={"least": least})


def find_unused_abbreviations() -> Iterator[Erratum]:
    """Erratum of abbreviations below Eq. 21 that no entry names, directly or through another."""
    used, waiting = set[str](), list(transcript.ENTRIES)
    while waiting:
        name = waiting.pop()
        if name not in used:
            used.add(name)
            waiting += transcript.MADE_OF.get(name, ())
    # The two spellings of what turns with a link are an erratum of their own.
    unused = sorted(set(transcript.MADE_OF) - used - {"I_cip"})
    if unused:
        numbers = {"names": " and ".join(unused)}
        yield Erratum("unused", size=float(len(unused)), quoted=numbers)


def find_ambiguous_symbols() -> Iterator[Erratum]:
    """Errata of symbols with several quantities, and of quantities with several symbols."""
    for kind, other, between in (("symbol", "quantity", "; "), ("quantity", "symbol", ", ")):
        groups: dict[str, list[transcript.SymbolDefinition]] = defaultdict(list)
        for definition in transcript.DEFINITIONS:
            groups[getattr(definition, kind)].append(definition)
        for name, definitions in groups.items():
            others = list(dict.fromkeys(getattr(entry, other) for entry in definitions))
            if len(others) > 1:
                quoted_texts = {
                    "where": "; ".join(entry.where for entry in definitions),
                    "name": name,
                }
                yield Erratum(
                    f"symbol-{name}" if kind == "symbol" else f"symbols-{'-'.join(others)}",
                    size=float(len(others)),
                    quoted={**quoted_texts, "others": between.join(others)},
                )
