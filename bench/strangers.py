#!/usr/bin/env python3
"""Photographs of another thing, put into sets of one figure: does `capture` name them, and only them?

    strangers.py --sets NAME=FOLDER,NAME=FOLDER,... [--bin DIR] [--work DIR] [--photographs 24] [--cases one,few,...]
                 [--masks] [--json FILE]

Each set gets photographs of the next one, at several places and in several numbers; folders are only read. Cases:

    one      one stranger, in the middle of the set
    ends     two strangers, the first photograph and the last
    quarter  as many as are told from a second figure's set: a quarter of all
    mixed    half of the one, half of the other: refused, both named
    double   one photograph twice, with other bytes (saved again by `synth damage --kind strip-exif`)
    none     the set alone

Without --masks only the decision is run (at least as many photographs are asked for as there are, so that a
set with strangers ends before it is segmented). With it, the others' masks are compared with those of the set
alone: least overlap. Exit code 1 if a row is wrong. Needs only Python.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

CASES = ['one', 'ends', 'quarter', 'mixed', 'double', 'none']
PHOTOGRAPHS = ('.jpg', '.jpeg', '.png', '.tif')


def pictures_of(folder, count):
    """@return `count` photographs that follow each other, from the first on"""
    files = sorted(f for f in pathlib.Path(folder).iterdir() if f.suffix.lower() in PHOTOGRAPHS)
    return files[:count]


def places_of(case, count):
    """Where in the set strangers take a photograph's place."""
    if case == 'one':
        return [count // 2]
    if case == 'ends':
        return [0, count - 1]
    if case == 'quarter':
        return [4 * k + 1 for k in range(count // 4)]
    if case == 'mixed':
        return list(range(0, count, 2))
    return []


def make(bin_dir, own, others, case, folder):
    """@return names of the strangers"""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    places = places_of(case, len(own))
    strangers = []
    for i, file in enumerate(own):
        name = f'p{i:03}{file.suffix.lower()}'
        if i in places:
            source = others[len(strangers) * len(others) // len(places)]
            name = f'p{i:03}{source.suffix.lower()}'
            strangers.append(name)
            shutil.copyfile(source, folder / name)
        else:
            shutil.copyfile(file, folder / name)
    if case == 'double':
        again = folder.parent / 'again'
        shutil.rmtree(again, ignore_errors=True)
        again.mkdir()
        third = sorted(folder.iterdir())[2]
        shutil.copyfile(third, again / third.name)
        call([bin_dir / 'keypose', 'synth', 'damage', '--photos', again, '--output', folder.parent / 'saved', '--kind', 'strip-exif'])
        shutil.copyfile(folder.parent / 'saved' / third.name, folder / ('z' + third.name))
        strangers.append('z' + third.name)
    return strangers


def call(command):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def capture(bin_dir, photos, work, least):
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    done = call([bin_dir / 'keypose-capture', '--photos', photos, '--images', work / 'images', '--report', work / 'report.json',
                 '--min_images', least])
    (work / 'log.txt').write_text(done.stdout)
    report = work / 'report.json'
    return done, json.loads(report.read_text()) if report.exists() else {}


def names_after(text, words):
    """Names of photographs in the sentence that has these words."""
    found = [line for line in text.splitlines() if words in line]
    return sorted(set(re.findall(r'z?p\d{3}\.\w+', found[0].split(words)[1]))) if found else []


def judge(case, done, strangers):
    """@return (right, what was said)"""
    told = names_after(done.stdout, 'show another thing than the others')
    doubles = names_after(done.stdout, 'show the same view twice')
    if case == 'mixed':
        refused = done.returncode == 3 and 'different things' in done.stdout
        return refused, 'refused, both named' if refused else f'exit {done.returncode}'
    if case == 'double':
        twin = strangers[0][1:]
        right = doubles == sorted([twin, strangers[0]]) and not told
        return right, 'the pair' if right else f'{doubles or "nothing"}, strangers {told or "none"}'
    right = told == strangers and not doubles
    extra = [n for n in told if n not in strangers]
    missed = [n for n in strangers if n not in told]
    said = 'nothing' if not told and not doubles else 'all, and only they' if right else f'missed {missed}, beside them {extra + doubles}'
    return right, said


def overlap(first, second):
    """Least overlap of masks of one name in two folders, by the program's own reader."""
    least = 1.0
    for mask in sorted((first / 'masks').iterdir()):
        if not (second / 'masks' / mask.name).exists():
            continue
        if mask.read_bytes() == (second / 'masks' / mask.name).read_bytes():
            continue
        a, b = raw(mask), raw(second / 'masks' / mask.name)
        both = sum(1 for p, q in zip(a, b) if p > 127 and q > 127)
        either = sum(1 for p, q in zip(a, b) if p > 127 or q > 127)
        least = min(least, both / max(1, either))
    return least


def raw(file):
    done = subprocess.run(['ffmpeg', '-loglevel', 'error', '-i', str(file), '-f', 'rawvideo', '-pix_fmt', 'gray', '-'],
                          stdout=subprocess.PIPE, check=True)
    return done.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--sets', required=True)
    parser.add_argument('--bin', default='build/release/bin')
    parser.add_argument('--work')
    parser.add_argument('--photographs', type=int, default=24)
    parser.add_argument('--cases', default=','.join(CASES))
    parser.add_argument('--masks', action='store_true')
    parser.add_argument('--json')
    args = parser.parse_args()
    sets = [pair.split('=', 1) for pair in args.sets.split(',')]
    work, bin_dir = pathlib.Path(args.work or tempfile.mkdtemp(prefix='strangers_')), pathlib.Path(args.bin)
    rows = []
    for i, (name, folder) in enumerate(sets):
        own = pictures_of(folder, args.photographs)
        others = pictures_of(sets[(i + 1) % len(sets)][1], args.photographs)
        alone = None
        for case in args.cases.split(','):
            here = work / f'{name}_{case}'
            strangers = make(bin_dir, own, others, case, here / 'photos')
            least = 8 if args.masks else len(list((here / 'photos').iterdir()))
            done, _ = capture(bin_dir, here / 'photos', here / 'run', least) if case != 'none' or not alone else alone
            right, said = judge(case, done, strangers)
            row = {'set': name, 'case': case, 'photographs': len(own), 'strangers': strangers, 'said': said, 'right': right}
            if args.masks and case in ('one', 'ends', 'quarter'):
                if alone is None:
                    make(bin_dir, own, others, 'none', work / f'{name}_alone/photos')
                    alone = capture(bin_dir, work / f'{name}_alone/photos', work / f'{name}_alone/run', 8)
                row['least_overlap'] = overlap(work / f'{name}_alone/run/images', here / 'run/images')
            rows.append(row)
            print(f'{name} {case}: {said}{"" if right else "  WRONG"} {row.get("least_overlap", "")}', file=sys.stderr, flush=True)
            if args.json:
                pathlib.Path(args.json).write_text(json.dumps(rows, indent=1) + '\n')
    print('| set | case | strangers | named | least overlap of the others\' masks |\n|---|---|---|---|---|')
    for r in rows:
        print(f'| {r["set"]} | {r["case"]} | {len(r["strangers"])} | {"" if r["right"] else "WRONG: "}{r["said"]} | {r.get("least_overlap", "")} |')
    print(f'\n{sum(r["right"] for r in rows)} of {len(rows)} right')
    sys.exit(0 if all(r['right'] for r in rows) else 1)


if __name__ == '__main__':
    main()
