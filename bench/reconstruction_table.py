#!/usr/bin/env python3
"""Compares reconstruction programs on the same photographs, masks and cameras.

Measures time, memory, silhouettes and held-out views.

    reconstruction_table.py measure --set NAME=FOLDER ... [--views 34|all ...] [--peer FILE.json ...]
                                    [--ours-only] [--runs 1] [--masks both|neither] [--max-size 1000]
                                    [--json FILE] [--work DIR] [--reuse FILE.json]
                                    [--ours-option STAGE.OPTION=VALUE ...] [--resume] [--bin DIR]
                                    [--tools DIR] [--colmap colmap]
    reconstruction_table.py show FILE.json ...       prints the tables of files written with --json
    reconstruction_table.py prepare --set ...        only makes the inputs, in --work

FOLDER contains `images` (capture's output: photographs, masks/, capture.json) and `model` (COLMAP's, all
cameras). --views takes that many views, spread evenly over the names. Every sixth of them (the third, the
ninth, ...) is held out: no program gets it. Every program gets the remaining cameras, sparse points and
photographs and, with --masks both, the masks. `score_views` scores the results on the original photographs:
silhouettes in all chosen views, PSNR and SSIM in the held-out ones.

Ours: the stages dense, mesh, refine, cleanup, unwrap and bake, with default options except --max-size for dense
and refine, and those of --ours-option. A stage gets every input that it has and that exists by then. A peer is
a file

    {"mask_suffix": ".mask.png",
     "steps": {"dense": ["program", "--in", "{model}", "--size", "{max_size}", "--out", "{work}/cloud.ply"], ...},
     "prepare": ["import"],                        optional: steps that are shown but do not count
     "masked": {"dense": ["--masks", "{masks}"]},  arguments added to a step if there are masks
     "results": {"Peer": {"steps": ["dense", ...], "mesh": "{work}/mesh.obj", "texture": "{work}/page.png"}, ...}}

{work} is an empty folder. {images}, {model} and {masks} (STEM + mask_suffix) are undistorted by COLMAP.
{max_size} is the given size. Programs run in {work}. Each step runs once per run, even if several results use
it. `texture` may be absent if the mesh names its texture.

Processor time is user + system time of the program and of the children that it waited for. Memory is the
largest resident size of any of its processes. Programs use all cores. With --runs, a program's figures are
medians. --reuse takes peers from an earlier --json if set, views, masks and size are the same. --resume
continues a peer's stopped run in --work. Needs only Python, and `colmap`, which deletes views from models and
undistorts.
"""
import argparse
import json
import os
import pathlib
import shutil
import statistics
import string
import subprocess
import sys
import tempfile
import time

HOLD_OUT_EVERY, HOLD_OUT_FROM = 6, 2
ENVIRONMENT = {'OMP_WAIT_POLICY': 'passive'}  # waiting OpenMP threads must not count as work
PORTS = {'dense': 'cloud', 'mesh': 'surface', 'refine': 'refined', 'cleanup': 'clean', 'unwrap': 'unwrapped', 'bake': 'texture'}
FILES = {'cloud': 'cloud.ply', 'surface': 'surface.ply', 'refined': 'refined.ply', 'clean': 'clean.ply', 'unwrapped': 'unwrapped.obj', 'texture': 'texture.png'}


class Failure(Exception):
    """A program failed. The message has its name and the path of its log."""


def run_quietly(command, log):
    with open(log, 'wb') as out:
        if subprocess.run([str(word) for word in command], stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL).returncode != 0:
            raise Failure(f'{command[0]} {command[1]} failed: see {log}')


def timed(command, folder, log):
    """Runs a program. @return its processor seconds, wall seconds and peak memory"""
    start = time.monotonic()
    with open(log, 'wb') as out:
        process = subprocess.Popen([str(word) for word in command], cwd=folder, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
                                   env={**os.environ, **ENVIRONMENT})
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise Failure(f'{command[0]} ended with {process.returncode}: see {log}')
    return {'cpu_s': usage.ru_utime + usage.ru_stime, 'wall_s': time.monotonic() - start, 'peak_mib': usage.ru_maxrss / 1024}


