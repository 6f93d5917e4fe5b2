"""The rigid baseline of Eq. 1 at four levels, by the same Lagrange derivation.

`links` is the paper's rigid arm; each further level adds what the gears bring along rigidly.
"""

from __future__ import annotations

from crosscheck.analytic.derivation.bodies import Body, carried_bodies, link_bodies, spinning_bodies
from crosscheck.analytic.derivation.chain import Chain
from crosscheck.analytic.derivation.stage import Stage


def rigid_bodies(chain: Chain, level: str) -> list[Body]:
    """Bodies that a rigid level counts."""
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
