"""Cross-checks equations of motion of geared robot arms against independent multibody engines.

Compare two models of the built-in arm at one state:

    >>> import crosscheck
    >>> arm = crosscheck.load_arm("paper-labelled")
    >>> scenario = crosscheck.load_scenario("pd")
    >>> derived = crosscheck.build("analytic:coupled", arm, scenario)
    >>> engine = crosscheck.build("pinocchio:coupled", arm, scenario)
    >>> difference = derived.mass_matrix([0.3, -0.8]) - engine.mass_matrix([0.3, -0.8])
    >>> bool(abs(difference).max() < 1e-12)
    True

``crosscheck.check(arm)`` runs every comparison, ``crosscheck.try_equations(equations, arm)`` judges
equations of your own, and ``crosscheck.testing.assert_agrees`` asserts that they are right. Results
print themselves, and a notebook shows them with a picture.
"""

from __future__ import annotations

from crosscheck.lazy import make_lazy_names

__version__ = "0.1.0"
# What every reader of JSON holds exactly; the command line and a record take the same seeds.
LARGEST_SEED = 2**32 - 1
_MODULES = {
    "Agreement": "crosscheck.findings",
    "Arm": "crosscheck.models.arm.arm",
    "CheckResult": "crosscheck.report.summary",
    "CannotDo": "crosscheck.models.errors",
    "Coordinates": "crosscheck.trial.input.equations",
    "Diverged": "crosscheck.models.errors",
    "Equations": "crosscheck.trial.input.equations",
    "Finding": "crosscheck.findings",
    "InputError": "crosscheck.models.errors",
    "Model": "crosscheck.models.interface",
    "Robot": "crosscheck.models.robot.robot",
    "Scenario": "crosscheck.models.experiment.scenario",
    "Switches": "crosscheck.models.experiment.scenario",
    "Unfinished": "crosscheck.models.errors",
    "build": "crosscheck.api",
    "check": "crosscheck.api",
    "from_sympy": "crosscheck.trial.input.symbolic",
    "load_arm": "crosscheck.api",
    "load_robot": "crosscheck.api",
    "load_scenario": "crosscheck.api",
    "simulate": "crosscheck.api",
    "sweep": "crosscheck.studies.api",
    "switches": "crosscheck.models.experiment.scenario",
    "try_equations": "crosscheck.testing",
}
__all__ = list(_MODULES)
__getattr__, __dir__ = make_lazy_names(__name__, _MODULES)
