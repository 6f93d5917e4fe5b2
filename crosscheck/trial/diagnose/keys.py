"""Terms of an entry: a product of an arm's quantities before a wave and a signal."""

from __future__ import annotations

from typing import NamedTuple

from crosscheck.trial.diagnose.polynomial import Monomial

Wave = tuple[int, ...]  # whole multiples of the joint angles of q, the first one positive


class TermKey(NamedTuple):
    """What a coefficient stands before: a signal times the cosine or sine of a joint angle sum.

    function ``cos`` of wave 0 is 1. signal: '' (none), an output torque ``T_1``, a mesh force of a
    planet ``F_sp1`` (``F_sp1_2``: planet 2), a rate of the user's ``phi_1'``, a damper's rate in
    contact ``D_sp1``, what springs do to an angle ``Q_sp1``.
    """

    wave: Wave
    function: str = "cos"
    signal: str = ""


class Product(NamedTuple):
    """A term of an entry: number * powers of symbols, before a key."""

    key: TermKey
    monomial: Monomial

    @property
    def symbols(self) -> tuple[str, ...]:
        """That it has."""
        return tuple(name for name, _ in self.monomial.powers)


Entry = tuple[Product, ...]
