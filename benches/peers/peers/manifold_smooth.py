"""manifold3d, a whole process: a mesh made smooth and refined, its points with normals written to a file.

Usage: manifold_smooth.py IN.off N OUT, where N is into how many parts every edge is cut.
"""

import sys
import time

start = time.process_time()
import manifold3d
import numpy as np
from off import read_off

loaded = time.process_time()
points, triangles = read_off(sys.argv[1])
mesh = manifold3d.Mesh(np.array(points, np.float32), np.array(triangles, np.uint32))
smooth = manifold3d.Manifold.smooth(mesh).refine(int(sys.argv[2])).calculate_normals(0)
refined = smooth.to_mesh()
with open(sys.argv[3], "wb") as out:
    refined.vert_properties.tofile(out)
    refined.tri_verts.tofile(out)
print(f"loading={loaded - start}\tpoints={len(refined.vert_properties)}\ttriangles={len(refined.tri_verts)}")
