#!/usr/bin/env python3
"""Halves and doubles each tuned constant (core/tuned.h) and measures how the result changes.

    sensitivity.py [--bin build/sensitive/bin] [--data DATA] [--scorer SCORER] [--only REGEX] [--work DIR]
                   [--json FILE]
    sensitivity.py show FILE.json        prints the table of a file written with --json

The programs must be built with the constants open to change:

    cmake --preset release -B build/sensitive -DKEYPOSE_SENSITIVITY=ON && cmake --build build/sensitive

Each constant is measured by the stage that it is in, on the clay character of `keypose synth photos` (16
photographs of 640 px; seed 1) against its truth, and constants of registration and interpolation as named below.
A constant that only acts in cases that these inputs do not have shows no change: that is said with `-`.

    masks     1 - IoU of the masks, by the true surface
    surface   distance of the refined or cleaned surface to the true one, over the diagonal
    stereo    the same as `surface`, from `dense` on
    unwrap    share of the texture's square that the charts leave empty
    bake      error of the photographs shown again by the textured mesh (root mean square, 0 to 1)
    register  mean error of a limb bent by 180 degrees, seeds 0 and 1 with 7 landmarks and none, exact truth; with
              --data also of two real pairs, 12 landmarks and none
    bend      distance of the middle frame of a tube, bent and twisted by 150 to 450 degrees, from the ideal pose

Needs python3-numpy and python3-scipy for `register` and `bend`.
"""
import argparse
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TUNED = re.compile(r'KEYPOSE_TUNED\((\w+),\s*(\w+),\s*([^)]+)\);(?:\s*///?<?\s*(.*))?')
STRUCT = re.compile(r'^\s*struct (\w+)')
NO_CHANGE = 5e-4  # relative; less is shown as none


def constants():
    """All tuned constants of the sources: file, struct, name, value, comment."""
    found = []
    for path in sorted(ROOT.glob('*/**/*')):
        folder = path.relative_to(ROOT).parts[0]
        if path.suffix not in ('.h', '.cpp') or folder in ('build', 'core', 'node_modules') or folder.startswith('build'):
            continue
        struct = ''
        for line in path.read_text().splitlines():
            if match := STRUCT.match(line):
                struct = match[1]
            if match := TUNED.search(line):
                found.append({'file': str(path.relative_to(ROOT)), 'struct': struct, 'name': match[2], 'value': value_of(match[3]),
                              'whole': match[1] == 'int', 'comment': match[4] or ''})
    return found


def value_of(text):
    """A number, or an expression of numbers as in 15.0 / 255 or 35 * EIGEN_PI / 180."""
    numbers = re.sub(r'(EIGEN_PI|M_PI|std::numbers::pi)', repr(math.pi), text)
    numbers = re.sub(r'(?<=[0-9.])[Ff]\b', '', numbers)
    if not re.fullmatch(r'[-+*/ 0-9.e]+', numbers):
        sys.exit(f'sensitivity: a tuned constant has the value {text}, which is no number')
    return float(eval(numbers, {}))  # only digits and the four operations


