#!/usr/bin/env python3
"""Halves and doubles each tuned constant (core/values/tuned.h) and measures how the result changes.

    sensitivity.py run --results FILE.jsonl --work DIR [--bin build/sensitive/bin]
                       [--inputs-bin DIR] [--only REGEX] [--scenes NAME,...] [--budget MINUTES]
                       [--scorer FILE] [--data DATA] [--other-builds]
    sensitivity.py write FILE.jsonl [--page docs/results/sensitivity.md]
    sensitivity.py left FILE.jsonl

The programs must be built with the constants open to change:

    cmake --preset release -B build/sensitive -DKEYPOSE_SENSITIVITY=ON
    cmake --build build/sensitive --target programs score_views

`run` measures scenes with known truth one after the other (sensitivity_scenes.py). A scene first
runs with all constants as they are, which gives its figure and which constants it reads; each
constant that it reads, and that no earlier scene did, is then measured with half of its value and
with twice as much. Results are appended to FILE.jsonl as they come, so a run can be ended at any
time, and the same command goes on with it: what is there is not measured again, unless the
constant's value or the scene's programs have changed since (--other-builds: also if only the
programs have). The inputs stay in --work. --inputs-bin names the programs that make the inputs and
the scores, by default those of --bin. --only picks constants by FILE:NAME. --budget ends the run
after so many minutes. A stage that refuses, or takes over five times its usual time, is said in the
table. `register` is only measured with --scorer (see register_table.py).

`write` renews the page's table: rows that FILE.jsonl does not have stay, with an asterisk, while
the constant has the same value. `left` prints the constants without a measurement.

Needs python3-numpy and python3-scipy.
"""
import argparse
import hashlib
import json
import math
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

import sensitivity_page
from sensitivity_inputs import Inputs, Programs, Refused, TooLong
from sensitivity_page import read_results
from sensitivity_scenes import all_scenes, timed

ROOT = pathlib.Path(__file__).resolve().parent.parent
TUNED = re.compile(r'KEYPOSE_TUNED\((\w+),\s*(\w+),\s*([^;]+)\);(?:[ \t]*///?<?[ \t]*([^\n]*))?')
STRUCT = re.compile(r'^\s*struct (\w+)', re.MULTILINE)
FACTORS = (('half', 0.5), ('double', 2))
NO_SOURCES = ('docs', 'node_modules')


def constants(root=ROOT):
    """All tuned constants of the sources: file, struct, name, value, comment."""
    found = []
    for path in sorted([*root.glob('*/**/*.h'), *root.glob('*/**/*.cpp')]):
        file = path.relative_to(root)
        if file.parts[0].startswith('build') or file.parts[0] in NO_SOURCES:
            continue
        text = path.read_text()
        if 'KEYPOSE_TUNED(' in text and file.name not in ('tuned.h', 'tuned_test.cpp'):
            found += constants_of(str(file), text)
    return found


def constants_of(file, text):
    structs = [(match.start(), match[1]) for match in STRUCT.finditer(text)]
    found = []
    for match in TUNED.finditer(text):
        before = [name for at, name in structs if at < match.start()]
        found.append({'id': f'{file}:{match[2]}', 'file': file, 'name': match[2],
                      'struct': before[-1] if before else '', 'value': value_of(match[3]),
                      'whole': match[1] == 'int', 'comment': match[4] or ''})
    return found


def value_of(text):
    """A number, or an expression of numbers as in 15.0 / 255 or 35 * EIGEN_PI / 180."""
    numbers = re.sub(r'(EIGEN_PI|M_PI|std::numbers::pi|kPi)', repr(math.pi), text)
    numbers = re.sub(r'(?<=[0-9.])[Ff]\b', '', numbers)
    if not re.fullmatch(r'[-+*/ 0-9.e]+', numbers):
        sys.exit(f'sensitivity: a tuned constant has the value {text}, which is no number')
    return float(eval(numbers, {}))  # only digits and the four operations


def changed(constant, factor):
    value = constant['value'] * factor
    return max(1, math.floor(value)) if constant['whole'] else value


class Results:
    """The file of results: one JSON object a line, appended as it comes."""

    def __init__(self, path):
        self.path = pathlib.Path(path)
        self.rows = read_results(self.path)
        text = self.path.read_bytes() if self.path.exists() else b''
        self.torn = bool(text) and not text.endswith(b'\n')

    def add(self, row):
        with self.path.open('a') as file:
            file.write(('\n' if self.torn else '') + json.dumps(row) + '\n')
            file.flush()
            os.fsync(file.fileno())
        self.torn = False
        self.rows.append(row)

    def find(self, build, **wanted):
        """The last row with these values; of this build, unless `build` is None."""
        for row in reversed(self.rows):
            if build in (None, row['build']) and all(row.get(k) == v for k, v in wanted.items()):
                return row
        return None


class OutOfTime(Exception):
    pass


