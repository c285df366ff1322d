"""Reads a triangle mesh with trimesh and prints JSON about what it holds.

usage: check_mesh.py FILE
"""
import json
import sys

import numpy as np
import trimesh

mesh = trimesh.load(sys.argv[1], process=False)
transform = np.eye(4)
if isinstance(mesh, trimesh.Scene):
    transform, name = mesh.graph[mesh.graph.nodes_geometry[0]]
    mesh = mesh.geometry[name]
normals = mesh.vertex_normals.copy() if "vertex_normals" in mesh._cache else None
mesh.apply_transform(transform)
if normals is not None:
    normals = normals @ np.asarray(transform)[:3, :3].T
    normals /= np.linalg.norm(normals, axis=1)[:, None]
as_written = {"vertices": len(mesh.vertices), "faces": len(mesh.faces), "first": mesh.vertices[:12].tolist()}
merged = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
merged.merge_vertices(merge_norm=True, merge_tex=True)
report = as_written | {
    "watertight": bool(merged.is_watertight),
    "winding_consistent": bool(merged.is_winding_consistent),
    "euler": int(merged.euler_number),
    "volume": float(merged.volume),
    "center": merged.bounds.mean(axis=0).tolist(),
    "stored_normals": normals is not None,
    "units": mesh.units,
}
if normals is not None:
    radial = mesh.vertices - np.asarray(report["center"])
    radial /= np.linalg.norm(radial, axis=1)[:, None]
    report["largest_normal_error"] = float(np.linalg.norm(normals - radial, axis=1).max())
print(json.dumps(report, indent=1))
