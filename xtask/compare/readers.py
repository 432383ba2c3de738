"""Coordinates of point clouds and meshes as other readers find them: readers.py FOLDER OUT

For every PLY, PCD, STL, OBJ and OFF file below FOLDER the coordinates are written to OUT as little endian doubles, three per point, and a
line of JSON says what they are: `ordered` points, the `corners` of all triangles in their order, or a `set` whose order is the reader's.
Needs numpy, trimesh, plyfile and pypcd4.
"""

import json
import os
import sys

import numpy
import plyfile
import pypcd4
import trimesh


def read_ply(path):
    data = plyfile.PlyData.read(path)
    for element in data:
        names = {p.name.lower(): p.name for p in element.properties}
        if "x" in names and "y" in names:
            zeros = numpy.zeros(len(element.data))
            columns = [element.data[names[axis]] if axis in names else zeros for axis in "xyz"]
            return "plyfile", "ordered", numpy.column_stack([c.astype(float) for c in columns])
    raise ValueError("no coordinates")


def read_pcd(path):
    cloud = pypcd4.PointCloud.from_path(path)
    return "pypcd4", "ordered", cloud.numpy(("x", "y", "z")).astype(float)


def read_stl(path):
    mesh = trimesh.load(path, process=False, force="mesh")
    return "trimesh", "corners", numpy.asarray(mesh.triangles, float).reshape(-1, 3)


def read_mesh(path):
    found = trimesh.load(path, process=False, maintain_order=True)
    parts = found.dump() if isinstance(found, trimesh.Scene) else [found]
    return "trimesh", "set", numpy.vstack([numpy.asarray(part.vertices, float) for part in parts])


READERS = {".ply": read_ply, ".pcd": read_pcd, ".stl": read_stl, ".obj": read_mesh, ".off": read_mesh}


def main(folder, out):
    paths = [os.path.join(base, name) for base, _, names in os.walk(folder) for name in names]
    for number, path in enumerate(sorted(paths)):
        reader = READERS.get(os.path.splitext(path)[1].lower())
        if reader is None:
            continue
        try:
            name, kind, points = reader(path)
            target = os.path.join(out, f"{number}.bin")
            numpy.ascontiguousarray(points, "<f8").tofile(target)
            print(json.dumps({"path": path, "reader": name, "kind": kind, "file": target}))
        except Exception as error:  # whatever the readers raise
            print(json.dumps({"path": path, "error": f"{type(error).__name__}: {error}"[:80]}))


main(*sys.argv[1:3])
