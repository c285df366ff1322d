"""OpenCASCADE: the triangles of a mesh sewn to a solid and written as STEP; a request is `step FILE.off`."""

import os
import sys
import tempfile
import time

from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeSolid,
    BRepBuilderAPI_Sewing,
)
from OCP.gp import gp_Pnt
from OCP.Message import Message, Message_Gravity
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.TopoDS import TopoDS
from off import read_off

# Below the shortest edges by far.
TOLERANCE = 1e-6


def sew(points, triangles):
    sewing = BRepBuilderAPI_Sewing(TOLERANCE)
    for triangle in triangles:
        polygon = BRepBuilderAPI_MakePolygon(*(gp_Pnt(*points[k]) for k in triangle), True)
        sewing.Add(BRepBuilderAPI_MakeFace(polygon.Wire(), True).Face())
    sewing.Perform()
    return sewing.SewedShape()


def write(shape, path):
    writer = STEPControl_Writer()
    solid = BRepBuilderAPI_MakeSolid(as_shell(shape)).Solid()
    writer.Transfer(solid, STEPControl_StepModelType.STEPControl_ManifoldSolidBrep)
    writer.Write(path)


def as_shell(shape):
    cast = getattr(TopoDS, "Shell_s", None) or TopoDS.Shell
    return cast(shape)


def answer(path):
    points, triangles = read_off(path)
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.step")
        start = time.process_time()
        shape = sew(points, triangles)
        sewn = time.process_time()
        write(shape, out)
        end = time.process_time()
        size = os.path.getsize(out)
    return f"seconds={end - start}\tfit={sewn - start}\twrite={end - sewn}\tbytes={size}"


def silence():
    """OpenCASCADE prints statistics of what it writes."""
    printers = Message.DefaultMessenger_s().Printers()
    for i in range(1, printers.Length() + 1):
        printers.Value(i).SetTraceLevel(Message_Gravity.Message_Fail)


silence()
print("ready", flush=True)
for line in sys.stdin:
    try:
        text = answer(line.rstrip("\n").split("\t")[1])
    except Exception as error:  # A peer may fail in any way; the table says how.
        text = "error=" + " ".join(str(error).split())
    print(text, flush=True)
