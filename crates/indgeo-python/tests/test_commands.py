import warnings
from pathlib import Path

import numpy as np
import pytest
from shapes import quarter_circle, rotation, square, wave

import indgeo


def test_distances_from_a_circle_are_exact():
    angle = np.linspace(0.1, 1.4, 200)
    radius = np.linspace(0.2, 3.0, 200)
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=1)
    feet = indgeo.project(quarter_circle(), points)
    assert feet.ok
    assert np.abs(feet.distance - np.abs(radius - 1)).max() < 1e-14
    assert np.abs(feet.foot - np.stack([np.cos(angle), np.sin(angle)], axis=1)).max() < 1e-7
    assert (feet.lower_bound <= feet.distance).all()
    assert set(feet.point_status) == {"converged"}
    assert feet.parameter.shape == (200, 1)


def test_rows_that_are_not_finite_keep_their_place():
    points = np.array([[0.5, 0.5, 1.0], [np.nan, 0, 0], [0.2, 0.1, -2.0]])
    with pytest.warns(indgeo.IndgeoWarning, match="NaN or infinite"):
        feet = indgeo.project(square(), points)
    assert feet.distance[0] == 1.0 and feet.distance[2] == -2.0 and np.isnan(feet.distance[1])
    assert list(feet.point_status) == ["converged", "invalid_point", "converged"]


def test_each_point_alone_has_the_bits_of_all_together():
    points = np.random.default_rng(2).uniform(-0.2, 1.2, (40, 3))
    together = indgeo.project(wave(), points, threads=2)
    for index in range(0, 40, 7):
        alone = indgeo.project(wave(), points[index : index + 1], threads=1)
        assert alone.distance[0] == together.distance[index]
        assert (alone.foot[0] == together.foot[index]).all()


def test_an_inspection_finds_the_bump(tmp_path):
    x, y = np.meshgrid(np.linspace(0.05, 0.95, 40), np.linspace(0.05, 0.95, 40), indexing="ij")
    z = np.zeros_like(x)
    z[10:13, 20:24] = 0.03
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    page = tmp_path / "report.html"
    found = indgeo.inspect(square(), points, tolerance=0.02, report=page)
    assert not found.ok and found.status == "out_of_tolerance" and not found.within_tolerance
    assert (found.outcome == "over").sum() == 12 and (found.outcome == "within").sum() == 1588
    assert np.abs(found.deviation - z.ravel()).max() < 1e-15
    assert page.read_text().lower().startswith("<!doctype html")
    up = np.eye(4)
    up[2, 3] = -0.03
    assert not indgeo.inspect(square(), points, tolerance=0.02, transform=up).ok
    assert indgeo.inspect(square(), points, tolerance=0.031).ok


def test_a_registration_takes_a_motion_back():
    surface = wave()
    uv = np.random.default_rng(3).uniform(0, 1, (800, 2))
    there = surface.evaluate(uv)
    turn = rotation([1, 2, 3], 0.3)
    moved = there @ turn.T + [0.05, -0.1, 0.07]
    found = indgeo.register(surface, moved)
    assert found.ok, found.status
    assert np.abs(found.apply(moved) - there).max() < 1e-9
    assert np.abs(found.matrix[:3, :3] - turn.T).max() < 1e-9
    again = indgeo.register(surface, moved, init=found.matrix)
    assert again.ok and np.abs(again.apply(moved) - there).max() < 1e-9


def test_a_curve_through_a_circle():
    angle = np.random.default_rng(4).uniform(0, 2 * np.pi, 400)
    fit = indgeo.fit_curve(5 * np.stack([np.cos(angle), np.sin(angle)], axis=1), tolerance=1e-3)
    assert fit.ok and fit.max <= 1e-3 and fit.within_tolerance
    radii = np.linalg.norm(fit.curve.tessellate(2000), axis=1)
    assert np.abs(radii - 5).max() < 2e-3


def test_a_surface_through_a_height_field():
    rng = np.random.default_rng(5)
    xy = rng.uniform(0, 1, (3000, 2))
    z = 0.2 * np.sin(3 * xy[:, 0]) * xy[:, 1]
    fit = indgeo.fit_surface(np.column_stack([xy, z]), tolerance=1e-3)
    assert fit.max <= 1e-3
    grid = fit.surface.grid(60).reshape(-1, 3)
    assert np.abs(grid[:, 2] - 0.2 * np.sin(3 * grid[:, 0]) * grid[:, 1]).max() < 4e-3


