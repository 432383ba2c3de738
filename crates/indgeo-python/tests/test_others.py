import pickle

import numpy as np
import pytest
from shapes import square

import indgeo


def points():
    return np.array([[0.2, 0.3, 0.01], [0.6, 0.1, -0.2]])


def test_results_are_told_and_pickled():
    found = indgeo.inspect(square(), points(), 0.1)
    again = pickle.loads(pickle.dumps(found))
    assert again.ok == found.ok and np.array_equal(again.deviation, found.deviation)
    assert found.to_dict()["command"] == "inspect"
    assert "out_of_tolerance" in found._repr_html_()


def test_tables_are_frames():
    pandas = pytest.importorskip("pandas")
    frame = indgeo.inspect(square(), points(), 0.1).to_pandas()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame["result"]) == ["within", "under"]


def test_trimesh_there_and_back():
    trimesh = pytest.importorskip("trimesh")
    box = indgeo.Mesh.from_trimesh(trimesh.creation.box())
    assert indgeo.project(box, [[0.0, 0.0, 0.9]]).distance[0] == pytest.approx(0.4)
    assert box.to_trimesh().is_watertight


def test_commands_without_a_function_run_by_name(tmp_path):
    vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0.0]]
    mesh = indgeo.Mesh(vertices, [[0, 1, 2], [1, 3, 2]])
    out = tmp_path / "distance.csv"
    found = indgeo.command("geodesic", mesh, from_=0, out=out)
    assert found.ok and found.report["command"] == "geodesic"
    rows = [line.split(",") for line in out.read_text().splitlines()[1:]]
    assert [round(float(row[-1]), 12) for row in rows] == [0, 1, 1, round(2**0.5, 12)]
    with pytest.raises(ValueError, match="unrecognized subcommand 'melt'"):
        indgeo.command("melt", mesh)


def test_the_examples_of_the_documentation_hold():
    import doctest

    import indgeo.commands

    for module in (indgeo, indgeo.commands):
        result = doctest.testmod(module)
        assert result.attempted and not result.failed
