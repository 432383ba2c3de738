"""Inspection and registration of scans in many files, or of parts of one file, on one machine or on a Dask cluster.

Every tile is measured by itself and leaves behind a partial result with exact sums; the partial results are folded here. Report, page
and pose are the same to the byte whatever the number of workers, the order in which they finish, or how often one of them died.

>>> from dask.distributed import Client                                                      # doctest: +SKIP
>>> found = indgeo.distributed.inspect("part.step", "tiles/*.laz", 0.05, client=Client("scheduler:8786"))  # doctest: +SKIP

Needs nothing else without a client; with one, `pip install indgeo[distributed]`. Workers see the model and the tiles under the same
absolute paths as this process.
"""

from __future__ import annotations

import glob
import os
import socket
import tempfile
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._command import Call, IndgeoWarning
from .results import Registration, _Judged

#: A folder, a glob, a file, or several files; a part of a file is (path, start, stop) with numbers of points from 0.
Tiles = str | os.PathLike | Sequence[str | os.PathLike | tuple[str | os.PathLike, int, int]]

#: Extensions of the files of points that count in a folder.
EXTENSIONS = (".ply", ".xyz", ".csv", ".pts", ".ptx", ".pcd", ".las", ".laz", ".e57", ".obj", ".stl", ".off", ".txt", ".asc")


@dataclass(frozen=True, order=True)
class Tile:
    """A file of points, or the points `start` up to but not `stop` of it, counted from 0."""

    path: str
    start: int | None = None
    stop: int | None = None

    def _options(self) -> dict[str, Any]:
        return {} if self.start is None else {"points": f"{self.start}..{self.stop}"}

    def __str__(self) -> str:
        return self.path if self.start is None else f"{self.path} {self.start}..{self.stop}"


@dataclass(eq=False)
class TiledInspection(_Judged):
    """What an inspection of many tiles found; `report` is that of `indgeo inspect MODEL TILES`.

    page: the page (HTML) if one was asked for, as bytes; it was written to the file as well.
    tiles: the tiles in the order in which their points are numbered.
    """

    tiles: tuple[Tile, ...] = ()
    page: bytes | None = field(default=None, repr=False)

    @property
    def points(self) -> int:
        """Number of points that were read."""
        return self.report["results"]["points"]

    def _rows(self) -> list[tuple[str, Any]]:
        return [("points", self.points), ("within", self.share_within), ("rms", self.rms), ("max", self.max)]


@dataclass(eq=False)
class TiledRegistration(Registration):
    """The motion that lays the points of many tiles on a model.

    matrix (4, 4): takes points to the model. rms: of the distances from the tangent planes before the last step, in the unit of the
    files. ok: the last step moved the points by no more than the tolerance, and no motion was left undetermined.
    steps: of each step `rms`, `motion` (a share of the size of the model), `points_used`, `free`, `matrix`, and the sums.
    """

    steps: list[dict[str, Any]] = field(default_factory=list, repr=False)


def tiles_of(tiles: Tiles, chunk: int | None = None) -> list[Tile]:
    """The tiles that are meant, in the order in which their points are numbered: by their paths.

    tiles: a folder (all files of points in it), a glob, a file, or several of these and of (path, start, stop).
    chunk: cuts each whole file into parts of so many points.
    """
    listed = [tiles] if isinstance(tiles, (str, os.PathLike)) else list(tiles)
    found: list[Tile] = []
    for entry in listed:
        if isinstance(entry, Tile):
            found.append(entry)
        elif isinstance(entry, tuple):
            path, start, stop = entry
            path = os.path.abspath(path)
            if not (0 <= start < stop):
                raise ValueError(f"{path}: the part {start}..{stop} is empty, give 0 <= start < stop")
            found.append(Tile(path, int(start), int(stop)))
        else:
            found += [Tile(path) for path in _files(os.path.abspath(entry))]
    if not found:
        raise ValueError("there are no tiles, give a folder, a glob, or files")
    if chunk is not None:
        if chunk < 1:
            raise ValueError(f"chunk is {chunk}, it must be at least 1")
        found = [part for tile in found for part in _parts(tile, chunk)]
    found.sort(key=lambda tile: (tile.path, tile.start or 0))
    return found


