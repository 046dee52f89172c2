#!/usr/bin/env python3
"""Photographs of rooms as people take them at home, generated with their truth and real ones, through `keypose init` and `keypose run`.

    rooms.py run [--bin DIR] [--work DIR] [--seeds 1-24] [--refusals 1-2] [--kinds walk,mat,...] [--photographs 0] [--size 1200x800]
                 [--real NAME=PHOTOS ...] [--parts whole,half,noexif,small] [--ways keypose,colmap,network] [--until STEP]
                 [--say touching|nothing|all] [--json FILE]
    rooms.py show FILE.json ...

`keypose synth room` makes one room for each of --seeds (of the seed's kind, or of those of --kinds only), and for each of --refusals a carving
on a trunk and a relief on a wall, which do not stand free. Real sets (--real) have no truth; --parts gives them whole, every second photograph,
without EXIF, at 800 pixels. What is in --work already is not made again, so that a stopped run goes on where it was.

Ways: `keypose` is the whole pipeline, or as far as --until; --say says once, in one photograph, what the figure is not (a line over what
touches it), or everywhere what it is, by places that the truth knows. `colmap` is structure from motion with whole pictures, without masks, by COLMAP's own programs.
`network` is the masks of the network alone (needs the tool salience_masks in --bin).

    cameras    placed of all; wrong: more than 2 degrees, or 5 % of the distance, from the truth after the alignment with which most agree
    still      cameras that agree with what stands still instead, where the figure turned
    masks      overlap with the true figure (pixels of both over those of either): median, worst
    base       what the mesh has too much at its foot, of the diagonal: under the plane that the figure stands on, or beside its lowest eighth
    surface    mean distance of the mesh from the true surface, of the diagonal; of one side alone the unseen side is not judged
    told       verdict of the report, or `refused` with the reason

A row disagrees if a ruin is called good, if a figure that stands free is refused, or if a carving is not refused. A ruin has a wrong camera, a base
above 2 % or a surface above 1 %. Needs only Python, and colmap for that way.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

RUIN_BASE, RUIN_SURFACE = 0.02, 0.01
PARTS = ('whole', 'half', 'noexif', 'small')
WAYS = ('keypose', 'colmap', 'network')
CARVINGS = ('trunk', 'relief')


def call(*words, may_fail=False, log=None):
    done = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          env={**os.environ, 'QT_QPA_PLATFORM': 'offscreen'})
    if done.returncode < 0:
        sys.exit(f'rooms: {" ".join(map(str, words[:4]))} was stopped by signal {-done.returncode}; start again, what is there is kept')
    if log:
        log.write_text(done.stdout)
    if done.returncode != 0 and not may_fail:
        sys.exit(f'rooms: {" ".join(map(str, words[:4]))} failed:\n{done.stdout[-3000:]}')
    return done


def numbers(text):
    """'1-3,7' -> [1, 2, 3, 7]"""
    found = []
    for part in filter(None, text.split(',')):
        first, _, last = part.partition('-')
        found += range(int(first), int(last or first) + 1)
    return found


class Room:
    """One set of photographs, with its truth or without."""

    def __init__(self, args, name, photos, truth=None, words=()):
        self.args, self.name, self.photos, self.truth, self.words = args, name, photos, truth, words
        self.work = args.work / name
        self.about = json.loads((truth / 'room.json').read_text()) if truth else None
        suffixes = ('.jpg', '.jpeg', '.png')
        self.count = sum(path.suffix.lower() in suffixes for path in photos.iterdir())

    def program(self, name):
        return self.args.bin / name

    def score(self, **given):
        """What `synth score-room` says of a model, masks, a mesh; empty where they are missing."""
        there = [word for key, path in given.items() if path and path.exists() for word in (f'--{key}', path)]
        if not self.truth or not there or ('mesh' in given and '--model' not in there):
            return {}
        done = call(self.program('keypose'), 'synth', 'score-room', '--truth', self.truth, *there, may_fail=True)
        return json.loads(done.stdout) if done.returncode == 0 else {'failed': done.stdout.strip()}

    def row(self, way, seconds, **more):
        about = self.about or {}
        return {'set': self.name, 'way': way, 'kind': about.get('kind', 'real'), 'stands_on': about.get('stands_on', ''), 'second': about.get('second', ''),
                'free_standing': about.get('free_standing', True), 'photographs': self.count, 'seconds': round(seconds, 1), **more}


def said_of(room):
    """Words for `keypose figure` in one photograph that shows the figure whole and alone: a line over the thing that touches it, else a click on it."""
    if not room.truth or room.args.say == 'nothing':
        return []
    good = [p for p in room.about['photographs'] if not p['cut'] and not p['hand'] and p['inside'][0] >= 0]
    if not good:
        return []
    if room.about['second'] == 'touching':
        widest = max(good, key=lambda p: p['beside'][2] - p['beside'][0])
        return ['--not', '%s:%d,%d-%d,%d' % (widest['name'], *widest['beside'])]
    return ['--at', '%s:%d,%d' % (good[0]['name'], *good[0]['inside'])] if room.args.say == 'all' else []


def latest(project, pattern):
    found = sorted(project.glob(f'.keypose/cache/*/*/{pattern}'), key=lambda path: path.stat().st_mtime)
    return found[-1] if found else None


def by_keypose(room):
    project, started = room.work / 'project', time.monotonic()
    shutil.rmtree(project, ignore_errors=True)
    call(room.program('keypose'), 'init', project, '--pose', f'figure={room.photos}')
    said = said_of(room)
    if said:
        call(room.program('keypose'), 'figure', '-C', project, '--pose', 'figure', *said)
    until = ['--until', room.args.until] if room.args.until else []
    done = call(room.program('keypose'), 'run', '-C', project, '--progress', 'lines', *until, *room.words, may_fail=True, log=room.work / 'run.txt')
    out = project / 'out/figure'
    row = room.row('keypose', time.monotonic() - started, exit=done.returncode, said=bool(said), why='')
    if done.returncode == 0:
        report = project / 'out/report/report.json'
        row['told'] = 'done'
        if report.exists():
            verdict = next(v for v in json.loads(report.read_text())['verdicts'] if v['about'] == 'figure')
            row['told'], row['why'] = verdict['grade'], verdict['why']
    else:
        row['told'] = 'refused' if done.returncode in (3, 6) else 'failed'
        lines = done.stdout.strip().splitlines()
        row['why'] = ([line for line in lines if 'error' in line] or lines[-1:] or [''])[-1].strip()
    masks = latest(project, 'masked/masks') or latest(project, 'images/masks')
    row.update(room.score(model=out / 'model', masks=masks, mesh=out / 'clean.ply'))
    if not room.truth:
        row.update(real_numbers(room, out))
    return row


def real_numbers(room, out):
    """Cameras of a set without truth."""
    model = out / 'model'
    if not model.exists():
        return {}
    return {'cameras': {'total': room.count, 'placed': placed(model), 'wrong': None}, 'mesh': (out / 'clean.ply').exists()}


def placed(model):
    data = (model / 'images.bin').read_bytes()[:8]
    return int.from_bytes(data, 'little')


def by_colmap(room):
    """Structure from motion with all that the pictures show; the largest model counts."""
    folder, started = room.work / 'colmap', time.monotonic()
    shutil.rmtree(folder, ignore_errors=True)
    (folder / 'sparse').mkdir(parents=True)
    database = ['--database_path', folder / 'database.db']
    call('colmap', 'feature_extractor', *database, '--image_path', room.photos, '--SiftExtraction.use_gpu', 0, '--SiftExtraction.max_image_size', 1600,
         '--SiftExtraction.max_num_features', 4096, '--ImageReader.camera_model', 'RADIAL')
    call('colmap', 'exhaustive_matcher', *database, '--SiftMatching.use_gpu', 0)
    call('colmap', 'mapper', *database, '--image_path', room.photos, '--output_path', folder / 'sparse', may_fail=True)
    models = sorted((path for path in (folder / 'sparse').iterdir() if (path / 'images.bin').exists()), key=placed)
    row = room.row('colmap', time.monotonic() - started, told='', why='')
    if not models:
        return {**row, 'cameras': {'total': room.count, 'placed': 0, 'wrong': []}}
    if not room.truth:
        return {**row, 'cameras': {'total': room.count, 'placed': placed(models[-1]), 'wrong': None}}
    return {**row, **room.score(model=models[-1])}


def by_network(room):
    folder, started = room.work / 'network', time.monotonic()
    shutil.rmtree(folder, ignore_errors=True)
    done = call(room.program('salience_masks'), room.photos, folder, may_fail=True)
    row = room.row('network', time.monotonic() - started, told='', why=done.stdout.strip())
    return {**row, **room.score(masks=folder)}


def generated(args, seed, kind):
    name = f'{kind or "room"}_{seed}'
    world = args.work / name / 'world'
    if not (world / 'truth/figure/room.json').exists():
        words = ['--seed', seed, '--size', args.size]
        words += ['--kind', kind] if kind else []
        words += ['--photographs', args.photographs] if args.photographs else []
        call(args.bin / 'keypose', 'synth', 'room', world, *words)
    return Room(args, name, world / 'photos/figure', world / 'truth/figure')


def part_of(args, name, photos, part):
    """A real set, or a part of it."""
    folder = args.work / f'{name}_{part}'
    if part == 'half' and not (folder / 'photos').exists():
        (folder / 'photos').mkdir(parents=True)
        names = sorted(path.name for path in photos.iterdir() if path.suffix.lower() in ('.jpg', '.jpeg', '.png'))
        for each in names[::2]:
            shutil.copy(photos / each, folder / 'photos' / each)
    if part == 'noexif' and not (folder / 'photos').exists():
        call(args.bin / 'keypose', 'synth', 'damage', '--photos', photos, '--output', folder / 'photos', '--kind', 'strip-exif')
    folder.mkdir(parents=True, exist_ok=True)
    own = folder / 'photos'
    return Room(args, folder.name, own if own.exists() else photos, words=['--set', 'capture.max_size=800'] if part == 'small' else [])


def rooms_of(args):
    wanted = args.kinds.split(',') if args.kinds else None
    for seed in numbers(args.seeds):
        room = generated(args, seed, None)
        if not wanted or room.about['kind'] in wanted:
            yield room
    for seed in numbers(args.refusals):
        for kind in CARVINGS:
            yield generated(args, seed, kind)
    for real in args.real:
        name, _, photos = real.partition('=')
        for part in args.parts.split(','):
            yield part_of(args, name, pathlib.Path(photos), part)


def is_ruin(row):
    base, cameras = row.get('base', {}), row.get('cameras', {})
    surface = base.get('mean_to_truth', 0) if row['kind'] != 'one-side' else 0
    return bool(cameras.get('wrong')) or max(base.get('below', 0), base.get('beside', 0)) > RUIN_BASE or surface > RUIN_SURFACE


def agrees(row):
    if row['way'] != 'keypose':
        return True
    if not row['free_standing']:
        return row['told'] == 'refused'
    return row['told'] not in ('refused', 'failed') and not (row['told'] == 'good' and is_ruin(row))


def run(args):
    rows = []
    for room in rooms_of(args):
        for way in args.ways.split(','):
            room.work.mkdir(parents=True, exist_ok=True)
            kept = room.work / f'{way}.json'
            if not kept.exists():
                row = {'keypose': by_keypose, 'colmap': by_colmap, 'network': by_network}[way](room)
                kept.write_text(json.dumps(row, indent=1) + '\n')
            rows.append(json.loads(kept.read_text()))
            print(line(rows[-1]), file=sys.stderr, flush=True)
            if args.json:
                pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')
    return rows


def share(value):
    return '' if value is None else f'{100 * value:.2f} %'


def line(row):
    cameras, masks, base = row.get('cameras', {}), row.get('masks', {}), row.get('base', {})
    wrong = cameras.get('wrong')
    still = cameras.get('agree_with_room', '') if row['kind'] in ('mat', 'mat-hand', 'both') else ''
    cells = [row['set'], row['way'], row['kind'], row['stands_on'], row['second'] + (', said' if row.get('said') else ''),
             f'{cameras["placed"]} of {cameras["total"]}' if cameras else '', '' if wrong is None else len(wrong), still,
             f'{masks["median"]:.3f}' if masks else '', f'{masks["worst"]:.3f}' if masks else '',
             share(max(base['below'], base['beside'])) if base else '', share(base['mean_to_truth']) if base and row['kind'] != 'one-side' else '',
             row['told'] + ('' if agrees(row) else ' DISAGREES'), f'{row["seconds"]:.0f}', row['why'][:160].replace('|', '/')]
    return '| ' + ' | '.join(map(str, cells)) + ' |'


def summary(rows):
    """One line for each way, over the generated figures that stand free."""
    for way in WAYS:
        mine = [row for row in rows if row['way'] == way and row['kind'] != 'real' and row['free_standing']]
        if not mine:
            continue
        total = sum(row['photographs'] for row in mine)
        cameras = [row['cameras'] for row in mine if row.get('cameras')]
        right = sum(c['placed'] - len(c['wrong']) for c in cameras)
        overlaps = sorted(value for row in mine for value in row.get('masks', {}).get('each', {}).values())
        words = [f'{way}: {len(mine)} rooms']
        if way != 'network':
            words.append(f'cameras {right} of {total} ({100 * right / total:.1f} %), wrong {sum(len(c["wrong"]) for c in cameras)}')
        if overlaps:
            words.append(f'masks {overlaps[len(overlaps) // 2]:.3f} in the median, {overlaps[0]:.3f} at worst')
        if way == 'keypose':
            bases = [max(row['base']['below'], row['base']['beside']) for row in mine if row.get('base')]
            words.append(f'base at most {share(max(bases))}' if bases else 'no mesh')
            words.append(f'refused {sum(row["told"] in ("refused", "failed") for row in mine)}')
            words.append(f'ruins called good {sum(row["told"] == "good" and is_ruin(row) for row in mine)}')
        print('- ' + '; '.join(words))
    carvings = [row for row in rows if row['way'] == 'keypose' and not row['free_standing']]
    if carvings:
        print(f'- carvings: {sum(agrees(row) for row in carvings)} of {len(carvings)} refused, in at most {max(row["seconds"] for row in carvings):.0f} s')


def show(rows):
    print('| set | way | kind | stands on | second thing | cameras | wrong | still | masks, median | worst | base | surface | told | s | why |')
    print('|' + '---|' * 15)
    for row in rows:
        print(line(row))
    print()
    summary(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    runs = commands.add_parser('run')
    runs.add_argument('--bin', type=pathlib.Path, default=pathlib.Path('build/release/bin'))
    runs.add_argument('--work', type=pathlib.Path)
    runs.add_argument('--seeds', default='1-24')
    runs.add_argument('--refusals', default='')
    runs.add_argument('--kinds', default='')
    runs.add_argument('--photographs', type=int, default=0)
    runs.add_argument('--size', default='1200x800')
    runs.add_argument('--real', action='append', default=[], metavar='NAME=PHOTOS')
    runs.add_argument('--parts', default='whole')
    runs.add_argument('--ways', default='keypose')
    runs.add_argument('--until', default='')
    runs.add_argument('--say', choices=('touching', 'nothing', 'all'), default='touching')
    runs.add_argument('--json')
    commands.add_parser('show').add_argument('files', nargs='+')
    args = parser.parse_args()
    if args.command == 'show':
        return show([row for name in args.files for row in json.loads(pathlib.Path(name).read_text())])
    for given, known in ((args.parts, PARTS), (args.ways, WAYS)):
        unknown = [word for word in given.split(',') if word not in known]
        if unknown:
            parser.error(f"'{unknown[0]}' is unknown; there are {', '.join(known)}")
    args.bin = args.bin.resolve()
    args.work = (args.work or pathlib.Path(tempfile.mkdtemp(prefix='rooms_'))).resolve()
    rows = run(args)
    show(rows)
    sys.exit(0 if all(map(agrees, rows)) else 1)


if __name__ == '__main__':
    main()
