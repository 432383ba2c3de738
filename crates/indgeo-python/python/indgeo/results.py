"""What the functions return: arrays, the numbers that matter, and the whole report of the command."""

from __future__ import annotations

import html
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .shapes import Curve, Model, Surface


@dataclass(eq=False)
class Result:
    """The outcome of a command.

    ok: whether what was asked for holds, for every point, as proven (exit status 0 of the command line).
    status: `done`, or what the report calls it otherwise.
    report: the machine-readable report, as `--json` writes it; schemas in docs/schema.
    warnings: what the user should know; each was also given to `warnings.warn` as an `IndgeoWarning`.
    """

    ok: bool = field(init=False)
    status: str = field(init=False)
    summary: str = field(init=False, repr=False)
    report: dict[str, Any] = field(init=False, repr=False)
    warnings: tuple[str, ...] = field(init=False, repr=False)

    def _of(self, ended: Any) -> Any:
        self.ok = ended.exit_code == 0
        self.status = ended.report["status"]
        self.summary = ended.summary
        self.report = ended.report
        self.warnings = ended.warnings
        return self

    def to_dict(self) -> dict[str, Any]:
        """The report: plain lists, numbers and strings."""
        return self.report

    def _rows(self) -> list[tuple[str, Any]]:
        return []

    def _repr_html_(self) -> str:
        rows = [("status", self.status), *self._rows(), *(("warning", w) for w in self.warnings)]
        cells = (f"<tr><th style='text-align:left'>{name}</th><td>{html.escape(_short(value))}</td></tr>" for name, value in rows)
        return f"<table><caption>{type(self).__name__}</caption>{''.join(cells)}</table>"


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _frame(columns: dict[str, NDArray]) -> Any:
    import pandas

    return pandas.DataFrame(columns)


@dataclass(eq=False)
class _PerPoint(Result):
    """A result with a row per point.

    columns: each column of the command line by its name, (N,).
    """

    columns: dict[str, NDArray] = field(repr=False)

    def to_pandas(self) -> Any:
        """A DataFrame with one row per point, as the CSV of the command line."""
        return _frame(self.columns)


@dataclass(eq=False)
class Projection(_PerPoint):
    """Footpoints, one per point and in the order of the points.

    distance (N,): in the unit of the files, signed where the model has sides; NaN for points that are not finite.
    foot (N, D), parameter (N, 1 or 2; none on a mesh), shape (N,): where the foot is.
    lower_bound (N,): proven; no point of the model is nearer.
    point_status (N,): `converged`, `on_boundary`, `uncertified`, `invalid_point`, ...
    """

    distance: NDArray[np.float64] = field(repr=False)
    foot: NDArray[np.float64] = field(repr=False)
    parameter: NDArray[np.float64] = field(repr=False)
    shape: NDArray[np.int32] = field(repr=False)
    lower_bound: NDArray[np.float64] = field(repr=False)
    point_status: NDArray = field(repr=False)

    @property
    def rms(self) -> float | None:
        """Root mean square distance."""
        return self.report["results"]["rms"]

    @property
    def max(self) -> float | None:
        """Largest distance, without its sign."""
        return self.report["results"]["max"]

    def _rows(self) -> list[tuple[str, Any]]:
        return [("points", len(self.distance)), ("rms", self.rms), ("max", self.max)]


class _Judged(Result):
    """What inspections have in common, of points in memory and of tiles."""

    @property
    def within_tolerance(self) -> bool:
        """Whether enough points are within the tolerance."""
        return self.report["results"]["within_tolerance"]

    @property
    def share_within(self) -> float:
        """Share of the judged points that are."""
        return self.report["results"]["share_within"]

    @property
    def rms(self) -> float | None:
        """Root mean square deviation."""
        return self.report["results"]["rms"]

    @property
    def max(self) -> float | None:
        """Largest deviation, without its sign."""
        return self.report["results"]["max"]


