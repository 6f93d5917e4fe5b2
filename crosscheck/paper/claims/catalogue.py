"""Every statement of the paper that asserts a number or a direction, in the paper's order."""

from __future__ import annotations

from crosscheck.paper.claims import abstract, section2, section3, section4, section5
from crosscheck.paper.claims.rule import Claim

CLAIMS: tuple[Claim, ...] = (
    *abstract.CLAIMS,
    *section2.CLAIMS,
    *section3.CLAIMS,
    *section4.CLAIMS,
    *section5.CLAIMS,
)
BY_ID = {claim.id: claim for claim in CLAIMS}
