"""
The paper's algorithms, iteration by iteration
==============================================

A listener sees every iterate of Algorithm 1, and the star maps of Algorithm 2 that remove the remaining folds. A
recording keeps energies and foldings.
"""

import matplotlib.pyplot as plt
import numpy as np

import igl_spheremap as ism

v, f = ism.samples.make("dino", n_vertices=1500)
recording = ism.Recording(f)
result = ism.spherical_conformal_map(v, f, method="lai2014", listener=recording)
for entry in result.rounds:
    print(
        f"round {entry.round}: {entry.foldings_before:,} folded faces before, {entry.foldings_after:,} after"
    )
assert result.certificate.folding_free

# %%
# Energies above the least one, 4 pi, and folded faces. Each star map begins where the lines jump.

figure, axes = plt.subplots(1, 2, figsize=(8, 3), layout="constrained")
axes[0].semilogy([step.energy - 4 * np.pi for step in recording.history])
axes[0].set(xlabel="iterate", ylabel="energy - 4 pi")
axes[1].plot(recording.foldings)
axes[1].set(xlabel="iterate", ylabel="folded faces", yscale="symlog")
figure