class Inputs:
    """One set of photographs, reduced to the chosen views, in the form for programs and the scorer."""

    def __init__(self, name, folder, views, masked, args, work):
        self.name, self.folder, self.masked, self.args = name, pathlib.Path(folder).resolve(), masked, args
        self.work = work / f'{name}_{views}_{"masked" if masked else "unmasked"}'
        self.work.mkdir(parents=True, exist_ok=True)
        self.capture = json.loads((self.folder / 'images/capture.json').read_text())
        placed = self.placed()
        self.chosen = evenly(placed, len(placed) if views == 'all' else int(views))
        self.held_out = self.chosen[HOLD_OUT_FROM::HOLD_OUT_EVERY]
        self.training = [name for name in self.chosen if name not in self.held_out]
        self.held_out_file = self.work / 'held_out.txt'
        self.held_out_file.write_text('\n'.join(self.held_out) + '\n')
        self.model = self.without('model', placed, self.training)
        self.scored_model = self.without('scored_model', placed, self.chosen)
        self.images = self.folder / 'images' if masked else self.images_without_masks()

    def key(self):
        return {'set': self.name, 'views': len(self.chosen), 'held_out': len(self.held_out), 'masked': self.masked, 'max_size': self.args.max_size}

    def placed(self):
        """Names of the photographs in the model, sorted."""
        text = self.work / 'text'
        text.mkdir(exist_ok=True)
        run_quietly([self.args.colmap, 'model_converter', '--input_path', self.folder / 'model', '--output_path', text, '--output_type', 'TXT'],
                    self.work / 'colmap.log')
        lines = [line for line in (text / 'images.txt').read_text().splitlines() if not line.startswith('#')]
        shutil.rmtree(text)
        return sorted(line.split(maxsplit=9)[9] for line in lines[::2])

    def without(self, which, placed, kept):
        """The model with only these views."""
        out = self.work / which
        if not (out / 'images.bin').exists():
            out.mkdir(exist_ok=True)
            names = self.work / 'deleted.txt'
            names.write_text(''.join(f'{name}\n' for name in placed if name not in kept))
            run_quietly([self.args.colmap, 'image_deleter', '--input_path', self.folder / 'model', '--output_path', out, '--image_names_path', names],
                        self.work / 'colmap.log')
        return out

    def images_without_masks(self):
        out = self.work / 'images'
        out.mkdir(exist_ok=True)
        for image in self.capture['images']:
            image['mask'] = ''
            # A copy, since neither names in capture.json nor links may lead out of the folder.
            copy = out / image['name']
            if not copy.exists():
                shutil.copy(self.folder / 'images' / image['name'], copy)
        (out / 'capture.json').write_text(json.dumps(self.capture))
        return out

    def undistorted(self, mask_suffix):
        """The folder with images/, sparse/ and, if masks are given, masks/."""
        out = self.work / 'undistorted'
        if not (out / 'sparse/images.bin').exists():
            run_quietly([self.args.colmap, 'image_undistorter', '--image_path', self.folder / 'images', '--input_path', self.model, '--output_path', out],
                        self.work / 'undistorter.log')
        if self.masked:
            run_quietly([f'{self.args.tools}/undistort_masks', self.model, out / 'sparse', self.folder / 'images/masks', out / 'masks', mask_suffix],
                        self.work / 'masks.log')
        return out

    def score(self, mesh, texture, work):
        out = work / 'score.json'
        command = [f'{self.args.tools}/score_views', '--mesh', mesh, '--model', self.scored_model, '--photographs', self.folder / 'images',
                   '--held-out', self.held_out_file, '--json', out, '--picture', work / 'score.png']
        run_quietly(command + (['--texture', texture] if texture else []), work / 'score.log')
        score = json.loads(out.read_text())
        return {**{key: score['all'][key] for key in ('iou', 'precision', 'recall')},
                **{key: score['held_out'].get(key) for key in ('psnr_db', 'gained_psnr_db', 'ssim', 'gained_ssim')}}


