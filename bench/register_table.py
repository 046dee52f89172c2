#!/usr/bin/env python3
"""Compares registration programs: error against the truth, flips, processor time. Prints Markdown rows.

    register_table.py pairs    --data PAIRS --scorer SCORER [--landmarks 12,0] [--only NAME ...]
    register_table.py tentacle --scorer SCORER [--angles 60,90,120,180,270] [--landmarks 13,7,0]
                               [--seeds 0-9] [--noise 0.001] [--holes 6]
    register_table.py show     FILE.json ...         prints the tables of files written with --json

Seeds 0 to 9 are for choosing parameters, 10 to 39 for reporting. Options of the first two commands:
    --bin DIR              our programs
    --methods auto,nricp   methods of keypose-register; may be empty
    --peer NAME=TEMPLATE   another program's command line
    --runs N               runs of each program; the time is their median
    --timeout S  --json FILE  --work DIR (kept; default: a temporary folder)

A template contains {source} {target} {landmarks} {out}: the meshes, the landmarks as lines
`source_vertex target_vertex`, and the output file. {source_obj} {target_obj} {out_obj} are the same in OBJ. A
template with {landmarks} runs only on pairs with landmarks; others run on all pairs. Every program gets one
thread. Processor time is user + system time of the program and of the children that it waited for.

SCORER is called as `SCORER SOURCE REGISTERED TARGET [PAIRS_OF_VERTICES]` and prints JSON with err_mean, err_p95,
err_max, surface_mean, hausdorff, flipped, degenerate and finite; meshes.py beside it reads meshes. If
PAIRS_OF_VERTICES has every source vertex, the JSON also has flipped_true: the number of faces that oppose the
same face at its true position. (`flipped` compares with the nearest face of the target, which in a crease may
belong to the other wall.) On synthetic pairs the error is the distance to the exact position of each vertex,
divided by the same diagonal. `itself` is the scorer's count of `flipped` in the true positions. A run fails if it
gives no mesh, a mean error above 1 % of the diagonal, a number that is not finite, or more flips than the truth
itself. Needs python3-numpy and python3-scipy.
"""
import argparse
import json
import os
import pathlib
import shlex
import statistics
import subprocess
import sys
import tempfile
import threading

import numpy as np

FAILURE_MEAN = 0.01
ONE_THREAD = {'OMP_NUM_THREADS': '1', 'OPENBLAS_NUM_THREADS': '1', 'MKL_NUM_THREADS': '1', 'TBB_NUM_THREADS': '1'}


class Pair:
    """One registration problem: its files, and how results are judged."""

    def __init__(self, name, source, target, vertex_pairs=None, picks=(), landmarks=0, truth=None, gt=None, keys=None):
        self.name, self.source, self.target = name, pathlib.Path(source), pathlib.Path(target)
        self.vertex_pairs = vertex_pairs  # file of lines `source_vertex target_vertex`, or None
        self.picks = list(picks)          # input of keypose-register
        self.landmarks = landmarks
        self.truth = truth                # mesh with the exact positions, or None
        self.gt = gt                      # file for the scorer, or None
        self.keys = keys or {}            # the row's key values
        self.known = None                 # (source, truth): meshes of the faces with known positions, or None
        self.itself = None                # flips of the truth by the scorer's measure


class Judge:
    def __init__(self, scorer):
        self.scorer = pathlib.Path(scorer)
        sys.path.insert(0, str(self.scorer.parent))
        import meshes
        self.meshes = meshes

    def score(self, source, registered, target, gt=None):
        command = [sys.executable, str(self.scorer), str(source), str(registered), str(target)] + ([str(gt)] if gt else [])
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            return {'failure': 'the scorer said: ' + (done.stderr.strip().splitlines() or ['nothing'])[-1]}
        return json.loads(done.stdout)

    def itself(self, pair):
        """Flips of the true positions; only faces whose corners all have one."""
        if pair.itself is None and pair.known:
            pair.itself = self.score(pair.known[0], pair.known[1], pair.target).get('flipped')
        return pair.itself

    def judge(self, pair, registered):
        row = self.score(pair.source, registered, pair.target, pair.gt)
        if 'failure' in row:
            return row
        if pair.truth:
            row.update(self.against_truth(pair, registered))
        row['itself'] = self.itself(pair)
        return row

    def against_truth(self, pair, registered):
        points, faces = self.meshes.read(str(registered))
        truth, _ = self.meshes.read(str(pair.truth))
        row = {'faces': len(faces), 'flipped_against_truth': int((np.einsum('ij,ij->i', normals(points, faces), normals(truth, faces)) < 0).sum())}
        if pair.gt is None:
            error = np.linalg.norm(points - truth, axis=1) / self.meshes.diagonal(self.meshes.read(str(pair.target))[0])
            row.update(err_mean=float(error.mean()), err_p95=float(np.quantile(error, .95)), err_max=float(error.max()))
        return row


