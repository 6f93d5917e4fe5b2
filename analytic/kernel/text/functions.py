"""Sine, cosine and hyperbolic tangent as lines of a kernel's text.

A turn is the natural unit of a phase: c - rint(c) is exact, where a phase in radians would be
reduced with an error of its own. Between a quarter of a turn before and after 0 the sine is
r P(r^2), P interpolated at the Chebyshev nodes of r^2: it errs by less than 4e-17 (tests recompute
it).
"""

from __future__ import annotations

import math

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
PER_LN2 = 1.4426950408889634
# ln 2 in two parts, the first with so few digits that a whole number of them is exact.
LN2_HIGH, LN2_LOW = 0.6931471803691238, 1.9082149292705877e-10
LARGEST = 20.0  # argument beyond which the hyperbolic tangent is 1 to all digits
# 1 / n! up to x^13 for |x| < ln 2 / 2: the rest is 4e-18.
EXPONENTIAL = tuple(1 / math.factorial(n) for n in range(14))


def reduce_turns(name: str, turns: str) -> list[str]:
    """Lines that set ``name`` to the turns less their nearest whole number."""
    return [f"{name} = {turns}", f"{name} -= rint({name})"]


def cosine(name: str, turns: str) -> list[str]:
    """Lines that set ``name`` to the cosine of turns, the sine of what they lack of a quarter.

    The polynomial is summed by pairs of pairs, which a processor works on at a time.
    """
    r = f"{name}_r"
    u, u2, u4 = (f"{name}_u{power}" for power in ("", "2", "4"))
    pairs = [
        f"({low!r} + {high!r} * {u})"
        for low, high in zip(SINE_OF_TURNS[:-1:2], SINE_OF_TURNS[1::2], strict=True)
    ]
    whole = f"({pairs[0]} + {pairs[1]} * {u2}) + ({pairs[2]} + {pairs[3]} * {u2}) * {u4}"
    return [
        *reduce_turns(r, turns),
        f"{r} = 0.25 - abs({r})",
        f"{u} = {r} * {r}",
        f"{u2} = {u} * {u}",
        f"{u4} = {u2} * {u2}",
        f"{name} = {r} * ({whole} + {SINE_OF_TURNS[-1]!r} * ({u4} * {u4}))",
    ]


def sine(name: str, turns: str) -> list[str]:
    """Lines that set ``name`` to the sine of turns, the cosine of a quarter less."""
    return cosine(name, f"{turns} - 0.25")


def hyperbolic_tangent(name: str, argument: str) -> list[str]:
    """Lines that set ``name`` to tanh(y) = 1 - 2 / (exp(2 y) + 1), within 4e-16; NaN stays NaN."""
    y, shifted, power = f"{name}_y", f"{name}_shifted", f"{name}_power"
    rest, series = f"{name}_rest", f"{name}_series"
    terms = [f"{series} = {series} * {rest} + {value!r}" for value in reversed(EXPONENTIAL[:-1])]
    return [
        f"{y} = {argument}",
        f"{y} = {LARGEST!r} if {y} > {LARGEST!r} else {y}",
        f"{y} = 2.0 * (-{LARGEST!r} if {y} < -{LARGEST!r} else {y})",
        f"{shifted} = {y} * {PER_LN2!r} + {ROUNDING!r}",
        f"{power} = {shifted} - {ROUNDING!r}",
        f"{rest} = {y} - {power} * {LN2_HIGH!r} - {power} * {LN2_LOW!r}",
        f"{series} = {EXPONENTIAL[-1]!r}",
        *terms,
        f"{name} = 1.0 - 2.0 / ({series} * power_of_two({shifted}) + 1.0)",
    ]
