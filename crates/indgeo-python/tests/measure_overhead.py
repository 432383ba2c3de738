"""What calling `project` from Python costs over the time that the command itself reports (reading, preparing, computing, writing), for
100,000 points.

    python crates/indgeo-python/tests/measure_overhead.py [POINTS]

Prints the time of the call, the times of the command in the same call, their ratio (wanted: at most 1.10), and, where the variable INDGEO
names the program, the time of the command line on the same points in a file. Each is the best of several runs. Exit status 1 if the ratio
is larger.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from shapes import wave

import indgeo

WANTED = 1.10
RUNS = 5


def main() -> int:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    points = np.random.default_rng(3).uniform([0, 0, -0.2], [1, 1, 0.4], (count, 3))
    runs = []
    for _ in range(RUNS):
        began = time.perf_counter()
        found = indgeo.project(wave(), points)
        called = time.perf_counter() - began
        timings = found.report["timings"]
        runs.append((called / sum(timings.values()), called, timings["compute"], sum(timings.values())))
    ratio, called, computed, own = min(runs)
    print(f"{count} points: call {called:.3f} s, the command {own:.3f} s (computing {computed:.3f} s), ratio {ratio:.3f} (wanted: {WANTED} at most)")
    program = os.environ.get("INDGEO")
    if program:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            wave().save(folder / "model.json")
            (folder / "points.ply").write_bytes(indgeo.Cloud(points)._data())
            command = [program, "project", "model.json", "points.ply", "-o", "feet.ply", "--json", "report.json", "--quiet"]
            times = []
            for _ in range(RUNS):
                subprocess.run(command, cwd=folder, check=False)
                times.append(sum(json.loads((folder / "report.json").read_text())["timings"].values()))
            print(f"command line: {min(times):.3f} s, ratio of the best call to it {min(run[1] for run in runs) / min(times):.3f}")
    return 0 if ratio <= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
