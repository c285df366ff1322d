"""Reads the files of some models with trimesh, VTK and Gmsh and compares them with what should be in them.

usage: read_outputs.py FOLDER MODEL [MODEL ...]
Beside FOLDER/MODEL.obj and so on there are MODEL.triangles, three points for each flat triangle, and for patches with a net
MODEL.inside, a point of each: f64, little-endian. Prints JSON: for each file the largest distance of a point from where it should be,
relative to the largest coordinate, or what else is wrong.
"""
import json
import pathlib
import sys

import gmsh
import numpy as np
import trimesh
import vtk
from vtk.util.numpy_support import vtk_to_numpy

MESHES = ["glb", "3mf", "obj", "off", "ply", "stl"]


def miss(found, expected):
    if found.shape != expected.shape:
        return f"{found.shape} and not {expected.shape}"
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def triangles_of_mesh(path):
    mesh = trimesh.load(path, process=False)
    if isinstance(mesh, trimesh.Scene):
        transform, name = mesh.graph[mesh.graph.nodes_geometry[0]]
        mesh = mesh.geometry[name].copy()
        mesh.apply_transform(transform)
    points = mesh.vertices[mesh.faces]
    if path.suffix == ".glb":
        # Metres, y up.
        x, y, z = np.moveaxis(points, -1, 0)
        points = 1000 * np.stack([x, -z, y], axis=-1)
    return points


def points_of_vtu(path, inside):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    grid = reader.GetOutput()
    if inside is None:
        points = vtk_to_numpy(grid.GetPoints().GetData())
        return points[vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 3)]
    found = []
    for c in range(grid.GetNumberOfCells()):
        cell = grid.GetCell(c)
        sub, x, weights = vtk.mutable(0), [0.0] * 3, [0.0] * cell.GetNumberOfPoints()
        cell.EvaluateLocation(sub, [0.2, 0.5, 0.0], x, weights)
        found.append(x)
    return np.array(found)


def points_of_msh(path, curved):
    gmsh.clear()
    gmsh.open(str(path))
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    points = np.asarray(coordinates).reshape(-1, 3)
    types, _, nodes = gmsh.model.mesh.getElements(2)
    if curved:
        _, _, inside = gmsh.model.mesh.getJacobians(types[0], [0.2, 0.5, 0.0])
        return np.asarray(inside).reshape(-1, 3)
    place = np.zeros(int(tags.max()) + 1, dtype=int)
    place[tags] = np.arange(len(tags))
    return points[place[np.asarray(nodes[0]).reshape(-1, 3)]]


gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
folder, report = pathlib.Path(sys.argv[1]), {}
for model in sys.argv[2:]:
    triangles = np.fromfile(folder / f"{model}.triangles").reshape(-1, 3, 3)
    name = folder / f"{model}.inside"
    inside = np.fromfile(name).reshape(-1, 3) if name.exists() else None
    for ending in MESHES:
        report[f"{model}.{ending}"] = miss(triangles_of_mesh(folder / f"{model}.{ending}"), triangles)
    flat = triangles if inside is None else inside
    report[f"{model}.vtu"] = miss(points_of_vtu(folder / f"{model}.vtu", inside), flat)
    report[f"{model}.msh"] = miss(points_of_msh(folder / f"{model}.msh", inside is not None), flat)
gmsh.finalize()
print(json.dumps(report, indent=1))
