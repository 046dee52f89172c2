#!/usr/bin/env python3
"""Runs a newcomer's sets, good and bad ones, through `keypose init` and `keypose run`.

Does each set end correctly or with a refusal, and does the verdict agree with the truth?

    newcomers.py [--bin DIR] [--work DIR] [--kinds plain,weak,...] [--seeds 1] [--more 20] [--json FILE]

`keypose synth photos` renders every kind of set (24 photographs of 640 x 480 unless the kind says otherwise),
once per seed of --seeds. --more adds that many sets with further seeds, cycling through the kinds. A set is
judged by its surface: mean distance, both ways, / diagonal.

    right     below 0.5 %, and as many handles as the true masks see through on the true surface
    ruin      above 1 %, or a genus different from the truth's
    between   neither

The result for the user is `refused` (exit code 3 or 6 with a reason), or the verdict of out/report/report.json.
Result and truth disagree if a ruin is called good, if a right set is called wrong, if a set that others finish
is refused, or on any other exit code. Exit code 1 if any row disagrees. Needs only Python.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

RIGHT_BELOW, RUIN_ABOVE = 0.005, 0.01

# Options of `synth photos`. `may_refuse`: a refusal is correct too. `damage`: copies damaged by `synth damage`.
KINDS = {
    'plain': {'options': []},
    'weak': {'options': ['--texture', 'weak', '--views', 32]},
    'columns': {'options': ['--character', 'columns']},
    'hip': {'options': ['--poses', 'hip'], 'pose': 'hip'},
    'stray': {'options': ['--stray', 1]},
    'hand': {'options': ['--hand', 2]},
    'moved': {'options': ['--moved', '0.5:5mm,7deg'], 'may_refuse': True},
    'lamp': {'options': ['--lamp-fall', 0.6]},
    'sparse60': {'options': ['--views', 12], 'may_refuse': True},
    'sparse': {'options': ['--character', 'columns', '--views', 16, '--elevations', '20'], 'may_refuse': True,
               'damage': [('strip-exif', None), ('rotate', 'IMG_0003.jpg,IMG_0009.jpg')]},
}


def call(command, may_fail=False):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0 and not may_fail:
        sys.exit(f'newcomers: {" ".join(map(str, command))} failed:\n{done.stdout[-3000:]}')
    return done


def render(bin_dir, world, kind, seed):
    """@return the folder of the newcomer's photographs"""
    pose = kind.get('pose', 'rest')
    if not (world / f'truth/{pose}/world.json').exists():
        defaults = ['--width', 640, '--views', 24, '--poses', pose]
        names = {word for word in kind['options'] if str(word).startswith('--')}
        kept = [word for i in range(0, len(defaults), 2) if defaults[i] not in names for word in defaults[i:i + 2]]
        call([bin_dir / 'keypose', 'synth', 'photos', '--output', world, '--seed', seed, *kept, *kind['options']])
    photos = world / 'photos' / pose
    for number, (damage, names) in enumerate(kind.get('damage', [])):
        copy = world / f'damaged{number}'
        shutil.rmtree(copy, ignore_errors=True)
        words = [bin_dir / 'keypose', 'synth', 'damage', '--photos', photos, '--output', copy, '--kind', damage]
        call(words + (['--names', names] if names else []))
        photos = copy
    return photos


def seen_genus(bin_dir, world, pose, photos_of_truth):
    """Handles of the true surface that the true masks see through.

    Others, such as a slit between arm and body that faces no camera, cannot be reconstructed.
    """
    truth, work = world / 'truth' / pose, world / 'seen'
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir()
    call([bin_dir / 'keypose-capture', '--photos', photos_of_truth, '--masks', truth / 'masks', '--images', work / 'images'])
    surface = truth / ('outer.ply' if (truth / 'outer.ply').exists() else 'surface.ply')
    call([bin_dir / 'keypose-cleanup', '--surface', surface, '--images', work / 'images', '--model', truth / 'cameras', '--clean', work / 'clean.ply',
          '--report', work / 'cleanup.json'])
    return json.loads((work / 'cleanup.json').read_text())['measurements']['handles_seen_through']


