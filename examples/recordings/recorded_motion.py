"""Write the simulated recording payload.csv: ``python recorded_motion.py payload.csv``.

Five seconds at 1 kHz of the paper's arm with a payload of 10.2 kg, where its file has 10, as rigid
gears would move it; noise of 1e-5 rad and 0.1 N m. Nothing in it was measured.
"""

import sys

import numpy as np

import crosscheck

HEADER = "t_s,theta_1_rad,theta_2_rad,torque_1_N_m,torque_2_N_m"
DIGITS = ["%.3f", "%.7f", "%.7f", "%.3f", "%.3f"]  # a hundredth of the noise

arm = crosscheck.load_arm("paper-labelled").model_copy(update={"payload_mass_kg": 10.2})
model = crosscheck.build("analytic:coupled", arm, crosscheck.load_scenario("pd"))
time = np.arange(5_000) * 1e-3
rates = 2 * np.pi * np.outer([1.0, 1.1], [0.2, 0.5, 0.9, 1.3])  # of sines, joint by joint [rad/s]
sizes = 0.3 / (1 + 3 * np.array([0.2, 0.5, 0.9, 1.3]))  # [rad]
draw = np.random.default_rng(0)
turned = rates * time[:, None, None] + draw.uniform(0, 2 * np.pi, rates.shape)
angles = (sizes * np.sin(turned)).sum(axis=2)
torques = model.inverse_dynamics(
    angles,
    (sizes * rates * np.cos(turned)).sum(axis=2),
    -(sizes * rates**2 * np.sin(turned)).sum(axis=2),
)
angles += 1e-5 * draw.normal(size=angles.shape)
torques += 0.1 * draw.normal(size=torques.shape)
table = np.column_stack([time, angles, torques])
np.savetxt(sys.argv[1], table, delimiter=",", header=HEADER, comments="", fmt=DIGITS)
