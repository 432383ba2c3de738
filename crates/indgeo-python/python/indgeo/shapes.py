"""Curves, surfaces, and models of several of them."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _indgeo
from .clouds import Mesh


def _flag(document: dict[str, Any], name: str) -> bool:
    return bool(document.get(name) or False)


class _Shape:
    """What curves and surfaces have in common: the NURBS JSON that they are written in."""

    _native_class: Any
    _document: dict[str, Any]

    def __init__(self, document: dict[str, Any]) -> None:
        self._document = {key: value for key, value in document.items() if value is not None}
        # Checks everything, so that no shape exists that the library refuses.
        self._native = self._native_class(json.dumps(self._document))

    def to_json(self) -> str:
        """The shape as NURBS JSON; numbers come back bit for bit."""
        return json.dumps(self._document)

    @classmethod
    def from_json(cls, text: str) -> Any:
        """The shape of a text in NURBS JSON."""
        return cls(json.loads(text))

    def save(self, path: str | os.PathLike, *, name: str | None = None, unit: str | None = None) -> None:
        """Writes the shape: .json, .step, .igs by the extension of `path`; others as a tessellation.

        name, unit: what STEP and IGES state; mm without.
        """
        Model([self]).save(path, name=name, unit=unit)

    @property
    def name(self) -> str | None:
        """Its name."""
        return self._document.get("name")

    @property
    def control_points(self) -> NDArray[np.float64]:
        """Control points, (n, D) of a curve, (n_u, n_v, 3) of a surface; not multiplied by their weights."""
        return np.array(self._document["control_points"], dtype=np.float64)

    @property
    def weights(self) -> NDArray[np.float64] | None:
        """Weights in the arrangement of the control points; None where the shape is not rational."""
        weights = self._document.get("weights")
        return None if weights is None else np.array(weights, dtype=np.float64)

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and self._document == other._document  # type: ignore[attr-defined]

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self._document,)


class Curve(_Shape):
    """A B-spline curve in the plane or in space, rational or not.

    `Curve.bspline(...)` makes one from arrays. Parameters outside the domain continue the curve, or are wrapped if it is periodic.
    """

    _native_class = _indgeo.Curve

    @staticmethod
    def bspline(
        degree: int,
        knots: ArrayLike,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        periodic: bool = False,
        name: str | None = None,
    ) -> Curve:
        """A curve of n control points (n, 2 or 3) with n + degree + 1 knots."""
        document = {
            "kind": "curve",
            "degree": int(degree),
            "knots": np.asarray(knots, dtype=np.float64).tolist(),
            "control_points": np.asarray(control_points, dtype=np.float64).tolist(),
            "weights": None if weights is None else np.asarray(weights, dtype=np.float64).tolist(),
            "periodic": periodic or None,
            "name": name,
        }
        return Curve(document)

    @property
    def degree(self) -> int:
        """The degree."""
        return int(self._document["degree"])

    @property
    def knots(self) -> NDArray[np.float64]:
        """All knots, (n + degree + 1,)."""
        return np.array(self._document["knots"], dtype=np.float64)

    @property
    def is_periodic(self) -> bool:
        """Whether the curve closes smoothly."""
        return _flag(self._document, "periodic")

    @property
    def domain(self) -> tuple[float, float]:
        """The interval of parameters."""
        return self._native.domain()

    def evaluate(self, t: ArrayLike) -> NDArray[np.float64]:
        """Points at the parameters t (N,): (N, D)."""
        return self.derivatives(t, 0)[:, 0]

    def derivatives(self, t: ArrayLike, order: int = 1) -> NDArray[np.float64]:
        """Points and derivatives at t (N,): (N, order + 1, D), the point at [:, 0]; order at most 8."""
        return self._native.derivatives(_parameters(t), order)

    def curvature(self, t: ArrayLike) -> NDArray[np.float64]:
        """Curvatures at t (N,): (N,), with a sign in the plane; NaN where the curve has no tangent."""
        return self._native.curvature(_parameters(t))

    def tessellate(self, n: int = 200) -> NDArray[np.float64]:
        """n points at equal steps of the parameter, (n, D)."""
        return self.evaluate(np.linspace(*self.domain, n))

    def __repr__(self) -> str:
        points = self.control_points
        return f"<Curve degree {self.degree}, {len(points)} control points in {points.shape[1]}D>"


class Surface(_Shape):
    """A B-spline surface in space, rational or not; `Surface.bspline(...)` makes one from arrays."""

    _native_class = _indgeo.Surface

    @staticmethod
    def bspline(
        degrees: tuple[int, int],
        knots_u: ArrayLike,
        knots_v: ArrayLike,
        control_points: ArrayLike,
        weights: ArrayLike | None = None,
        *,
        periodic: tuple[bool, bool] = (False, False),
        name: str | None = None,
    ) -> Surface:
        """A surface of control points (n_u, n_v, 3)."""
        document = {
            "kind": "surface",
            "degree_u": int(degrees[0]),
            "degree_v": int(degrees[1]),
            "knots_u": np.asarray(knots_u, dtype=np.float64).tolist(),
            "knots_v": np.asarray(knots_v, dtype=np.float64).tolist(),
            "control_points": np.asarray(control_points, dtype=np.float64).tolist(),
            "weights": None if weights is None else np.asarray(weights, dtype=np.float64).tolist(),
            "periodic_u": periodic[0] or None,
            "periodic_v": periodic[1] or None,
            "name": name,
        }
        return Surface(document)

    @property
    def degrees(self) -> tuple[int, int]:
        """The degrees in u and v."""
        return int(self._document["degree_u"]), int(self._document["degree_v"])

    @property
    def knots(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """All knots in u and in v."""
        return np.array(self._document["knots_u"], dtype=np.float64), np.array(self._document["knots_v"], dtype=np.float64)

    @property
    def is_periodic(self) -> tuple[bool, bool]:
        """Whether the surface closes smoothly in u and in v."""
        return _flag(self._document, "periodic_u"), _flag(self._document, "periodic_v")

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The intervals of u and of v."""
        return self._native.domain()

    @property
    def trim(self) -> list[NDArray[np.float64]]:
        """Closed loops of parameters, each (K, 2), between which the data of a fit lie; empty where they fill the whole rectangle."""
        return [np.array(loop, dtype=np.float64) for loop in self._document.get("trim") or []]

    def evaluate(self, uv: ArrayLike) -> NDArray[np.float64]:
        """Points at the parameters uv (N, 2): (N, 3)."""
        return self._native.evaluate(_pairs(uv))

    def derivatives(self, uv: ArrayLike, order: int = 1) -> NDArray[np.float64]:
        """Partial derivatives at uv (N, 2): (N, order + 1, order + 1, 3), [i, k, l] that of order k in u and l in v.

        NaN where k + l > order; order at most 8.
        """
        return self._native.derivatives(_pairs(uv), order)

    def normals(self, uv: ArrayLike) -> NDArray[np.float64]:
        """Unit normals du × dv at uv (N, 2): (N, 3); NaN where the surface is not regular."""
        return self._native.normals_and_curvatures(_pairs(uv))[0]

    def curvatures(self, uv: ArrayLike) -> NDArray[np.float64]:
        """Principal curvatures at uv (N, 2): (N, 2); NaN where the surface is not regular."""
        return self._native.normals_and_curvatures(_pairs(uv))[1]

    def grid(self, n: int = 50, m: int | None = None) -> NDArray[np.float64]:
        """Points at n × m equal steps of the parameters, (n, m, 3)."""
        (u0, u1), (v0, v1) = self.domain
        m = n if m is None else m
        u, v = np.meshgrid(np.linspace(u0, u1, n), np.linspace(v0, v1, m), indexing="ij")
        return self.evaluate(np.stack([u.ravel(), v.ravel()], axis=1)).reshape(n, m, 3)

    def tessellate(self, chord: float | None = None) -> Mesh:
        """Triangles that stay within `chord` of the surface; a thousandth of its size without."""
        from .commands import tessellate

        return tessellate(self, chord=chord)

    def __repr__(self) -> str:
        n, m = self.control_points.shape[:2]
        return f"<Surface degrees {self.degrees[0]} × {self.degrees[1]}, {n} × {m} control points>"


