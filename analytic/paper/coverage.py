"""The arms to which the paper's own equations apply."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crosscheck.models.arm.arm import Arm

PAPER_COVERAGE = "needs two joints with three equal planets each, no gravity and no friction"


def is_covered_by_paper(arm: Arm) -> bool:
    """Whether Eqs. 16-22 cover an arm."""
    from crosscheck.models.arm.planets import (
        find_unlike_planets,  # its schema, for which no list waits
    )

    planets = [joint.planet_count for joint in arm.joints]
    rubbed = any(joint.friction_N_m_s_per_rad for joint in arm.joints)
    alike = next(find_unlike_planets(arm), None) is None
    return planets == [3, 3] and alike and not any(arm.gravity_m_per_s2) and not rubbed
