"""VTK's flying edges on a grid of the compiled field, on one thread."""

import vtkmodules.vtkCommonCore as core
from grid import Grid
from served import serve
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D

core.vtkSMPTools.SetBackend("Sequential")


def solve(request):
    grid = Grid(request)
    image = vtkImageData()
    image.SetDimensions(*grid.values.shape[::-1])
    image.SetOrigin(*grid.origin)
    image.SetSpacing(grid.step, grid.step, grid.step)
    image.GetPointData().SetScalars(numpy_to_vtk(grid.values.reshape(-1), deep=False))
    contour = vtkFlyingEdges3D()
    contour.SetInputData(image)
    contour.SetValue(0, 0.0)
    contour.ComputeNormalsOff()
    contour.ComputeGradientsOff()
    contour.ComputeScalarsOff()
    contour.Update()
    return contour.GetOutput()


def mesh(output):
    points = vtk_to_numpy(output.GetPoints().GetData())
    return points, vtk_to_numpy(output.GetPolys().GetConnectivityArray()).reshape(-1, 3)


serve(solve, mesh)
