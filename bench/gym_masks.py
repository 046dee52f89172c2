#!/usr/bin/python3
"""Masks of the gym's actor against masks that were painted by hand.

    gym_masks.py MASKS [--truth gym_masks.json] [--json FILE]

MASKS is a folder with cam01/005.png and on: `masks` of what `keypose silhouettes --masked` writes, or a
project's folder, in which it is looked for. For each of the 20 frames it prints the overlap (area of what both
have over the area of what either has), and what is too much and what is lacking over the same area; then
mean and least.

The outlines in gym_masks.json, in pixels of the film's picture (a pixel's centre is a whole number; holes are
outlines too, by the even-odd rule), were drawn by hand around the actor in an enlarged picture with a grid,
moved to the nearest edge within 7 pixels by a local GrabCut (Rother et al., SIGGRAPH 2004), looked at and mended
by hand. No mask of Keypose's had a part in it. `left_out` is the box (x, y, x, y) of the mosaic over the face, in which
no outline can be seen: it is not compared. Needs python3-numpy.
"""
import argparse
import json
import pathlib
import struct
import sys
import zlib

import numpy as np


def unfiltered(raw, rows, stride, step):
    """The bytes of a PNG's rows, whose filters are undone."""
    out = np.zeros((rows, stride), np.uint8)
    before = bytearray(stride)
    for y in range(rows):
        kind, line = raw[y * (stride + 1)], bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        for x in range(stride) if kind else ():
            left, up = line[x - step] if x >= step else 0, before[x]
            corner = before[x - step] if x >= step else 0
            if kind == 4:
                ways = [abs(up - corner), abs(left - corner), abs(left + up - 2 * corner)]
                add = (left, up, corner)[ways.index(min(ways))]
            else:
                add = (0, left, up, (left + up) // 2)[kind]
            line[x] = (line[x] + add) & 255
        out[y] = np.frombuffer(bytes(line), np.uint8)
        before = line
    return out


def read_mask(path):
    """A grey PNG of one or eight bits a pixel, true where it is white."""
    data, at, pixels, head = path.read_bytes(), 8, b'', None
    while at < len(data):
        length, kind = struct.unpack_from('>I4s', data, at)
        body = data[at + 8:at + 8 + length]
        head = struct.unpack('>IIBBBBB', body) if kind == b'IHDR' else head
        pixels += body if kind == b'IDAT' else b''
        at += 12 + length
    width, height, bits, colour, _, _, interlaced = head
    if bits not in (1, 8) or colour != 0 or interlaced:
        sys.exit(f'gym_masks: {path} is no grey PNG of one or eight bits')
    rows = unfiltered(zlib.decompress(pixels), height, (width * bits + 7) // 8, 1)
    return np.unpackbits(rows, axis=1)[:, :width] > 0 if bits == 1 else rows > 127


def filled(outlines, width, height):
    """The pixels whose centres are inside of the outlines, by the even-odd rule, or on one of them."""
    crossings = np.zeros((height, width + 1), np.int64)
    edge = np.zeros((height, width), bool)
    for outline in outlines:
        points = np.array(outline, float).reshape(-1, 2)
        for (x0, y0), (x1, y1) in zip(points, np.roll(points, -1, axis=0)):
            steps = int(max(abs(x1 - x0), abs(y1 - y0))) + 1
            xs = np.clip(np.round(np.linspace(x0, x1, steps)).astype(int), 0, width - 1)
            ys = np.clip(np.round(np.linspace(y0, y1, steps)).astype(int), 0, height - 1)
            edge[ys, xs] = True
            low, high = sorted((y0, y1))
            rows = np.arange(max(0, int(np.ceil(low))), min(height, int(np.ceil(high))))
            at = np.ceil(x0 + (rows - y0) * (x1 - x0) / (y1 - y0)) if y0 != y1 else rows
            crossings[rows, np.clip(at, 0, width).astype(int)] += 1
    return edge | (np.cumsum(crossings, axis=1)[:, :width] % 2 == 1)


def folder_of(masks):
    """The folder with cam01 and on: the one given, or the newest one in a project."""
    if (masks / 'cam01').is_dir():
        return masks
    found = sorted(masks.glob('.keypose/cache/*/*/masked/masks'), key=lambda path: path.stat().st_mtime)
    if not found:
        sys.exit(f'gym_masks: {masks} has neither masks cam01/000.png and on, nor a run of silhouettes')
    return found[-1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('masks', type=pathlib.Path)
    parser.add_argument('--truth', type=pathlib.Path, default=pathlib.Path(__file__).with_name('gym_masks.json'))
    parser.add_argument('--json', type=pathlib.Path)
    args = parser.parse_args()
    folder, rows = folder_of(args.masks), []
    for frame in json.loads(args.truth.read_text())['frames']:
        mask = read_mask(folder / frame['camera'] / f'{frame["frame"]:03d}.png')
        truth = filled(frame['outlines'], mask.shape[1], mask.shape[0])
        if frame['left_out']:
            left, top, right, bottom = frame['left_out']
            mask[top:bottom, left:right] = truth[top:bottom, left:right] = False
        either = max(1, (mask | truth).sum())
        rows.append({'camera': frame['camera'], 'frame': frame['frame'], 'overlap': (mask & truth).sum() / either,
                     'too_much': (mask & ~truth).sum() / either, 'lacking': (truth & ~mask).sum() / either})
        print('{camera} {frame:3d}  overlap {overlap:.3f}  too much {too_much:.3f}  lacking {lacking:.3f}'.format(**rows[-1]))
    overlaps = [row['overlap'] for row in rows]
    print(f'mean {sum(overlaps) / len(overlaps):.3f}, least {min(overlaps):.3f}')
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + '\n')


if __name__ == '__main__':
    main()
