#!/usr/bin/env python3
"""Measures the stage locate on generated pictures against the exact cameras.

    locate_table.py run [--bin DIR] [--work DIR] [--seeds 11-20] [--views 4] [--size 1920x1080] [--cases NAMES]
                        [--json FILE]
    locate_table.py show FILE.json ...

For each seed: another clay character of `keypose synth photos` with all limbs moved, its mesh (12,000 faces) and a
texture baked from 16 photographs of 640 pixels; and pictures of it from other places by another lens. Each is located
by itself, in several cases:

    textured     mesh, texture and the exact matte
    captured     mesh, texture and the matte that `capture` makes from these few pictures
    outline      mesh and the exact matte, no texture
    bare         mesh and texture, no matte
    no-exif      as textured, but the focal length is not told
    clicks       six exact places, without matte and texture
    quick        likewise, with --quick
    quick-matte  likewise, and the exact matte
    empty        the set without the character: must end with exit code 3

Errors are those of camera from character. --work keeps the files: what is there is not made again. Needs only Python.
"""
import argparse
import json
import math
import pathlib
import resource
import struct
import subprocess
import sys
import tempfile

CASES = ('textured', 'captured', 'outline', 'bare', 'no-exif', 'clicks', 'quick', 'quick-matte', 'empty')


def call(command, check=True):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if check and done.returncode != 0:
        sys.exit(f'locate_table: {" ".join(map(str, command[:3]))} failed:\n{done.stdout[-3000:]}')
    return done


def numbers(text):
    """'11-14,20' as a list."""
    found = []
    for part in text.split(','):
        first, _, last = part.partition('-')
        found += range(int(first), int(last or first) + 1)
    return found


def read_cameras(folder):
    """COLMAP's binary model: name -> (rotation w x y z, translation, camera parameters)."""
    lenses, views = {}, {}
    data = (folder / 'cameras.bin').read_bytes()
    at = 8
    for _ in range(struct.unpack_from('<Q', data)[0]):
        key, model, width, height = struct.unpack_from('<iiQQ', data, at)
        count = {0: 3, 1: 4, 2: 4, 3: 5, 4: 8}[model]
        lenses[key] = (model, width, height, struct.unpack_from(f'<{count}d', data, at + 24))
        at += 24 + 8 * count
    data = (folder / 'images.bin').read_bytes()
    at = 8
    for _ in range(struct.unpack_from('<Q', data)[0]):
        _, *pose, key = struct.unpack_from('<i7di', data, at)
        at += 64
        end = data.index(b'\0', at)
        name = data[at:end].decode()
        points, = struct.unpack_from('<Q', data, end + 1)
        at = end + 9 + 24 * points
        views[name] = (pose[:4], pose[4:], lenses[key])
    return views


def product(a, b):
    return (a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0])


def turned(q, x):
    r = product(product(q, (0, *x)), (q[0], -q[1], -q[2], -q[3]))
    return r[1:]


def angle(a, b):
    """Of the rotation between two unit quaternions, degrees."""
    d = product((a[0], -a[1], -a[2], -a[3]), b)
    return 2 * math.degrees(math.atan2(math.sqrt(d[1] ** 2 + d[2] ** 2 + d[3] ** 2), abs(d[0])))


def distance(a, b):
    return math.sqrt(sum((x - y) ** 2 for x, y in zip(a, b)))


def found_view(frame):
    """Camera from character of one frame of a shot.json."""
    camera, place = frame['camera_from_world'], frame['world_from_character']
    rotation = product(camera['rotation'], place['rotation'])
    translation = [a + b for a, b in zip(turned(camera['rotation'], place['translation']), camera['translation'])]
    return rotation, translation


def center(rotation, translation):
    back = (rotation[0], -rotation[1], -rotation[2], -rotation[3])
    return [-x for x in turned(back, translation)]


def project(view, x):
    rotation, translation, (_, _, _, (fx, fy, cx, cy, k1, k2, p1, p2)) = view
    y = [a + b for a, b in zip(turned(rotation, x), translation)]
    u, v = y[0] / y[2], y[1] / y[2]
    r2 = u * u + v * v
    radial = 1 + r2 * (k1 + r2 * k2)
    return fx * (u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u)) + cx, fy * (v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v)) + cy


def read_vertices(path):
    return [tuple(map(float, line.split()[1:4])) for line in path.read_text().splitlines() if line.startswith('v ')]


