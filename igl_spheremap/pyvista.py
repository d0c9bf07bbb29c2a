"""PyVista's meshes get the namespace `spheremap`, by `import igl_spheremap.pyvista` or at its first use."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista as pv

from .balance import ON_SPHERE
from .balance.balanced_spherical_map import balanced_spherical_map
from .maps.sphere_map import SphereMap
from .maps.spherical_conformal_map import spherical_conformal_map
from .result.method import Method

#: Data that a map adds at the points and at the cells of its sphere.
FACTOR, ANGLES, AREAS = "conformal factor", "angle differences", "log area ratios"


@pv.register_dataset_accessor("spheremap", pv.PolyData)
class SphereMapAccessor:
    """Maps of a surface to the unit sphere, as ``mesh.spheremap``.

    Attributes
    ----------
    result : SphereMap or None
        On a sphere that `map` or `balance` made: the map with its certificate, for `igl_spheremap.transfer` and others.

    Examples
    --------
    >>> import pyvista as pv
    >>> import igl_spheremap as ism
    >>> import igl_spheremap.pyvista
    >>> mesh = pv.PolyData.from_regular_faces(*ism.samples.make("spheroid", n_vertices=500))
    >>> sphere = mesh.spheremap.map()
    >>> ism.certify(sphere).folding_free, sphere.n_points == mesh.n_points
    (True, True)
    """

    result: SphereMap | None = None

    def __init__(self, mesh: pv.PolyData) -> None:
        self._mesh = mesh

    def map(self, method: str | Method = "auto", **options: Any) -> pv.PolyData:
        """Map the surface to the unit sphere: conformally, without foldings, certified.

        Parameters
        ----------
        method : str or options of a method
            As of `igl_spheremap.spherical_conformal_map`.
        **options
            Its other options.

        Returns
        -------
        pyvista.PolyData
            The mesh with its points on the sphere, all its data, and the conformal factor at the points, and the mean
            sizes of angle differences in degrees and the logarithms of area ratios at the cells.

        Raises
        ------
        MeshError
            If the mesh is not a closed triangle mesh of genus 0.
        """
        return self._sphere(spherical_conformal_map(self._mesh, method=method, **options))

    def balance(self, balance: float = ON_SPHERE, method: str | Method = "auto") -> pv.PolyData:
        """Map the surface by a compromise between angles and areas.

        Parameters
        ----------
        balance : float
            0 keeps angles, 1 areas; the default is that of `igl_spheremap.balanced_spherical_map`.
        method : str or options of a method
            The method of the conformal map that it starts from.

        Returns
        -------
        pyvista.PolyData
            As from `map`.

        Raises
        ------
        MeshError
            If the mesh is not a closed triangle mesh of genus 0.
        """
        return self._sphere(balanced_spherical_map(self._mesh, balance=balance, method=method))

    def _sphere(self, result: SphereMap) -> pv.PolyData:
        sphere = self._mesh.copy()
        sphere.points = result.sphere
        sphere.point_data[FACTOR] = result.conformal_factor()
        sphere.cell_data[ANGLES] = np.abs(result.angle_differences()).mean(axis=1)
        sphere.cell_data[AREAS] = result.log_area_ratios()
        sphere.spheremap.result = result
        return sphere
