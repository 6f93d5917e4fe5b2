"""What decides H1: the tooth error's part of the third fluctuation exists only under `omega_t`."""

from __future__ import annotations

from collections.abc import Mapping

from crosscheck.audit.phase.maps import Presence

UNDEFINED = "undefined"


def h1_verdict(maps: Presence, supports: Mapping[str, bool | None]) -> str:
    """`holds` if the simulations say so and no kind of evidence that was run speaks against it.

    maps: where the tooth error makes a fluctuation; supports: the other kinds of evidence.
    """
    if maps == Presence.UNKNOWN:
        return UNDEFINED
    if maps != Presence.PRINTED:
        return "does not hold"
    for answer, but in ((False, "not"), (None, UNDEFINED)):
        names = [name for name, supported in supports.items() if supported is answer]
        if names:
            return f"holds in the simulations, but {but} in: {', '.join(names)}"
    return "holds"