def without_exif(jpeg):
    """The picture without its APP1 segments."""
    kept, at = jpeg[:2], 2
    while jpeg[at] == 0xFF and jpeg[at + 1] != 0xDA:
        end = at + 2 + struct.unpack_from('>H', jpeg, at + 2)[0]
        if jpeg[at + 1] != 0xE1:
            kept += jpeg[at:end]
        at = end
    return kept + jpeg[at:]


class Seed:
    """The files and results of one character."""

    def __init__(self, args, seed):
        self.args, self.seed = args, seed
        self.bin = pathlib.Path(args.bin)
        self.locate = pathlib.Path(args.locate or self.bin / 'keypose-locate')
        self.folder = args.work / f'seed_{seed}'

    def program(self, name):
        return self.bin / f'keypose-{name}'

    def photographs(self, name, words):
        world = self.folder / name
        if not (world / 'done').exists():
            call([self.program('synth'), 'photos', '--output', world, '--poses', 'limbs', '--seed', self.seed, '--pose-seed', self.seed, '--spacing', 0.004, *words])
            (world / 'done').write_text('')
        return world

    def make(self):
        """The character with its texture, and the pictures to locate."""
        f = self.folder
        f.mkdir(parents=True, exist_ok=True)
        world = self.photographs('world', ['--views', 16, '--width', 640, '--height', 480])
        truth = world / 'truth/limbs'
        if not (f / 'texture.png').exists():
            surface = truth / ('outer.ply' if (truth / 'outer.ply').exists() else 'surface.ply')
            call([self.program('cleanup'), '--surface', surface, '--faces', 12000, '--clean', f / 'clean.ply'])
            call([self.program('unwrap'), '--clean', f / 'clean.ply', '--unwrapped', f / 'mesh.obj'])
            call([self.program('capture'), '--photos', world / 'photos/limbs', '--images', f / 'images', '--overwrite'])
            call([self.program('bake'), '--mesh', f / 'mesh.obj', '--images', f / 'images', '--model', truth / 'cameras', '--texture_size', 1024, '--hold_out', 0,
                  '--texture', f / 'texture.png'])
        width, height = self.args.size.split('x')
        film = self.photographs('film', ['--views', self.args.views, '--elevations', 6, 24, '--width', width, '--height', height, '--focal', 45,
                                         '--photographer-seed', self.seed + 100, '--clean-plate'])
        if 'captured' in self.args.cases and not (f / 'film_images').exists():
            call([self.program('capture'), '--photos', film / 'photos/limbs', '--images', f / 'film_images', '--min_images', 2])
        return film

    def clicks(self, view):
        """Six vertices far from each other that the camera sees, found by the least depth near their pixels."""
        vertices = read_vertices(self.folder / 'mesh.obj')
        rotation, translation, _ = view
        depth = lambda x: turned(rotation, x)[2] + translation[2]
        nearest = {}
        for i, x in enumerate(vertices):
            u, v = project(view, x)
            cell = (int(u / 60), int(v / 60))
            if cell not in nearest or depth(x) < depth(vertices[nearest[cell]]):
                nearest[cell] = i
        chosen = [min(nearest.values())]
        while len(chosen) < 6:
            chosen.append(max(nearest.values(), key=lambda i: min(distance(vertices[i], vertices[k]) for k in chosen)))
        return {'schema': 1, 'clicks': [{'pixel': list(project(view, vertices[i])), 'vertex': i} for i in chosen]}

    def words(self, case, film, name, view):
        """The command line of one case."""
        f = self.folder
        words = ['--mesh', f / 'mesh.obj', '--plate', film / 'photos/limbs' / name]
        if case in ('textured', 'captured', 'no-exif', 'bare', 'empty'):
            words += ['--textures', f / 'texture.png']
        if case == 'captured':
            words += ['--matte', f / 'film_images/masks' / (name + '.png')]
        if case in ('textured', 'no-exif', 'outline', 'quick-matte'):
            words += ['--matte', film / 'truth/limbs/masks' / (name + '.png')]
        if case in ('clicks', 'quick', 'quick-matte'):
            (f / 'clicks.json').write_text(json.dumps(self.clicks(view)))
            words += ['--clicks', f / 'clicks.json'] + (['--quick', 'true'] if case != 'clicks' else [])
        if case == 'empty':
            words[words.index('--plate') + 1] = film / 'background/limbs.jpg'
        if case == 'no-exif':
            bare = f / ('bare_' + name)
            bare.write_bytes(without_exif((film / 'photos/limbs' / name).read_bytes()))
            words[words.index('--plate') + 1] = bare
        return words

    def measure(self, case, film, name, view):
        f = self.folder
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = call([self.locate, *self.words(case, film, name, view), '--shot', f / 'shot.json', '--report', f / 'report.json', '--overwrite'], check=False)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        row = {'seed': self.seed, 'name': name, 'case': case, 'exit': done.returncode,
               'cpu_s': after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}
        if done.returncode != 0:
            row['message'] = done.stdout.strip().splitlines()[-1][:300]
            return row
        report = json.loads((f / 'report.json').read_text())
        shot = json.loads((f / 'shot.json').read_text())
        rotation, translation = found_view(shot['frames'][0])
        away = distance(center(*view[:2]), [0, 0, 0.1])
        measured = report['measurements']
        row.update(seconds=report['seconds'], turn_deg=angle(rotation, view[0]),
                   center=distance(center(rotation, translation), center(*view[:2])) / away,
                   contour_px=measured['contour_px'], iou=measured['iou_least'], method=measured['frames'][0]['method'],
                   inliers=measured['frames'][0]['inliers'], correlation=measured['frames'][0]['correlation'], rival=measured['frames'][0]['rival_ratio'],
                   focal=measured['focal'], focal_error=shot['camera']['fx'] / view[2][3][0] - 1, focal_seen=measured['focal_seen'], center_seen_px=measured.get('center_seen_px'), k1=shot['camera']['k1'])
        return row


