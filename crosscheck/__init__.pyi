"""Types of the public names, for type checkers and editors."""

from crosscheck.api import build as build
from crosscheck.api import check as check
from crosscheck.api import load_arm as load_arm
from crosscheck.api import load_robot as load_robot
from crosscheck.api import load_scenario as load_scenario
from crosscheck.api import simulate as simulate
from crosscheck.findings import Agreement as Agreement
from crosscheck.findings import Finding as Finding
from crosscheck.models.arm.arm import Arm as Arm
from crosscheck.models.errors import CannotDo as CannotDo
from crosscheck.models.errors import Diverged as Diverged
from crosscheck.models.errors import InputError as InputError
from crosscheck.models.errors import Unfinished as Unfinished
from crosscheck.models.experiment.scenario import Scenario as Scenario
from crosscheck.models.experiment.scenario import Switches as Switches
from crosscheck.models.experiment.scenario import switches as switches
from crosscheck.models.interface import Model as Model
from crosscheck.models.robot.robot import Robot as Robot
from crosscheck.report.summary import CheckResult as CheckResult
from crosscheck.studies.api import sweep as sweep
from crosscheck.testing import try_equations as try_equations
from crosscheck.trial.input.equations import Coordinates as Coordinates
from crosscheck.trial.input.equations import Equations as Equations
from crosscheck.trial.input.symbolic import from_sympy as from_sympy

__version__: str
LARGEST_SEED: int
