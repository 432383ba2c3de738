"""Curves by FITPACK (scipy) with a given number of control points, and their orthogonal distances.

Called by `cargo xtask compare` with the folder of the cases; prints one line per case: name, control points, rms, seconds.
FITPACK needs an order of the points and their parameters: it gets the order along the true shape where the file has one, and
parameters by chord length.
"""

import sys
import time

import numpy as np
from scipy import interpolate, optimize


def chord_lengths(points, closed):
    steps = np.linalg.norm(np.diff(np.vstack([points, points[:1]]) if closed else points, axis=0), axis=1)
    lengths = np.concatenate([[0.0], np.cumsum(steps)])
    return lengths / lengths[-1]


def fit(points, controls, closed):
    """The least squares cubic with uniform inner knots: splprep with task -1."""
    data = np.vstack([points, points[:1]]) if closed else points
    parameters = chord_lengths(points, closed)
    inner = controls if closed else controls - 4
    knots = np.linspace(0.0, 1.0, inner + 1 if closed else inner + 2)[1:-1]
    full = np.concatenate([[0.0] * 4, knots, [1.0] * 4])
    spline, _ = interpolate.splprep(data.T, u=parameters, k=3, task=-1, t=full, per=closed)
    return spline


def distances(spline, points):
    dense = np.linspace(0.0, 1.0, 20001)
    curve = np.array(interpolate.splev(dense, spline)).T
    result = []
    for point in points:
        nearest = np.argmin(np.sum((curve - point) ** 2, axis=1))
        low, high = dense[max(nearest - 1, 0)], dense[min(nearest + 1, len(dense) - 1)]
        square = lambda t: np.sum((np.array(interpolate.splev(t, spline)) - point) ** 2)
        found = optimize.minimize_scalar(square, bounds=(low, high), method="bounded", options={"xatol": 1e-12})
        result.append(np.sqrt(min(found.fun, np.sum((curve[nearest] - point) ** 2))))
    return np.array(result)


def main(folder):
    for name, columns, controls, closed in [
        ("a1_rect.xyz", 2, 12, True),
        ("a3_bean.xyz", 2, 12, True),
        ("b_open3d_ordered.xyz", 3, 24, False),
    ]:
        points = np.loadtxt(f"{folder}/{name}")[:, :columns]
        begin = time.perf_counter()
        spline = fit(points, controls, closed)
        seconds = time.perf_counter() - begin
        rms = np.sqrt(np.mean(distances(spline, points) ** 2))
        print(f"{name} {controls} {rms:.6e} {seconds:.4f}")


if __name__ == "__main__":
    main(sys.argv[1])
