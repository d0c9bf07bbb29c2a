"""Cortical surfaces registered to templates: from white surfaces to files for pipelines."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from typing import Literal

from ...gate import PathLike, gate
from ...io.formats import Convention
from ...populations.engine import USUAL, Engine
from ...populations.map_many import manifest_of
from ...populations.page import check_page, write_population_page
from ...populations.run_many import run_many
from ...populations.table import RegistrationRow
from .jobs import describe_datasets, hemisphere_jobs
from .page import registration_sheet
from .task import SphereRegistration


@gate
def register_hemispheres(
    sources: Sequence[PathLike],
    out: str,
    *,
    to: Sequence[str] = ("fsaverage",),
    names: Sequence[Convention] = ("bids",),
    labels: Sequence[str] = (),
    reflect: bool = False,
    hemisphere: Literal["L", "R"] | None = None,
    pial: str | None = None,
    force: bool = False,
    manifest: PathLike | None = None,
    engine: Engine = USUAL,
    report: PathLike | None = None,
    listener: Callable[[RegistrationRow], None] | None = None,
) -> list[RegistrationRow]:
    """Register cortical surfaces to templates, and write the files that pipelines expect.

    Of each hemisphere: its sphere, the sphere registered to each template, the base-2 logarithm of the change of areas
    by registration, FreeSurfer's sulc, curv and area, and the surface with the vertices of each template. If the pial
    surface lies beside a white one, or is given, their midthickness is registered, and written, too; else the surface
    itself, under the name of its own kind. Spheres have radius 100 and are certified as they are written.

    Parameters
    ----------
    sources : sequence of path-like
        White surfaces, one a hemisphere, or midthickness or pial ones: names tell it (white, smoothwm, wm, inner; pial,
        pia, gray; midthickness, graymid, central, mid), else they are called surfaces.
    out : str
        The folder for the files, made if it is missing: ``{folder}`` is that of the source, ``{subject}`` its subject.
    to : sequence of str
        Templates: fsaverage (the default), fsaverage3 to 7, fsLR, from the folders that `template_files` lists, or
        ``NAME=SURFACE,SPHERE``, files of which ``{hemi}`` is lh or rh and ``{side}`` L or R.
    names : sequence of {"bids", "freesurfer", "hcp", "fmriprep"}
        Conventions of file names. FreeSurfer's files are written in its formats, the others as GIFTI. HCP's sulc and
        curvature have the other sign. "fmriprep" is BIDS, and smriprep's further inputs: both surfaces, thickness, and
        a mask of the cortex.
    labels : sequence of str
        Files of labels at the vertices of a template, which are carried to the surfaces, each with its margin, see
        `label_margin`. ``{hemi}`` and ``{side}`` are as above; files whose names tell another side are left out.
    reflect : bool
        Register mirror images to the templates of the other side; the spheres fit the surfaces as they are, and the
        names of the files say ``mirrored``.
    hemisphere : {"L", "R"}, optional
        The side, if neither names nor files tell it.
    pial : str, optional
        The pial surfaces of white ones: ``{folder}`` and ``{subject}`` are as above, ``{hemi}`` and ``{side}``, too. By
        default the file beside a white one that has its name but for that word.
    force, manifest, engine, report
        As of `igl_spheremap.map_many`; the page shows the atlases' borders, or those between folds, on each surface
        beside the template.
    listener : callable, optional
        Called with each row; may raise StopIteration to end with the jobs in flight.

    Returns
    -------
    list of RegistrationRow
        One for each source, in their order.

    Raises
    ------
    ValueError
        If a name is unknown, or two files would have one place.
    FileError
        If a template is not found, a side is not known, or the manifest can't be written.
    MeshError
        If no template has as many vertices as a file has labels.

    Examples
    --------
    >>> import os, tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.shapes.cortices.sphere_registration import register_hemispheres
    >>> v, f = ism.samples.make("pear", n_vertices=500)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     surface, sphere = (os.path.join(folder, name) for name in ("template.ply", "sphere.ply"))
    ...     ism.write_mesh(surface, v, f)
    ...     _ = ism.write_map(sphere, ism.balanced_spherical_map(v, f))
    ...     source = os.path.join(folder, "sub-01_hemi-L_white.ply")
    ...     ism.write_mesh(source, 1.1 * v, f)
    ...     (row,) = register_hemispheres([source], folder, to=[f"mine={surface},{sphere}"])
    ...     sorted(name for name in os.listdir(folder) if name.startswith("sub-01_hemi-L_space"))[1]
    'sub-01_hemi-L_space-mine_desc-reg_arealdistortion.shape.gii'
    >>> row.status, row.unlike < 0.1
    ('certified', True)
    """
    jobs = hemisphere_jobs(
        sources,
        out,
        to=to,
        names=names,
        labels=labels,
        reflect=reflect,
        hemisphere=hemisphere,
        pial=pial,
    )
    if report is not None:
        check_page(report)
    task = SphereRegistration(reflect=reflect, force=force, folder=os.getcwd())
    log = manifest or manifest_of(f"{out}/", "sphere-reg")
    rows = run_many(jobs, task, log, engine, listener)
    describe_datasets(jobs)
    if report is not None:
        write_population_page(report, rows, registration_sheet(rows, jobs, task), engine.processes)
    return rows
