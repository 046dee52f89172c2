#!/usr/bin/env python3
"""Compares the whole pipeline on synthetic turntable photographs with the truth.

Measures points in pixel footprints, completeness, cameras, finger-prints, the visual hull, and each step's share
of the time.

    ring_table.py run [--bin DIR] [--work DIR] [--textures rich,weak] [--views 36] [--width 1440]
                      [--set STEP.OPTION=VALUE ...] [--json FILE]
    ring_table.py show FILE.json ...

Uses the clay character of `keypose synth photos` in its rest pose: two rings, 1440 x 1080 pixels, finger-prints
0.15 mm high and 3 mm apart that move the surface, with exact cameras, masks and surface beside the photographs.
The photographs go through `keypose run --until bake` with default options; then `keypose synth score` compares.
--work keeps the files: existing photographs are not rendered again, but the project is made anew. Times are wall
clock; run it alone on the machine. Needs only Python.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

PRINTS = ['--spacing', '0.0009', '--prints-move', '--print-height', '0.00015', '--print-spacing', '0.003']
STEPS = ['capture', 'sfm', 'masks', 'dense', 'mesh', 'refine', 'cleanup', 'unwrap', 'bake']


def call(command):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f'ring_table: {command[0]} {command[1]} failed:\n{done.stdout[-3000:]}')
    return done.stdout


def render(bin_dir, folder, texture, views, width):
    if (folder / 'truth/rest/world.json').exists():
        return
    call([bin_dir / 'keypose-synth', 'photos', '--output', folder, '--poses', 'rest', '--texture', texture, '--views', views, '--width', width,
          '--height', width * 3 // 4, *PRINTS])


def newest_record(project):
    return json.loads(max((project / '.keypose/runs').glob('*.json')).read_text())


def run_pipeline(bin_dir, world, project, settings):
    """The run's record: seconds in total and per step."""
    shutil.rmtree(project, ignore_errors=True)  # nothing from the cache
    call([bin_dir / 'keypose', 'init', project, '--pose', f'rest={world / "photos/rest"}'])
    words = [bin_dir / 'keypose', 'run', '-C', project, '--until', 'bake']
    for setting in settings:
        words += ['--set', setting]
    call(words)
    return newest_record(project)


def score(bin_dir, world, project):
    hull = world / 'hull.ply'
    if not hull.exists():
        call([bin_dir / 'keypose-synth', 'hull', '--truth', world / 'truth/rest', '--output', hull])
    out = project / 'out/rest'
    return json.loads(call([bin_dir / 'keypose-synth', 'score', '--truth', world / 'truth/rest', '--model', out / 'model', '--mesh',
                            out / 'clean.ply', '--cloud', out / 'cloud.ply', '--hull', hull]))


def measure(args):
    work = pathlib.Path(args.work or tempfile.mkdtemp(prefix='ring_table_'))
    bin_dir = pathlib.Path(args.bin)
    results = {}
    for texture in args.textures.split(','):
        world, project = work / texture, work / f'project_{texture}'
        render(bin_dir, world, texture, args.views, args.width)
        record = run_pipeline(bin_dir, world, project, args.set)
        results[texture] = {'record': record, 'score': score(bin_dir, world, project)}
    return {'views': args.views, 'width': args.width, 'textures': results}


def percent(value, digits=1):
    return f'{100 * value:.{digits}f} %'


def score_rows(s):
    """The measurements of one texture, by the label of their row."""
    cameras, surface, hull = s['cameras'], s['surface_refined'], s['hull']
    points = s['points'].get('sure', s['points']['all'])
    rows = {
        'cameras placed': f'{cameras["placed"]} of {cameras["total"]}',
        'camera centres, of their distance: mean, largest': f'{percent(cameras["mean_over_distance"], 3)}, {percent(cameras["max_over_distance"], 3)}',
        'points of stereo and rims': f'{points["points"]:,}',
        'within one pixel footprint': percent(points['within_one_footprint']),
        'distance in footprints: median, 90 %, 99 %': f'{points["median_footprints"]:.2f}, {points["p90_footprints"]:.2f}, {points["p99_footprints"]:.1f}',
        'seen surface with a point within 1 % of the height: all points, without hull and bridges':
            f'{percent(s["points"]["all"]["completeness_seen"])}, {percent(points["completeness_seen"])}',
        'mesh, mean distance both ways, of the diagonal': percent(surface['mean_over_diag'], 3),
        'mean error beside the exact hull\'s, on seen surface': f'{1000 * hull["mean_m"]:.3f} mm, {1000 * hull["hull_mean_m"]:.3f} mm, ratio {hull["ratio"]:.2f}',
        'seen surface more than a footprint worse than the hull': percent(hull['worse_share'], 2),
        'closed': 'yes' if s['closed']['closed'] else 'no',
    }
    if 'detail' in s:
        rows['finger-prints: height recovered, correlation'] = f'{percent(s["detail"]["gain"], 0)}, {s["detail"]["correlation"]:.2f}'
    return rows


def show(data):
    textures = data['textures']
    print(f'{data["views"]} photographs, {data["width"]} x {data["width"] * 3 // 4}\n')
    print('| | ' + ' | '.join(textures) + ' |')
    print('|---|' + '---|' * len(textures))
    tables = [score_rows(t['score']) for t in textures.values()]
    for row in tables[0]:
        print(f'| {row} | ' + ' | '.join(table.get(row, '') for table in tables) + ' |')
    print('\n| step | ' + ' | '.join(f'{name}, s (share), peak' for name in textures) + ' |')
    print('|---|' + '---|' * len(textures))
    for step in STEPS:
        cells = []
        for t in textures.values():
            found = [s for s in t['record']['steps'] if s['id'].split('/')[0] == step]
            seconds, peak = sum(s['seconds'] for s in found), max((s['peak_bytes'] for s in found), default=0)
            cells.append(f'{seconds:.1f} ({percent(seconds / t["record"]["seconds"], 0)}), {peak / 2**20:.0f} MiB')
        print(f'| {step} | ' + ' | '.join(cells) + ' |')
    print('| all | ' + ' | '.join(f'{t["record"]["seconds"]:.0f}' for t in textures.values()) + ' |')


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    run = commands.add_parser('run')
    run.add_argument('--bin', default='build/release/bin')
    run.add_argument('--work')
    run.add_argument('--textures', default='rich,weak')
    run.add_argument('--views', type=int, default=36)
    run.add_argument('--width', type=int, default=1440)
    run.add_argument('--set', action='append', default=[])
    run.add_argument('--json')
    commands.add_parser('show').add_argument('files', nargs='+')
    args = parser.parse_args()
    if args.command == 'show':
        for path in args.files:
            show(json.loads(pathlib.Path(path).read_text()))
        return
    data = measure(args)
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(data, indent=1))
    show(data)


if __name__ == '__main__':
    main()
