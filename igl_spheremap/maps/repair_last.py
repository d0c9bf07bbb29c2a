"""The repair of a minimisation's folds: once, at its end."""

from __future__ import annotations

import time
from dataclasses import replace

from ..angles.effort import Effort
from ..angles.plan import plan_repair
from ..angles.repair import repair
from ..descent.energies import Energy
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..operators.laplacian import build_operators
from ..paper.settings import PaperGauge
from ..result.run import Round, Run, Stage, Status
from ..sphere.moebius import fix_gauge
from ..untangle.embedding import fix_orientation
from ..untangle.local_repair import has_few_foldings, repair_locally, restore_gauge
from ..verify.certificate import Certificate
from ..verify.distortion import mean_angle_difference
from .sphere_map import SphereMap


def repair_last(
    mesh: Mesh,
    x: FloatArray,
    run: Run,
    energy: Energy,
    gauge: PaperGauge,
    keeps_its_place: bool = False,
) -> SphereMap:
    """A minimiser in the gauge, its folds repaired: few locally, more as by `auto`.

    If the rest of the map `keeps_its_place`, always locally. The energy is that of the result.
    """
    began, rounds = time.perf_counter(), run.rounds
    if gauge == "centred":
        x = fix_gauge(mesh, x)
    before, run = Certificate.of(x, mesh.f), replace(run, gauge=gauge)
    count = f"{before.foldings:,} of {len(mesh.f):,} faces"
    if keeps_its_place or has_few_foldings(before, mesh.f):
        x, certificate = repair_locally(mesh, x, before)
        if gauge == "centred":
            x, certificate = restore_gauge(mesh, x)
        note = f"minimiser, {count} repaired"
    else:
        x = fix_orientation(x, mesh.f)
        before = Certificate.of(x, mesh.f)
        plan = plan_repair(mesh, x, energy.evaluate(x)[0], before, None, Effort())
        operators = build_operators(mesh)
        x, certificate, run = repair(mesh, x, before, run, plan, operators, centred=True)
        run = replace(run, status=Status.DONE)
        note = f"the repair made the map: {count} of the minimiser folded"
    value = energy.evaluate(x)[0]
    record = Round(
        round=len(rounds),
        start=str(Stage.REPAIR),
        foldings_before=before.foldings,
        foldings_after=certificate.foldings,
        iterations=0,
        energy=value,
        mean_angle_difference=mean_angle_difference(mesh, x),
        status=Status.DONE,
        seconds=time.perf_counter() - began,
    )
    notes, rounds = (*run.notes, note), (*rounds, record)
    return SphereMap(mesh, x, certificate, replace(run, energy=value, rounds=rounds, notes=notes))
