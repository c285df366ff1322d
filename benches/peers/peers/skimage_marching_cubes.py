"""scikit-image's marching cubes (Lewiner) on a grid of the compiled field."""

from grid import Grid
from served import serve
from skimage.measure import marching_cubes


def solve(request):
    grid = Grid(request)
    points, triangles, _, _ = marching_cubes(grid.values, 0.0, spacing=(grid.step,) * 3)
    # Points are z, y, x from the corner of the grid.
    return points[:, ::-1] + grid.origin, triangles


serve(solve, lambda result: result)
