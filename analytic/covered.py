"""Which arms the paper's own equations are about."""

from __future__ import annotations

from models.arm import Arm, Planetary

PAPERS_KIND = "needs two joints with three planets each, no gravity and no friction"


def papers_kind(arm: Arm) -> bool:
    """Whether Eqs. 16-22 cover it."""
    geared = [joint for joint in arm.joints if isinstance(joint, Planetary)]
    planets = [joint.planet_count for joint in arm.joints]
    still = not any(arm.gravity_m_per_s2) and not any(j.friction_N_m_s_per_rad for j in geared)
    return planets == [3, 3] and still