@dataclass(eq=False)
class Inspection(_PerPoint, _Judged):
    """Deviations of points from a model, judged by a tolerance.

    deviation (N,): in the unit of the files, positive on the side of the normals; NaN for points that were not measured.
    foot (N, 3): where each was measured.
    outcome (N,): `within`, `under`, `over`, or why a point was not measured, as in the column `result` of the command line.
    """

    deviation: NDArray[np.float64] = field(repr=False)
    foot: NDArray[np.float64] = field(repr=False)
    outcome: NDArray = field(repr=False)

    def _rows(self) -> list[tuple[str, Any]]:
        return [
            ("points", len(self.deviation)),
            ("within tolerance", self.within_tolerance),
            ("share within", self.share_within),
            ("rms", self.rms),
            ("max", self.max),
        ]


@dataclass(eq=False)
class Registration(Result):
    """A motion that lays points on a model: x ↦ matrix · x in homogeneous coordinates.

    matrix (4, 4): its rotation times `scale`, and its translation in the unit of the files.
    scale: 1 unless a scale was asked for.
    rms: root mean square distance of the points that count from the model, in the unit of the files; NaN without points.
    """

    matrix: NDArray[np.float64]
    scale: float
    rms: float

    @property
    def covariance(self) -> NDArray[np.float64] | None:
        """Covariance of the motion (6, 6): translation, then rotation about its origin; None where there is none."""
        found = self.report["results"].get("covariance")
        return None if not found else np.array(found["rows"], dtype=np.float64)

    @property
    def equivalent_poses(self) -> list[Any]:
        """Poses that the shape of the model does not tell apart, this one the first; empty where there are none."""
        return self.report["results"].get("equivalent_poses") or []

    def apply(self, points: ArrayLike) -> NDArray[np.float64]:
        """The points (N, 3) moved; (N, 2) in the plane."""
        array = np.asarray(points, dtype=np.float64)
        d = array.shape[-1]
        return array @ self.matrix[:d, :d].T + self.matrix[:d, 3]

    def _rows(self) -> list[tuple[str, Any]]:
        return [("rms", self.rms), ("scale", self.scale), ("matrix", self.matrix.tolist())]


@dataclass(eq=False)
class Views(Result):
    """Poses of many views.

    matrices (K, 4, 4): of view i that which brings it into the common frame; NaN where its place was not found. Translations are in the
    unit of the files.
    rms: root mean square distance of the matched points, in that unit; None without any.
    """

    matrices: NDArray[np.float64] = field(repr=False)
    rms: float | None

    def _rows(self) -> list[tuple[str, Any]]:
        return [("views", len(self.matrices)), ("rms", self.rms)]


@dataclass(eq=False)
class _Fit(Result):
    """What all fits report."""

    @property
    def _numbers(self) -> dict[str, Any]:
        return self.report["results"]

    @property
    def rms(self) -> float:
        """Root mean square distance of the points that count."""
        return self._numbers["rms"]

    @property
    def max(self) -> float:
        """The largest distance of one of them."""
        return self._numbers["max"]

    @property
    def within_tolerance(self) -> bool | None:
        """Whether the tolerance holds; None where none was asked for."""
        return self._numbers["within_tolerance"]

    def _rows(self) -> list[tuple[str, Any]]:
        return [("rms", self.rms), ("max", self.max), ("within tolerance", self.within_tolerance)]


@dataclass(eq=False)
class CurveFit(_Fit):
    """A fitted curve.

    model: the curve, or all of them where the points are several outlines, in the unit of the points.
    """

    model: Model

    @property
    def curve(self) -> Curve:
        """The curve, the first of several."""
        return self.model[0]  # type: ignore[return-value]


@dataclass(eq=False)
class SurfaceFit(_Fit):
    """A fitted surface.

    surface: a B-spline surface, rational where weights were asked for, in the unit of the points.
    """

    surface: Surface


@dataclass(eq=False)
class Parameterization(_PerPoint):
    """Parameters of points on a base surface.

    parameter (N, 2); NaN where a point has none. used (N,): whether the point counts for a fit.
    distance (N,): signed, from the base surface. base: the base surface.
    """

    base: Surface
    parameter: NDArray[np.float64] = field(repr=False)
    distance: NDArray[np.float64] = field(repr=False)
    used: NDArray[np.bool_] = field(repr=False)

    def _rows(self) -> list[tuple[str, Any]]:
        return [("points", len(self.used)), ("used", int(self.used.sum())), ("rms", self.report["results"]["rms"])]