def normals(points, faces):
    return np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])


def write_ply(path, points, faces):
    header = (f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n'
              f'element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n')
    rows = np.empty(len(faces), dtype=[('n', 'u1'), ('v', '<i4', 3)])
    rows['n'], rows['v'] = 3, faces
    pathlib.Path(path).write_bytes(header.encode() + points.astype('<f8').tobytes() + rows.tobytes())


def write_obj(path, points, faces):
    with open(path, 'w') as file:
        file.writelines('v %.12g %.12g %.12g\n' % tuple(p) for p in points)
        file.writelines('f %d %d %d\n' % tuple(f + 1) for f in faces)


def timed(command, timeout, log):
    """(exit status, processor seconds); the status is None if the run was stopped."""
    with open(log, 'wb') as out:
        process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, env={**os.environ, **ONE_THREAD})
    stopped = threading.Event()
    timer = threading.Timer(timeout, lambda: (stopped.set(), process.kill()))
    timer.start()
    _, status, usage = os.wait4(process.pid, 0)
    timer.cancel()
    process.returncode = os.waitstatus_to_exitcode(status)
    return (None if stopped.is_set() else process.returncode), usage.ru_utime + usage.ru_stime


class Program:
    """A named command line, filled in for each pair."""

    def __init__(self, name, template=None, register=None, method=None):
        self.name, self.template, self.register, self.method = name, template, register, method

    def takes(self, pair):
        return self.template is None or pair.vertex_pairs is not None or '{landmarks}' not in self.template

    def command(self, pair, out, work, meshes):
        if self.template is None:
            picks = [word for path in pair.picks for word in ('--landmarks', str(path))]
            return [self.register, '--method', self.method, '--source', str(pair.source), '--target', str(pair.target), *picks, '--registered', str(out)]
        places = {'source': pair.source, 'target': pair.target, 'landmarks': pair.vertex_pairs or '', 'out': out, 'out_obj': out.with_suffix('.obj')}
        for which in ('source', 'target'):
            if '{' + which + '_obj}' in self.template:
                places[which + '_obj'] = as_obj(places[which], work / f'{which}.obj', meshes)
        return [word.format(**places) for word in shlex.split(self.template)]

    def run(self, pair, runs, timeout, work, meshes):
        """(registered mesh or None, processor seconds, what went wrong)"""
        out = work / 'registered.ply'
        command = self.command(pair, out, work, meshes)
        seconds = []
        for _ in range(runs):
            for path in (out, out.with_suffix('.obj')):
                path.unlink(missing_ok=True)
            status, cpu = timed(command, timeout, work / 'log.txt')
            seconds.append(cpu)
            if status != 0:
                return None, cpu, f'stopped after {timeout:.0f} s' if status is None else f'exit status {status}'
        made = [path for path in (out, out.with_suffix('.obj')) if path.exists()]
        return (made[0] if made else None), statistics.median(seconds), '' if made else 'wrote no mesh'


def as_obj(path, copy, meshes):
    if path.suffix == '.obj':
        return path
    write_obj(copy, *meshes.read(str(path)))
    return copy


def real_pairs(args, judge, work):
    """Pairs of a folder with source.obj, target.obj, landmarks.txt and optionally gt.txt.

    Without gt.txt the landmarks are the truth.
    """
    for folder in sorted(pathlib.Path(args.data).iterdir()):
        if not (folder / 'source.obj').exists() or (args.only and folder.name not in args.only):
            continue
        gt = folder / 'gt.txt' if (folder / 'gt.txt').exists() else folder / 'landmarks.txt'
        known, whole = known_faces(folder, gt, work, judge.meshes)
        for count in args.landmarks:
            lines = (folder / 'landmarks.txt').read_text().splitlines(keepends=True)[:count]
            chosen = work / f'{folder.name}_{count}.txt'
            chosen.write_text(''.join(lines))
            pair = Pair(folder.name, folder / 'source.obj', folder / 'target.obj', chosen if count else None, [chosen] if count else [], len(lines),
                        known[1] if whole else None, gt, {'pair': folder.name, 'landmarks': len(lines)})
            pair.known = known
            yield pair


