#!/usr/bin/env python3
"""Compares the frame halfway between a straight tube and a bent or twisted one with the ideal pose.

    bench/interpolation_table.py BIN_DIR [--json FILE]

BIN_DIR contains keypose-interpolate. The tube has 3,600 faces, length 2 and radius 0.12; twists use a bar of
0.4 x 0.4 x 2. Per shape and method the table has the error of the middle frame against the ideal pose (half the
angle): mean over vertices after a rigid fit / diagonal. It also has the largest deviation of area and volume
from their paths over nine in-betweens. For sequences of three keys it has the same deviations, and the jump of
speed at the middle key.
"""
import argparse
import json
import math
import pathlib
import subprocess
import tempfile

import numpy as np

METHODS = ["linear", "paper", "arap", "volumetric"]
ANGLES = [150, 270, 300, 450, 720]


def tube(radius, length, segments, rings):
    points = [
        (radius * math.cos(2 * math.pi * s / segments), radius * math.sin(2 * math.pi * s / segments), length * r / rings)
        for r in range(rings + 1)
        for s in range(segments)
    ]
    low, high = len(points), len(points) + 1
    points += [(0, 0, 0), (0, 0, length)]
    faces = []
    for s in range(segments):
        t = (s + 1) % segments
        for r in range(rings):
            a, b, c, d = r * segments + s, r * segments + t, (r + 1) * segments + s, (r + 1) * segments + t
            faces += [(a, b, d), (a, d, c)]
        faces += [(low, t, s), (high, rings * segments + s, rings * segments + t)]
    return np.array(points), np.array(faces, dtype=np.int32)


def bar(side, length, across, rings):
    """A tube of square cross-section with `across` quads per side."""
    points, faces = tube(1, length, 4 * across, rings)
    ring = []
    for s in range(4 * across):
        q, k = divmod(s, across)
        u = 2 * k / across - 1
        ring.append([(u, -1), (1, u), (-u, 1), (-1, -u)][q])
    for r in range(rings + 1):
        points[r * 4 * across : (r + 1) * 4 * across, :2] = np.array(ring) * side / 2
    return points, faces


def bent(p, length, angle):
    if angle == 0:
        return p.copy()
    radius = length / angle
    a, r = p[:, 2] / radius, radius - p[:, 0]
    return np.stack([radius - r * np.cos(a), p[:, 1], r * np.sin(a)], 1)


def twisted(p, length, angle):
    a = p[:, 2] / length * angle
    return np.stack([p[:, 0] * np.cos(a) - p[:, 1] * np.sin(a), p[:, 0] * np.sin(a) + p[:, 1] * np.cos(a), p[:, 2]], 1)


def write_ply(path, points, faces):
    head = (
        "ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty double x\nproperty double y\nproperty double z\n"
        "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(points), len(faces))
    )
    rows = np.zeros(len(faces), dtype=[("n", "u1"), ("corners", "<i4", 3)])
    rows["n"], rows["corners"] = 3, faces
    path.write_bytes(head.encode() + points.astype("<f8").tobytes() + rows.tobytes())


def read_points(path):
    data = path.read_bytes()
    start = data.index(b"end_header\n") + len(b"end_header\n")
    count = int(data[:start].split(b"element vertex ")[1].split()[0])
    return np.frombuffer(data, "<f8", 3 * count, start).reshape(-1, 3)


def rigid_error(frame, truth):
    a, b = frame - frame.mean(0), truth - truth.mean(0)
    u, _, vt = np.linalg.svd(a.T @ b)
    turn = u @ np.diag([1, 1, np.linalg.det(u @ vt)]) @ vt
    return np.linalg.norm(a @ turn - b, axis=1).mean() / np.linalg.norm(truth.max(0) - truth.min(0))


class Runner:
    def __init__(self, bin_dir, folder):
        self.program = str(pathlib.Path(bin_dir).resolve() / "keypose-interpolate")
        self.folder = folder

    def run(self, keys, faces, method, steps, timeline=None):
        out = self.folder / "frames"
        subprocess.run(["rm", "-rf", str(out)], check=True)
        command = [self.program, "--method", method, "--steps", str(steps), "--frames", str(out), "--report", str(self.folder / "report.json")]
        for i, key in enumerate(keys):
            write_ply(self.folder / ("key%d.ply" % i), key, faces)
            command += ["--keys", str(self.folder / ("key%d.ply" % i))]
        if timeline:
            (self.folder / "timeline.json").write_text(json.dumps(timeline))
            command += ["--timeline", str(self.folder / "timeline.json")]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return None, done.stderr.strip().splitlines()[-1:]
        return out, json.loads((out / "distortion.json").read_text())


