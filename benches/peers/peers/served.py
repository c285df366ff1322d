"""A peer in Python as a process that answers requests; README.md has the protocol."""

import sys
import time
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Request:
    name: str
    formula: str
    box: list[float]
    parameter: float
    output: str

    @classmethod
    def read(cls, line):
        name, formula, box, parameter, output = line.rstrip("\n").split("\t")
        return cls(name, formula, [float(x) for x in box.split()], float(parameter), output)


def write_mesh(path, points, triangles):
    """For the measuring program, as measure/src/shape.rs has it."""
    with open(path, "wb") as out:
        out.write(b"mesh....")
        np.array([len(points), len(triangles)], "<u8").tofile(out)
        np.ascontiguousarray(points, "<f8").tofile(out)
        np.ascontiguousarray(triangles, "<u4").tofile(out)


def answer(line, solve, mesh):
    request = Request.read(line)
    wall, cpu = time.perf_counter(), time.process_time()
    result = solve(request)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    points, triangles = mesh(result)
    if len(triangles) == 0:
        return "error=no triangles"
    if request.output != "-":
        write_mesh(request.output, points, triangles)
    # Indices and single-precision coordinates.
    size = 12 * len(points) + 12 * len(triangles)
    return f"seconds={cpu}\twall={wall}\tbytes={size}\tfile=0\telements={len(triangles)}"


def serve(solve, mesh):
    """`solve` is timed; `mesh` gives the points and triangles of what it returns."""
    print("ready", flush=True)
    for line in sys.stdin:
        try:
            text = answer(line, solve, mesh)
        except MemoryError:
            text = "error=out of memory"
        except Exception as error:  # A peer may fail in any way; the table says how.
            text = "error=" + " ".join(str(error).split())
        print(text, flush=True)
