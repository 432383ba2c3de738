#!/usr/bin/env python3
"""Registrations by Open3D and by indgeo, one after the other: CPU seconds on one thread, and errors against the true pose.

open3d_registration.py INDGEO FIXTURES. Needs open3d and numpy. The seconds of Open3D are those of the registration alone, with the
estimate of normals; those of indgeo are of the whole process. TRE is the root mean square distance of the points from where the
true pose moves them, as a share of the diagonal of the model. Each pair runs three times; the fastest of each is printed.
"""
import json, os, resource, subprocess, sys, tempfile, time

os.environ["OMP_NUM_THREADS"] = os.environ["RAYON_NUM_THREADS"] = "1"
import numpy as np
import open3d as o3d

indgeo, fixtures = sys.argv[1:3]
folder = tempfile.mkdtemp()
registration = o3d.pipelines.registration
o3d.utility.set_verbosity_level(o3d.utility.VerbosityLevel.Error)
o3d.utility.random.seed(1)
random = np.random.default_rng(1)


def rotation(degrees, seed):
    axis = np.random.default_rng(seed).normal(size=3)
    return o3d.geometry.get_rotation_matrix_from_axis_angle(axis / np.linalg.norm(axis) * np.deg2rad(degrees))


def displaced(points, degrees, move, seed):
    """Points moved away, and the pose that brings them back."""
    pose = np.eye(4)
    pose[:3, :3] = rotation(degrees, seed)
    pose[:3, 3] = np.random.default_rng(seed + 1).normal(size=3) * move
    return (points - pose[:3, 3]) @ pose[:3, :3], pose


def cloud(points):
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))


def saved(name, geometry):
    path = os.path.join(folder, name)
    write = o3d.io.write_triangle_mesh if hasattr(geometry, "triangles") else o3d.io.write_point_cloud
    assert write(path, geometry)
    return path


def by_indgeo(model, scan, *options):
    pose = os.path.join(folder, "pose.json")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([indgeo, "register", model, scan, "--transform", pose, "--threads", "1", *options], capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if run.returncode not in (0, 1):
        raise SystemExit(run.stderr)
    with open(pose) as file:
        return seconds, np.array(json.load(file)["matrix"]), f"exit {run.returncode}"


def by_open3d(register):
    begin = time.process_time()
    pose = register().transformation
    return time.process_time() - begin, np.asarray(pose), ""


def with_normals(points, neighbours=20):
    points = o3d.geometry.PointCloud(points)
    points.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(neighbours))
    return points


def point_to_plane(source, target, reach, start=np.eye(4)):
    end = registration.ICPConvergenceCriteria(1e-9, 1e-9, 100)
    plane = registration.TransformationEstimationPointToPlane()
    return registration.registration_icp(source, target, reach, start, plane, end)


def by_features(source, target, voxel):
    """FPFH features, RANSAC, then point to plane."""
    def prepared(points):
        few = with_normals(points.voxel_down_sample(voxel), 30)
        search = o3d.geometry.KDTreeSearchParamHybrid(radius=5 * voxel, max_nn=100)
        return few, registration.compute_fpfh_feature(few, search)
    (few_source, source_features), (few_target, target_features) = prepared(source), prepared(target)
    checks = [registration.CorrespondenceCheckerBasedOnEdgeLength(0.9), registration.CorrespondenceCheckerBasedOnDistance(1.5 * voxel)]
    found = registration.registration_ransac_based_on_feature_matching(
        few_source, few_target, source_features, target_features, True, 1.5 * voxel,
        registration.TransformationEstimationPointToPoint(False), 3, checks, registration.RANSACConvergenceCriteria(100000, 0.999))
    return point_to_plane(source, with_normals(target), voxel, found.transformation)


def compare(name, points, truth, size, model, scan, peer, options=(), times=3):
    def error(pose):
        moved = points @ (pose[:3, :3] - truth[:3, :3]).T + pose[:3, 3] - truth[:3, 3]
        return np.sqrt(np.mean(np.sum(moved**2, axis=1))) / size
    theirs, ours = [], []
    for _ in range(times):
        theirs.append(by_open3d(peer))
        ours.append(by_indgeo(model, scan, *options))
    (t, their_pose, _), (o, our_pose, status) = min(theirs, key=lambda r: r[0]), min(ours, key=lambda r: r[0])
    print(f"{name:48} {t:8.2f} {error(their_pose):10.1e} {o:8.2f} {error(our_pose):10.1e} {o / t:7.2f}  {status}", flush=True)


