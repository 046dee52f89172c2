#!/usr/bin/env python3
"""How files of other programs are read: the commands a user would type, on inputs with known right values.

    files_table.py [--reports DIR] [--bin DIR] [--kinds glTF,BVH,...] [--work DIR] [--json FILE]

--reports: small inputs that repeat public reports, described by a README.md there; left out where absent. Beside
these, inputs are made on the fly by ffmpeg, Blender, assimp, COLMAP, OpenCV and Pillow, or written by hand where
the format is text. Each case is judged by numbers: `right` (all within their bounds), `named` (exit 2 to 6, or a
warning or note, whose text names the feature), `wrong` (neither, though the command succeeds), `badly` (refused
without a word about the feature, or ended in no such way). Exit code 1 if a case ends otherwise
than it should. Prints a markdown table, then what was wrong. Needs python3-numpy, python3-opencv, python3-pil;
programs that are absent leave their cases out.
"""
import argparse
import importlib
import json
import pathlib
import sys
import tempfile

try:
    from files_cases import CASES, Bench, run_case

    for module in ('meshes', 'cameras', 'rigs', 'photographs', 'films'):
        importlib.import_module('files_' + module)  # adds its cases
except ImportError as missing:
    sys.exit(f'files_table: no module {missing.name}; apt-get install python3-numpy python3-opencv python3-pil')

COLUMNS = ('right', 'named', 'wrong', 'badly')
HEAD = '| kind | read by | right | named | wrong without a word | refused badly | the right value, and ours |'


def values(rows):
    """The largest of each number of the right cases, and what was named."""
    worst = {}
    for row in rows:
        for label, value, bound in row['numbers'] if row['got'] == 'right' else ():
            worst[label] = max(worst.get(label, (0, 0)), (value, bound))
    parts = [f'{label} {value:.2g} (at most {bound:g})' for label, (value, bound) in worst.items()]
    named = [row['name'] for row in rows if row['got'] == 'named']
    faults = [f'**{row["name"]}: {row["got"]}**' for row in rows if row['got'] not in ('skipped', row['wanted'])]
    return '; '.join(parts + (['named: ' + ', '.join(named)] if named else []) + faults)


def show(rows):
    print(HEAD + '\n|---|---|---|---|---|---|---|')
    for kind, by in dict.fromkeys((row['kind'], row['by']) for row in rows):
        of = [row for row in rows if (row['kind'], row['by']) == (kind, by)]
        counts = [sum(row['got'] == column for row in of) for column in COLUMNS]
        if sum(counts):
            print(f'| {kind} | {by} | ' + ' | '.join(str(n) if n else '' for n in counts) + f' | {values(of)} |')
    ran = [row for row in rows if row['got'] != 'skipped']
    off = [row for row in ran if row['got'] != row['wanted']]
    print(f'\n{len(ran)} inputs, {len(ran) - len(off)} as they should be, {len(rows) - len(ran)} left out.')
    for row in off:
        print(f'\n{row["kind"]}, {row["name"]}: {row["got"]} instead of {row["wanted"]}; {row["numbers"]}\n  {row["said"]}')
    for row in rows:
        if row['got'] == 'skipped':
            print(f'\nleft out: {row["kind"]}, {row["name"]}: {row["said"]}')
    return bool(off)


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    arguments.add_argument('--reports', type=pathlib.Path, help='folder of the public reports')
    arguments.add_argument('--bin', type=pathlib.Path, default=pathlib.Path('build/release/bin'))
    arguments.add_argument('--work', type=pathlib.Path, help='keeps what was made; default: a temporary folder')
    arguments.add_argument('--kinds', help='only kinds whose names hold one of these, comma-separated')
    arguments.add_argument('--json', type=pathlib.Path, help='also writes all rows')
    given = arguments.parse_args()
    if given.reports and not given.reports.is_dir():
        print(f'files_table: {given.reports} is not there: only inputs made here', file=sys.stderr)
    wanted = [c for c in CASES if not given.kinds or any(k.lower() in (c[0] + c[2]).lower() for k in given.kinds.split(','))]
    wanted.sort(key=lambda c: list(dict.fromkeys((k[0], k[1]) for k in CASES)).index((c[0], c[1])))
    with tempfile.TemporaryDirectory() as temporary:
        work = (given.work or pathlib.Path(temporary)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        b = Bench(given.bin.resolve(), given.reports.resolve() if given.reports else None, work)
        rows = []
        for one in wanted:
            rows.append(run_case(b, *one))
            print(f'{rows[-1]["got"]:8} {rows[-1]["seconds"]:5.1f} s  {one[0]}, {one[2]}', file=sys.stderr)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1))
    sys.exit(show(rows))


if __name__ == '__main__':
    main()
