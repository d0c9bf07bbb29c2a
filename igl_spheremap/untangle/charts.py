"""Charts for a layout: where edges are small compared with coordinates, positions are relative to the deepest tip."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import connected_components

from ..verify.atlas import ChartAtlas, certify_atlas
from .layout import Layout

#: Largest log(coordinate / edge) within a chart: edges keep nine of float64's sixteen digits.
_DEEP = 14.0


def make_atlas(layout: Layout, root: int) -> ChartAtlas:
    """The layout about one vertex, with further charts for deep limbs, and its certificate."""
    f, n = layout.f, layout.n
    graph = sp.csr_matrix((np.ones(f.size), (f.ravel(), np.roll(f, -1, axis=1).ravel())), shape=(n, n))
    unit = float(np.median(layout.log_edge))
    z, chart, parent, origin = layout.about(root, unit), np.zeros(n, dtype=np.int64), [-1], [0j]
    while True:
        size = np.log(np.where(z == 0, np.finfo(float).tiny, np.abs(z)))
        lost = np.flatnonzero(size + unit - layout.log_edge > _DEEP)
        if not len(lost):
            break
        parts, label = connected_components(graph[lost][:, lost], directed=False)
        for k in range(parts):
            part = lost[label == k]
            tip = int(part[np.argmin(layout.log_edge[part])])
            parent.append(int(chart[tip]))
            origin.append(complex(z[tip]))
            z[part], chart[part] = layout.about(tip, unit)[part], len(parent) - 1
    atlas = ChartAtlas(layout.hole, chart, z, np.array(parent), np.array(origin))
    return replace(atlas, certificate=certify_atlas(atlas, f))
