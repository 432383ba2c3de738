"""Shapes with closed forms that the tests share."""

import numpy as np

import indgeo


def quarter_circle(radius=1.0):
    """A quarter of a circle around the origin, in the first quadrant."""
    points = radius * np.array([[1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return indgeo.Curve.bspline(2, [0, 0, 0, 1, 1, 1], points, [1.0, 0.5**0.5, 1.0])


def square(size=1.0):
    """The square 0 ≤ x, y ≤ size in the plane z = 0, with normals along +z."""
    points = size * np.array([[[0, 0, 0], [0, 1, 0]], [[1, 0, 0], [1, 1, 0]]], dtype=float)
    return indgeo.Surface.bspline((1, 1), [0, 0, 1, 1], [0, 0, 1, 1], points)


def wave(n=9):
    """A free-form surface without symmetries over the unit square."""
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n), indexing="ij")
    z = 0.15 * np.sin(4 * x) * np.cos(3 * y + 0.4) + 0.1 * x * x * y
    knots = np.concatenate([[0.0] * 3, np.linspace(0, 1, n - 2), [1.0] * 3])
    return indgeo.Surface.bspline((3, 3), knots, knots, np.stack([x, y, z], axis=2))


def rotation(axis, angle):
    """The rotation matrix about an axis (Rodrigues)."""
    a = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    k = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * (k @ k)
