"""The generalized force of the reference in terms, in the coordinates q of a layout."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np

from crosscheck.analytic.derivation.bodies import Body
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.efforts import drive_rows, mesh_rows
from crosscheck.analytic.derivation.gears import gears
from crosscheck.analytic.derivation.lagrange import weight_terms
from crosscheck.analytic.paper.mesh_force import in_contact, mesh_force, phase_force
from crosscheck.analytic.paper.mesh_frequency import mesh_phase
from crosscheck.analytic.paper.stiffness import stiffness, stiffness_slope
from crosscheck.analytic.paper.tooth_error import whole_error
from crosscheck.models.arm.arm import Arm, Planetary
from crosscheck.models.arm.layout import MESHES, Layout
from crosscheck.models.experiment.scenario import Switches
from crosscheck.trial.diagnose.polynomial import TermKey, symbol
from crosscheck.trial.diagnose.values import damper_name

Columns = Mapping[str, np.ndarray]  # signals by name, (K,) each


class Forces(NamedTuple):
    """driven: coefficient by row and key; damped: (row, rate, coefficient) on rates of q."""

    driven: Mapping[tuple[int, TermKey], Any]
    damped: Sequence[tuple[int, int, Any]]


class ForcedMesh(NamedTuple):
    """A mesh with a force of its own: its joint (from 0), planet (from 0), and names.

    force, damper, work: signals; damping: symbol of its damping, of ``planets`` together.
    """

    joint: int
    planet: int
    pair: str
    force: str
    damper: str
    work: str
    damping: str
    planets: int


def rate_name(coordinate: str) -> str:
    """The signal that is a coordinate's rate."""
    return f"{coordinate}'"


def named_meshes(arm: Arm, layout: Layout) -> list[ForcedMesh]:
    """In the order of crosscheck.analytic.derivation.gears."""
    found = []
    for place in layout.meshing:
        joint, number = arm.joints[place], place + 1
        assert isinstance(joint, Planetary)  # as joints with mesh displacements are
        for planet in range(joint.planet_count if layout.free else 1):
            suffix = f"{number}_{planet + 1}" if layout.free else f"{number}"
            for pair in ("sp", "pr"):
                force, damper, work = (f"{kind}_{pair}{suffix}" for kind in "FDQ")
                own = damper_name(pair, joint, number, planet)
                count = joint.planet_count if layout.free else 1
                found.append(ForcedMesh(place, planet, pair, force, damper, work, own, count))
    return found


def forces(chain: Chain, bodies: Sequence[Body], arm: Arm, chosen: Switches) -> Forces:
    """Drive, meshes, dampers, friction and weight (see docs/explanation/equations.md)."""
    layout = chain.layout
    still = (0,) * len(chain.stages)
    driven: dict[tuple[int, TermKey], Any] = {}
    damped: list[tuple[int, int, Any]] = []
    for number, row in enumerate(drive_rows(chain), start=1):
        _add(driven, row, 1, TermKey(still, signal=f"T_{number}"))
    meshes = named_meshes(arm, layout)
    for mesh, row in zip(meshes, mesh_rows(chain), strict=True):
        _add(driven, row, 1, TermKey(still, signal=mesh.force))
        moved = layout.displacement(MESHES[mesh.pair == "pr"], mesh.joint, mesh.planet)
        damper = symbol(mesh.damping) * Fraction(-1, mesh.planets)
        moved = np.array([int(entry) for entry in moved], dtype=object)
        if chosen.damping == "contact":
            _add(driven, moved, damper, TermKey(still, signal=mesh.damper))
        else:
            places = np.flatnonzero(moved)
            damped += [
                (int(a), int(b), damper * moved[a] * moved[b]) for a in places for b in places
            ]
        if chosen.mesh_work == "conservative":
            theta = int(layout.theta[mesh.joint])
            driven[theta, TermKey(still, signal=mesh.work)] = 1
    for number, (joint, place) in enumerate(zip(arm.joints, layout.theta, strict=True), start=1):
        if joint.friction_N_m_s_per_rad:
            damped.append((int(place), int(place), -1 * symbol(f"c{number}")))
    driven |= _weight(chain, bodies, arm)
    return Forces(driven, damped)


def _add(
    driven: dict[tuple[int, TermKey], Any], row: np.ndarray, factor: Any, key: TermKey
) -> None:
    for place in np.flatnonzero(row):
        driven[int(place), key] = factor * row[place]


def _weight(chain: Chain, bodies: Sequence[Body], arm: Arm) -> dict[tuple[int, TermKey], Any]:
    """Cosines and sines of link angles."""
    pull = [
        symbol(f"g_{axis}") if g else 0 for axis, g in zip("xy", arm.gravity_m_per_s2, strict=True)
    ]
    if not any(pull):
        return {}
    found: defaultdict[tuple[int, TermKey], Any] = defaultdict(lambda: 0)
    weight = weight_terms(bodies, chain.angles[1:], (pull[0], pull[1]))
    for (row, wave), pair in weight.items():
        turned = tuple(wave[place] for place in chain.layout.theta)
        for function, coefficient in zip(("cos", "sin"), pair, strict=True):
            if coefficient:
                found[row, TermKey(turned, function)] += coefficient
    return dict(found)


class ForceStates(NamedTuple):
    """Where forces are asked for: t (K,), q and v (K, n) of the layout, torque (K, joints)."""

    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    torque: np.ndarray


class Phases(NamedTuple):
    """How mesh phases are counted: by absolute link angles; faster by factors (meshes,) or one."""

    absolute: bool = False
    faster: np.ndarray | float = 1.0


USUAL = Phases()


def signal_columns(
    arm: Arm, layout: Layout, chosen: Switches, states: ForceStates, phases: Phases = USUAL
) -> Columns:
    """Output torques [N m], forces of a planet's meshes [N], and the dampers' rates [m/s].

    Those of the user's rates are the caller's: ``rate_name`` of each coordinate.
    """
    found = {f"T_{j + 1}": states.torque[:, j] for j in range(states.torque.shape[1])}
    data, meshes = gears(arm, layout, chosen), named_meshes(arm, layout)
    clock, q, v = states.t[:, None], states.q, states.v
    of_two = data.less >= 0
    x, rate = (each[:, data.where] - of_two * each[:, data.less] for each in (q, v))
    turned = np.array((q, v))
    if phases.absolute:
        turned[:, :, layout.theta] = turned[:, :, layout.theta].cumsum(axis=2)
    phase = mesh_phase(
        data.phase, data.rate * phases.faster, data.offset, clock, *turned[:, :, data.theta]
    )
    gap = x - whole_error(phase, data.E, data.lead, data.static)
    touching = in_contact(gap, data.b) | data.damps_apart
    for i, mesh in enumerate(meshes):
        k = stiffness(data.law, i, phase[:, i], data.k_m[i], data.k_a[i])
        found[mesh.force] = mesh_force(data.dead_zone, gap[:, i], k, data.b[i], data.sigma[i])
        if chosen.damping == "contact":
            found[mesh.damper] = np.where(touching[:, i], rate[:, i], 0.0)
        if chosen.mesh_work == "conservative":
            slopes = (
                stiffness_slope(data.law, i, phase[:, i], data.k_a[i]),
                data.E[i] * np.cos(phase[:, i] + data.lead[i]),
            )
            on_phase = phase_force(gap[:, i], k, *slopes, data.b[i])
            found[mesh.work] = data.planets[i] * data.rate[i] * on_phase
    return found
