#!/usr/bin/env python3
"""Measures poses from few photographs against the truth.

    few_photographs.py run [--bin DIR] [--work DIR] [--seeds 11-40] [--counts 4,6,8,12] [--template scan|truth]
                           [--scan SEEDS] [--json FILE]
    few_photographs.py show FILE.json ...

For each seed: another character of `keypose synth photos`, its template from 32 photographs by `keypose run`, and the
pose `limbs` of that seed, in which arms, ear and tail turn by 30 to 120 degrees, from each number of photographs by
the stages `capture` and `fit`. With `--template truth`, which takes a fifth of the time, the template is not
reconstructed: it is the true surface at rest, with 20,000 faces and unwrapped, and its texture is baked from the 32
photographs through the true cameras and masks. The error is the distance of each vertex from the exact place of its
material point, over the pose's diagonal, with both frames aligned by their cameras. --scan also takes the pose through
the whole pipeline with 36 photographs, and with the fewest and the most of --counts, for those seeds. `seconds` are of
the two stages together, by the clock. A seed whose limbs collide in every direction that synth tries is left out.
--work keeps the files: what is there is not made again. Needs only Python.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

TEMPLATE_PHOTOGRAPHS, SCAN_PHOTOGRAPHS = 32, 36


class NoPose(Exception):
    """The character of this seed cannot take the pose."""


def call(command, check=True):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if check and 'take another --pose-seed' in done.stdout:
        raise NoPose(done.stdout.strip().splitlines()[-1])
    if check and done.returncode != 0:
        sys.exit(f'few_photographs: {" ".join(map(str, command[:3]))} failed:\n{done.stdout[-3000:]}')
    return done


def numbers(text):
    """'11-14,20' as a list."""
    found = []
    for part in text.split(','):
        first, _, last = part.partition('-')
        found += range(int(first), int(last or first) + 1)
    return found


class Seed:
    """The files and results of one character."""

    def __init__(self, args, seed):
        self.bin = pathlib.Path(args.bin)
        self.seed = seed
        self.exact = args.template == 'truth'
        self.folder = args.work / f'seed_{seed}'
        self.project = self.folder / 'project'

    def program(self, name):
        return self.bin / f'keypose{name}'

    def photographs(self, name, words):
        """The folder of a world with these photographs; the template's are in the world `rest`."""
        world = self.folder / name
        if not (world / 'done').exists():
            call([self.program('-synth'), 'photos', '--output', world, '--seed', self.seed, '--pose-seed', self.seed, *words])
            (world / 'done').write_text('')
        return world

    def template(self):
        """The truth, and the folder with the template's mesh.obj, texture.png and model."""
        world = self.photographs('rest', ['--poses', 'rest', '--views', TEMPLATE_PHOTOGRAPHS])
        out = self.folder / 'true_template' if self.exact else self.project / 'out/rest'
        if not (out / 'texture.png').exists():
            if self.exact:
                self.true_template(world, out)
            else:
                call([self.program(''), 'init', self.project, '--pose', f'rest={world / "photos/rest"}'])
                call([self.program(''), 'run', '-C', self.project, '--until', 'complete'])
        return world / 'truth/rest', out

    def true_template(self, world, out):
        out.mkdir(exist_ok=True)
        truth = world / 'truth/rest'
        call([self.program('-cleanup'), '--surface', truth / 'surface.ply', '--clean', out / 'clean.ply', '--overwrite'])
        call([self.program('-unwrap'), '--clean', out / 'clean.ply', '--unwrapped', out / 'mesh.obj', '--overwrite'])
        call([self.program('-capture'), '--photos', world / 'photos/rest', '--masks', truth / 'masks', '--images', out / 'images', '--overwrite'])
        shutil.copytree(truth / 'cameras', out / 'model', dirs_exist_ok=True)
        call([self.program('-bake'), '--mesh', out / 'mesh.obj', '--images', out / 'images', '--model', out / 'model', '--hold_out', 0,
              '--texture', out / 'texture.png', '--overwrite'])

    def few(self, count):
        """One pose from `count` photographs by the stages capture and fit."""
        _, rest = self.template()
        world = self.photographs(f'few_{count}', ['--poses', 'limbs', '--views', TEMPLATE_PHOTOGRAPHS, '--few', f'limbs={count}'])
        folder = self.folder / f'{"true" if self.exact else "fit"}_{count}'
        folder.mkdir(exist_ok=True)
        if not (folder / 'fit.json').exists():
            call([self.program('-capture'), '--photos', world / 'photos/limbs', '--images', folder / 'images', '--min_images', 2, '--overwrite',
                  '--report', folder / 'capture.json'])
            done = call([self.program('-fit'), '--template', rest / 'mesh.obj', '--texture', rest / 'texture.png', '--images', folder / 'images',
                         '--rig', rest / 'model', '--fitted', folder / 'fitted.obj', '--model', folder / 'model', '--picture',
                         folder / 'fitted.png', '--overwrite', '--report', folder / 'fit.json'], check=False)
            if done.returncode != 0:
                return {'failed': done.stdout.strip().splitlines()[-1]}
        report = json.loads((folder / 'fit.json').read_text())
        seconds = report['seconds'] + json.loads((folder / 'capture.json').read_text())['seconds']
        row = self.score(world, folder / 'model', folder / 'fitted.obj')
        row.update(seconds=seconds, iou=report['measurements']['iou_mean'], unseen=report['measurements']['unseen'])
        return row

    def scan(self, count):
        """The pose from `count` photographs by the whole pipeline."""
        world = self.photographs(f'scan_{count}', ['--poses', 'rest,limbs', '--views', SCAN_PHOTOGRAPHS, '--few', f'limbs={count}'])
        project = self.folder / f'scan_{count}_project'
        if not (project / 'out/limbs/mesh.obj').exists():
            rest, limbs = f'rest={world / "photos/rest"}', f'limbs={world / "photos/limbs"}'
            if not project.exists():
                call([self.program(''), 'init', project, '--pose', rest, '--pose', limbs])
            text = (project / 'pipeline.yaml').read_text().replace('method: fit', 'method: scan')
            (project / 'pipeline.yaml').write_text(text)
            done = call([self.program(''), 'run', '-C', project, '--until', 'register'], check=False)
            if done.returncode != 0:
                lines = [line for line in done.stdout.splitlines() if 'error' in line]
                return {'failed': lines[-1] if lines else f'exit {done.returncode}'}
        out = project / 'out/limbs'
        return self.score(world, out / 'model', out / 'mesh.obj', (world / 'truth/rest', project / 'out/rest'))

    def score(self, world, model, mesh, template=None):
        """`template` is the truth of the template and the folder with its mesh.obj and model."""
        truth, rest = template or self.template()
        done = call([self.program('-synth'), 'score', '--truth', world / 'truth/limbs', '--model', model, '--mesh', mesh, '--registered', mesh,
                     '--template-truth', truth, '--template-model', rest / 'model', '--template-mesh', rest / 'mesh.obj'])
        return json.loads(done.stdout)['correspondence']


