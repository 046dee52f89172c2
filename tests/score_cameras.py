#!/usr/bin/python3
"""Prints the distances between the camera centres of two COLMAP models, as one JSON line.

    score_cameras.py MODEL REFERENCE

The arguments are folders with images.bin or images.txt. A similarity fitted to the centres (Umeyama) transforms
MODEL into REFERENCE's frame. Errors are fractions of REFERENCE's mean distance from its cameras to the point
nearest to their optical axes. Needs python3-numpy.
"""
import json
import os
import struct
import sys

import numpy as np


def poses(folder):
    """Name -> (rotation 3 x 3 camera from world, centre in world)."""
    found = {}
    text = os.path.join(folder, "images.txt")
    if os.path.exists(os.path.join(folder, "images.bin")):
        data = open(os.path.join(folder, "images.bin"), "rb").read()
        (count,), at = struct.unpack_from("<Q", data), 8
        for _ in range(count):
            q = struct.unpack_from("<7d", data, at + 4)
            at += 4 + 56 + 4
            end = data.index(b"\0", at)
            name = data[at:end].decode()
            (features,) = struct.unpack_from("<Q", data, end + 1)
            at = end + 9 + 24 * features
            found[name] = pose(q)
    else:
        lines = [line for line in open(text) if not line.startswith("#")]
        for line in lines[::2]:
            words = line.split()
            if len(words) >= 10:
                found[" ".join(words[9:])] = pose([float(x) for x in words[1:8]])
    return found


def pose(q):
    w, x, y, z = np.array(q[:4]) / np.linalg.norm(q[:4])
    rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                         [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                         [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
    return rotation, -rotation.T @ np.array(q[4:7])


def looked_at(entries):
    """The point nearest to all optical axes."""
    a, b = np.zeros((3, 3)), np.zeros(3)
    for rotation, centre in entries:
        project = np.eye(3) - np.outer(rotation[2], rotation[2])
        a += project
        b += project @ centre
    return np.linalg.solve(a, b)


def similarity(a, b):
    """The least-squares similarity from rows of `a` to rows of `b`."""
    ma, mb = a.mean(0), b.mean(0)
    u, s, vt = np.linalg.svd((b - mb).T @ (a - ma) / len(a))
    d = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    scale = (s * np.diag(d)).sum() / ((a - ma) ** 2).sum() * len(a)
    return (a - ma) @ (scale * u @ d @ vt).T + mb


def main():
    model, reference = poses(sys.argv[1]), poses(sys.argv[2])
    names = sorted(set(model) & set(reference))
    if len(names) < 3:
        sys.exit("score_cameras: the two models share %d images; 3 are needed" % len(names))
    a = np.array([model[n][1] for n in names])
    b = np.array([reference[n][1] for n in names])
    distance = np.linalg.norm(np.array([c for _, c in reference.values()]) - looked_at(reference.values()), axis=1).mean()
    error = np.linalg.norm(similarity(a, b) - b, axis=1) / distance
    print(json.dumps({"shared": len(names), "model": len(model), "reference": len(reference), "mean": round(error.mean(), 9),
                      "rms": round(float(np.sqrt((error ** 2).mean())), 9), "max": round(error.max(), 9)}))


main()
