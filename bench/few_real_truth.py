"""What a known mesh shows in the cameras of a COLMAP model: silhouettes, and clicks on places of it. For few_real.py."""
import random
import struct
import zlib

import numpy as np

CELL = 6  # of the depth buffer by which visible vertices are found [px]


def read_views(model):
    """Name -> (rotation, translation, width, height, parameters fx fy cx cy k1 k2 p1 p2)."""
    data = (model / 'cameras.bin').read_bytes()
    (count,), at, cameras = struct.unpack_from('<Q', data), 8, {}
    for _ in range(count):
        name, kind, width, height = struct.unpack_from('<iiQQ', data, at)
        length = {0: 3, 1: 4, 2: 4, 3: 5, 4: 8}[kind]
        p = struct.unpack_from(f'<{length}d', data, at + 24)
        at += 24 + 8 * length
        if kind in (0, 2, 3):  # one focal length
            p = (p[0], *p)
        cameras[name] = width, height, (*p, 0, 0, 0, 0)[:8]
    data = (model / 'images.bin').read_bytes()
    (count,), at, views = struct.unpack_from('<Q', data), 8, {}
    for _ in range(count):
        w, x, y, z, *t = struct.unpack_from('<7d', data, at + 4)
        (camera,) = struct.unpack_from('<i', data, at + 60)
        end = data.index(b'\0', at + 64)
        rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        views[data[at + 64:end].decode()] = (rotation, np.array(t), *cameras[camera])
        (features,) = struct.unpack_from('<Q', data, end + 1)
        at = end + 9 + 24 * features
    return views


def read_mesh(path):
    lines = open(path).read().splitlines()
    points = np.array([line.split()[1:4] for line in lines if line.startswith('v ')], float)
    faces = np.array([[int(corner.split('/')[0]) - 1 for corner in line.split()[1:4]] for line in lines if line.startswith('f ')])
    return points, faces


def project(points, view):
    """Pixels, and depths."""
    rotation, translation, _, _, (fx, fy, cx, cy, k1, k2, p1, p2) = view
    x, y, z = (points @ rotation.T + translation).T
    u, v = x / z, y / z
    q = u * u + v * v
    s = 1 + k1 * q + k2 * q * q
    return np.stack([fx * (u * s + 2 * p1 * u * v + p2 * (q + 2 * u * u)) + cx, fy * (v * s + 2 * p2 * u * v + p1 * (q + 2 * v * v)) + cy], 1), z


def silhouette(points, faces, view):
    """255 where the mesh covers the pixel's centre."""
    width, height = view[2:4]
    picture = np.zeros((height, width), np.uint8)
    pixels, _ = project(points, view)
    for a, b, c in pixels[faces]:
        low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        x0, y0 = np.maximum(low - 1, 0).astype(int)
        x1, y1 = np.minimum(high + 2, (width, height)).astype(int)
        if x1 <= x0 or y1 <= y0:
            continue
        x, y = np.arange(x0, x1) + 0.5, (np.arange(y0, y1) + 0.5)[:, None]
        sides = [(q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) for p, q in ((a, b), (b, c), (c, a))]
        # With a little over, so that no gap is left between neighbours.
        inside = np.logical_and.reduce([side >= -0.5 for side in sides]) | np.logical_and.reduce([side <= 0.5 for side in sides])
        picture[y0:y1, x0:x1][inside] = 255
    return picture


def write_grey_png(path, picture):
    height, width = picture.shape
    rows = b''.join(b'\0' + row.tobytes() for row in picture)

    def part(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    head = struct.pack('>IIBBBBB', width, height, 8, 0, 0, 0, 0)
    path.write_bytes(b'\x89PNG\r\n\x1a\n' + part(b'IHDR', head) + part(b'IDAT', zlib.compress(rows, 3)) + part(b'IEND', b''))


def visible(points, faces, view):
    """Which vertices the view shows, not from the side, and where."""
    rotation, translation, width, height, _ = view
    pixels, depth = project(points, view)
    normals = np.zeros_like(points)
    across = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    for k in range(3):
        np.add.at(normals, faces[:, k], across)
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    eye = -rotation.T @ translation
    facing = ((eye - points) * normals).sum(1) / np.linalg.norm(eye - points, axis=1)
    every, deep = np.concatenate([pixels, pixels[faces].mean(1)]), np.concatenate([depth, depth[faces].mean(1)])
    buffer = np.full((height // CELL + 1, width // CELL + 1), 1e9)
    cells = np.clip((every / CELL).astype(int), 0, (width // CELL, height // CELL))
    np.minimum.at(buffer, (cells[:, 1], cells[:, 0]), deep)
    near = np.minimum.reduce([np.roll(buffer, shift, (0, 1)) for shift in np.ndindex(3, 3)])
    near = np.roll(near, (-1, -1), (0, 1))
    own = cells[:len(points)]
    slack = 0.012 * np.linalg.norm(np.ptp(points, axis=0))
    inside = np.all((pixels > 5) & (pixels < np.array([width, height]) - 5), axis=1)
    return (depth < near[own[:, 1], own[:, 0]] + slack) & (facing > 0.45) & inside, pixels


def clicks(mesh, model, names, count, error_px):
    """Picks of `count` places of the lower 45 % of the figure, far from each other, each in all photographs that show it
    (two or more), beside their place by a normal error."""
    points, faces = read_mesh(mesh)
    views = read_views(model)
    seen = {name: visible(points, faces, views[name]) for name in names}
    shown = sum(seen[name][0].astype(int) for name in names)
    height = (points[:, 2] - points[:, 2].min()) / np.ptp(points[:, 2])
    candidates = [int(i) for i in np.argsort(-shown) if shown[i] >= 2 and height[i] < 0.45]
    chosen = [min(candidates, key=lambda i: height[i])]
    while len(chosen) < count:
        chosen.append(max(candidates, key=lambda i: min(np.linalg.norm(points[i] - points[j]) for j in chosen)))
    pick = random.Random(1)
    return [{'name': f'p{n}', 'image': name, 'vertex': i, 'pixel': [round(value + pick.gauss(0, error_px), 1) for value in seen[name][1][i]]}
            for n, i in enumerate(chosen) for name in names if seen[name][0][i]]
