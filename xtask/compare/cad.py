"""CAD files as OpenCASCADE reads them: cad.py FILE…

For every face of every STEP or IGES file a line of JSON: its name, area, kind of surface, and the numbers of a B-spline; before them a line
for the file with its unit, the name of its product, the number of free edges and whether the shape is valid. Lengths are in millimetres.
Needs cadquery-ocp.
"""

import json
import sys

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.collections import Sequence_TCollection_AsciiString
from OCP.Geom import Geom_BSplineSurface, Geom_RectangularTrimmedSurface
from OCP.GProp import GProp_GProps
from OCP.IGESControl import IGESControl_Reader
from OCP.StepBasic import StepBasic_Product
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


def text(handle):
    return handle.ToCString() if handle is not None else ""


def spline(face):
    surface = BRep_Tool.Surface_s(face)
    if isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    if not isinstance(surface, Geom_BSplineSurface):
        return None
    points, weights = [], []
    for i in range(1, surface.NbUPoles() + 1):
        for j in range(1, surface.NbVPoles() + 1):
            pole = surface.Pole(i, j)
            points += [pole.X(), pole.Y(), pole.Z()]
            weights.append(surface.Weight(i, j))
    knots_u = [surface.UKnot(i) for i in range(1, surface.NbUKnots() + 1) for _ in range(surface.UMultiplicity(i))]
    knots_v = [surface.VKnot(i) for i in range(1, surface.NbVKnots() + 1) for _ in range(surface.VMultiplicity(i))]
    return {"points": points, "weights": weights, "knots_u": knots_u, "knots_v": knots_v}


def read(path):
    is_step = path.lower().endswith((".step", ".stp"))
    reader = STEPControl_Reader() if is_step else IGESControl_Reader()
    status = reader.ReadFile(path)
    roots = reader.TransferRoots()
    shape = reader.OneShape()
    about = {"path": path, "status": str(status), "roots": roots, "valid": BRepCheck_Analyzer(shape).IsValid()}
    if is_step:
        units = [Sequence_TCollection_AsciiString() for _ in range(3)]
        reader.FileUnits(*units)
        about["unit"] = units[0].Value(1).ToCString() if units[0].Length() else ""
        model = reader.StepModel()
        entities = [model.Value(i) for i in range(1, model.NbEntities() + 1)]
        about["product"] = [text(e.Name()) for e in entities if isinstance(e, StepBasic_Product)]
    edges = TopExp_Explorer(shape, TopAbs_EDGE, TopAbs_FACE)
    about["free_edges"] = 0
    while edges.More():
        about["free_edges"] += 1
        edges.Next()
    print(json.dumps(about))
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        face = TopoDS.Face(faces.Current())
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties, 1e-12)
        item = reader.WS().TransferReader().EntityFromShapeResult(face, 1)
        name = text(item.Name()) if is_step and item is not None and hasattr(item, "Name") else ""
        kind = str(BRepAdaptor_Surface(face).GetType()).split("_")[-1].split(":")[0]
        found = {"name": name, "area": properties.Mass(), "kind": kind, "reversed": str(face.Orientation()).endswith("REVERSED"), "spline": spline(face)}
        print(json.dumps(found))
        faces.Next()


for path in sys.argv[1:]:
    read(path)