def evenly(names, count):
    if count > len(names):
        raise Failure(f'{count} views were asked for, the model places {len(names)}')
    return [names[i * len(names) // count] for i in range(count)]


def row_of(inputs, program, steps, counted, mesh, texture, work):
    """The table's row for one result of one run."""
    return {**inputs.key(), 'program': program, 'steps': steps, 'cpu_s': sum(steps[step]['cpu_s'] for step in counted),
            'peak_mib': max(steps[step]['peak_mib'] for step in counted), 'counted': counted, 'bytes': os.path.getsize(mesh),
            **inputs.score(mesh, texture, work)}


def run_ours(inputs, args, work):
    have = {'images': inputs.images, 'model': inputs.model}
    steps = {}
    for stage, port in PORTS.items():
        program = f'{args.bin}/keypose-{stage}'
        if stage == 'refine' and not os.path.exists(program):
            continue  # older builds, used for comparison, have no refine
        known = json.loads(subprocess.run([program, '--describe'], check=True, capture_output=True).stdout)
        have['mesh'] = have.get('unwrapped')
        have[port] = work / FILES[port]
        command = [program, f'--{port}', have[port], '--report', work / f'{stage}.json']
        for item in known['inputs']:
            if have.get(item['name']):
                command += [f'--{item["name"]}', have[item['name']]]
        if stage in ('dense', 'refine'):
            command += ['--max_size', args.max_size]
        for option in args.ours_option:
            name, value = option.split('=', 1)
            if name.split('.')[0] == stage:
                command += [f'--{name.split(".")[1]}', value]
        steps[stage] = timed(command, work, work / f'{stage}.log')
        have['surface'] = have.get('refined', have.get('surface'))  # later stages use the refined surface
    return [row_of(inputs, args.ours_name, steps, list(steps), have['unwrapped'], have['texture'], work)]


def run_peer(inputs, peer, work):
    undistorted = inputs.undistorted(peer.get('mask_suffix', '.png'))
    places = {'work': work, 'images': undistorted / 'images', 'model': undistorted / 'sparse', 'masks': undistorted / 'masks',
              'undistorted': undistorted, 'max_size': inputs.args.max_size}
    fill = lambda word: string.Formatter().vformat(word, (), places)
    record = work / 'steps.json'
    rows, steps = [], json.loads(record.read_text()) if record.exists() else {}
    for program, result in peer['results'].items():
        for step in result['steps']:
            if step not in steps:
                words = peer['steps'][step] + (peer.get('masked', {}).get(step, []) if inputs.masked else [])
                steps[step] = timed([fill(word) for word in words], work, work / f'{step}.log')
                record.write_text(json.dumps(steps))
        counted = [step for step in result['steps'] if step not in peer.get('prepare', [])]
        texture = fill(result['texture']) if 'texture' in result else None
        scores = work / program.replace(' ', '_').replace('/', '_')
        scores.mkdir(exist_ok=True)
        rows.append(row_of(inputs, program, {step: steps[step] for step in result['steps']}, counted, fill(result['mesh']), texture, scores))
    return rows


def fresh(folder, keep=False):
    if not keep:
        shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def reused(rows, inputs, peer):
    key = inputs.key()
    found = [row for row in rows if row['program'] in peer['results'] and all(row[name] == value for name, value in key.items())]
    return found if {row['program'] for row in found} == set(peer['results']) else None


def measure(args, work):
    rows = []
    earlier = [row for path in args.reuse for row in json.loads(pathlib.Path(path).read_text())]
    peers = [] if args.ours_only else [json.loads(pathlib.Path(path).read_text()) for path in args.peer]
    for views in args.views:
        for named in args.set:
            inputs = Inputs(*named.split('=', 1), views, args.masks == 'both', args, work)
            for run in range(args.runs):
                if args.ours_name:
                    add(rows, run_ours(inputs, args, fresh(inputs.work / 'ours' / str(run))), args)
                for number, peer in enumerate(peers):
                    known = reused(earlier, inputs, peer)
                    if known is None:
                        known = run_peer(inputs, peer, fresh(inputs.work / f'peer{number}' / str(run), args.resume))
                    elif run > 0:
                        continue
                    add(rows, known, args)
    return rows


def add(rows, new, args):
    for row in new:
        rows.append(row)
        print('#', {key: round(value, 4) if isinstance(value, float) else value for key, value in row.items()}, file=sys.stderr, flush=True)
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')


def medians(group):
    """One row with the medians of a program's runs."""
    merged = dict(group[0])
    for key, value in merged.items():
        if isinstance(value, float):
            merged[key] = statistics.median(row[key] for row in group)
    merged['steps'] = {step: {key: statistics.median(row['steps'][step][key] for row in group) for key in figures}
                       for step, figures in group[0]['steps'].items()}
    return {**merged, 'runs': len(group)}


def grouped(rows):
    groups = {}
    for row in rows:
        groups.setdefault((row['set'], row['views'], row['masked'], row['max_size'], row['program']), []).append(row)
    return [medians(group) for group in groups.values()]


def show(value, digits):
    return '' if value is None else f'{value:.{digits}f}'


def print_tables(rows):
    merged = grouped(rows)
    print('| set | views (held out) | masks | px | program | runs | CPU s | memory MiB | IoU | precision | recall | PSNR dB | PSNR after gain dB | SSIM |')
    print('|---|---|---|---|---|---|---|---|---|---|---|---|---|---|')
    for row in merged:
        print(f"| {row['set']} | {row['views']} ({row['held_out']}) | {'yes' if row['masked'] else 'no'} | {row['max_size']} | {row['program']} | {row['runs']} "
              f"| {row['cpu_s']:.1f} | {row['peak_mib']:.0f} | {row['iou']:.4f} | {row['precision']:.4f} | {row['recall']:.4f} "
              f"| {show(row['psnr_db'], 2)} | {show(row['gained_psnr_db'], 2)} | {show(row['gained_ssim'], 4)} |")
    print('\n| set | views | program | step | CPU s | wall s | memory MiB |')
    print('|---|---|---|---|---|---|---|')
    for row in merged:
        for step, figures in row['steps'].items():
            counts = '' if step in row['counted'] else ' (not counted)'
            print(f"| {row['set']} | {row['views']} | {row['program']} | {step}{counts} | {figures['cpu_s']:.1f} | {figures['wall_s']:.1f} | {figures['peak_mib']:.0f} |")


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest='mode', required=True)
    modes.add_parser('show').add_argument('files', nargs='+')
    here = str(pathlib.Path(__file__).resolve().parent.parent / 'build/release/bin')
    for mode in (modes.add_parser('measure'), modes.add_parser('prepare')):
        mode.add_argument('--set', action='append', required=True, metavar='NAME=FOLDER')
        mode.add_argument('--views', nargs='+', default=['34'])
        mode.add_argument('--masks', choices=['both', 'neither'], default='both')
        mode.add_argument('--max-size', type=int, default=1000)
        mode.add_argument('--peer', action='append', default=[], metavar='FILE.json')
        mode.add_argument('--ours-only', action='store_true')
        mode.add_argument('--ours-name', default='keypose', help='name in the table; empty: run only peers')
        mode.add_argument('--ours-option', action='append', default=[], metavar='STAGE.OPTION=VALUE')
        mode.add_argument('--runs', type=int, default=1)
        mode.add_argument('--reuse', action='append', default=[], metavar='FILE.json')
        mode.add_argument('--resume', action='store_true')
        mode.add_argument('--bin', default=here)
        mode.add_argument('--tools', default=here, help='folder of score_views and undistort_masks')
        mode.add_argument('--colmap', default='colmap')
        mode.add_argument('--json')
        mode.add_argument('--work')
    return parser.parse_args()


def main():
    args = parse()
    if args.mode == 'show':
        print_tables([row for path in args.files for row in json.loads(pathlib.Path(path).read_text())])
        return
    args.bin, args.tools = os.path.abspath(args.bin), os.path.abspath(args.tools)
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(args.work or temporary).resolve()
        try:
            if args.mode == 'prepare':
                for views in args.views:
                    for named in args.set:
                        inputs = Inputs(*named.split('=', 1), views, args.masks == 'both', args, work)
                        print(inputs.key(), inputs.undistorted('.png'))
                return
            print_tables(measure(args, work))
        except Failure as failure:
            sys.exit(f'reconstruction_table: {failure}')


if __name__ == '__main__':
    main()
