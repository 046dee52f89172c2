#!/usr/bin/python3
"""Poses from few photographs, on real ones.

    few_real.py run --set NAME=PHOTOS ... [--bin DIR] [--work DIR] [--views 0] [--max-size 1600]
                    [--fit-size 1600] [--angles 20,40,60] [--exact-masks] [--clicks 0] [--json FILE]
    few_real.py show FILE.json ...

For each set of photographs: the cameras of --views of them (0: all) by `sfm`; a template from all but six, spread
evenly, by the stages masks to bake, with --max-size for dense and refine (and --fit-size for fit). The template is bent by a known map, of
each angle: its upper half about a horizontal axis, evenly over the middle half of its height (Barr's bend). The stage
`fit` bends it back to the six photographs, which capture masks by themselves; with the template's cameras as the rig
(`rig`), and with the lens alone (`alone`: the cameras are found by texture). The error is the distance of the vertices
from where they were before the map, over the diagonal, after alignment by the six cameras, and for `shape` by the vertices
themselves: how wrong the pose is wherever it stands. Silhouettes and colours are
compared in six further photographs by `score_views`, for the fitted mesh and for the template before the map; fit never
saw them, but the template's texture did. --exact-masks fits to silhouettes of the template before the map instead of
capture's masks; --clicks N picks so many places of the lower part, 3 pixels beside the truth, in the photographs that show them. --work keeps the files: what is there is not made again. Needs
python3-numpy, colmap (which deletes views from models) and the tool score_views in --bin.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import numpy as np

import few_real_truth as truth

FEW = 6


def call(*words, check=True):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if check and done.returncode != 0:
        sys.exit(f'few_real: {" ".join(map(str, words[:3]))} failed:\n{done.stdout[-3000:]}')
    return done


def camera_centres(model):
    """Name -> centre, of a COLMAP model."""
    data = (model / 'images.bin').read_bytes()
    (count,), at = struct.unpack_from('<Q', data), 8
    found = {}
    for _ in range(count):
        w, x, y, z, *t = struct.unpack_from('<7d', data, at + 4)
        at += 64
        end = data.index(b'\0', at)
        rotation = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                             [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                             [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        found[data[at:end].decode()] = -rotation.T @ np.array(t)
        (features,) = struct.unpack_from('<Q', data, end + 1)
        at = end + 9 + 24 * features
    return found


def similarity(a, b):
    """Scale, rotation and shift from rows of `a` to rows of `b` (Umeyama)."""
    ma, mb = a.mean(0), b.mean(0)
    u, s, vt = np.linalg.svd((b - mb).T @ (a - ma) / len(a))
    d = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    scale = (s * np.diag(d)).sum() / ((a - ma) ** 2).sum() * len(a)
    rotation = u @ d @ vt
    return scale, rotation, mb - scale * rotation @ ma


def read_points(path):
    return np.array([line.split()[1:4] for line in open(path) if line.startswith('v ')], float)


def write_moved(source, path, points):
    """A copy of an OBJ file with other positions."""
    rows = iter(points)
    with open(path, 'w') as out:
        for line in open(source):
            out.write('v %.9g %.9g %.9g\n' % tuple(next(rows)) if line.startswith('v ') else line)


def bent(points, degrees):
    """Barr's bend about the horizontal axis across which the figure is thinner; z is up."""
    low, high = points.min(0), points.max(0)
    across = int(np.argmin((high - low)[:2]))
    middle = (low[across] + high[across]) / 2
    begin, length = low[2] + 0.25 * (high[2] - low[2]), 0.5 * (high[2] - low[2])
    turn = math.radians(degrees)
    radius = length / turn
    z, y = points[:, 2], points[:, across] - middle
    share = np.clip((z - begin) / length, 0, 1)
    angle, beyond = turn * share, np.maximum(z - begin - length, 0)
    moved = points.copy()
    moved[:, across] = middle + radius * (1 - np.cos(angle)) + y * np.cos(angle) + beyond * np.sin(angle)
    moved[:, 2] = np.where(z < begin, z, begin + radius * np.sin(angle) - y * np.sin(angle) + beyond * np.cos(angle))
    return moved