def known_faces(folder, gt, work, meshes):
    """Files of the source and of its true positions, with only the faces whose corners have one, or None.

    Also returns whether these are all faces.
    """
    points, faces = meshes.read(str(folder / 'source.obj'))
    target, _ = meshes.read(str(folder / 'target.obj'))
    rows = np.loadtxt(gt, dtype=int)[:, :2]
    places = np.full(points.shape, np.nan)
    places[rows[:, 0]] = target[rows[:, 1]]
    kept = faces[np.isfinite(places[faces]).all((1, 2))]
    if len(kept) == 0:
        return None, False
    files = work / f'{folder.name}_known_source.ply', work / f'{folder.name}_known_truth.ply'
    write_ply(files[0], points, kept)
    write_ply(files[1], np.where(np.isfinite(places), places, target[0]), kept)
    return files, len(kept) == len(faces)


def synthetic_pairs(args, judge, work):
    del judge
    for count in args.landmarks:
        for angle in args.angles:
            for seed in args.seeds:
                name = f'{args.shape}_{seed}_{angle:g}_{count}_{args.noise:g}_{args.holes}_{args.hole_area:g}_{args.ratio:g}_{args.turn:g}'
                folder = work / 'pairs' / name
                if not (folder / 'world.json').exists():
                    subprocess.run([f'{args.bin}/keypose-synth', 'pair', str(folder), '--shape', args.shape, '--seed', str(seed), '--bend', str(angle),
                                    '--landmarks', str(count), '--noise', str(args.noise), '--holes', str(args.holes), '--hole-area', str(args.hole_area),
                                    '--ratio', str(args.ratio), '--turn', str(args.turn)], check=True, stdout=subprocess.DEVNULL)
                picks = [folder / 'source_landmarks.json', folder / 'target_landmarks.json'] if count else []
                pair = Pair(name, folder / 'source.ply', folder / 'target.ply', folder / 'landmarks.txt' if count else None, picks, count,
                            folder / 'truth.ply', None, {'shape': args.shape, 'bend': angle, 'landmarks': count, 'seed': seed})
                pair.known = (pair.source, pair.truth)
                yield pair


def is_failure(row):
    return ('failure' in row or not row['finite'] or not row['err_mean'] <= FAILURE_MEAN or row['flipped'] > (row.get('itself') or 0))


def measure(pairs, programs, judge, args, work):
    rows = []
    for pair in pairs:
        for program in programs:
            if not program.takes(pair):
                continue
            folder = work / 'runs' / program.name
            folder.mkdir(parents=True, exist_ok=True)
            made, cpu, fault = program.run(pair, args.runs, args.timeout, folder, judge.meshes)
            row = {**pair.keys, 'program': program.name, 'cpu_s': cpu}
            row.update({'failure': fault} if fault else judge.judge(pair, made))
            row['failed'] = is_failure(row)
            rows.append(row)
            print('#', {key: round(value, 5) if isinstance(value, float) else value for key, value in row.items()}, file=sys.stderr, flush=True)
    return rows


def show(value, digits=4):
    return '' if value is None else f'{value:.{digits}f}' if isinstance(value, float) else f'{value:,}' if isinstance(value, int) else str(value)


def print_pairs(rows):
    print('| pair | landmarks | program | mean | 95 % | largest | surface mean | Hausdorff | flipped | itself | flipped, true | degenerate | CPU s |')
    print('|---|---|---|---|---|---|---|---|---|---|---|---|---|')
    for row in rows:
        head = f"| {row['pair']} | {row['landmarks']} | {row['program']} |"
        if 'failure' in row:
            print(head, row['failure'], '| | | | | | | | |', show(row['cpu_s'], 2), '|')
            continue
        cells = [show(row.get(key)) for key in ('err_mean', 'err_p95', 'err_max', 'surface_mean', 'hausdorff', 'flipped', 'itself',
                                              'flipped_true', 'degenerate')]
        print(head, ' | '.join(cells), '|', show(row['cpu_s'], 2), '|')


