"""Scans in many files: the same bytes in one process, on a cluster, and with a worker that is killed."""

import json
import os
import signal
import subprocess

import numpy as np
import pytest
from shapes import wave

import indgeo
from indgeo import distributed

TOLERANCE = 0.02


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """A model, a scan of it in three tiles, and the same scan in one file."""
    folder = tmp_path_factory.mktemp("scene")
    model = folder / "model.json"
    wave().save(model)
    rng = np.random.default_rng(5)
    uv = rng.uniform(0.02, 0.98, (6000, 2))
    points = wave().evaluate(uv)
    points = points + rng.normal(0, 0.005, points.shape)
    points[::501, 2] = np.nan
    (folder / "tiles").mkdir()
    for number, tile in enumerate(np.array_split(points, 3)):
        (folder / "tiles" / f"{number}.ply").write_bytes(indgeo.Cloud(tile)._data())
    (folder / "whole.ply").write_bytes(indgeo.Cloud(points)._data())
    return folder


@pytest.fixture(scope="module")
def client():
    dask = pytest.importorskip("dask.distributed", reason="dask[distributed] is not installed")
    with dask.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with dask.Client(cluster) as client:
            yield client


@pytest.fixture(autouse=True)
def here(scene, monkeypatch):
    """Paths of files are part of the bytes."""
    monkeypatch.chdir(scene)


def found(**options):
    """Report and page of an inspection of the tiles, as bytes."""
    with pytest.warns(indgeo.IndgeoWarning, match="NaN or infinite"):
        result = distributed.inspect("model.json", **{"tiles": "tiles", "tolerance": TOLERANCE, "report": "page.html", **options})
    assert (os.path.getsize("page.html"), open("page.html", "rb").read()) == (len(result.page), result.page)
    return json.dumps(result.report), result.page


def test_tiles_are_one_cloud(scene):
    report, page = found()
    listed = [os.path.join("tiles", f"{number}.ply") for number in (2, 0, 1)]
    assert found(tiles=listed) == (report, page)
    assert found(tiles="tiles/*.ply") == (report, page)
    assert found(chunk=701) == (report, page)
    numbers = json.loads(report)["results"]
    assert (numbers["points"], numbers["points_dropped"], numbers["points_used"]) == (6000, 12, 5988)
    # The same as of the points in one piece, but for the names of the files.
    with pytest.warns(indgeo.IndgeoWarning):
        whole = indgeo.inspect("model.json", "whole.ply", TOLERANCE)
    assert whole.report["results"]["total"] == numbers["total"]
    assert whole.report["results"]["worst"] == numbers["worst"]


def test_the_command_line_writes_the_same_bytes():
    program = os.environ.get("INDGEO")
    if not program:
        pytest.skip("INDGEO does not name the program")
    report, page = found()
    here = os.getcwd()
    typed = f"{program} inspect {here}/model.json {here}/tiles -t {TOLERANCE} --report page.html --json report.json --no-timings --quiet"
    assert subprocess.run(typed.split(), check=False).returncode < 2
    assert json.dumps(json.load(open("report.json"))) == report
    assert open("page.html", "rb").read() == page


def test_a_cluster_gives_the_same_bytes(client):
    assert found(client=client) == found()
    assert found(client=client, chunk=500) == found()


def test_a_worker_that_is_killed_changes_nothing(client):
    alone = found()
    pids = list(client.run(os.getpid).values())
    killed = []

    def kill(text, done, total):
        assert (text, total) == ("tiles", 42)
        if not killed:
            killed.append(pids[0])
            os.kill(pids[0], signal.SIGKILL)

    assert found(client=client, chunk=150, progress=kill) == alone
    assert killed
    client.wait_for_workers(2, timeout=60)


def test_registration_of_tiles(client):
    start = np.eye(4)
    start[:3, 3] = [0.01, -0.008, 0.01]
    with pytest.warns(indgeo.IndgeoWarning):
        alone = distributed.register("model.json", "tiles", init=start)
        many = distributed.register("model.json", "tiles", init=start, client=client, chunk=900)
    assert alone.ok and alone.status == "done"
    assert np.array_equal(alone.matrix, many.matrix)
    assert alone.steps == many.steps
    # The points were made on the model, with noise.
    assert np.abs(alone.matrix - np.eye(4)).max() < 2e-3
    assert alone.rms == pytest.approx(0.005, rel=0.05)
    assert np.allclose(alone.apply(np.zeros((1, 3))), alone.matrix[:3, 3])
    with pytest.warns(indgeo.IndgeoWarning):
        short = distributed.register("model.json", "tiles", init=start, max_iterations=1)
    assert (short.ok, short.status, len(short.steps)) == (False, "max_iterations", 1)


def test_what_cannot_be_used_is_named(tmp_path, client):
    (tmp_path / "empty").mkdir()
    with pytest.raises(ValueError, match="empty: the folder holds no scans"):
        distributed.inspect("model.json", tmp_path / "empty", 0.1)
    with pytest.raises(ValueError, match="no file is called so"):
        distributed.inspect("model.json", str(tmp_path / "*.ply"), 0.1)
    with pytest.raises(ValueError, match="there are no tiles"):
        distributed.inspect("model.json", [], 0.1)
    with pytest.raises(ValueError, match=r"part 5\.\.5 is empty"):
        distributed.inspect("model.json", [("whole.ply", 5, 5)], 0.1)
    with pytest.raises(TypeError, match="model is Surface"):
        distributed.inspect(wave(), "tiles", 0.1)
    # A gap, and a part that is there twice.
    with pytest.raises(ValueError, match=r"points 100\.\.6000 of .*whole.ply are in no partial result"):
        distributed.inspect("model.json", [("whole.ply", 0, 100)], 0.1)
    with pytest.raises(ValueError, match="whole.ply are in .* already"):
        distributed.inspect("model.json", [("whole.ply", 0, 6000), ("whole.ply", 10, 6000)], 0.1)
    damaged = tmp_path / "damaged.ply"
    damaged.write_bytes(open("whole.ply", "rb").read()[:5000])
    for where in (None, client):
        with pytest.raises(ValueError, match="damaged.ply"):
            distributed.inspect("model.json", [damaged], 0.1, client=where)
        with pytest.raises(OSError, match="nothing.json"):
            distributed.inspect("nothing.json", "tiles", 0.1, client=where)
        with pytest.raises(OSError, match="nothing.ply"):
            distributed.inspect("model.json", ["nothing.ply"], 0.1, client=where)
    with pytest.raises(OSError, match=r"\(tile .*tiles.\d\.ply, on "):
        distributed.inspect("nothing.json", "tiles", 0.1, client=client)
    with pytest.raises(OSError, match="page.html"):
        distributed.inspect("model.json", "tiles", 0.1, report=tmp_path / "no" / "page.html")
    assert sorted(os.listdir(tmp_path)) == ["damaged.ply", "empty"]
