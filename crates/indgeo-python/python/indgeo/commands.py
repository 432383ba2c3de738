"""The commands as functions. Lengths are in the unit of the inputs; units, defaults and verdicts are those of the command line.

A `model` is a path (STEP, IGES, NURBS JSON, STL, PLY, OBJ, ...), a `Curve`, `Surface`, `Model` or `Mesh`. `points` are an array (N, 3),
(N, 2) in the plane, a `Cloud`, a `Mesh` (its vertices) or a path. Keyword arguments that are not listed go to the command line as they are:
`max_distance=2.0` is `--max-distance=2.0`, `True` is a switch. `threads` does not change results. `progress` is `True` (a bar by tqdm) or a
function of (text, done, total). An interrupt (Ctrl-C) stops the work.

Every function raises `ValueError` for input that cannot be used and `OSError` for files that cannot be read or written, with the message
of the command line. A result whose `ok` is false is no error: the answer is "no", or it is not proven.
"""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._command import Call, IndgeoWarning, Progress
from .clouds import Cloud, Mesh
from .results import CurveFit, Inspection, Parameterization, Projection, Registration, Result, SurfaceFit, Views
from .shapes import Curve, Model, Surface

AnyModel = str | os.PathLike | Curve | Surface | Model | Mesh | Sequence[Curve | Surface]
AnyPoints = str | os.PathLike | ArrayLike | Cloud | Mesh
_EXTRA = {"x", "y", "z", "nx", "ny", "nz"}


def read(
    path: str | os.PathLike,
    *,
    scan: str | int | None = None,
    drop_non_finite: bool = False,
    decimal_comma: bool = False,
) -> Cloud | Mesh | Model:
    """Reads points, triangles, or curves and surfaces, in any format that the command line reads; recognised by content.

    scan: name or number of one scan of a file of several (E57, PTX); all together without.
    """
    options = {"scan": scan, "drop_non_finite": drop_non_finite, "decimal_comma": decimal_comma}
    info = Call("info")
    info.arguments.append(info._path(path, "path", "a path"))
    found = info.options({"scan": scan, "decimal_comma": decimal_comma}).run().report["inputs"][0]
    name = "content.json" if found["shapes"] else "content.ply"
    call = Call("convert")
    call.arguments += [call._path(path, "path", "a path"), call.memory(name)]
    ended = call.options(options).run()
    if found["shapes"]:
        return Model.from_json(ended.text(name))
    table = ended.points(name)
    points = table.stack("x", "y", "z")
    if len(table.triangles):
        return Mesh(points, table.triangles)
    normals = table.stack("nx", "ny", "nz")
    columns = {name: column for name, column in table.columns.items() if name not in _EXTRA}
    return Cloud(points, normals if normals.shape[1] == 3 else None, columns)