def measure(args):
    results = []
    for seed in numbers(args.seeds):
        one = Seed(args, seed)
        try:
            few = {str(count): one.few(count) for count in numbers(args.counts)}
        except NoPose as why:
            print(f'seed {seed} is left out: {why}', flush=True)
            continue
        counts = sorted(numbers(args.counts))
        scan = {}
        if args.scan and seed in numbers(args.scan):
            scan = {str(count): one.scan(count) for count in (SCAN_PHOTOGRAPHS, counts[0], counts[-1])}
        results.append({'seed': seed, 'few': few, 'scan': scan})
        print(f'seed {seed}: ' + ', '.join(f'{count}: {words(row)}' for count, row in few.items()), flush=True)
        if args.json:
            pathlib.Path(args.json).write_text(json.dumps(results, indent=1) + '\n')
    return results


def words(row):
    return row['failed'] if 'failed' in row else f"{100 * row['mean']:.3f} % ({row['flipped']} flipped)"


def show(results):
    counts = sorted({int(count) for result in results for count in result['few']})
    print('| photographs | seeds | mean error | median seed | worst seed | 95 % of vertices within | flipped faces, all seeds | seconds, median |')
    print('|---|---|---|---|---|---|---|---|')
    for count in counts:
        rows = [result['few'][str(count)] for result in results if str(count) in result['few']]
        good = sorted((row for row in rows if 'failed' not in row), key=lambda row: row['mean'])
        if not good:
            continue
        mean = sum(row['mean'] for row in good) / len(good)
        p95 = sum(row['p95'] for row in good) / len(good)
        seconds = sorted(row['seconds'] for row in good)[len(good) // 2]
        print(f"| {count} | {len(good)} of {len(rows)} | {100 * mean:.3f} % | {100 * good[len(good) // 2]['mean']:.3f} % | "
              f"{100 * good[-1]['mean']:.3f} % | {100 * p95:.2f} % | {sum(row['flipped'] for row in good)} | {seconds:.0f} |")
    for result in results:
        for count, row in result['scan'].items():
            print(f"scan, seed {result['seed']}, {count} photographs: {words(row)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    run = commands.add_parser('run')
    run.add_argument('--bin', default='build/release/bin')
    run.add_argument('--work', type=pathlib.Path)
    run.add_argument('--seeds', default='11-40')
    run.add_argument('--counts', default='4,6,8,12')
    run.add_argument('--template', choices=('scan', 'truth'), default='scan')
    run.add_argument('--scan', default='')
    run.add_argument('--json')
    shown = commands.add_parser('show')
    shown.add_argument('files', nargs='+')
    args = parser.parse_args()
    if args.command == 'show':
        return show([result for name in args.files for result in json.loads(pathlib.Path(name).read_text())])
    args.work = args.work or pathlib.Path(tempfile.mkdtemp(prefix='few_photographs_'))
    return show(measure(args))


if __name__ == '__main__':
    main()
