"""From Python to a command and back."""

from __future__ import annotations

import json
import os
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _columns, _indgeo, _ply
from .clouds import Cloud, Mesh, _points
from .shapes import Curve, Model, Surface

Progress = bool | Callable[[str, int, int], object]


class IndgeoWarning(UserWarning):
    """What a command says that the user should know."""


@dataclass
class Ended:
    """What came of a command."""

    exit_code: int
    report: dict[str, Any]
    summary: str
    warnings: tuple[str, ...]
    outputs: dict[str, NDArray[np.uint8]]

    def data(self, name: str) -> bytes:
        return self.outputs[name].tobytes()

    def text(self, name: str) -> str:
        return self.data(name).decode()

    def points(self, name: str) -> _ply.Table:
        return _ply.Table(self.data(name))

    def table(self, name: str) -> _columns.Table:
        return _columns.Table(self.outputs[name])


class Call:
    """A command line in the making; arrays and shapes become files in memory, called as the arguments they stand for."""

    def __init__(self, command: str) -> None:
        self.arguments = [command]
        self.inputs: dict[str, bytes] = {}

    def memory(self, name: str) -> str:
        """The name of an output in memory."""
        return "\0" + name

    def _input(self, name: str, data: bytes) -> str:
        self.inputs[name] = data
        return "\0" + name

    def model(self, model: Any, name: str = "model") -> Call:
        if isinstance(model, (Curve, Surface, Model)):
            self.arguments.append(self._input(name, model.to_json().encode()))
        elif isinstance(model, Mesh):
            self.arguments.append(self._input(name, model._data()))
        elif isinstance(model, (list, tuple)) and model and all(isinstance(s, (Curve, Surface)) for s in model):
            return self.model(Model(list(model)), name)
        else:
            self.arguments.append(self._path(model, name, "a path, a Curve, Surface, Model or Mesh"))
        return self

    def points(self, points: Any, name: str = "points") -> Call:
        if isinstance(points, (Cloud, Mesh)):
            self.arguments.append(self._input(name, points._data()))
        elif isinstance(points, (str, bytes, os.PathLike)):
            self.arguments.append(self._path(points, name, "a path"))
        else:
            self.arguments.append(self._input(name, Cloud(_points(points, name, (2, 3)))._data()))
        return self

    def matrix(self, option: str, value: Any) -> Call:
        """A 4 × 4 matrix, several of them (K, 4, 4), or the path of a file."""
        if value is None:
            return self
        if not isinstance(value, (str, os.PathLike)):
            array = np.asarray(value, dtype=np.float64)
            if array.shape[-2:] != (4, 4) or array.ndim not in (2, 3):
                raise ValueError(f"{option} has shape {array.shape}, it must be (4, 4) or (K, 4, 4)")
            listed = array.tolist()
            document: Any = {"matrix": listed} if array.ndim == 2 else [{"matrix": m} for m in listed]
            value = self._input(option, json.dumps(document).encode())
        return self.option(option, value)

    def option(self, name: str, value: Any) -> Call:
        """An option of the command line; None and False leave it out, True is a switch."""
        if value is None or value is False:
            return self
        flag = "--" + name.rstrip("_").replace("_", "-")
        if value is True:
            self.arguments.append(flag)
        else:
            self.arguments.append(f"{flag}={_text(value)}")
        return self

    def options(self, values: dict[str, Any]) -> Call:
        for name, value in values.items():
            self.option(name, value)
        return self

    @staticmethod
    def _path(value: Any, name: str, wanted: str) -> str:
        if not isinstance(value, (str, bytes, os.PathLike)):
            raise TypeError(f"{name} is {type(value).__name__}, it must be {wanted}")
        path = os.fsdecode(value)
        if "\0" in path:
            raise ValueError(f"{name}: a path holds no NUL")
        # A name that begins like an option is still a file.
        return os.path.join(".", path) if path.startswith("-") else path

    def run(self, progress: Progress = False) -> Ended:
        with _watched(progress) as watch:
            exit_code, text, summary, told, error, outputs = _indgeo.call(self.arguments, self.inputs, watch)
        for warning in told:
            warnings.warn(warning, IndgeoWarning, stacklevel=3)
        if error is not None:
            kind, message = error
            raise OSError(message) if kind == "file" else ValueError(message)
        return Ended(exit_code, json.loads(text), summary, tuple(told), outputs)


def _text(value: Any) -> str:
    if isinstance(value, (list, tuple, np.ndarray)):
        return ",".join(_text(part) for part in value)
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return os.fsdecode(value) if isinstance(value, os.PathLike) else str(value)


class _watched:
    """The callback for progress: a function as given, or a bar (`tqdm` if it is there)."""

    def __init__(self, progress: Progress) -> None:
        self.progress = progress
        self.bar: Any = None

    def __enter__(self) -> Callable[[str, int, int], object] | None:
        if callable(self.progress):
            return self.progress
        if not self.progress:
            return None
        try:
            from tqdm.auto import tqdm
        except ImportError:
            raise ValueError("progress=True needs the package tqdm; give a function (text, done, total) instead") from None
        self.bar = tqdm(leave=False)
        return self._tell

    def _tell(self, text: str, done: int, total: int) -> None:
        self.bar.set_description_str(text, refresh=False)
        self.bar.total = total or None
        self.bar.n = done
        self.bar.refresh()

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()
