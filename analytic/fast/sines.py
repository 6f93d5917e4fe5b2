"""Sine and cosine of a phase in turns, by a polynomial: as text that a compiler can vectorise.

A turn is the natural unit: c - rint(c) is exact, where a phase in radians would be reduced with an
error of its own. Between a quarter of a turn before and after 0 the sine is r P(r^2), P
interpolated at the Chebyshev nodes of r^2: it errs by less than 4e-17 (tests recompute it).
"""

from __future__ import annotations

# P, constant part first.
SINE_OF_TURNS = (
    6.283185307179586,
    -41.341702240399755,
    81.60524927607362,
    -76.70585975282492,
    42.058693925428685,
    -15.0946416761179,
    3.8199280942271643,
    -0.7177337921413454,
    0.10089695501646812,
)
# Added and taken away again, it leaves the nearest whole number of anything below 2^51.
ROUNDING = 6755399441055744.0


def reduced(name: str, turns: str) -> list[str]:
    """Lines that set ``name``: the turns less their nearest whole number."""
    return [f"{name} = {turns}", f"{name} -= {name} + {ROUNDING!r} - {ROUNDING!r}"]


def cosine(name: str, turns: str, alone: bool) -> list[str]:
    """Lines that set ``name``: the sine of what the turns lack of a quarter.

    alone: nothing else is worked out meanwhile, and the shortest chain is the fastest; else the
    fewest operations.
    """
    r = f"{name}_r"
    polynomial = _pairs if alone else _nested
    return [*reduced(r, turns), f"{r} = 0.25 - abs({r})", *polynomial(name, r)]


def sine(name: str, turns: str, alone: bool) -> list[str]:
    """Lines that set ``name``: the cosine, a quarter of a turn later."""
    return cosine(name, f"{turns} - 0.25", alone)


def _nested(name: str, r: str) -> list[str]:
    """Horner's scheme."""
    u, (*low, highest) = f"{name}_u", SINE_OF_TURNS
    steps = [f"{name} = {name} * {u} + {value!r}" for value in reversed(low)]
    return [f"{u} = {r} * {r}", f"{name} = {highest!r}", *steps, f"{name} = {name} * {r}"]


def _pairs(name: str, r: str) -> list[str]:
    """By pairs of pairs, which a processor works on at a time."""
    u, u2, u4 = (f"{name}_u{power}" for power in ("", "2", "4"))
    pairs = [
        f"({low!r} + {high!r} * {u})"
        for low, high in zip(SINE_OF_TURNS[:-1:2], SINE_OF_TURNS[1::2], strict=True)
    ]
    whole = f"({pairs[0]} + {pairs[1]} * {u2}) + ({pairs[2]} + {pairs[3]} * {u2}) * {u4}"
    return [
        f"{u} = {r} * {r}",
        f"{u2} = {u} * {u}",
        f"{u4} = {u2} * {u2}",
        f"{name} = {r} * ({whole} + {SINE_OF_TURNS[-1]!r} * ({u4} * {u4}))",
    ]