def test_parameters_around_a_tube():
    rng = np.random.default_rng(6)
    angle, height = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(0, 5, 3000)
    points = np.stack([np.cos(angle), np.sin(angle), height], axis=1)
    found = indgeo.parameterize(points, shape="cylinder")
    assert found.used.mean() > 0.98
    assert np.abs(found.distance[found.used]).max() < 0.05
    assert np.isfinite(found.parameter[found.used]).all()


def test_meshes_and_files_are_models(tmp_path):
    vertices = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=float)
    mesh = indgeo.Mesh(vertices, [[0, 1, 2], [0, 2, 3]])
    points = np.array([[0.3, 0.4, 0.5], [2.0, 0.5, 0.0]])
    assert np.allclose(np.abs(indgeo.project(mesh, points).distance), [0.5, 1.0], rtol=0, atol=1e-15)
    path = tmp_path / "scan.csv"
    path.write_text("x,y,z\n0.3,0.4,0.5\n2,0.5,0\n")
    assert np.allclose(np.abs(indgeo.project(mesh, path).distance), [0.5, 1.0], rtol=0, atol=1e-15)
    cloud = indgeo.read(path)
    assert isinstance(cloud, indgeo.Cloud) and np.array_equal(cloud.points, points)


def test_normals_choose_the_side_of_a_thin_wall():
    lower, upper = square(), square()
    points = np.array([[0.5, 0.5, 0.02]])
    top = {"kind": "surface", **upper._document}
    top["control_points"] = (upper.control_points + [0, 0, 0.03]).tolist()
    flipped = dict(lower._document)
    flipped["control_points"] = lower.control_points[::-1].tolist()
    wall = indgeo.Model([indgeo.Surface(flipped), indgeo.Surface(top)])
    down = indgeo.Cloud(points, normals=[[0, 0, -1.0]])
    assert abs(indgeo.project(wall, points).distance[0]) == pytest.approx(0.01)
    assert abs(indgeo.project(wall, down, max_angle=60).distance[0]) == pytest.approx(0.02)


def test_vectors_of_a_result_are_used_where_they_lie():
    points = np.random.default_rng(5).uniform(-0.2, 1.2, (300, 3))
    feet = indgeo.project(wave(), points)
    assert list(feet.columns)[:9] == ["x", "y", "z", "foot_x", "foot_y", "foot_z", "distance", "shape", "u"]
    assert np.array_equal(np.stack([feet.columns[name] for name in "xyz"], axis=1), points)
    assert feet.foot.flags.c_contiguous and feet.foot.flags.aligned and feet.foot.flags.writeable
    assert np.shares_memory(feet.foot, feet.columns["foot_y"]) and np.shares_memory(feet.parameter, feet.columns["v"])
    assert feet.columns["shape"].dtype == np.int32 and (feet.columns["shape"] == 0).all()
    assert np.abs(np.linalg.norm(points - feet.foot, axis=1) - np.abs(feet.distance)).max() < 1e-14
    assert np.abs(wave().evaluate(feet.parameter) - feet.foot).max() < 1e-14


def test_names_of_points_come_back(tmp_path):
    path = tmp_path / "named.csv"
    path.write_text("name,x,y,z\nbore 1,0.5,0.5,0.25\n,0.25,0.5,-1\nÖse,0.1,0.2,0.5\n", encoding="utf-8")
    feet = indgeo.project(square(), path)
    assert list(feet.columns["name"]) == ["bore 1", "", "Öse"]
    assert list(feet.distance) == [0.25, -1.0, 0.5]


def test_places_on_a_part_are_words():
    part = Path(__file__).parents[3] / "fixtures" / "cad" / "nema-17-bracket.step"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        points = indgeo.tessellate(part, chord=5.0).vertices[:50]
    feet = indgeo.project(part, points + 1e-3)
    assert set(feet.columns["on"]) <= {"face", "edge", "vertex"}
    assert {"inside", "outside"} <= set(feet.columns["side"]) <= {"inside", "outside", "none"}
    assert set(feet.point_status) <= {"converged", "on_boundary"}
