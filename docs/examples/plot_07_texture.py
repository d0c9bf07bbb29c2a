"""
Texture coordinates
===================

The map has no boundary; a texture needs a seam. The octahedral layout fills a square without poles.
"""

import matplotlib.pyplot as plt

import igl_spheremap as ism

v, f = ism.samples.make("pear", n_vertices=600)
result = ism.spherical_conformal_map(v, f)
figure, axes = plt.subplots(1, 2, figsize=(7.2, 3.2), layout="constrained")
for ax, projection in zip(axes, ("equirectangular", "octahedral"), strict=True):
    atlas = ism.texture_atlas(result, projection=projection)
    assert 0 <= atlas.uv.min() <= atlas.uv.max() <= 1
    ax.triplot(*atlas.uv.T, atlas.f, color="black", linewidth=0.4)
    ax.set(
        title=f"{projection}: {len(atlas.uv):,} vertices",
        aspect="equal",
        xticks=[0, 1],
        yticks=[0, 1],
    )
figure
