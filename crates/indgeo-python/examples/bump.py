# %% [markdown]
# # A bump of .03 on a free-form part
# A surface, a scan of it with noise, a tilt and a bump whose height is known; the bump comes back.

# %%
import sys

import numpy as np

import indgeo

n = 9
x, y = np.meshgrid(np.linspace(0, 10, n), np.linspace(0, 10, n), indexing="ij")
z = 0.8 * np.sin(0.5 * x) * np.cos(0.4 * y)
knots = np.concatenate([[0.0] * 3, np.linspace(0, 1, n - 2), [1.0] * 3])
part = indgeo.Surface.bspline((3, 3), knots, knots, np.stack([x, y, z], axis=2), name="part")

# %% The scan: 40,000 points, noise .002, a bump of height .03 around (u, v) = (.6, .4).
rng = np.random.default_rng(1)
uv = rng.uniform(0.02, 0.98, (40_000, 2))
bump = 0.03 * np.exp(-((uv - [0.6, 0.4]) ** 2).sum(axis=1) / 0.05**2)
height = bump + rng.normal(0, 0.002, len(uv))
scan = part.evaluate(uv) + part.normals(uv) * height[:, None]
turn = np.deg2rad(4)
tilt = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
scan = scan @ tilt.T + [0.3, -0.2, 0.1]

# %% Back onto the part, and measured.
pose = indgeo.register(part, scan)
found = indgeo.inspect(part, pose.apply(scan), tolerance=0.01)
print(f"registered: {pose.ok}, rms {pose.rms:.4f}")
print(f"within tolerance: {found.within_tolerance}, {(found.outcome == 'over').sum()} points over")
print(f"highest point {found.deviation.max():.4f}, known {height.max():.4f}")

# %% A picture of the deviations.
if len(sys.argv) > 1:
    import matplotlib.pyplot as plt

    foot = found.foot
    figure, axes = plt.subplots(figsize=(7, 5.5), layout="constrained")
    dots = axes.scatter(foot[:, 0], foot[:, 1], c=found.deviation, s=3, cmap="coolwarm", vmin=-0.03, vmax=0.03)
    figure.colorbar(dots, label="deviation")
    axes.set(xlabel="x", ylabel="y", title="Deviations from the part", aspect="equal")
    figure.savefig(sys.argv[1], dpi=110)