class Real:
    """One set of photographs, its template, and what was fitted."""

    def __init__(self, args, name, photos):
        self.args, self.name = args, name
        self.work = args.work / name
        self.work.mkdir(parents=True, exist_ok=True)
        names = sorted(path.name for path in pathlib.Path(photos).iterdir() if path.suffix.lower() in ('.jpg', '.jpeg', '.png'))
        count = args.views or len(names)
        self.source = pathlib.Path(photos)
        self.names = [names[i * len(names) // count] for i in range(count)]

    def stage(self, name, **ports):
        """Runs a stage unless its first output is there already. `out_PORT` are outputs."""
        outputs = {key[4:]: path for key, path in ports.items() if key.startswith('out_')}
        if next(iter(outputs.values())).exists():
            return
        words = [word for key, value in ports.items() for word in ('--' + key.removeprefix('out_'), value)]
        call(self.args.bin / f'keypose-{name}', *words, '--overwrite', '--report', self.work / f'{name}.json')

    def copied(self, folder, names):
        folder.mkdir(exist_ok=True)
        for name in names:
            if not (folder / name).exists():
                shutil.copy(self.source / name, folder / name)
        return folder

    def only(self, which, names):
        """The model with only these views."""
        out = self.work / which
        if not (out / 'images.bin').exists():
            out.mkdir(exist_ok=True)
            listed = self.work / f'{which}.txt'
            listed.write_text(''.join(f'{name}\n' for name in camera_centres(self.model) if name not in names))
            call('colmap', 'image_deleter', '--input_path', self.model, '--output_path', out, '--image_names_path', listed)
        return out

    def template(self):
        w, size = self.work, self.args.max_size
        photos = self.copied(w / 'photos', self.names)
        self.stage('capture', photos=photos, out_images=w / 'images')
        self.model = w / 'model'
        self.stage('sfm', images=w / 'images', out_model=self.model)
        placed = sorted(camera_centres(self.model))
        self.few = [placed[(2 * i + 1) * len(placed) // (2 * FEW)] for i in range(FEW)]
        rest = [name for name in placed if name not in self.few]
        self.further = [rest[i * len(rest) // FEW] for i in range(FEW)]
        known = self.only('known', rest)
        self.stage('masks', images=w / 'images', model=known, out_masked=w / 'masked')
        self.stage('dense', images=w / 'masked', model=known, max_size=size, out_cloud=w / 'cloud.ply')
        self.stage('mesh', cloud=w / 'cloud.ply', images=w / 'masked', model=known, out_surface=w / 'surface.ply')
        self.stage('refine', images=w / 'masked', model=known, surface=w / 'surface.ply', max_size=size, out_refined=w / 'refined.ply')
        self.stage('cleanup', surface=w / 'refined.ply', images=w / 'masked', model=known, out_clean=w / 'clean.ply')
        self.stage('unwrap', clean=w / 'clean.ply', out_unwrapped=w / 'mesh.obj')
        self.stage('bake', mesh=w / 'mesh.obj', images=w / 'masked', model=known, hold_out=0, out_texture=w / 'texture.png')
        self.stage('capture', photos=self.copied(w / 'few', self.few), min_images=2, out_images=w / 'few_images')

    def score(self, mesh, picture):
        """Silhouettes and colours in the further views."""
        further = self.only('further', self.further)
        out = self.work / 'score.json'
        call(self.args.bin / 'score_views', '--mesh', mesh, '--texture', self.work / 'texture.png', '--model', further, '--photographs', self.work / 'photos',
             '--masks', self.work / 'masked/masks', '--json', out, '--picture', picture)
        means = json.loads(out.read_text())['all']
        return {key: means[key] for key in ('iou', 'psnr_db', 'gained_psnr_db')}

    def exact_images(self):
        """The six photographs with silhouettes of the template before the map as masks."""
        folder = self.work / 'few_exact'
        if not folder.exists():
            shutil.copytree(self.work / 'few_images', folder)
            points, faces = truth.read_mesh(self.work / 'mesh.obj')
            views = truth.read_views(self.model)
            for name in self.few:
                truth.write_grey_png(folder / f'masks/{name}.png', truth.silhouette(points, faces, views[name]))
        return folder

    def picks(self):
        """The words for fit, with --clicks."""
        if not self.args.clicks:
            return []
        file = self.work / f'clicks_{self.args.clicks}.json'
        file.write_text(json.dumps({'schema': 2, 'pixels': truth.clicks(self.work / 'mesh.obj', self.model, self.few, self.args.clicks, 3)}))
        return ['--landmarks', file]

    def fit(self, degrees, alone):
        w = self.work
        name = f'{degrees}_{"alone" if alone else "rig"}' + '_exact' * self.args.exact_masks + f'_clicks{self.args.clicks}' * bool(self.args.clicks)
        images = self.exact_images() if self.args.exact_masks else w / 'few_images'
        folder = w / name
        folder.mkdir(exist_ok=True)
        rest = read_points(w / 'mesh.obj')
        start = bent(rest, degrees)
        write_moved(w / 'mesh.obj', folder / 'bent.obj', start)
        rig = self.only('one', self.further[:1]) if alone else self.model
        if not (folder / 'fit.json').exists():
            done = call(self.args.bin / 'keypose-fit', '--template', folder / 'bent.obj', '--texture', w / 'texture.png', '--images', images,
                        '--rig', rig, '--fitted', folder / 'fitted.obj', '--model', folder / 'model', '--picture', folder / 'fitted.png', '--overwrite',
                        '--max_size', self.args.fit_size, '--report', folder / 'fit.json', *self.picks(), check=False)
            if done.returncode != 0:
                return {'failed': done.stdout.strip().splitlines()[-1]}
        report = json.loads((folder / 'fit.json').read_text())
        ours, true = camera_centres(folder / 'model'), camera_centres(self.model)
        names = sorted(ours)
        scale, rotation, shift = similarity(np.array([ours[n] for n in names]), np.array([true[n] for n in names]))
        moved = scale * read_points(folder / 'fitted.obj') @ rotation.T + shift
        write_moved(w / 'mesh.obj', folder / 'placed.obj', moved)
        diagonal = np.linalg.norm(np.ptp(rest, axis=0))
        error = np.linalg.norm(moved - rest, axis=1) / diagonal
        scale, rotation, shift = similarity(moved, rest)
        of_shape = np.linalg.norm(scale * moved @ rotation.T + shift - rest, axis=1) / diagonal
        return {'placed': len(names), 'rig': report['measurements']['rig'], 'away': float(np.linalg.norm(start - rest, axis=1).mean() / diagonal),
                'mean': float(error.mean()), 'p95': float(np.percentile(error, 95)), 'max': float(error.max()), 'shape': float(of_shape.mean()), 'seconds': report['seconds'],
                **self.score(folder / 'placed.obj', folder / 'views.png')}


def measure(args):
    results = []
    for named in args.set:
        real = Real(args, *named.split('=', 1))
        real.template()
        result = {'set': real.name, 'views': len(real.names), 'few': real.few, 'further': real.further,
                  'full': real.score(real.work / 'mesh.obj', real.work / 'views.png'), 'fits': []}
        results.append(result)
        for degrees in map(int, args.angles.split(',')):
            for alone in (False, True):
                result['fits'].append({'degrees': degrees, 'alone': alone, **real.fit(degrees, alone)})
                print(real.name, result['fits'][-1], flush=True)
                if args.json:
                    pathlib.Path(args.json).write_text(json.dumps(results, indent=1) + '\n')
    return results


def show(results):
    print('| set | bent by | cameras | away before | mean error | of the shape | 95 % of vertices within | largest | IoU in six unseen views | PSNR there |')
    print('|---|---|---|---|---|---|---|---|---|---|')
    for result in results:
        full = result['full']
        print(f"| {result['set']} | full reconstruction | | | | | | | {full['iou']:.4f} | {full['gained_psnr_db']:.2f} dB |")
        for row in result['fits']:
            cameras = 'by texture' if row['alone'] else 'of the rig'
            if 'failed' in row:
                print(f"| {result['set']} | {row['degrees']} degrees | {cameras} | {row['failed']} |")
                continue
            print(f"| {result['set']} | {row['degrees']} degrees | {cameras} | {100 * row['away']:.1f} % | {100 * row['mean']:.2f} % | {100 * row['shape']:.2f} % | {100 * row['p95']:.2f} % | "
                  f"{100 * row['max']:.1f} % | {row['iou']:.4f} | {row['gained_psnr_db']:.2f} dB |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    run = commands.add_parser('run')
    run.add_argument('--set', action='append', required=True, metavar='NAME=PHOTOS')
    run.add_argument('--bin', type=pathlib.Path, default=pathlib.Path('build/release/bin'))
    run.add_argument('--work', type=pathlib.Path)
    run.add_argument('--views', type=int, default=0)
    run.add_argument('--max-size', type=int, default=1600)
    run.add_argument('--fit-size', type=int, default=1600)
    run.add_argument('--angles', default='20,40,60')
    run.add_argument('--exact-masks', action='store_true')
    run.add_argument('--clicks', type=int, default=0)
    run.add_argument('--json')
    commands.add_parser('show').add_argument('files', nargs='+')
    args = parser.parse_args()
    if args.command == 'show':
        return show([result for name in args.files for result in json.loads(pathlib.Path(name).read_text())])
    args.work = args.work or pathlib.Path(tempfile.mkdtemp(prefix='few_real_'))
    return show(measure(args))


if __name__ == '__main__':
    main()
