"""
The paper's algorithms, iteration by iteration
==============================================

A listener sees every iterate of Algorithm 1, and the star maps of Algorithm 2 that remove what is still folded. A
recording keeps energies and foldings.
"""

import igl_spheremap as ism
from igl_spheremap.draw.run import plot_run

v, f = ism.samples.make("dino", n_vertices=1500)
recording = ism.Recording(f)
result = ism.spherical_conformal_map(v, f, method="lai2014", listener=recording)
for entry in result.rounds:
    print(
        f"round {entry.round}: {entry.foldings_before:,} folded faces before, {entry.foldings_after:,} after"
    )
assert result.certificate.folding_free

figure = plot_run(
    recording.history,
    recording.foldings,
    result.angle_differences(),
    result.log_area_ratios(),
    title="a dinosaur",
)
figure
