# %% [markdown]
# # A published mass matrix beside an engine's
#
# The equations of the paper as printed, and the corrected derivation, are built by name like any
# model. So is Exudyn's gear tree, which shares no formula with them. All three answer at the same
# random states.

# %%
import matplotlib.pyplot as plt
import numpy as np

import crosscheck

arm, scenario = crosscheck.load_arm("paper-labelled"), crosscheck.load_scenario("pd")
engine = crosscheck.build("exudyn:tree", arm, scenario)
print(", ".join(engine.coordinates))

# %% [markdown]
# Entries have units of their own, so each difference is measured by the root of both diagonal
# entries.

# %%
draw = np.random.default_rng(0)
sizes = [np.pi if name.startswith("theta") else 1e-4 for name in engine.coordinates]
states = draw.uniform(-1, 1, (100, len(sizes))) * sizes


def compare(name):
    """The largest relative difference of each entry of M."""
    model, found = crosscheck.build(name, arm, scenario), 0.0
    for state in states:
        expected = engine.mass_matrix(state)
        root = np.sqrt(np.diag(expected))
        apart = np.abs(model.mass_matrix(state) - expected) / np.outer(root, root)
        found = np.maximum(found, apart)
    return found


printed, corrected = compare("analytic:printed"), compare("analytic:physical")
print(f"printed: {printed.max():.1%}, corrected: {corrected.max():.0e}")

# %%
figure, axes = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True)
for side, title, found in zip(axes, ("printed", "corrected"), (printed, corrected), strict=True):
    image = side.imshow(np.log10(found.clip(1e-16)), cmap="Reds", vmin=-12, vmax=-1)
    side.set_title(title)
    side.set_xticks(range(6), engine.coordinates, rotation=45)
side.set_yticks(range(6), engine.coordinates)
figure.colorbar(image, ax=axes, label="relative difference, power of ten")
figure.suptitle("M: what is red is wrong")
