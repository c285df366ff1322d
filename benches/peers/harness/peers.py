"""The programs for formulas: how they are started, and which number makes their result finer."""

from collections.abc import Callable
from dataclasses import dataclass, field

from . import install
from .search import Ladder, Resolution


@dataclass(frozen=True)
class Peer:
    name: str
    licence: str
    # Its version, once it is installed.
    version: Callable
    # Installs the program and gives its command, or raises Missing.
    prepare: Callable = None
    search: object = None
    # What the number in a request means.
    parameter: str = ""
    environment: Callable = field(default=dict)


def uses_fields():
    return {"PEER_FIELDS": str(install.fields())}


def intervals(target):
    # Where one of a grid with 64 intervals is off by 2e-3.
    return 64 * (2e-3 / target) ** 0.5


def isopatch(effort):
    return Peer(
        name=f"isopatch {effort}",
        licence="MIT OR Apache-2.0",
        prepare=lambda: [install.isopatch_example("peer_surfaces"), effort],
        version=install.commit,
        # It is asked for the target itself, and for less only where the measuring program sees more than that.
        search=Ladder(lambda target: [target, 0.8 * target, 0.6 * target]),
        parameter="tolerance",
    )


PEERS = [
    isopatch("quick"),
    isopatch("full"),
    Peer(
        name="VTK flying edges",
        licence="BSD-3-Clause",
        prepare=lambda: install.python_peer("vtk_flying_edges.py", "vtk"),
        version=lambda: install.python_package("vtk"),
        search=Resolution(intervals, 2),
        parameter="intervals",
        environment=uses_fields,
    ),
    Peer(
        name="scikit-image",
        licence="BSD-3-Clause",
        prepare=lambda: install.python_peer("skimage_marching_cubes.py", "scikit-image"),
        version=lambda: install.python_package("scikit-image"),
        search=Resolution(intervals, 2),
        parameter="intervals",
        environment=uses_fields,
    ),
    Peer(
        name="fidget",
        licence="MPL-2.0",
        prepare=lambda: [install.cargo(install.HERE / "peers" / "fidget", environment=install.NATIVE) / "peer-fidget"],
        version=lambda: install.locked(install.HERE / "peers" / "fidget", "fidget"),
        search=Ladder(lambda _: range(4, 12)),
        parameter="depth",
    ),
    Peer(
        name="CGAL",
        licence="GPL-3.0-or-later",
        prepare=install.cgal,
        version=lambda: install.debian("libcgal-dev"),
        # Facets that are nearer than t have samples that are off by about 2t.
        search=Resolution(lambda target: 2 / target, 1, whole=False, to_parameter=lambda n: 1 / n),
        parameter="distance",
    ),
]
