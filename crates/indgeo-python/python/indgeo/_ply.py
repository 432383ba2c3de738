"""Binary PLY in memory: the form in which points and triangles go to a command and come back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_KINDS = {"double": "<f8", "float": "<f4", "int": "<i4", "uint": "<u4", "uchar": "u1", "char": "i1", "short": "<i2", "ushort": "<u2"}
_NAMES = {"f8": "double", "f4": "float", "i4": "int", "u4": "uint", "u1": "uchar", "i1": "char", "i2": "short", "u2": "ushort"}


def write(columns: dict[str, NDArray], triangles: NDArray | None = None) -> bytes:
    """Columns of numbers of equal length, and triangles (M, 3) over them."""
    kinds = []
    for name, column in columns.items():
        kind = np.dtype(column.dtype).str[1:]
        kinds.append((name, "<" + kind if kind in _NAMES else "<f8"))
    rows = np.empty(len(next(iter(columns.values()))), dtype=kinds)
    for name, column in columns.items():
        rows[name] = column
    return _written(kinds, rows, triangles)


def write_points(points: NDArray[np.float64], triangles: NDArray | None = None) -> bytes:
    """Coordinates (N, 3) in rows, and triangles (M, 3) over them."""
    return _written([(name, "<f8") for name in "xyz"], np.ascontiguousarray(points, dtype="<f8"), triangles)


def _written(kinds: list[tuple[str, str]], rows: NDArray, triangles: NDArray | None) -> bytes:
    count = len(rows)
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {count}"]
    header += [f"property {_NAMES[np.dtype(kind).str[1:]]} {name}" for name, kind in kinds]
    body = [rows.view(np.uint8).data]
    if triangles is not None:
        header += [f"element face {len(triangles)}", "property list uchar uint vertex_indices"]
        faces = np.empty(len(triangles), dtype=[("count", "u1"), ("corners", "<u4", 3)])
        faces["count"] = 3
        faces["corners"] = triangles
        body.append(faces.view(np.uint8).data)
    return b"".join([("\n".join([*header, "end_header"]) + "\n").encode("ascii"), *body])


class Table:
    """The vertices of a PLY file by column, and its triangles."""

    def __init__(self, data: bytes) -> None:
        # The rows are read where they are: copying them takes as long as all the rest.
        end = data.find(b"end_header\n")
        lines = data[: max(end, 0)].decode("utf-8", "replace").splitlines()
        elements: list[tuple[str, int, list[tuple[str, ...]]]] = []
        for line in lines:
            words = line.split()
            if words[:1] == ["element"]:
                elements.append((words[1], int(words[2]), []))
            elif words[:1] == ["property"]:
                elements[-1][2].append(tuple(words[1:]))
        self.columns: dict[str, NDArray] = {}
        self.triangles = np.empty((0, 3), dtype=np.uint32)
        body, at = data, end + len(b"end_header\n")
        for name, count, properties in elements:
            if name == "vertex":
                at = self._vertices(body, at, count, properties)
            elif name == "face" and count > 0:
                kind = np.dtype([("count", "u1"), ("corners", "<u4", 3)])
                faces = np.frombuffer(body, dtype=kind, count=count, offset=at)
                self.triangles = faces["corners"].copy()
                at += count * kind.itemsize

    def _vertices(self, body: bytes, at: int, count: int, properties: list[tuple[str, ...]]) -> int:
        fixed = [(name[-1], _KINDS[name[0]]) for name in properties if name[0] != "list"]
        lists = [p for p in properties if p[0] == "list"]
        kind = np.dtype(fixed)
        if not lists:
            rows = np.frombuffer(body, dtype=kind, count=count, offset=at)
            self.columns = {name: np.ascontiguousarray(rows[name]) for name, _ in fixed}
            return at + count * kind.itemsize
        # Names of points are the last column and of different lengths.
        length = np.dtype(_KINDS[lists[0][1]])
        rows = np.empty(count, dtype=kind)
        labels = []
        for row in range(count):
            rows[row] = np.frombuffer(body, dtype=kind, count=1, offset=at)[0]
            at += kind.itemsize
            size = int(np.frombuffer(body, dtype=length, count=1, offset=at)[0])
            at += length.itemsize
            labels.append(body[at : at + size].decode("utf-8", "replace"))
            at += size
        self.columns = {name: rows[name].copy() for name, _ in fixed}
        self.columns[lists[0][-1]] = np.array(labels, dtype=object)
        return at

    def stack(self, *names: str) -> NDArray[np.float64]:
        """Columns side by side, (N, number of names); those that are missing are left out."""
        present = [self.columns[name] for name in names if name in self.columns]
        count = len(next(iter(self.columns.values()))) if self.columns else 0
        return np.stack(present, axis=1) if present else np.empty((count, 0))
