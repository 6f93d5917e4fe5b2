# %% [markdown]
# # Rotors as armature, and what couples them
#
# Most simulators add a rotor's reflected inertia to the diagonal of M, the *armature*. A rotor also
# turns with the link that carries its motor, which couples joints. How large is that on a PUMA 560?

# %%
from types import SimpleNamespace

import crosscheck

robot = crosscheck.load_robot("puma560")
armature = crosscheck.build("analytic:armature", robot, crosscheck.load_scenario("pd"))
equations = SimpleNamespace(mass_matrix=armature.mass_matrix)
crosscheck.try_equations(equations, robot, level="coupled", name="armature")