def truth_of(bin_dir, world, pose, out):
    """Mean surface error / diagonal, and whether the genus is the truth's; None without a mesh."""
    if not (out / 'clean.ply').exists() or not (out / 'model').exists():
        return None
    done = call([bin_dir / 'keypose', 'synth', 'score', '--truth', world / 'truth' / pose, '--model', out / 'model', '--mesh', out / 'clean.ply'],
                may_fail=True)
    if done.returncode != 0:
        return {'error': float('inf'), 'genus_right': False}  # so far off that no alignment succeeds
    score = json.loads(done.stdout)
    genus = seen_genus(bin_dir, world, pose, world / 'photos' / pose)
    return {'error': score['surface_refined']['mean_over_diag'], 'genus_right': score['closed']['genus'] == genus}


def grade_of(truth):
    if truth is None:
        return 'nothing'
    if truth['error'] > RUIN_ABOVE or not truth['genus_right']:
        return 'ruin'
    return 'right' if truth['error'] < RIGHT_BELOW else 'between'


def agrees(kind, verdict, truth):
    if verdict == 'refused':
        return bool(kind.get('may_refuse'))
    if verdict == 'failed':
        return False
    return not (truth == 'ruin' and verdict == 'good') and not (truth == 'right' and verdict == 'wrong')


def walk(bin_dir, work, name, seed):
    kind = KINDS[name]
    pose = kind.get('pose', 'rest')
    world = work / f'{name}_{seed}'
    photos = render(bin_dir, world, kind, seed)
    project = world / 'project'
    shutil.rmtree(project, ignore_errors=True)
    call([bin_dir / 'keypose', 'init', project, '--pose', f'{pose}={photos}'])
    done = call([bin_dir / 'keypose', 'run', '-C', project], may_fail=True)
    (world / 'run.txt').write_text(done.stdout)
    row = {'kind': name, 'seed': seed, 'exit': done.returncode, 'why': ''}
    report = project / 'out/report/report.json'
    if done.returncode in (3, 6):
        row['verdict'] = 'refused'
        row['why'] = ([line for line in done.stdout.splitlines() if 'error' in line] or [''])[-1].strip()
    elif done.returncode != 0 or not report.exists():
        row['verdict'] = 'failed'
    else:
        verdict = next(v for v in json.loads(report.read_text())['verdicts'] if v['about'] == pose)
        row['verdict'], row['why'] = verdict['grade'], verdict['why']
    truth = truth_of(bin_dir, world, pose, project / 'out' / pose)
    row['error'] = truth['error'] if truth else None
    row['genus_right'] = truth['genus_right'] if truth else None
    row['truth'] = grade_of(truth)
    row['agrees'] = agrees(kind, row['verdict'], row['truth'])
    return row


def show(rows):
    print('| set | seed | surface error | genus | truth | told | agrees | why |\n|---|---|---|---|---|---|---|---|')
    for r in rows:
        error = '' if r['error'] is None else f'{100 * r["error"]:.3f} %'
        genus = '' if r['genus_right'] is None else 'right' if r['genus_right'] else 'wrong'
        print(f'| {r["kind"]} | {r["seed"]} | {error} | {genus} | {r["truth"]} | {r["verdict"]} | {"yes" if r["agrees"] else "NO"} | {r["why"][:200]} |')
    print(f'\n{sum(r["agrees"] for r in rows)} of {len(rows)} agree')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bin', default='build/release/bin')
    parser.add_argument('--work', help='working folder; existing sets are not rendered again')
    parser.add_argument('--kinds', default=','.join(KINDS))
    parser.add_argument('--seeds', default='1')
    parser.add_argument('--more', type=int, default=0)
    parser.add_argument('--json')
    args = parser.parse_args()
    kinds = args.kinds.split(',')
    unknown = [k for k in kinds if k not in KINDS]
    if unknown:
        parser.error(f'unknown kind {unknown[0]}; there are {", ".join(KINDS)}')
    sets = [(kind, int(seed)) for seed in args.seeds.split(',') if seed for kind in kinds]
    sets += [(kinds[i % len(kinds)], 101 + i) for i in range(args.more)]
    work = pathlib.Path(args.work or tempfile.mkdtemp(prefix='newcomers_'))
    rows = []
    for name, seed in sets:
        rows.append(walk(pathlib.Path(args.bin), work, name, seed))
        r = rows[-1]
        print(f'{r["kind"]} {r["seed"]}: {r["truth"]}, told {r["verdict"]}{"" if r["agrees"] else "  DISAGREES"}', file=sys.stderr, flush=True)
        if args.json:
            pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')
    show(rows)
    sys.exit(0 if all(r['agrees'] for r in rows) else 1)


if __name__ == '__main__':
    main()
