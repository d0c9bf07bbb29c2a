"""A result's key holds its causes, but neither places of files nor wording of notes."""

from dataclasses import fields, replace

import pytest

from igl_spheremap.apps.cli.exits import Shell
from igl_spheremap.errors import as_call
from igl_spheremap.maps.options import Auto, Lai2014
from igl_spheremap.populations.job import Job, key_of
from igl_spheremap.populations.mapping import SphereMapping
from igl_spheremap.shapes.cortices.task import SphereRegistration
from igl_spheremap.shapes.groups.jobs import CarryMember, MapMember, MemberJob, RegisterMember
from igl_spheremap.shapes.groups.turns import Restarts
from igl_spheremap.shapes.harmonics.spharm_pdm import ShapeExpansion

HERE = {"force": False, "folder": "/here", "say": as_call}
MAPPING = SphereMapping(Auto(), 0.5, None, **HERE)
TASKS = [
    MAPPING,
    ShapeExpansion(MAPPING, 15, 10, **HERE),
    SphereRegistration(reflect=False, **HERE),
    MapMember(icosphere="ico:4", balance=1.0, **HERE),
    RegisterMember(icosphere="ico:4", **HERE),
    CarryMember(icosphere="ico:4", **HERE),
]
#: Another value of each field.
OTHER = {
    "force": True,
    "folder": "/there",
    "say": Shell({}),
    "version": "0",
    "method": Lai2014(),
    "balance": 0.25,
    "repair": {"weld": 1e-9},
    "mapping": replace(MAPPING, balance=0.75),
    "degree": 16,
    "subdivision": 11,
    "reflect": True,
    "icosphere": "ico:5",
}
JOB = MemberJob("a.npz", "b.npz", features=("c.npz:thickness",))


def test_every_option_of_every_task_is_in_the_key():
    for task in TASKS:
        for field in fields(task):
            other = replace(task, **{field.name: OTHER[field.name]})
            same = key_of(Job("a.ply", "b.ply"), task, ".") == key_of(
                Job("a.ply", "b.ply"), other, "."
            )
            assert same == (field.name in HERE), (task, field.name)
    assert len({key_of(Job("a.ply", "b.ply"), task, ".") for task in TASKS}) == len(TASKS)


def test_the_key_of_a_method_holds_its_options():
    one, other = (replace(MAPPING, method=method) for method in (Auto(), Auto(max_iterations=3)))
    assert key_of(Job("a.ply", "b.ply"), one, ".") != key_of(Job("a.ply", "b.ply"), other, ".")


@pytest.mark.parametrize(
    ("change", "same"),
    [
        ({"is_map": True}, False),
        ({"restarts": Restarts(mirror=True)}, False),
        ({"turn": ((1.0,),)}, False),
        ({"features": ("c.npz:curv",)}, False),
        ({"target": "d.npz"}, False),
        ({"features": ("elsewhere/c.npz:thickness",)}, True),
        ({"source": "elsewhere/a.npz"}, True),
    ],
)
def test_what_is_taken_of_a_members_files_is_in_the_key(change, same):
    task = TASKS[3]
    assert (key_of(JOB, task, ".") == key_of(replace(JOB, **change), task, ".")) == same
