"""Reads a .vtu file with VTK, tessellates its higher-order cells and prints JSON about points, area and volume.

usage: check_vtu.py FILE.vtu
The distances are those of the tessellated points from the unit sphere.
"""
import json
import sys

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

reader = vtk.vtkXMLUnstructuredGridReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
surface = vtk.vtkDataSetSurfaceFilter()
surface.SetInputData(grid)
surface.SetNonlinearSubdivisionLevel(4)
surface.Update()
clean = vtk.vtkCleanPolyData()
clean.SetInputData(surface.GetOutput())
clean.SetTolerance(1e-9)
clean.Update()
triangles = vtk.vtkTriangleFilter()
triangles.SetInputData(clean.GetOutput())
triangles.Update()
mass = vtk.vtkMassProperties()
mass.SetInputData(triangles.GetOutput())
mass.Update()
edges = vtk.vtkFeatureEdges()
edges.SetInputData(triangles.GetOutput())
edges.BoundaryEdgesOn()
edges.NonManifoldEdgesOn()
edges.FeatureEdgesOff()
edges.ManifoldEdgesOff()
edges.Update()

radius = np.linalg.norm(vtk_to_numpy(triangles.GetOutput().GetPoints().GetData()), axis=1)
# The same patches, evaluated by the cells themselves at one place inside each.
inside = []
for c in range(grid.GetNumberOfCells()):
    cell = grid.GetCell(c)
    sub, x, weights = vtk.mutable(0), [0.0] * 3, [0.0] * cell.GetNumberOfPoints()
    cell.EvaluateLocation(sub, [0.2, 0.5, 0.0], x, weights)
    inside.append(x)
report = {
    "cells": grid.GetNumberOfCells(),
    "points": grid.GetNumberOfPoints(),
    "cell_types": sorted({grid.GetCellType(c) for c in range(grid.GetNumberOfCells())}),
    "degree": int(grid.GetCell(0).GetOrder()),
    "vertices": vtk_to_numpy(grid.GetPoints().GetData())[:12].tolist(),
    "largest_distance": float(np.abs(radius - 1).max()),
    "volume": mass.GetVolume(),
    "open_edges": edges.GetOutput().GetNumberOfCells(),
    "inside": inside,
}
normals = grid.GetPointData().GetNormals()
if normals is not None:
    n, p = vtk_to_numpy(normals), vtk_to_numpy(grid.GetPoints().GetData())
    report["largest_normal_error"] = float(np.linalg.norm(n - p / np.linalg.norm(p, axis=1)[:, None], axis=1).max())
print(json.dumps(report, indent=1))