def pairs(runner):
    rows = []
    for shape, deform, (points, faces) in (("bend", bent, tube(0.12, 2, 30, 59)), ("twist", twisted, bar(0.4, 2, 8, 56))):
        for degrees in ANGLES:
            angle = math.radians(degrees)
            for method in METHODS:
                out, result = runner.run([points, deform(points, 2, angle)], faces, method, 9)
                row = {"shape": shape, "degrees": degrees, "method": method}
                if out is None:
                    row["failed"] = " ".join(result)
                else:
                    row["middle"] = rigid_error(read_points(out / "frame_0005.ply"), deform(points, 2, angle / 2))
                    row["area"] = result["segments"][0]["area"]["path_deviation"]
                    row["volume"] = result["segments"][0]["volume"]["path_deviation"]
                rows.append(row)
    return rows


def sequences(runner):
    """Three keys. Frames a thousandth of a span around the middle key give the speed on both sides."""
    rows = []
    points, faces = tube(0.12, 2, 30, 59)
    twist_points, twist_faces = bar(0.4, 2, 8, 56)
    for name, deform, p, f, degrees in (
        ("bend 0, 150, 270", bent, points, faces, (0, 150, 270)),
        ("bend 0, 270, 450", bent, points, faces, (0, 270, 450)),
        ("bend 0, 270, 0", bent, points, faces, (0, 270, 0)),
        ("twist 0, 150, 300", twisted, twist_points, twist_faces, (0, 150, 300)),
        ("twist 0, 360, 720", twisted, twist_points, twist_faces, (0, 360, 720)),
    ):
        keys = [deform(p, 2, math.radians(d)) for d in degrees]
        row = {"keys": name}
        out, result = runner.run(keys, f, "arap", 9)
        row["area"] = max(s["area"]["path_deviation"] for s in result["segments"])
        row["volume"] = max(s["volume"]["path_deviation"] for s in result["segments"])
        for travel in ("smooth", "linear"):
            timeline = {"schema": 2, "fps": 1000, "interpolation": travel, "keys": [{"time": 0}, {"time": 1}, {"time": 2.4}]}
            out, result = runner.run(keys, f, "arap", 0, timeline)
            q = [read_points(out / ("frame_%04d.ply" % i)) for i in range(998, 1003)]
            before, after = (3 * q[2] - 4 * q[1] + q[0]) / 2, (-3 * q[2] + 4 * q[3] - q[4]) / 2
            speed = np.linalg.norm(keys[1] - keys[0], axis=1).max() / 1000
            row["jump_" + travel] = np.linalg.norm(after - before, axis=1).max() / speed
        rows.append(row)
    return rows


def number(value):
    return "-" if value is None else ("%.1e" % value if abs(value) < 1e-3 else "%.4f" % value)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin_dir")
    parser.add_argument("--json")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        runner = Runner(arguments.bin_dir, pathlib.Path(folder))
        rows, through = pairs(runner), sequences(runner)
    print("| shape | degrees | method | middle frame to the ideal pose | area off its path | volume off its path |\n|---|---|---|---|---|---|")
    for r in rows:
        values = (r["failed"], "", "") if "failed" in r else (number(r["middle"]), number(r["area"]), number(r["volume"]))
        print("| %s | %d | %s | %s | %s | %s |" % ((r["shape"], r["degrees"], r["method"]) + values))
    print("\n| keys | area off its path | volume off its path | jump of pace, smooth | jump of pace, linear |\n|---|---|---|---|---|")
    for r in through:
        print("| %s | %s | %s | %s | %s |" % (r["keys"], number(r["area"]), number(r["volume"]), number(r["jump_smooth"]), number(r["jump_linear"])))
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps({"pairs": rows, "sequences": through}, indent=1) + "\n")


if __name__ == "__main__":
    main()