def measure(args):
    rows = []
    for seed in numbers(args.seeds):
        one = Seed(args, seed)
        film = one.make()
        views = read_cameras(film / 'truth/limbs/cameras')
        for case in args.cases.split(','):
            for name, view in sorted(views.items()):
                if case == 'empty' and rows and rows[-1]['case'] == 'empty' and rows[-1]['seed'] == seed:
                    continue
                rows.append(one.measure(case, film, name, view))
                print(json.dumps(rows[-1]), file=sys.stderr)
        if args.json:
            pathlib.Path(args.json).write_text(json.dumps({'rows': rows}, indent=1) + '\n')
    return rows


def spread(values, unit):
    values = sorted(values)
    if not values:
        return '-'
    return f'{values[len(values) // 2]:.3g} / {values[min(len(values) - 1, int(0.9 * len(values)))]:.3g} / {values[-1]:.3g}{unit}'


def show(rows):
    """Found: within a degree, and an overlap of 0.98 where there is a matte to measure it by."""
    print('| case | pictures | found | rotation [deg] | contour [px] | IoU, least | centre [% of distance] | CPU [s] |')
    print('|---|---|---|---|---|---|---|---|')
    for case in CASES:
        these = [row for row in rows if row['case'] == case]
        if not these:
            continue
        if case == 'empty':
            print(f"| {case} | {len(these)} | refused {sum(row['exit'] == 3 for row in these)} | | | | | {spread([row['cpu_s'] for row in these], '')} |")
            continue
        found = [row for row in these if row['exit'] == 0 and row['turn_deg'] < 1 and (row['iou'] > 0.98 or case in ('bare', 'clicks', 'quick'))]
        cells = [case, len(these), f'{len(found)} ({100 * len(found) / len(these):.0f} %)', spread([row['turn_deg'] for row in found], ''),
                 spread([row['contour_px'] for row in found], ''), f"{min([row['iou'] for row in found], default=0):.4f}",
                 spread([100 * row['center'] for row in found], ''), spread([row['cpu_s'] for row in these], '')]
        print('| ' + ' | '.join(map(str, cells)) + ' |')
    print('\nThree numbers are the median, the 90th percentile and the greatest, of what was found.')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    run = commands.add_parser('run')
    run.add_argument('--bin', default='build/release/bin')
    run.add_argument('--locate', help='another keypose-locate than that in --bin')
    run.add_argument('--work', type=pathlib.Path)
    run.add_argument('--seeds', default='11-20')
    run.add_argument('--views', type=int, default=4)
    run.add_argument('--size', default='1920x1080')
    run.add_argument('--cases', default=','.join(CASES))
    run.add_argument('--json')
    commands.add_parser('show').add_argument('files', nargs='+')
    args = parser.parse_args()
    if args.command == 'show':
        show([row for name in args.files for row in json.loads(pathlib.Path(name).read_text())['rows']])
        return
    with tempfile.TemporaryDirectory() as folder:
        args.work = args.work or pathlib.Path(folder)
        show(measure(args))


if __name__ == '__main__':
    main()