def _files(path: str) -> list[str]:
    if os.path.isdir(path):
        names = sorted(name for name in os.listdir(path) if not name.startswith("."))
        files = [os.path.join(path, name) for name in names if name.lower().endswith(EXTENSIONS)]
        if not files:
            raise ValueError(f"{path}: the folder holds no scans: no file with an extension such as .ply, .laz, .e57 or .xyz")
        return files
    if not os.path.exists(path) and glob.has_magic(path):
        files = sorted(name for name in glob.glob(path) if os.path.isfile(name))
        if not files:
            raise ValueError(f"{path}: no file is called so")
        return files
    return [path]


def _parts(tile: Tile, chunk: int) -> Iterator[Tile]:
    if tile.start is not None:
        yield tile
        return
    report = Call("info").points(tile.path).run().report
    count = report["inputs"][0]["points_read"]
    if count <= chunk:
        yield tile
        return
    for start in range(0, count, chunk):
        yield Tile(tile.path, start, min(start + chunk, count))


def inspect(
    model: str | os.PathLike,
    tiles: Tiles,
    tolerance: float | None = None,
    *,
    client: Any = None,
    chunk: int | None = None,
    transform: ArrayLike | str | os.PathLike | None = None,
    report: str | os.PathLike | None = None,
    progress: Callable[[str, int, int], object] | None = None,
    threads: int | None = None,
    **options: Any,
) -> TiledInspection:
    """Signed deviations of the points of many files from a model, as `indgeo.inspect` of all of them together.

    model: path. tiles: see `tiles_of`. tolerance: allowed deviation to both sides, in the unit of the files; further options as of
    `indgeo.inspect` (`lower`, `upper`, `min_share`, `max_angle`, `along`, `picture`, ...).
    client: a `dask.distributed.Client`; without, the tiles are measured one after another in this process.
    chunk: cuts files into parts of so many points. transform (4, 4): moves the points first. report: writes a page (HTML).
    progress: called with a text, the number of finished tiles, and of all. threads: of each worker.

    Raises ValueError or OSError with the name of the file: of a damaged tile, a folder without scans, a model that a worker does not see.
    """
    parts = tiles_of(tiles, chunk)
    if report is not None and not os.path.isdir(os.path.dirname(os.path.abspath(report))):
        # Said before the work, not after it.
        raise OSError(f"{os.fspath(report)}: there is no such folder; create the folder first")
    if report is None:
        # The sample for the picture is not needed, and takes the most of a partial result.
        options.setdefault("picture", 1)
    options |= {"tolerance": tolerance, "threads": threads}
    tasks = [("inspect", _path(model, "model"), tile, _matrix(transform), dict(options)) for tile in parts]
    with _partials(tasks, client, progress) as partials:
        call = Call("merge")
        call.arguments += partials.paths
        options = {"model": _path(model, "model"), "report": report, "no_timings": True, "threads": threads}
        ended = call.options(options).run()
    page = None if report is None else Path(report).read_bytes()
    return TiledInspection(tiles=tuple(parts), page=page)._of(ended)


