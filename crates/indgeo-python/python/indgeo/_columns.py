"""Results of a command in memory: arrays that are used where they lie."""

from __future__ import annotations

import json
import re

import numpy as np
from numpy.typing import NDArray

_ALIGNMENT = 8


class Table:
    """Columns of equal length, and what their codes mean.

    columns: each by its name, (N,). Columns of a vector are views of one matrix, which `stack` returns.
    """

    def __init__(self, data: NDArray[np.uint8]) -> None:
        at = int(np.argmax(data == ord("\n"))) + 1
        header = json.loads(data[:at].tobytes())
        self.rows: int = header["rows"]
        self.columns: dict[str, NDArray] = {}
        self.codes: dict[str, dict[int, str]] = {}
        self._matrices: dict[tuple[str, ...], NDArray] = {}
        for array in header["arrays"]:
            names, kind = tuple(array["columns"]), np.dtype(array["kind"])
            size = self.rows * len(names) * kind.itemsize
            matrix = data[at : at + size].view(kind).reshape(self.rows, len(names))
            at += -(-size // _ALIGNMENT) * _ALIGNMENT
            self._matrices[names] = matrix
            self.columns |= {name: matrix[:, index] for index, name in enumerate(names)}
        if header["names"] is not None:
            ends = data[at : at + 8 * self.rows].view("<u8").tolist()
            texts = data[at + 8 * self.rows :].tobytes()
            labels = [texts[first:last].decode("utf-8", "replace") for first, last in zip([0, *ends], ends)]
            self.columns[header["names"]] = np.array(labels, dtype=object)
        for comment in header["comments"]:
            self._learn(comment)

    def _learn(self, comment: str) -> None:
        for part in comment.split("; "):
            name, colon, rest = part.partition(": ")
            pairs = re.findall(r"(\d+) ([a-z_]+)", rest)
            if colon and pairs:
                self.codes[name] = {int(code): word for code, word in pairs}

    def with_words(self) -> dict[str, NDArray]:
        """The columns, codes as the words that they stand for."""
        return {name: self._words(name, column) if name in self.codes else column for name, column in self.columns.items()}

    def _words(self, name: str, column: NDArray) -> NDArray:
        words = [self.codes[name].get(code, str(code)) for code in range(256)]
        return np.array(words)[column]

    def stack(self, *names: str) -> NDArray[np.float64]:
        """Columns side by side, (N, number of names); those that are missing are left out."""
        present = tuple(name for name in names if name in self.columns)
        if present in self._matrices:
            return self._matrices[present]
        if not present:
            return np.empty((self.rows, 0))
        return np.stack([self.columns[name] for name in present], axis=1)