class Scenes:
    """The inputs of all measurements, made once with the constants as they are."""

    def __init__(self, args):
        self.args, self.work, self.bin = args, pathlib.Path(args.work), pathlib.Path(args.bin).resolve()
        self.world = self.work / 'world'
        self.truth = self.world / 'truth/rest'
        self.base = self.work / 'base'
        if not (self.base / 'texture.png').exists():
            self.make()

    def call(self, program, *words, setting=None):
        env = dict(os.environ)
        env.pop('KEYPOSE_TUNED', None)
        if setting:
            env['KEYPOSE_TUNED'] = setting
        done = subprocess.run([str(self.bin / program), *map(str, words)], env=env, capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f'{program}: {done.stderr.strip()[-300:]}')
        return done.stdout

    def stage(self, name, folder, setting=None, **ports):
        words = []
        for port, value in ports.items():
            words += [f'--{port}', value]
        self.call(f'keypose-{name}', *words, '--report', folder / f'{name}.json', '--overwrite', setting=setting)

    def make(self):
        self.base.mkdir(parents=True, exist_ok=True)
        if not self.truth.exists():
            self.call('keypose-synth', 'photos', '--output', self.world, '--poses', 'rest', '--views', 16, '--width', 640)
        b = self.base
        self.masks(b, None)
        self.stereo(b, None)
        self.cleanup(b, None)
        self.unwrap(b, None)
        self.bake(b, None)

    # Each makes its stage's outputs in a folder from the inputs in `base`, with one constant changed.
    def masks(self, to, setting):
        self.stage('capture', to, setting, photos=self.world / 'photos/rest', images=to / 'images')
        self.stage('masks', to, setting, images=to / 'images', model=self.truth / 'cameras', masked=to / 'masked')

    def stereo(self, to, setting):
        camera = {'model': self.truth / 'cameras', 'images': self.base / 'masked'}
        self.stage('dense', to, setting, **camera, cloud=to / 'cloud.ply')
        self.meshing(to, setting, to / 'cloud.ply')

    def meshing(self, to, setting, cloud=None):
        camera = {'model': self.truth / 'cameras', 'images': self.base / 'masked'}
        self.stage('mesh', to, setting, **camera, cloud=cloud or self.base / 'cloud.ply', surface=to / 'surface.ply')
        self.refine(to, setting, to / 'surface.ply')

    def refine(self, to, setting, surface=None):
        camera = {'model': self.truth / 'cameras', 'images': self.base / 'masked'}
        self.stage('refine', to, setting, **camera, surface=surface or self.base / 'surface.ply', refined=to / 'refined.ply')

    def cleanup(self, to, setting):
        camera = {'model': self.truth / 'cameras', 'images': self.base / 'masked'}
        self.stage('cleanup', to, setting, **camera, surface=self.base / 'refined.ply', clean=to / 'clean.ply', faces=8000)

    def unwrap(self, to, setting):
        self.stage('unwrap', to, setting, clean=self.base / 'clean.ply', unwrapped=to / 'mesh.obj')

    def bake(self, to, setting):
        self.stage('bake', to, setting, mesh=self.base / 'mesh.obj', images=self.base / 'masked', model=self.truth / 'cameras',
                   texture=to / 'texture.png', texture_size=1024, hold_out=0)

    # The figures: smaller is better.
    def mask_error(self, to):
        self.call('score_views', '--mesh', self.truth / 'surface.ply', '--model', self.truth / 'cameras', '--photographs', to / 'masked',
                  '--masks', to / 'masked/masks', '--json', to / 'score.json')
        return 1 - json.loads((to / 'score.json').read_text())['all']['iou']

    def surface_error(self, mesh):
        score = json.loads(self.call('keypose-synth', 'score', '--truth', self.truth, '--model', self.truth / 'cameras', '--mesh', mesh))
        return score['surface']['mean_over_diag']

    def empty_share(self, to):
        return 1 - json.loads((to / 'unwrap.json').read_text())['measurements']['utilisation']

    def bake_error(self, to):
        self.call('score_views', '--mesh', self.base / 'mesh.obj', '--texture', to / 'texture.png', '--model', self.truth / 'cameras',
                  '--photographs', self.base / 'masked', '--masks', self.base / 'masked/masks', '--json', to / 'score.json')
        return 10 ** (-json.loads((to / 'score.json').read_text())['all']['psnr_db'] / 20)

    def register_error(self, setting, to):
        env = dict(os.environ)
        if setting:
            env['KEYPOSE_TUNED'] = setting
        table = [sys.executable, ROOT / 'bench/register_table.py']
        common = ['--scorer', self.args.scorer, '--methods', 'auto', '--bin', self.bin]
        commands = [['tentacle', '--angles', '180', '--landmarks', '7,0', '--seeds', '0-1']]
        if self.args.data:
            commands.append(['pairs', '--data', self.args.data + '/pairs', '--only', 'cheb_rest_01', '--only', 'wolf', '--landmarks', '12,0'])
        errors = []
        for i, command in enumerate(commands):
            out = to / f'register_{i}.json'
            subprocess.run([str(w) for w in [*table, *command, *common, '--json', out]], env=env, capture_output=True, check=True)
            errors += [row['err_mean'] for row in rows_of(json.loads(out.read_text()))]
        return sum(errors) / len(errors)

    def bend_error(self, setting, to):
        env = dict(os.environ)
        if setting:
            env['KEYPOSE_TUNED'] = setting
        out = to / 'bend.json'
        subprocess.run([sys.executable, str(ROOT / 'bench/interpolation_table.py'), str(self.bin), '--json', str(out)], env=env,
                       capture_output=True, check=True)
        return mean_error(json.loads(out.read_text()))


