"""One component of a body's velocity, which its kinetic energy lacks or has twice.

Of a body of mass m it is 1/2 m x'^2 or 1/2 m y'^2, along the base's axes, so M differs by m times
the outer square of dx/dq or dy/dq: in every entry at once, and by angles that no entry has.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from crosscheck.models.arm.arm import Arm
from crosscheck.trial.coordinates.frame import Frame
from crosscheck.trial.diagnose.messages import format_monomial, format_monomial_latex
from crosscheck.trial.diagnose.polynomial import as_polynomial
from crosscheck.trial.diagnose.reference_terms import build_reference_bodies
from crosscheck.trial.judge.entries import Term


def generate_component_inertias(
    frame: Frame, arm: Arm, level: str, values: Mapping[str, float], angles: np.ndarray
) -> Iterator[tuple[Term, np.ndarray]]:
    """Each body's kinetic energy along each axis as a term, and what M (K, n, n) has of it.

    values: of the arm's symbols; angles (K, joints): joint angles, the first from the base's x.
    """
    chain, bodies = build_reference_bodies(frame, arm, level)
    absolute = angles.cumsum(axis=1)
    turns = np.array(chain.angles[1:], dtype=float) @ np.asarray(frame.matrix, dtype=float)
    for body in bodies:
        mass = next(as_polynomial(body.mass).monomials, None)
        if mass is None or not body.centre:
            continue
        levers = np.array(
            [sum(m.value(values) for m in as_polynomial(c).monomials) for c in body.centre]
        )
        owner = body.name if body.name[-1].isdigit() else f"the {body.name}"
        for axis, slopes in (("x", -np.sin(absolute)), ("y", np.cos(absolute))):
            jacobian = (levers * slopes[:, : len(levers)]) @ turns[: len(levers)]
            text = f"1/2 {format_monomial(mass)} {axis}'^2"
            words = f"of {owner}'s velocity along {axis}, in its kinetic energy"
            made = float(mass.value(values)) * np.einsum("ki,kj->kij", jacobian, jacobian)
            latex = rf"\frac{{1}}{{2}}{format_monomial_latex(mass)}\,\dot{{{axis}}}^{{2}}"
            yield Term(f"{text} {words}", latex=latex), made
