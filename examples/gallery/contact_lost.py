# %% [markdown]
# # Contact is lost
#
# Under PD control the teeth part and hit again. Printed and corrected equations part with them:
# after the first impact the mesh force of the printed ones is another.

# %%
import matplotlib.pyplot as plt

import crosscheck

arm = crosscheck.load_arm("paper-labelled")
scenario = crosscheck.load_scenario("pd").model_copy(update={"duration_s": 0.5})
runs = {
    name: crosscheck.simulate(crosscheck.build(f"analytic:{name}", arm, scenario))
    for name in ("printed", "physical")
}
force = {name: run["F_sp"].isel(joint=0, planet=0) for name, run in runs.items()}
print(force["physical"].attrs["long_name"], force["physical"].attrs["units"])

# %% [markdown]
# The force is 0 where contact is lost. The first time that it becomes so:

# %%
touch = force["physical"].values != 0.0
start = float(force["physical"].time[1:][touch[:-1] & ~touch[1:]][0])
print(f"contact is lost at {start * 1e3:.2f} ms")

# %%
figure, axes = plt.subplots(figsize=(8, 3.6))
near = slice(start + 4e-3, start + 12e-3)  # until the teeth hit again, and after
for name, colour in (("printed", "tab:red"), ("physical", "tab:green")):
    part = force[name].sel(time=near)
    axes.plot((part.time - start) * 1e3, part, color=colour, label=name)
axes.set_xlabel("ms after contact is lost")
axes.set_ylabel("sun-planet mesh force of joint 1 [N]")
axes.legend()