def register(
    model: str | os.PathLike,
    tiles: Tiles,
    *,
    init: ArrayLike | str | os.PathLike | None = None,
    client: Any = None,
    chunk: int | None = None,
    max_distance: float | None = None,
    max_angle: float | None = None,
    max_iterations: int = 50,
    tolerance: float = 1e-9,
    progress: Callable[[str, int, int], object] | None = None,
    threads: int | None = None,
    **options: Any,
) -> TiledRegistration:
    """The motion that lays the points of many files on a model of surfaces or triangles, by least squares of all of them.

    Steps of Gauss and Newton with the distances from tangent planes, each from the exact sums over all tiles, until a step moves the
    points by no more than `tolerance` (a share of the size of the model). No search over positions: `init` (4, 4) has to be near, such
    as the result of `indgeo.register` of one tile. max_distance: points farther from the model do not count, in the unit of the files.
    max_angle: nor those whose normals differ by more, in degrees. The other arguments are as of `inspect`.
    """
    parts = tiles_of(tiles, chunk)
    if max_iterations < 1:
        raise ValueError(f"max_iterations is {max_iterations}, it must be at least 1")
    path = _path(model, "model")
    options |= {"max_distance": max_distance, "max_angle": max_angle, "threads": threads}
    pose: Any = _matrix(init)
    steps: list[dict[str, Any]] = []
    ended = None
    for _ in range(max_iterations):
        tasks = [("register", path, tile, pose, dict(options)) for tile in parts]
        with _partials(tasks, client, progress) as partials:
            call = Call("merge")
            call.arguments += partials.paths
            ended = call.options({"model": path, "no_timings": True, "threads": threads}).run()
        step = ended.report["results"]
        steps.append(step)
        pose = step["matrix"]
        if step["motion"] <= tolerance:
            break
    last = steps[-1]
    out = TiledRegistration(matrix=np.array(last["matrix"]), scale=1.0, rms=last["rms"], steps=steps)._of(ended)
    converged = last["motion"] <= tolerance
    out.ok = converged and last["free"] == 0
    out.status = "max_iterations" if not converged else ("done" if out.ok else "underdetermined")
    return out


def _path(value: str | os.PathLike, name: str) -> str:
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name} is {type(value).__name__}, it must be a path that every worker sees")
    # Workers have folders of their own.
    return os.path.abspath(value)


def _matrix(value: ArrayLike | str | os.PathLike | None) -> Any:
    """A pose as it travels to the workers: numbers, or a path."""
    if value is None or isinstance(value, (str, os.PathLike)):
        return value if value is None else os.path.abspath(value)
    array: NDArray[np.float64] = np.asarray(value, dtype=np.float64)
    if array.shape != (4, 4):
        raise ValueError(f"the pose has shape {array.shape}, it must be (4, 4)")
    return array.tolist()


def _part(task: tuple[str, str, Tile, Any, dict[str, Any]], where: bool) -> bytes:
    """Measures one tile; runs on a worker."""
    command, model, tile, pose, options = task
    call = Call(command).model(model).points(tile.path)
    call.matrix("transform" if command == "inspect" else "init", pose)
    call.options({**options, **tile._options(), "partial": call.memory("partial.json")})
    with warnings.catch_warnings():
        # The merged result tells them.
        warnings.simplefilter("ignore", IndgeoWarning)
        try:
            return call.run().data("partial.json")
        except (ValueError, OSError) as error:
            if where:
                raise type(error)(f"{error} (tile {tile}, on {socket.gethostname()})") from None
            raise


class _partials:
    """Partial results in files of a folder that is gone at the end."""

    def __init__(
        self, tasks: list[tuple], client: Any, progress: Callable[[str, int, int], object] | None
    ) -> None:
        self.tasks = tasks
        self.client = client
        self.progress = progress
        self.paths: list[str] = []
        self.folder = tempfile.TemporaryDirectory(prefix="indgeo-partials-")

    def __enter__(self) -> _partials:
        try:
            self.paths = [os.path.join(self.folder.name, f"{number}.json") for number in range(len(self.tasks))]
            for done, (number, data) in enumerate(self._results(), 1):
                Path(self.paths[number]).write_bytes(data)
                if self.progress is not None:
                    self.progress("tiles", done, len(self.tasks))
        except BaseException:
            self.folder.cleanup()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.folder.cleanup()

    def _results(self) -> Iterable[tuple[int, bytes]]:
        if self.client is None:
            for number, task in enumerate(self.tasks):
                yield number, _part(task, False)
            return
        try:
            from dask.distributed import as_completed
        except ImportError:
            raise ValueError("a client needs the package dask: pip install 'indgeo[distributed]'") from None
        # Not pure: files may have changed since a task with the same arguments ran.
        futures = {self.client.submit(_part, task, True, pure=False): n for n, task in enumerate(self.tasks)}
        try:
            for future in as_completed(list(futures)):
                yield futures[future], future.result()
                future.release()
        finally:
            self.client.cancel(list(futures))


__all__ = ["Tile", "TiledInspection", "TiledRegistration", "inspect", "register", "tiles_of"]
