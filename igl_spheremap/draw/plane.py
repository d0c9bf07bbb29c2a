"""Maps to the plane as figures."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from .palette import FOLDED, INK
from .plot import BINS, SMALL, new_figure, plot_angles

#: Colours of logarithms of area ratios reach to this: areas half and double.
_REACH = float(np.log(2))


def plot_plane(p: FloatArray, f: IntArray, rim: IntArray, differences: FloatArray, ratios: FloatArray,
               title: str) -> Any:
    """A figure of a map: its image, coloured by area ratios, folded faces in their own colour, and two histograms.

    It takes images (n, 2), faces, vertices of the boundary loop, angle differences in degrees, and logarithms of area
    ratios.
    """
    figure, ((left, middle, right),) = new_figure(1, 3, title, size=(3.6, 3.4))
    shown = np.clip(np.nan_to_num(ratios), -_REACH, _REACH)
    drawn = left.tripcolor(p[:, 0], p[:, 1], f, facecolors=shown, cmap="PuOr_r", vmin=-_REACH, vmax=_REACH,
                           rasterized=True)
    side = p[f[:, 1]] - p[f[:, 0]], p[f[:, 2]] - p[f[:, 0]]
    folded = side[0][:, 0] * side[1][:, 1] <= side[0][:, 1] * side[1][:, 0]
    if folded.any():
        left.tripcolor(p[:, 0], p[:, 1], f[folded], facecolors=np.zeros(int(folded.sum())), color=FOLDED)
    around = np.append(rim, rim[0])
    left.plot(p[around, 0], p[around, 1], color=INK, linewidth=0.6)
    left.set_aspect("equal")
    left.set_axis_off()
    bar = figure.colorbar(drawn, ax=left, orientation="horizontal", shrink=0.8, ticks=[-_REACH, 0, _REACH])
    bar.ax.set_xticklabels(["half the area", "equal", "twice"], fontsize=SMALL)
    plot_angles(middle, differences)
    finite = ratios[np.isfinite(ratios)]
    size = np.abs(finite)
    right.hist(np.clip(finite, -3 * _REACH, 3 * _REACH), bins=BINS, color="0.4")
    right.set(yticks=[])
    right.set_xlabel("log(image area / source area) (ends hold the rest)", fontsize=SMALL)
    right.set_title(f"areas: mean size of the logarithm {size.mean():.3g},\n99% below "
                    f"{np.percentile(size, 99):.3g}", fontsize=SMALL)
    return figure
