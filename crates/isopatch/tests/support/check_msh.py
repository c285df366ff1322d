"""Reads a .msh file with Gmsh and prints JSON about its elements.

usage: check_msh.py FILE.msh
"""
import json
import sys

import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
gmsh.open(sys.argv[1])
tags, coordinates, _ = gmsh.model.mesh.getNodes()
points = np.asarray(coordinates).reshape(-1, 3)[np.argsort(tags)]
types, element_tags, element_nodes = gmsh.model.mesh.getElements(2)
name, dimension, order, nodes, local, corners = gmsh.model.mesh.getElementProperties(types[0])
connectivity = np.asarray(element_nodes[0]).reshape(-1, nodes)
sides = np.sort(np.concatenate([connectivity[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
_, uses = np.unique(sides, axis=0, return_counts=True)
# One point inside each element, where the weights of its corners are 0.3, 0.2 and 0.5.
_, determinants, inside = gmsh.model.mesh.getJacobians(types[0], [0.2, 0.5, 0.0])
report = {
    "types": [int(t) for t in types],
    "dimension": dimension,
    "order": order,
    "nodes_each": nodes,
    "elements": len(element_tags[0]),
    "nodes": len(tags),
    "open_edges": int((uses == 1).sum()),
    "largest_edge_use": int(uses.max()),
    "first": points[:12].tolist(),
    "inside": np.asarray(inside).reshape(-1, 3).tolist(),
    "smallest_determinant": float(np.min(determinants)),
}
gmsh.finalize()
print(json.dumps(report, indent=1))