def virtual_scan(scene, centre, size, direction, count, noise):
    """What a scanner sees of a mesh from a direction, on a square grid of rays."""
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    side = int(np.sqrt(count * 2.2))
    rays = scene.create_rays_pinhole(fov_deg=32, center=centre, eye=centre + direction * size * 1.6, up=[0.1, 1, 0.2], width_px=side, height_px=side)
    hit = scene.cast_rays(rays)
    seen = hit["t_hit"].isfinite().numpy()
    rays, distance = rays.numpy()[seen].astype(float), hit["t_hit"].numpy()[seen].astype(float)
    distance += random.normal(size=distance.shape) * noise
    return rays[:, :3] + rays[:, 3:] * distance[:, None]


print(f"{'work':48} {'Open3D s':>8} {'TRE':>10} {'ours s':>8} {'TRE':>10} {'ratio':>7}")
mesh = o3d.io.read_triangle_mesh(os.path.join(fixtures, "mesh/bunny.obj")).subdivide_loop(2)
size = np.linalg.norm(mesh.get_max_bound() - mesh.get_min_bound())
noise = 2e-4 * size


def sampled(count):
    return np.asarray(mesh.sample_points_uniformly(count).points)


target = cloud(sampled(40000))
moved, truth = displaced(sampled(40000) + random.normal(size=(40000, 3)) * noise, 8, 0.02 * size, 3)
source = cloud(moved)
model, scan = saved("target.ply", target), saved("source.ply", source)
compare("40,000 points on 40,000", moved, truth, size, model, scan, lambda: point_to_plane(source, with_normals(target), 0.05 * size))

model = saved("mesh.ply", mesh)
for count in (100_000, 1_000_000):
    moved, truth = displaced(sampled(count) + random.normal(size=(count, 3)) * noise, 8, 0.02 * size, 3)
    source = cloud(moved)
    scan = saved("source.ply", source)
    vertices = cloud(np.asarray(mesh.vertices))
    vertices.normals = mesh.compute_vertex_normals().vertex_normals
    compare(f"{count:,} points on {len(mesh.triangles):,} triangles", moved, truth, size, model, scan, lambda: point_to_plane(source, vertices, 0.05 * size))

scene = o3d.t.geometry.RaycastingScene()
scene.add_triangles(o3d.t.geometry.TriangleMesh.from_legacy(mesh))
centre = mesh.get_center()
front = virtual_scan(scene, centre, size, [0, 0.1, 1], 30000, noise)
for name, direction, start in (("scan on scan, 45 degrees apart, no start", [0.9, 0.2, 1], "global"), ("scan on scan, 100 degrees apart, start at 5 degrees", [1, 0.1, -0.2], "auto")):
    side = virtual_scan(scene, centre, size, direction, 22000, noise)
    moved, truth = displaced(side, 140 if start == "global" else 5, (0.4 if start == "global" else 0.01) * size, 7)
    source, target = cloud(moved), cloud(front)
    model, scan = saved("front.ply", target), saved("side.ply", source)
    if start == "global":
        peer = lambda: by_features(source, target, 0.02 * size)
    else:
        peer = lambda: point_to_plane(source, with_normals(target), 0.02 * size)
    compare(name, moved, truth, size, model, scan, peer, ("--start", start))

lidar = os.path.join(fixtures, "registration/small_gicp")
if os.path.isdir(lidar):
    target, source = (o3d.io.read_point_cloud(os.path.join(lidar, f"{name}.ply")) for name in ("target", "source"))
    truth = np.loadtxt(os.path.join(lidar, "T_target_source.txt"))
    points, extent = np.asarray(source.points), np.linalg.norm(target.get_max_bound() - target.get_min_bound())
    paths = [os.path.join(lidar, f"{name}.ply") for name in ("target", "source")]
    compare("lidar, from where it is", points, truth, extent, *paths, lambda: point_to_plane(source, with_normals(target), 1.0))
    compare("lidar, no start", points, truth, extent, *paths, lambda: by_features(source, target, 1.0), ("--start", "global"))
