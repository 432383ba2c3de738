import pickle

import numpy as np
import pytest
from shapes import quarter_circle, square, wave

import indgeo


def test_a_circle_has_its_radius_and_curvature():
    circle = quarter_circle(2.5)
    t = np.linspace(0, 1, 33)
    points = circle.evaluate(t)
    assert points.shape == (33, 2)
    assert np.abs(np.linalg.norm(points, axis=1) - 2.5).max() < 1e-14
    assert np.abs(circle.curvature(t) - 1 / 2.5).max() < 1e-13


def test_derivatives_are_those_of_differences():
    surface, h = wave(), 1e-5
    uv = np.random.default_rng(1).uniform(0.1, 0.9, (50, 2))
    jets = surface.derivatives(uv, 2)
    du = (surface.evaluate(uv + [h, 0]) - surface.evaluate(uv - [h, 0])) / (2 * h)
    dv = (surface.evaluate(uv + [0, h]) - surface.evaluate(uv - [0, h])) / (2 * h)
    assert np.abs(jets[:, 1, 0] - du).max() < 1e-7
    assert np.abs(jets[:, 0, 1] - dv).max() < 1e-7
    assert np.abs(jets[:, 0, 0] - surface.evaluate(uv)).max() < 1e-15
    assert np.isnan(jets[:, 2, 1]).all(), "the order is the sum of both"
    normals = np.cross(du, dv)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.abs(surface.normals(uv) - normals).max() < 1e-7


def test_a_plane_is_flat_and_a_parameter_that_is_no_number_has_no_point():
    plane = square()
    assert np.abs(plane.curvatures([[0.2, 0.7]])).max() == 0
    assert np.isnan(plane.evaluate([[np.nan, 0.5]])).all()
    with pytest.raises(ValueError, match=r"uv has shape \(1, 3\), it must be \(N, 2\)"):
        plane.evaluate([[0.1, 0.2, 0.3]])
    with pytest.raises(ValueError, match="order is 9, it must be 0 to 8"):
        plane.derivatives([[0.1, 0.2]], 9)


def test_shapes_come_back_from_text_and_pickles():
    for shape in (quarter_circle(), wave()):
        for again in (pickle.loads(pickle.dumps(shape)), type(shape).from_json(shape.to_json())):
            assert again == shape
            assert np.array_equal(again.control_points, shape.control_points)
    model = indgeo.Model([square(), wave()])
    assert pickle.loads(pickle.dumps(model)) == model
    assert indgeo.Model.from_json(model.to_json()) == model


def test_what_is_no_shape_is_refused():
    with pytest.raises(ValueError, match="knots"):
        indgeo.Curve.bspline(2, [0, 0, 1, 1], [[0, 0], [1, 0], [2, 0]])
    with pytest.raises(ValueError, match="model"):
        indgeo.Curve({"kind": "curve"})


@pytest.mark.parametrize("extension", ["json", "step", "igs"])
def test_files_hold_every_bit(tmp_path, extension):
    path = tmp_path / f"wave.{extension}"
    wave().save(path, unit="mm") if extension != "json" else wave().save(path)
    if extension == "json":
        again = indgeo.read(path)[0]
        assert np.array_equal(again.control_points, wave().control_points)
    feet = indgeo.project(path, wave().grid(5).reshape(-1, 3))
    assert feet.ok and feet.max < 1e-14


def test_a_tessellation_keeps_its_chord():
    surface = wave()
    mesh = surface.tessellate(chord=1e-3)
    assert len(mesh.triangles) > 50
    centres = mesh.vertices[mesh.triangles].mean(axis=1)
    assert indgeo.project(surface, centres).max < 1e-3
