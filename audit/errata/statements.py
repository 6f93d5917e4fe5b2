"""The paper's text, table, figures and symbols against themselves and first principles.

As in ``auxiliary``: each function returns an Erratum only where the two differ.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from analytic.derivation.symbols import geared_variables
from analytic.paper.energies import JOINTS
from audit.errata import transcript
from audit.errata.erratum import Erratum
from audit.measures.stage import PaperStage, paper_stage
from models.arm.arm import Arm
from models.experiment.scenario import PdDrive
from models.loading import load_scenario

EXTREME_M = 6e-3  # Section 4.1's largest clearance


def statement_errata(arm: Arm) -> Iterator[Erratum]:
    """Errata outside the equations, for this arm."""
    stage = paper_stage(arm)
    yield from initial_values()
    yield from masses_and_inertias(stage)
    yield from ring_mass()
    yield from rod_or_bar(arm)
    yield from tooth_thickness(stage)
    yield from torque_and_acceleration()
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
            "count",
            size=float(derived - printed),
            unit="values",
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
            yield Erratum(f"table-{name}", "table", size=size, unit="m", quoted=numbers)


def ring_mass() -> Iterator[Erratum]:
    """Table I gives the ring under M, m_j asks for it under m."""
    if "m_r2" in transcript.MADE_OF["m_j"]:
        yield Erratum("table-ring", "table", size=1.0, unit="values missing")


def rod_or_bar(arm: Arm) -> Iterator[Erratum]:
    """I_i of a slender rod against that of a square bar of the same cross-section."""
    link = arm.links[0]
    if link.cross_section_m2:
        share = link.cross_section_m2 / link.length_m**2
        numbers = {"percent": 100 * share}
        yield Erratum("rod-or-bar", "text", size=share, unit="of I_1", quoted=numbers)


def tooth_thickness(stage: PaperStage) -> Iterator[Erratum]:
    """6 mm over the thickness of a tooth at the pitch circle, half a pitch."""
    share = EXTREME_M / (math.pi * stage.joint.module_m / 2)
    if not math.isclose(share, transcript.THICKNESS_SHARE, rel_tol=0.1):
        size = share - transcript.THICKNESS_SHARE
        yield Erratum(
            "six-millimetres", "text", size=size, unit="tooth thicknesses", quoted={"share": share}
        )


def torque_and_acceleration() -> Iterator[Erratum]:
    """Eq. 23 for a vibration of the acceleration: D times the speed, a quarter period ahead."""
    drive = load_scenario("pd").drive
    assert isinstance(drive, PdDrive)
    rate = 2 * math.pi * transcript.FLUCTUATION_HZ
    gains = (
        float(np.max(drive.proportional_N_m_per_rad)),
        float(np.max(drive.derivative_N_m_s_per_rad)),
    )
    answer = -complex(gains[0], rate * gains[1]) / (1j * rate) ** 2  # torque over acceleration
    lead = math.degrees(float(np.angle(answer)))
    yield Erratum(
        "torque-follows",
        "text",
        size=abs(answer) * transcript.FLUCTUATION_RAD_S2,
        unit="N m",
        quoted={"lead": lead, "frequency": transcript.FLUCTUATION_HZ},
    )


def damping_and_convergence(stage: PaperStage) -> Iterator[Erratum]:
    """Damping ends vibrations: the times of decay to a tenth at two damping ratios."""
    slow, quick = (decay_s(stage, zeta) for zeta in (0.005, 0.05))
    if slow > quick:
        numbers = {"slow": 1e3 * slow, "quick": 1e3 * quick}
        yield Erratum("damping-converges", "text", size=slow - quick, unit="s", quoted=numbers)


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
        yield Erratum(
            "between-50-and-500", "text", size=widest, unit="times from one run to the next"
        )
    least = min(transcript.TOOTH_ERRORS_UM)
    if least > transcript.QUIET_UM:
        size = least - transcript.QUIET_UM
        yield Erratum("below-1-um", "text", size=size, unit="um", quoted={"least": least})


def unused_abbreviations() -> Iterator[Erratum]:
    """What is abbreviated below Eq. 21 and named by no entry, directly or through another."""
    used, waiting = set[str](), list(transcript.ENTRIES)
    while waiting:
        name = waiting.pop()
        if name not in used:
            used.add(name)
            waiting += transcript.MADE_OF.get(name, ())
    # The two spellings of what turns with a link are one slip of their own.
    for name in sorted(set(transcript.MADE_OF) - used - {"I_cip"}):
        yield Erratum(
            f"unused-{name}",
            "symbol",
            size=1.0,
            unit="symbols",
            quoted={"name": name},
        )


def index_without_use() -> Iterator[Erratum]:
    """r_cip carries the joint's index, what it is made of does not."""
    if transcript.MADE_OF["r_cip"] == ("r_c",):
        yield Erratum("index-r_cip", "symbol", size=1.0, unit="index")


def symbols_used_twice() -> Iterator[Erratum]:
    """One symbol, several quantities."""
    for symbol, definitions in _grouped((d.symbol, d) for d in transcript.DEFINITIONS):
        quantities = list(dict.fromkeys(d.quantity for d in definitions))
        if len(quantities) > 1:
            yield Erratum(
                f"symbol-{symbol}",
                "symbol",
                size=float(len(quantities)),
                unit="quantities",
                quoted=_named(definitions, symbol, "; ".join(quantities)),
            )


def quantities_with_two_symbols() -> Iterator[Erratum]:
    """One quantity, several symbols."""
    for quantity, definitions in _grouped((d.quantity, d) for d in transcript.DEFINITIONS):
        symbols = list(dict.fromkeys(d.symbol for d in definitions))
        if len(symbols) > 1:
            yield Erratum(
                f"symbols-{'-'.join(symbols)}",
                "symbol",
                size=float(len(symbols)),
                unit="symbols",
                quoted=_named(definitions, quantity, ", ".join(symbols)),
            )


def _named(
    definitions: Iterable[transcript.Definition], name: str, others: str
) -> dict[str, float | str]:
    return {"where": "; ".join(d.where for d in definitions), "name": name, "others": others}


def _grouped(
    named: Iterable[tuple[str, transcript.Definition]],
) -> Iterable[tuple[str, list[transcript.Definition]]]:
    """By name, in the order in which names first come."""
    groups: dict[str, list[transcript.Definition]] = defaultdict(list)
    for name, definition in named:
        groups[name].append(definition)
    return groups.items()
