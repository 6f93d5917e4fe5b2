"""The paper's text, table, figures and symbols against themselves and first principles.

As in ``auxiliary``: each function returns an Erratum only where the two differ.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import xarray as xr

from crosscheck.analytic.derivation.symbols import geared_variables
from crosscheck.analytic.model import RigidCoupled
from crosscheck.analytic.paper.energies import JOINTS
from crosscheck.audit.errata import transcript
from crosscheck.audit.errata.erratum import Erratum
from crosscheck.audit.measures.rigid import RIGID_STEP_S
from crosscheck.audit.measures.stage import PaperStage, paper_stage
from crosscheck.models.arm.arm import Arm
from crosscheck.models.experiment.scenario import PdDrive
from crosscheck.models.loading import load_scenario

EXTREME_M = 6e-3  # Section 4.1's largest clearance
CONSIDERABLE = 0.05  # overshoot of a step; a well damped loop (damping ratio 0.7) has 4.6 %
NEARLY_ALWAYS = 0.95


def statement_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata outside the equations, for this arm."""
    stage = paper_stage(arm)
    yield from initial_values()
    yield from masses_and_inertias(stage)
    yield from ring_mass()
    yield from rod_or_bar(arm)
    yield from tooth_thickness(stage)
    yield from two_errors_at_the_tip(arm)
    yield from speeding_up(arm)
    yield from overshoot(arm)
    yield from damping_and_convergence(stage)
    yield from where_nothing_was_run()
    yield from unused_abbreviations()
    yield from symbols_used_twice()
    yield from quantities_with_two_symbols()
    yield from index_without_use()


def initial_values() -> Iterator[Erratum]:
    """As many initial values as first-order states."""
    printed = len(transcript.INITIAL_VALUES)
    derived = 2 * len(geared_variables(JOINTS).q)
    if printed != derived:
        yield Erratum(
            "initial-values",
            size=float(derived - printed),
            quoted={"printed": printed, "derived": derived},
        )


def masses_and_inertias(stage: PaperStage) -> Iterator[Erratum]:
    """Table I: no gear's mass can lie, on average, beyond its pitch circle."""
    joint, geometry = stage.joint, stage.geometry
    gears = {
        "sun": (stage.sun_equivalent_mass_kg, joint.sun_mass_kg, geometry.r_s, joint.sun_teeth),
        "planet": (
            stage.planet_equivalent_mass_kg,
            joint.planet_mass_kg,
            geometry.r_p,
            joint.planet_teeth,
        ),
    }
    for name, (equivalent, mass, base, teeth) in gears.items():
        pitch = joint.module_m * teeth / 2
        gyration = base * math.sqrt(equivalent / mass) if mass > 0 else math.inf
        if gyration > pitch:
            numbers = {"M": equivalent, "m": mass, "gyration": 1e3 * gyration, "pitch": 1e3 * pitch}
            size = float(gyration - pitch)
            yield Erratum(f"table-{name}", size=size, quoted=numbers)


def ring_mass() -> Iterator[Erratum]:
    """Table I gives the ring under M, m_j asks for it under m."""
    if "m_r2" in transcript.MADE_OF["m_j"]:
        yield Erratum("table-ring", size=1.0)


def rod_or_bar(arm: Arm) -> Iterator[Erratum]:
    """I_i of a slender rod against that of a square bar of the same cross-section."""
    link = arm.links[0]
    if link.cross_section_m2:
        share = link.cross_section_m2 / link.length_m**2
        numbers = {"percent": 100 * share}
        yield Erratum("rod-or-bar", size=share, quoted=numbers)


def tooth_thickness(stage: PaperStage) -> Iterator[Erratum]:
    """6 mm over the thickness of a tooth at the pitch circle, half a pitch."""
    share = EXTREME_M / (math.pi * stage.joint.module_m / 2)
    if not math.isclose(share, transcript.THICKNESS_SHARE, rel_tol=0.1):
        size = share - transcript.THICKNESS_SHARE
        yield Erratum("six-millimetres", size=size, quoted={"share": share})


def overshoot(arm: Arm) -> Iterator[Erratum]:
    """How far the gains of Section 3.2 carry the shoulder past its goal, gears rigid."""
    run = _rigid(arm, "pd")
    drive = load_scenario("pd").drive
    assert isinstance(drive, PdDrive)
    beyond = float(run["theta"].values[:, 0].max() / np.max(drive.target_rad) - 1)
    if beyond > CONSIDERABLE:
        numbers = {"percent": 100 * beyond}
        yield Erratum("overshoot", size=beyond, quoted=numbers)


def speeding_up(arm: Arm) -> Iterator[Erratum]:
    """Share of the constant torque's run in which the shoulder gets faster, gears rigid."""
    speed = np.abs(_rigid(arm, "constant-torque")["theta_dot"].values[:, 0])
    share = float((np.diff(speed) > 0).mean())
    if share < NEARLY_ALWAYS:
        numbers = {"percent": 100 * share}
        yield Erratum("speeding-up", size=share, quoted=numbers)


