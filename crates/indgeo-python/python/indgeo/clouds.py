"""Points and triangles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _ply


def _points(points: ArrayLike, name: str, dimensions: tuple[int, ...]) -> NDArray[np.float64]:
    array = np.asarray(points)
    if array.dtype.kind not in "fiu":
        raise ValueError(f"{name} has dtype {array.dtype}, it must be a number")
    if array.ndim != 2 or array.shape[1] not in dimensions:
        wanted = " or ".join(f"(N, {d})" for d in dimensions)
        raise ValueError(f"{name} has shape {array.shape}, it must be {wanted}")
    if len(array) == 0:
        raise ValueError(f"{name} has no rows, give at least one point")
    return np.ascontiguousarray(array, dtype=np.float64)


@dataclass
class Cloud:
    """Points with what was measured at them.

    points: (N, 3), or (N, 2) in the plane; rows with NaN count as not finite.
    normals: (N, 3) or None.
    columns: further columns of numbers by name, each (N,).
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64] | None = None
    columns: Mapping[str, NDArray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.points = _points(self.points, "points", (2, 3))
        if self.normals is not None:
            self.normals = _points(self.normals, "normals", (3,))
            if len(self.normals) != len(self.points):
                raise ValueError(f"normals has {len(self.normals)} rows, points has {len(self.points)}")
        self.columns = {name: np.asarray(column) for name, column in self.columns.items()}
        for name, column in self.columns.items():
            if column.shape != (len(self.points),):
                raise ValueError(f"column {name!r} has shape {column.shape}, it must be ({len(self.points)},)")

    def __len__(self) -> int:
        return len(self.points)

    def _data(self) -> bytes:
        if self.points.shape[1] == 2:
            # Two columns say that the points lie in the plane; only text can.
            return "".join(f"{x!r} {y!r}\n" for x, y in self.points.tolist()).encode("ascii")
        if self.normals is None and not self.columns:
            return _ply.write_points(self.points)
        columns = dict(zip("xyz", self.points.T))
        if self.normals is not None:
            columns |= dict(zip(("nx", "ny", "nz"), self.normals.T))
        columns |= {name: c for name, c in self.columns.items() if c.dtype.kind in "fiu" and name not in columns}
        return _ply.write(columns)

    @staticmethod
    def from_open3d(cloud: Any) -> Cloud:
        """From an `open3d.geometry.PointCloud`."""
        normals = np.asarray(cloud.normals) if cloud.has_normals() else None
        return Cloud(np.asarray(cloud.points), normals)

    def to_pyvista(self) -> Any:
        """A `pyvista.PolyData` with normals and columns as point data."""
        import pyvista

        data = pyvista.PolyData(self.points)
        if self.normals is not None:
            data.point_data["normals"] = self.normals
        for name, column in self.columns.items():
            data.point_data[name] = column
        return data


@dataclass
class Mesh:
    """Triangles over vertices.

    vertices: (N, 3). triangles: (M, 3), indices from 0.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.uint32]

    def __post_init__(self) -> None:
        self.vertices = _points(self.vertices, "vertices", (3,))
        triangles = np.asarray(self.triangles)
        if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
            raise ValueError(f"triangles has shape {triangles.shape} and dtype {triangles.dtype}, it must be (M, 3) of integers")
        if len(triangles) and (triangles.min() < 0 or triangles.max() >= len(self.vertices)):
            raise ValueError(f"triangles names vertices that are not there: 0 to {len(self.vertices) - 1} are allowed")
        self.triangles = np.ascontiguousarray(triangles, dtype=np.uint32)

    def _data(self) -> bytes:
        return _ply.write_points(self.vertices, self.triangles)

    @staticmethod
    def from_trimesh(mesh: Any) -> Mesh:
        """From a `trimesh.Trimesh`."""
        return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces))

    @staticmethod
    def from_open3d(mesh: Any) -> Mesh:
        """From an `open3d.geometry.TriangleMesh`."""
        return Mesh(np.asarray(mesh.vertices), np.asarray(mesh.triangles))

    def to_trimesh(self) -> Any:
        """A `trimesh.Trimesh` with the same vertices and triangles."""
        import trimesh

        return trimesh.Trimesh(self.vertices, self.triangles, process=False)

    def to_pyvista(self) -> Any:
        """A `pyvista.PolyData`."""
        import pyvista

        faces = np.hstack([np.full((len(self.triangles), 1), 3), self.triangles])
        return pyvista.PolyData(self.vertices, faces.ravel())