def project(
    model: AnyModel,
    points: AnyPoints,
    *,
    mode: str = "certified",
    max_angle: float | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> Projection:
    """Footpoints on the model, each with a proof that no other point is nearer.

    mode: `certified`, `fast` (no proof) or `local`. max_angle: largest angle in degrees between the normals of points and feet.

    >>> import indgeo, numpy as np
    >>> circle = indgeo.Curve.bspline(2, [0, 0, 0, 1, 1, 1], [[1, 0], [1, 1], [0, 1]], [1, 0.5 ** 0.5, 1])
    >>> indgeo.project(circle, np.array([[2.0, 2.0]])).distance.round(12)
    array([1.82842712])
    """
    call = Call("project").model(model).points(points)
    call.options({"out": call.memory("feet.columns"), "mode": mode, "max_angle": max_angle, "threads": threads, **options})
    ended = call.run(progress)
    table = ended.table("feet.columns")
    columns = table.with_words()
    parameter = table.stack("t") if "t" in columns else table.stack("u", "v")
    return Projection(
        columns=columns,
        distance=columns["distance"],
        foot=table.stack("foot_x", "foot_y", "foot_z"),
        parameter=parameter,
        shape=columns.get("shape", np.zeros(table.rows, dtype=np.int32)),
        lower_bound=columns["lower_bound"],
        point_status=columns["status"],
    )._of(ended)


def inspect(
    model: AnyModel,
    points: AnyPoints,
    tolerance: float | None = None,
    *,
    lower: float | None = None,
    upper: float | None = None,
    min_share: float = 1.0,
    max_angle: float | None = None,
    transform: ArrayLike | str | os.PathLike | None = None,
    report: str | os.PathLike | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> Inspection:
    """Signed deviations of points from the model, and whether they are within tolerance.

    tolerance: allowed deviation to both sides; lower and upper replace one limit each. min_share: share of the points that must be within.
    max_angle: largest angle in degrees between the normals of point and model. transform (4, 4): moves the points first.
    report: writes a page (HTML) with the map of the deviations.
    """
    call = Call("inspect").model(model).points(points).matrix("transform", transform)
    call.options({"out": call.memory("deviations.columns"), "tolerance": tolerance, "lower": lower, "upper": upper})
    call.options({"min_share": min_share, "max_angle": max_angle, "report": report, "threads": threads, **options})
    ended = call.run(progress)
    table = ended.table("deviations.columns")
    columns = table.with_words()
    return Inspection(
        columns=columns,
        deviation=columns["distance"],
        foot=table.stack("foot_x", "foot_y", "foot_z"),
        outcome=columns["result"],
    )._of(ended)


def register(
    model: AnyModel,
    points: AnyPoints,
    *,
    init: ArrayLike | str | os.PathLike | None = None,
    scale: bool = False,
    lock: str | Sequence[str] | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> Registration:
    """The motion that lays the points on the model.

    init (4, 4) or (K, 4, 4): starts to be tried; without, where the points are, and all positions if that is not good.
    scale: finds a factor of size, too. lock: degrees of freedom that stay (`tx`, `ty`, `tz`, `rx`, `ry`, `rz`).
    """
    call = Call("register").model(model).points(points).matrix("init", init)
    call.options({"scale": scale, "lock": lock, "threads": threads, "transform": call.memory("motion.json"), **options})
    ended = call.run(progress)
    found = ended.report["results"]
    return Registration(matrix=np.array(found["matrix"]), scale=found["scale"], rms=_number(found["rms"]))._of(ended)


def register_views(
    views: Sequence[AnyPoints],
    *,
    init: ArrayLike | str | os.PathLike | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> Views:
    """Brings several scans of one object into a common frame.

    views: two or more clouds. init (K, 4, 4): a pose per view to start from.
    """
    call = Call("register-views")
    with tempfile.TemporaryDirectory(prefix="indgeo-") as folder:
        for index, view in enumerate(views):
            if isinstance(view, (str, os.PathLike)):
                call.points(view, f"views[{index}]")
                continue
            cloud = view if isinstance(view, (Cloud, Mesh)) else Cloud(np.asarray(view))
            path = Path(folder, f"view{index}.ply")
            path.write_bytes(cloud._data())
            call.arguments.append(str(path))
        call.matrix("init", init).options({"out": os.path.join(folder, "moved"), "threads": threads, **options})
        ended = call.run(progress)
    found = ended.report["results"]
    nowhere = [[np.nan] * 4] * 4
    matrices = [view.get("matrix") or nowhere for view in found["views"]]
    return Views(matrices=np.array(matrices, dtype=np.float64), rms=found["rms"])._of(ended)


def fit_curve(
    points: AnyPoints,
    *,
    tolerance: float | None = None,
    control_points: int | None = None,
    closed: bool | None = None,
    init: Curve | str | os.PathLike | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> CurveFit:
    """A B-spline curve, or several, through points in any order.

    tolerance: every point within it, with as few control points as that takes; without, the noise of the points decides.
    """
    shape = {"closed": closed is True, "open": closed is False}
    call = Call("fit-curve").points(points)
    call.options({"out": call.memory("curve.json"), "tolerance": tolerance, "control_points": control_points, **shape})
    call.options({"init": _shape(call, init), "threads": threads, **options})
    ended = call.run(progress)
    return CurveFit(model=Model.from_json(ended.text("curve.json")))._of(ended)


def fit_surface(
    points: AnyPoints,
    *,
    tolerance: float | None = None,
    control_points: tuple[int, int] | None = None,
    init: Surface | str | os.PathLike | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> SurfaceFit:
    """A B-spline surface through points in any order, without parameters.

    tolerance: every point within it; without, the noise of the points decides. control_points: (n, m).
    """
    call = Call("fit-surface").points(points)
    call.options({"out": call.memory("surface.json"), "tolerance": tolerance, "control_points": _pair(control_points)})
    call.options({"init": _shape(call, init), "threads": threads, **options})
    ended = call.run(progress)
    return SurfaceFit(surface=Model.from_json(ended.text("surface.json"))[0])._of(ended)  # type: ignore[arg-type]


def parameterize(
    points: AnyPoints,
    *,
    shape: str = "auto",
    axis: ArrayLike | None = None,
    threads: int | None = None,
    progress: Progress = False,
    **options: Any,
) -> Parameterization:
    """Parameters of points in any order, by their feet on a base surface that is found for them.

    shape: `auto`, or the kind of base surface. axis (3,): the direction around which a tube is laid.
    """
    call = Call("parameterize").points(points)
    call.options({"out": call.memory("base.json"), "params": call.memory("uv.columns"), "shape": shape, "threads": threads})
    call.options({"axis": None if axis is None else np.asarray(axis, dtype=np.float64), **options})
    ended = call.run(progress)
    table = ended.table("uv.columns")
    columns = table.with_words()
    return Parameterization(
        columns=columns,
        base=Model.from_json(ended.text("base.json"))[0],  # type: ignore[arg-type]
        parameter=table.stack("u", "v"),
        distance=columns["distance"],
        used=columns["used"].astype(bool),
    )._of(ended)


def command(name: str, *arguments: Any, threads: int | None = None, progress: Progress = False, **options: Any) -> Result:
    """Any command of the command line by its name; its files are read and written as it says.

    arguments: paths, arrays, clouds, meshes, curves and surfaces, in the order of the command line. An option that is a word of Python
    ends with an underscore: `from_=0`.

    >>> import indgeo
    >>> indgeo.command("info", indgeo.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])).report["inputs"][0]["triangles"]
    1
    """
    call = Call(name)
    for index, argument in enumerate(arguments):
        if isinstance(argument, (Curve, Surface, Model)):
            call.model(argument, f"argument{index}")
        else:
            call.points(argument, f"argument{index}")
    return Result()._of(call.options({"threads": threads, **options}).run(progress))


def tessellate(model: AnyModel, *, chord: float | None = None) -> Mesh:
    """Triangles that stay within `chord` of the surfaces of a model, in its unit; a thousandth of its size without."""
    call = Call("convert").model(model)
    call.arguments.append(call.memory("mesh.ply"))
    with warnings.catch_warnings():
        # Arrays have no unit.
        warnings.filterwarnings("ignore", ".* which this format does not state", IndgeoWarning)
        table = call.option("chord", chord).run().points("mesh.ply")
    return Mesh(table.stack("x", "y", "z"), table.triangles)


def _number(value: float | None) -> float:
    return float("nan") if value is None else value


def _pair(pair: Any) -> str | None:
    if pair is None or isinstance(pair, str):
        return pair
    n, m = pair
    return f"{n}x{m}"


def _shape(call: Call, init: Any) -> Any:
    if isinstance(init, (Curve, Surface)):
        return call._input("init", init.to_json().encode())
    return init


__all__ = [
    "command",
    "fit_curve",
    "fit_surface",
    "inspect",
    "parameterize",
    "project",
    "read",
    "register",
    "register_views",
    "tessellate",
]