class Model:
    """Several curves and surfaces, all in the plane or all in space."""

    def __init__(self, shapes: list[Curve | Surface]) -> None:
        if not shapes:
            raise ValueError("a model needs at least one curve or surface")
        self.shapes = list(shapes)

    @staticmethod
    def from_json(text: str) -> Model:
        """The model of a text in NURBS JSON: a curve, a surface, or several."""
        document = json.loads(text)
        listed = document.get("shapes", [document])
        return Model([Curve(s) if s.get("kind") == "curve" else Surface(s) for s in listed])

    def to_json(self) -> str:
        """The model as NURBS JSON."""
        if len(self.shapes) == 1:
            return self.shapes[0].to_json()
        return json.dumps({"kind": "model", "shapes": [shape._document for shape in self.shapes]})

    def save(self, path: str | os.PathLike, *, name: str | None = None, unit: str | None = None) -> None:
        """Writes the model: .json, .step, .igs by the extension of `path`; others as a tessellation."""
        from ._command import Call

        call = Call("convert").model(self, "model.json")
        call.arguments.append(call._path(path, "path", "a path"))
        call.options({"name": name, "unit": unit}).run()

    def __len__(self) -> int:
        return len(self.shapes)

    def __iter__(self) -> Iterator[Curve | Surface]:
        return iter(self.shapes)

    def __getitem__(self, index: int) -> Curve | Surface:
        return self.shapes[index]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self.shapes == other.shapes

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return f"<Model of {len(self.shapes)}: {', '.join(map(repr, self.shapes[:4]))}{', …' if len(self.shapes) > 4 else ''}>"


def _parameters(t: ArrayLike) -> NDArray[np.float64]:
    array = np.atleast_1d(np.asarray(t, dtype=np.float64))
    if array.ndim != 1:
        raise ValueError(f"t has shape {array.shape}, it must be (N,)")
    return np.ascontiguousarray(array)


def _pairs(uv: ArrayLike) -> NDArray[np.float64]:
    array = np.atleast_2d(np.asarray(uv, dtype=np.float64))
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"uv has shape {array.shape}, it must be (N, 2)")
    return np.ascontiguousarray(array)