def rows_of(value):
    """All objects with err_mean below a JSON value."""
    if isinstance(value, dict):
        return [value] if 'err_mean' in value else [row for part in value.values() for row in rows_of(part)]
    return [row for part in value for row in rows_of(part)] if isinstance(value, list) else []


def mean_error(value):
    errors = [row['middle'] for row in value['pairs'] if row['method'] in ('arap', 'volumetric') and row.get('middle') is not None]
    return sum(errors) / len(errors)


def scene_of(constant):
    file = constant['file']
    for start, scene in (('capture/board', ''), ('capture/', 'masks'), ('views/', 'stereo'), ('reconstruct/stereo', 'stereo'),
                         ('reconstruct/meshing', 'meshing'), ('reconstruct/refinement', 'refine'), ('cleanup/', 'cleanup'),
                         ('texture/bake/complete', ''), ('texture/bake', 'bake'), ('texture/', 'unwrap'), ('register/', 'register'),
                         ('deform/levels', 'register'), ('deform/poisson', 'bend'), ('interpolate/', 'bend')):
        if file.startswith(start):
            return scene
    return ''


def measure(scenes, scene, setting):
    """The figure with one constant changed; None if the stage refuses."""
    to = scenes.work / 'try'
    shutil.rmtree(to, ignore_errors=True)
    to.mkdir()
    try:
        if scene == 'register':
            return scenes.register_error(setting, to)
        if scene == 'bend':
            return scenes.bend_error(setting, to)
        getattr(scenes, scene)(to, setting)
        if scene == 'masks':
            return scenes.mask_error(to)
        if scene == 'unwrap':
            return scenes.empty_share(to)
        if scene == 'bake':
            return scenes.bake_error(to)
        return scenes.surface_error(to / ('clean.ply' if scene == 'cleanup' else 'refined.ply'))
    except (RuntimeError, subprocess.CalledProcessError) as error:
        print(f'  refused: {str(error)[-200:]}', file=sys.stderr)
        return None


def changed(constant, factor):
    value = constant['value'] * factor
    return max(1, math.floor(value)) if constant['whole'] else value


def run(args):
    scenes = Scenes(args)
    rows, base = [], {}
    for constant in constants():
        scene = scene_of(constant)
        name = f"{constant['file']}:{constant['name']}"
        if not scene or (args.only and not re.search(args.only, name)):
            continue
        if scene not in base:
            base[scene] = measure(scenes, scene, None)
        row = {**constant, 'scene': scene, 'as_is': base[scene]}
        for key, factor in (('half', 0.5), ('double', 2)):
            row[key] = measure(scenes, scene, f"{constant['file']}:{constant['name']}={changed(constant, factor)!r}")
        print(f"{name} {scene} {base[scene]:.5g}: half {row['half']}, double {row['double']}", flush=True)
        rows.append(row)
        if args.json:
            pathlib.Path(args.json).write_text(json.dumps(rows, indent=1))
    show(rows)


def change_text(row, key):
    if row[key] is None:
        return 'refused'
    relative = row[key] / row['as_is'] - 1
    return '-' if abs(relative) < NO_CHANGE else f'{100 * relative:+.1f} %'


def show(rows):
    print('| algorithm | constant | value | meaning | figure | half | double |\n|---|---|---|---|---|---|---|')
    for row in sorted(rows, key=lambda row: (row['scene'], row['file'])):
        print(f"| `{row['file']}` | `{row['name']}` | {row['value']:g} | {row['comment']} | {row['scene']} "
              f"| {change_text(row, 'half')} | {change_text(row, 'double')} |")


def main():
    if len(sys.argv) > 2 and sys.argv[1] == 'show':
        return show(json.loads(pathlib.Path(sys.argv[2]).read_text()))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bin', default=str(ROOT / 'build/sensitive/bin'))
    parser.add_argument('--data', default='')
    parser.add_argument('--scorer', default='')
    parser.add_argument('--only', default='')
    parser.add_argument('--work', default='')
    parser.add_argument('--json', default='')
    args = parser.parse_args()
    args.work = args.work or tempfile.mkdtemp(prefix='sensitivity_')
    run(args)


if __name__ == '__main__':
    main()