class Run:
    """@param scenes  of sensitivity_scenes.py
    @param known  constants, as of constants()
    @param deadline  of time.monotonic(), after which no measurement begins
    """

    def __init__(self, scenes, known, results, inputs, folder, deadline=math.inf,
                 any_build=False):
        self.scenes, self.known, self.results, self.inputs = scenes, known, results, inputs
        self.folder, self.deadline, self.any_build = pathlib.Path(folder), deadline, any_build
        self.commit = commit()

    def all(self, wanted):
        """Measures the constants in `wanted`, by their ids."""
        taken = set()
        for scene in self.scenes:
            mine = [c for c in self.known if c['file'].startswith(tuple(scene.rooms))]
            if not any(c['id'] in wanted and c['id'] not in taken for c in mine):
                continue
            missing = [p for p in scene.programs if not (self.folder / p).exists()]
            if missing:
                print(f'{scene.name}: not measured, {missing[0]} is not built', flush=True)
                continue
            build = None if self.any_build else self.build_of(scene)
            base = self.base(scene, build)
            if 'error' not in base:
                print(f"{scene.name}: not measured, {base['refused']}", flush=True)
                continue
            mine = [c for c in mine if c['id'] in base['read'] and c['id'] not in taken]
            taken |= {c['id'] for c in mine}
            for constant in mine:
                if constant['id'] in wanted:
                    self.constant(scene, build, base, constant)

    def build_of(self, scene):
        text = hashlib.sha256()
        for program in scene.programs:
            text.update((self.folder / program).read_bytes())
        return text.hexdigest()[:12]

    def base(self, scene, build):
        """The scene with all constants as they are, and which constants it reads."""
        found = self.results.find(build, scene=scene.name, kind='scene')
        if found:
            return found
        log = self.inputs.work / 'read.txt'
        log.unlink(missing_ok=True)
        row = self.measure(scene, {'KEYPOSE_TUNED_READ': str(log)}, 0)
        lines = set(log.read_text().split()) if log.exists() else set()
        read = [c['id'] for c in self.known if any(line.endswith(c['id']) for line in lines)]
        row = {'kind': 'scene', 'scene': scene.name, 'what': scene.what,
               'rooms': list(scene.rooms), **row, 'read': read}
        self.add(scene, row)
        return row

    def constant(self, scene, build, base, constant):
        for key, factor in FACTORS:
            value = changed(constant, factor)
            wanted = {'kind': key, 'scene': scene.name, 'id': constant['id'],
                      'value': constant['value'], 'changed': value}
            if self.results.find(build, **wanted):
                continue
            limit = 10 + 5 * base['cpu_s']
            setting = {'KEYPOSE_TUNED': f"{constant['id']}={value!r}"}
            self.add(scene, {**wanted, **self.measure(scene, setting, limit)})

    def add(self, scene, row):
        self.results.add({**row, 'build': self.build_of(scene), 'commit': self.commit})
        print(' '.join(str(row[k]) for k in ('scene', 'id', 'kind', 'error', 'refused', 'over_s')
                       if k in row), flush=True)

    def measure(self, scene, environment, limit_s):
        """The figure, or why there is none, and how long it took."""
        if time.monotonic() > self.deadline:
            raise OutOfTime
        to = self.inputs.work / 'try'
        shutil.rmtree(to, ignore_errors=True)
        to.mkdir(parents=True)
        programs = Programs(self.folder, limit_s, environment, self.inputs.programs.folder)
        try:
            error, cpu_s, wall_s = timed(lambda: scene.measure(self.inputs, programs, to),
                                         self.inputs)
        except Refused as why:
            return {'refused': str(why)}
        except TooLong as why:
            return {'over_s': round(why.seconds)}
        return {'error': error, 'cpu_s': round(cpu_s, 2), 'wall_s': round(wall_s, 2)}


def commit():
    done = subprocess.run(['git', '-C', str(ROOT), 'log', '-1', '--format=%h'],
                          capture_output=True, text=True)
    return done.stdout.strip()


def run(args):
    os.nice(10)
    for number in (signal.SIGINT, signal.SIGTERM):  # also where the shell lets them be ignored
        signal.signal(number, signal.default_int_handler)
    bin_folder = pathlib.Path(args.bin).resolve()
    inputs = Inputs(pathlib.Path(args.work).resolve(), Programs(args.inputs_bin or bin_folder))
    known = constants()
    scenes = [s for s in all_scenes(args.scorer, args.data) if not s.needs_scorer or args.scorer]
    if args.scenes:
        scenes = [s for s in scenes if s.name in args.scenes.split(',')]
    wanted = {c['id'] for c in known if re.search(args.only, c['id'])}
    deadline = time.monotonic() + 60 * args.budget if args.budget else math.inf
    results = Results(args.results)
    try:
        Run(scenes, known, results, inputs, bin_folder, deadline, args.other_builds).all(wanted)
    except OutOfTime:
        print(f'sensitivity: {args.budget:g} minutes are over; the same command goes on')
    except KeyboardInterrupt:
        print('sensitivity: interrupted; the same command goes on')
    print(sensitivity_page.summary(known, results.rows, all_scenes()))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True)
    command = commands.add_parser('run')
    command.add_argument('--results', required=True)
    command.add_argument('--work', required=True)
    command.add_argument('--bin', default=str(ROOT / 'build/sensitive/bin'))
    command.add_argument('--budget', type=float, default=0)
    command.add_argument('--other-builds', action='store_true')
    for name in ('inputs-bin', 'only', 'scenes', 'scorer', 'data'):
        command.add_argument(f'--{name}', default='')
    command = commands.add_parser('write')
    command.add_argument('results')
    command.add_argument('--page', default=str(ROOT / 'docs/results/sensitivity.md'))
    commands.add_parser('left').add_argument('results')
    args = parser.parse_args()
    if args.command == 'run':
        return run(args)
    rows = read_results(pathlib.Path(args.results))
    if args.command == 'left':
        return print('\n'.join(sensitivity_page.left(constants(), rows, all_scenes())))
    page = pathlib.Path(args.page)
    page.write_text(sensitivity_page.page(constants(), rows, page.read_text(), all_scenes()))
    print(sensitivity_page.summary(constants(), rows, all_scenes()))


if __name__ == '__main__':
    main()
