"""A robot's equations as one file of C, from the text that its kernel has."""

from __future__ import annotations

from collections.abc import Iterable

from crosscheck.analytic.kernel.export import (
    CFunction,
    assemble_c_file,
    make_c_lines,
    write_c_function,
)
from crosscheck.analytic.kernel.numbers import Numbers
from crosscheck.analytic.robot.equations import RobotEquations
from crosscheck.analytic.robot.structure import trace_mass_matrix


def generate_robot_c_source(equations: RobotEquations, prefix: str, header: str) -> str:
    """One file of C that needs its standard library alone.

    Accelerations (n,) of time, coordinates, rates and the motors' torques (free,), and, of robots
    on rigid gears, M (n * n, row by row); names begin with prefix. header: a comment before all.
    """
    s = equations.structure
    names, free = s.coordinates, s.mechanism.free
    loads = {f"{kind}_{x}": f"{kind}[{k}]" for kind in "qv" for k, x in enumerate(names)}
    loads |= {f"T{j}": f"torque[{j - 1}]" for j in s.driven_joints}
    state = "double t, const double q[N], const double v[N], const double torque[JOINTS]"
    dynamics = CFunction("acceleration", state, "a", tuple(f"a_{x}" for x in names))
    functions = [_function(dynamics, s.dynamics(), loads, equations.numbers, prefix)]
    if not s.displacements:
        places = range(free)
        entries = tuple(f"M{max(i, j)}_{min(i, j)}" for i in places for j in places)
        mass, text = (
            CFunction("mass_matrix", "const double q[N]", "M", entries),
            trace_mass_matrix(s),
        )
        numbers = equations.constants(text)
        functions.append(_function(mass, text.lines, loads, numbers, prefix))
    return assemble_c_file(header, len(names), free, "", "\n".join(functions))


def _function(
    part: CFunction, text: Iterable[str], loads: dict[str, str], numbers: Numbers, prefix: str
) -> str:
    """A function with its numbers inside: those of another have the same names."""
    return write_c_function(part, make_c_lines(text), loads, numbers, prefix, has_numbers=True)
