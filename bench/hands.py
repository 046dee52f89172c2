#!/usr/bin/env python3
"""Hands and tools before figures: is each one told of, and nothing else?

    hands.py --sets NAME=IMAGES:MODEL:MESH,... [--bin DIR] [--work DIR] [--kinds none,hand,tool] [--count 2]
             [--bent 0.02] [--json FILE]

IMAGES is a folder as `masks` or `capture` writes it, MODEL its cameras, MESH a mesh with texture coordinates. Each set
is baked as it is, and with a hand or tool (`synth damage`) in --count photographs, spread over the set; masks stay,
so that what lies before the figure is in them, as where it has the figure's colours. Where what is drawn covers less
than 2 % of the mask, nothing need be said. --bent also bakes each set on a mesh that is bent by this share of its
size, as a bad reconstruction is: nothing lies before it. Exit code 1 if a row is wrong. Needs Python and ffmpeg.
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

LEAST_SHARE = 0.02


def call(command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f'hands: {" ".join(map(str, command))} failed:\n{done.stdout[-2000:]}')
    return done


def grey(file):
    """@return bytes, a pixel each, of a picture at 480 px"""
    done = subprocess.run(['ffmpeg', '-loglevel', 'error', '-i', str(file), '-vf', 'scale=480:-2', '-f', 'rawvideo', '-pix_fmt', 'gray', '-'],
                          stdout=subprocess.PIPE, check=True)
    return done.stdout


def covered(before, after, mask):
    """Share of the mask where a photograph was drawn over."""
    a, b, m = grey(before), grey(after), grey(mask)
    inside = [i for i in range(len(m)) if m[i] > 127]
    return sum(1 for i in inside if abs(a[i] - b[i]) > 8) / max(1, len(inside))


def bend(source, target, share):
    """Moves the vertices of an OBJ file by a smooth field of that share of its diagonal."""
    lines = source.read_text().splitlines()
    points = [tuple(map(float, line.split()[1:4])) for line in lines if line.startswith('v ')]
    low, high = [min(p[k] for p in points) for k in range(3)], [max(p[k] for p in points) for k in range(3)]
    diagonal = math.dist(low, high)
    moved = iter(points)
    with open(target, 'w') as out:
        for line in lines:
            if not line.startswith('v '):
                out.write(line + '\n')
                continue
            p = next(moved)
            wave = [math.sin(9 * (p[(k + 1) % 3] - low[(k + 1) % 3]) / diagonal + k) for k in range(3)]
            out.write('v ' + ' '.join(f'{p[k] + share * diagonal * wave[k]:.7g}' for k in range(3)) + '\n')


def bake(bin_dir, images, model, mesh, work):
    report = work / 'report.json'
    call([bin_dir / 'keypose-bake', '--mesh', mesh, '--images', images, '--model', model, '--texture', work / 'texture.png', '--report', report,
          '--texture_size', 512, '--hold_out', 0])
    read = json.loads(report.read_text())
    told = [w.split('before the figure in ')[1].split(' (')[0] for w in read.get('warnings', []) if 'before the figure in' in w]
    against = [entry['name'] for entry in read['measurements'].get('distrusted', [])]
    return sorted(told + against), read['measurements']['color_fits']


def walk(args, name, images, model, mesh, kind):
    bin_dir, work = pathlib.Path(args.bin), pathlib.Path(args.work) / f'{name}_{kind}'
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    shares, folder = {}, images
    if kind == 'bent':
        bend(mesh, work / 'bent.obj', args.bent)
        mesh = work / 'bent.obj'
    elif kind != 'none':
        listed = json.loads((images / 'capture.json').read_text())['images']
        trusted = [one['name'] for one in listed if one.get('trusted', True)]
        start = 2 if kind == 'hand' else 5
        names = sorted({trusted[(start + k * len(trusted) // args.count) % len(trusted)] for k in range(args.count)})
        folder = work / 'images'
        call([bin_dir / 'keypose', 'synth', 'damage', '--photos', images, '--output', folder, '--kind', kind, '--names', ','.join(names)])
        shares = {n: covered(images / n, folder / n, images / 'masks' / (n + '.png')) for n in names}
    told, fits = bake(bin_dir, folder, model, mesh, work)
    false = [n for n in told if n not in shares]
    missed = [n for n in shares if n not in told and shares[n] >= LEAST_SHARE]
    return {'set': name, 'kind': kind, 'photographs': len(fits), 'shares': shares, 'told': told, 'false': false, 'missed': missed,
            'right': not false and not missed}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--sets', required=True)
    parser.add_argument('--bin', default='build/release/bin')
    parser.add_argument('--work')
    parser.add_argument('--kinds', default='none,hand,tool')
    parser.add_argument('--count', type=int, default=2)
    parser.add_argument('--bent', type=float, default=0)
    parser.add_argument('--json')
    args = parser.parse_args()
    args.work = args.work or tempfile.mkdtemp(prefix='hands_')
    rows = []
    for pair in args.sets.split(','):
        name, paths = pair.split('=', 1)
        images, model, mesh = map(pathlib.Path, paths.split(':'))
        for kind in args.kinds.split(',') + (['bent'] if args.bent else []):
            rows.append(walk(args, name, images, model, mesh, kind))
            print(rows[-1], file=sys.stderr, flush=True)
            if args.json:
                pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')
    print('| set | photographs | before the figure | covers | told | false | missed |\n|---|---|---|---|---|---|---|')
    for r in rows:
        shares = ', '.join(f'{100 * s:.1f} %' for s in r['shares'].values())
        print(f'| {r["set"]} | {r["photographs"]} | {r["kind"]} | {shares} | {len(r["told"])} | {len(r["false"])} | {len(r["missed"])} |')
    print(f'\n{sum(r["right"] for r in rows)} of {len(rows)} right')
    sys.exit(0 if all(r['right'] for r in rows) else 1)


if __name__ == '__main__':
    main()