def print_synthetic(rows):
    print('| bend | landmarks | program | seeds | mean | worst mean | largest | flipped, mean | flipped, worst | against truth, worst | failures | worst seed | CPU s |')
    print('|---|---|---|---|---|---|---|---|---|---|---|---|---|')
    cells = {}
    for row in rows:
        cells.setdefault((row['landmarks'], row['bend'], row['program']), []).append(row)
    for (landmarks, bend, program), group in cells.items():
        good = [row for row in group if 'failure' not in row]
        failures = f"{sum(row['failed'] for row in group)} of {len(group)}"
        if not good:
            print(f'| {bend:g} | {landmarks} | {program} | {len(group)} | | | | | | | {failures} | | |')
            continue
        worst = max(good, key=lambda row: row['err_mean'])
        figures = [show(statistics.mean(row['err_mean'] for row in good)), show(worst['err_mean']), show(max(row['err_max'] for row in good)),
                   show(float(statistics.mean(row['flipped'] for row in good)), 1), show(max(row['flipped'] for row in good)),
                   show(max(row['flipped_against_truth'] for row in good)), failures, str(worst['seed']),
                   show(statistics.median(row['cpu_s'] for row in good), 2)]
        print(f'| {bend:g} | {landmarks} | {program} | {len(group)} |', ' | '.join(figures), '|')


def numbers(text, kind=int):
    """'0-9,12' -> [0, ..., 9, 12]"""
    values = []
    for part in text.split(','):
        low, dash, high = part.partition('-')
        values += range(int(low), int(high) + 1) if dash and low else [kind(part)]
    return values


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    modes = parser.add_subparsers(dest='mode', required=True)
    pairs, tentacle, show_mode = modes.add_parser('pairs'), modes.add_parser('tentacle'), modes.add_parser('show')
    show_mode.add_argument('files', nargs='+')
    for mode in (pairs, tentacle):
        mode.add_argument('--scorer', required=True)
        mode.add_argument('--bin', default=str(pathlib.Path(__file__).resolve().parent.parent / 'build/release/bin'))
        mode.add_argument('--methods', default='auto,nricp')
        mode.add_argument('--peer', action='append', default=[], metavar='NAME=TEMPLATE')
        mode.add_argument('--runs', type=int, default=1)
        mode.add_argument('--timeout', type=float, default=600)
        mode.add_argument('--json')
        mode.add_argument('--work')
    pairs.add_argument('--data', required=True)
    pairs.add_argument('--only', nargs='*')
    pairs.add_argument('--landmarks', type=numbers, default=[12, 0])
    tentacle.add_argument('--shape', default='tentacle', choices=['tentacle', 'character'])
    tentacle.add_argument('--angles', type=lambda text: numbers(text, float), default=[60., 90., 120., 180., 270.])
    tentacle.add_argument('--landmarks', type=numbers, default=[13, 7, 0])
    tentacle.add_argument('--seeds', type=numbers, default=list(range(10)))
    tentacle.add_argument('--noise', type=float, default=0.001)
    tentacle.add_argument('--holes', type=int, default=6)
    tentacle.add_argument('--hole-area', type=float, default=0.02)
    tentacle.add_argument('--ratio', type=float, default=1)
    tentacle.add_argument('--turn', type=float, default=0)
    return parser.parse_args()


def print_table(rows):
    real = [row for row in rows if 'pair' in row]
    made = [row for row in rows if 'pair' not in row]
    if real:
        print_pairs(real)
    if made:
        print_synthetic(made)


def main():
    args = parse()
    if args.mode == 'show':
        print_table([row for path in args.files for row in json.loads(pathlib.Path(path).read_text())])
        return
    judge = Judge(args.scorer)
    programs = [Program(f'keypose {method}', register=f'{args.bin}/keypose-register', method=method) for method in args.methods.split(',') if method]
    programs += [Program(*peer.split('=', 1)) for peer in args.peer]
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(args.work or temporary).resolve()
        work.mkdir(parents=True, exist_ok=True)
        pairs = (real_pairs if args.mode == 'pairs' else synthetic_pairs)(args, judge, work)
        rows = measure(pairs, programs, judge, args, work)
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')
    print_table(rows)


if __name__ == '__main__':
    main()
