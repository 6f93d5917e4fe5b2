"""The bodies of an arm with their true absolute velocities.

They are those of Eqs. 16-19, for any number of joints; where the paper drops a velocity (the
elbow's planets share no rotation of link 1 in Eq. 18) the true one stands here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import DirectStage, Stage


@dataclass(frozen=True)
class Body:
    """A rigid body of a planar chain.

    mass [kg] and inertia [kg m^2] about its centre; angle: row of its absolute angle; centre: per
    link, the distance c_k [m] of its centre along that link (empty: on the base).
    """

    name: str
    mass: Any
    inertia: Any
    angle: np.ndarray
    centre: tuple[Any, ...] = ()


def build_bodies(chain: Chain) -> list[Body]:
    """Every body of the arm."""
    bodies = [body for joint in chain.numbers for body in link_bodies(chain, joint)]
    for joint in chain.numbers:
        bodies += carried_bodies(chain, joint) + spinning_bodies(chain, joint)
    return bodies


def link_bodies(chain: Chain, joint: int) -> list[Body]:
    """The link behind a joint, and the payload at the end of the last one (Eqs. 17, 19)."""
    stage, angle, origin = chain.stages[joint - 1], chain.angles[joint], chain.centre_of(joint)
    bodies = [Body(f"link {joint}", stage.m, stage.I_l, angle, (*origin, stage.d))]
    if joint == len(chain.stages):
        bodies.append(Body("payload", chain.payload, 0, angle, (*origin, stage.L)))
    return bodies


def carried_bodies(chain: Chain, joint: int) -> list[Body]:
    """Bodies that turn with the links at a joint, and the masses that it carries.

    The planets' centres, equally spaced on the carrier, act as their mass on the joint axis and
    as N m_p r_c^2 about it. A motor without gears is its mass and its rotor on the link.
    """
    stage, centre = chain.stages[joint - 1], chain.centre_of(joint)
    before, after = chain.angles[joint - 1], chain.angles[joint]
    if isinstance(stage, DirectStage):
        return [Body(f"motor {joint}", stage.m_m, stage.J_m, after, centre)]
    carrier = stage.M_c * stage.r_cp**2
    orbit = stage.N * stage.m_p * stage.r_c**2
    return [
        Body(f"ring {joint}", stage.m_r, stage.J_r, before, centre),
        Body(f"carrier {joint}", stage.m_c, carrier, after, centre),
        Body(f"planet centres {joint}", stage.N * stage.m_p, orbit, after, centre),
        Body(f"sun centre {joint}", stage.m_s, 0, before, centre),
    ]


def spinning_bodies(chain: Chain, joint: int) -> list[Body]:
    """Bodies of sun and planets that spin about their axes (masses are in `carried_bodies`)."""
    stage = chain.stages[joint - 1]
    if not isinstance(stage, Stage):
        return []
    base = chain.angles[joint - 1]
    sun, planet = stage.M_s * stage.r_s**2, stage.M_p * stage.r_p**2
    return [
        Body(f"sun {joint}", 0, sun, base + chain.sun_row(joint)),
        *(
            Body(f"planets {joint}", 0, count * planet, base - theta_p)
            for count, theta_p in chain.planet_rows(joint)
        ),
    ]


def rigid_bodies(chain: Chain, level: str) -> list[Body]:
    """Bodies that a level of the rigid baseline (Eq. 1) counts.

    `links` is the paper's rigid arm; each further level adds what the gears bring along rigidly.
    """
    bodies = [body for joint in chain.numbers for body in link_bodies(chain, joint)]
    for joint in chain.numbers if level != "links" else ():
        bodies += carried_bodies(chain, joint)
        if level == "coupled":
            bodies += spinning_bodies(chain, joint)
        if level == "armature":
            bodies += _armature_bodies(chain, joint)
    return bodies


def _armature_bodies(chain: Chain, joint: int) -> list[Body]:
    """Reflected inertia as a body, on the diagonal alone: as if the body before stood still."""
    stage = chain.stages[joint - 1]
    if not isinstance(stage, Stage):
        return []
    # a_1i of Eq. 21: sun and planets, geared to the carrier, as seen by the joint.
    inertia = (4 * stage.M_s + stage.N * stage.M_p) * stage.r_cp**2
    return [Body(f"armature {joint}", 0, inertia, chain.row("theta", joint))]