def _rigid(arm: Arm, scenario: str) -> xr.Dataset:
    """The rigid arm with all inertia of its gears, which shakes nowhere: theta is smooth."""
    update = {"step_s": RIGID_STEP_S, "record_every": 1}
    own = load_scenario(scenario).model_copy(update=update)
    return RigidCoupled(arm, own).simulate()


def two_errors_at_the_tip(arm: Arm) -> Iterator[Erratum]:
    """0.02 and 0.01 rad carried to the tip, the arm straight and bent to a right angle [m]."""
    inner, outer = (link.length_m for link in arm.links)
    first, second = transcript.DEVIATIONS_RAD
    straight, bent = (abs(first * inner + (first + second) * outer * turn) for turn in (1, 1j))
    if not math.isclose(straight, transcript.TIP_M, rel_tol=0.1):
        yield Erratum(
            "thirty-millimetres",
            size=straight - transcript.TIP_M,
            quoted={"straight": 1e3 * straight, "bent": 1e3 * bent},
        )


def damping_and_convergence(stage: PaperStage) -> Iterator[Erratum]:
    """Damping ends vibrations, not a clearance: times of decay to a tenth at two damping ratios."""
    slow, quick = (decay_s(stage, zeta) for zeta in (0.005, 0.05))
    if slow > quick:
        numbers = {"slow": 1e3 * slow, "quick": 1e3 * quick}
        for name in ("damping-converges", "clearance-converges"):
            yield Erratum(name, size=slow - quick, quoted=numbers)


def decay_s(stage: PaperStage, zeta: float) -> float:
    """Time in which the slowest mode of a stage, its carrier held, falls to a tenth."""
    count, k = stage.joint.planet_count, stage.mesh_stiffness_N_per_m
    sun, planets = stage.sun_equivalent_mass_kg, count * stage.planet_equivalent_mass_kg
    mass = np.array([[sun, sun], [sun, sun + planets]])
    stiffness = np.diag([count * k, count * k])
    damping = np.diag([2 * zeta * math.sqrt(count * k * m) for m in (sun, planets)])
    still, one = np.zeros((2, 2)), np.eye(2)
    states = np.block(
        [[still, one], [-np.linalg.solve(mass, stiffness), -np.linalg.solve(mass, damping)]]
    )
    return float(math.log(10) / -np.linalg.eigvals(states).real.max())


def where_nothing_was_run() -> Iterator[Erratum]:
    """Conclusions between and beyond the sizes that were simulated."""
    sizes = transcript.BACKLASHES_UM
    widest = max(larger / smaller for smaller, larger in pairwise(sizes))
    if widest > 2:
        yield Erratum("between-50-and-500", size=widest)
    least = min(transcript.TOOTH_ERRORS_UM)
    if least > transcript.QUIET_UM:
        size = least - transcript.QUIET_UM
        yield Erratum("below-1-um", size=size, quoted={"least": least})


def unused_abbreviations() -> Iterator[Erratum]:
    """What is abbreviated below Eq. 21 and named by no entry, directly or through another."""
    used, waiting = set[str](), list(transcript.ENTRIES)
    while waiting:
        name = waiting.pop()
        if name not in used:
            used.add(name)
            waiting += transcript.MADE_OF.get(name, ())
    # The two spellings of what turns with a link are an erratum of their own.
    for name in sorted(set(transcript.MADE_OF) - used - {"I_cip"}):
        yield Erratum(f"unused-{name}", size=1.0, quoted={"name": name})


def index_without_use() -> Iterator[Erratum]:
    """r_cip carries the joint's index, what it is made of does not."""
    if transcript.MADE_OF["r_cip"] == ("r_c",):
        yield Erratum("index-r_cip", size=1.0)


def symbols_used_twice() -> Iterator[Erratum]:
    """One symbol, several quantities."""
    for symbol, definitions in _grouped((d.symbol, d) for d in transcript.DEFINITIONS):
        quantities = list(dict.fromkeys(d.quantity for d in definitions))
        if len(quantities) > 1:
            yield Erratum(
                f"symbol-{symbol}",
                size=float(len(quantities)),
                quoted=_named(definitions, symbol, "; ".join(quantities)),
            )


def quantities_with_two_symbols() -> Iterator[Erratum]:
    """One quantity, several symbols."""
    for quantity, definitions in _grouped((d.quantity, d) for d in transcript.DEFINITIONS):
        symbols = list(dict.fromkeys(d.symbol for d in definitions))
        if len(symbols) > 1:
            yield Erratum(
                f"symbols-{'-'.join(symbols)}",
                size=float(len(symbols)),
                quoted=_named(definitions, quantity, ", ".join(symbols)),
            )


def _named(
    definitions: Iterable[transcript.SymbolDefinition], name: str, others: str
) -> dict[str, float | str]:
    return {"where": "; ".join(d.where for d in definitions), "name": name, "others": others}


def _grouped(
    named: Iterable[tuple[str, transcript.SymbolDefinition]],
) -> Iterable[tuple[str, list[transcript.SymbolDefinition]]]:
    """By name, in the order in which names first come."""
    groups: dict[str, list[transcript.SymbolDefinition]] = defaultdict(list)
    for name, definition in named:
        groups[name].append(definition)
    return groups.items()
