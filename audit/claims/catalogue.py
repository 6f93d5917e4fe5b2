"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

from crosscheck.audit.claims.rule import Claim
from crosscheck.audit.claims.statements import (
    ablations,
    abstract,
    control,
    section2,
    section3,
    section4,
    section5,
)

CLAIMS: tuple[Claim, ...] = (
    *abstract.CLAIMS,
    *section2.CLAIMS,
    *section3.CLAIMS,
    *control.CLAIMS,
    *ablations.CLAIMS,
    *section4.CLAIMS,
    *section5.CLAIMS,
)
# Ids that no statement has any more, nor ever gets again, with the reason.
RETIRED: tuple[tuple[str, str], ...] = (*ablations.RETIRED, *section4.RETIRED)
BY_ID = {claim.id: claim for claim in CLAIMS}
