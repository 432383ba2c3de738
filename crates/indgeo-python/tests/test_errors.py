import os
import subprocess

import numpy as np
import pytest
from shapes import square

import indgeo


def test_arrays_of_the_wrong_kind_are_named():
    with pytest.raises(ValueError, match=r"points has shape \(3,\), it must be \(N, 2\) or \(N, 3\)"):
        indgeo.project(square(), np.zeros(3))
    with pytest.raises(ValueError, match="points has dtype complex128, it must be a number"):
        indgeo.project(square(), np.zeros((3, 3), dtype=complex))
    with pytest.raises(ValueError, match="points has no rows"):
        indgeo.project(square(), np.zeros((0, 3)))
    with pytest.raises(ValueError, match=r"transform has shape \(3, 3\), it must be \(4, 4\)"):
        indgeo.inspect(square(), np.zeros((1, 3)), 0.1, transform=np.eye(3))
    with pytest.raises(ValueError, match="normals has 1 rows, points has 2"):
        indgeo.Cloud(np.zeros((2, 3)), normals=[[0, 0, 1]])
    with pytest.raises(ValueError, match="triangles names vertices that are not there: 0 to 2 are allowed"):
        indgeo.Mesh(np.zeros((3, 3)), [[0, 1, 3]])
    with pytest.raises(TypeError, match="model is int"):
        indgeo.project(3, np.zeros((1, 3)))


def test_files_that_are_not_there_are_no_values(tmp_path):
    missing = tmp_path / "nothing.ply"
    with pytest.raises(OSError, match="nothing.ply"):
        indgeo.project(square(), missing)
    with pytest.raises(OSError, match="nothing.ply"):
        indgeo.read(missing)
    with pytest.raises(OSError, match="create the folder first"):
        indgeo.inspect(square(), np.zeros((1, 3)), 0.1, report=tmp_path / "no" / "report.html")


def test_content_that_does_not_serve_is_a_value(tmp_path):
    with pytest.raises(ValueError, match="no point has finite coordinates"):
        indgeo.project(square(), np.full((2, 3), np.nan))
    with pytest.raises(ValueError, match="points have no normals"):
        indgeo.project(square(), np.zeros((1, 3)), max_angle=30)
    with pytest.raises(ValueError, match="--tolerance"):
        indgeo.inspect(square(), np.zeros((1, 3)), tolerance=-1.0)
    with pytest.raises(ValueError, match="unexpected argument '--colour"):
        indgeo.project(square(), np.zeros((1, 3)), colour="red")
    broken = tmp_path / "broken.ply"
    broken.write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty double x\nend_header\n12")
    with pytest.raises(ValueError, match="broken.ply"):
        indgeo.read(broken)


@pytest.mark.skipif("INDGEO" not in os.environ, reason="INDGEO names the program to compare with")
def test_messages_are_those_of_the_command_line(tmp_path):
    points = tmp_path / "flat.csv"
    points.write_text("x,y\n1,2\n")
    model = tmp_path / "square.json"
    square().save(model)
    run = subprocess.run([os.environ["INDGEO"], "project", model, points, "-o", tmp_path / "o.csv"], capture_output=True, text=True)
    assert run.returncode == 2
    with pytest.raises(ValueError) as caught:
        indgeo.project(model, points)
    assert run.stderr == f"error: {caught.value}\n"
