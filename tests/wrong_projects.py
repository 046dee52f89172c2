#!/usr/bin/env python3
"""Faulty projects, one fault each: `keypose` must give the right exit code and the necessary words.

    wrong_projects.py --bin build/release/bin [--only TEXT] [--show] [--list] [--jobs 2]

Makes a project of two poses from rendered photographs, once. Each case copies it, introduces one fault, and runs
one command. Checks in each case:

    - the exit code, and that the output contains each of the case's words,
    - `error: ` in the output, but no "bug", and no message of a library that aborts,
    - no result below out/, unchanged photographs, no temporary file in .keypose/tmp.

Cases of options are made from `keypose STAGE --describe`. Exit code 1 if any case fails. Needs only Python.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from wrong_cases import commands, other_kinds, photograph_files, pipeline_file
from wrong_cases.case import POSES, photographs, write

PATIENCE_S = 120 * float(os.environ.get('KEYPOSE_SLOWER', 1))
NEVER = ('bug', 'terminate called', 'Traceback', 'std::', 'Assertion', 'what():', 'basic_string', 'json.exception', 'yaml-cpp', 'OpenCV', 'nan%')


class Bench:
    """Makes the project once, and runs cases on copies of it."""

    def __init__(self, programs, work):
        self.keypose, self.work = programs / 'keypose', work
        world = work / 'world'
        made = subprocess.run([programs / 'keypose-synth', 'photos', '--output', world, '--poses', 'rest,bent', '--views', '10', '--width', '320', '--height',
                               '240', '--spacing', '0.008'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert made.returncode == 0, made.stdout
        self.project = work / 'project'
        for pose in ('rest', 'bent'):
            shutil.copytree(world / 'photos' / pose, self.project / 'photos' / pose)
        write(self.project / 'photos/notes.txt', b'shot on Monday')
        write(self.project / 'pipeline.yaml', POSES.encode())
        # Stores the output of --describe here; otherwise each copy would run the stages again, which takes a second.
        subprocess.run([self.keypose, 'status', '-C', self.project], stdout=subprocess.DEVNULL, check=True)

    def prepare(self, case, folder):
        shutil.copytree(self.project, folder)
        if case.yaml is not None:
            (folder / 'pipeline.yaml').write_bytes(case.yaml.encode('latin-1'))
        if case.spoil:
            case.spoil(folder)

    def run(self, number, case):
        """@return the faults of the output (empty: none), and the output"""
        folder = self.work / f'case_{number}'
        self.prepare(case, folder)
        before = prints_of(folder)
        first = photographs(folder)[0].name if photographs(folder) else ''
        command = [self.keypose, *case.command] + ([] if case.outside else ['-C', str(folder)])
        done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S,
                              env={**os.environ, **case.environment})
        answer = done.stdout.decode('utf-8', 'replace')
        wrong = [] if done.returncode == case.code else [f'exit code {done.returncode}, not {case.code}']
        wrong += [f'says no "{word}"' for word in case.words if (first if word == 'FIRST' else word) not in answer]
        wrong += [f'says "{word}"' for word in NEVER if word in answer]
        if case.code and 'error: ' not in answer:
            wrong.append('says no "error: "')
        if case.code and (folder / 'out').is_dir() and any((folder / 'out').rglob('*.ply')):
            wrong.append('left results')
        if case.code and (folder / '.keypose/tmp').is_dir() and not (folder / '.keypose/tmp').is_symlink() and any((folder / '.keypose/tmp').iterdir()):
            wrong.append('left temporary files')
        if any(after != before[name] for name, after in prints_of(folder).items() if name in before) or set(before) - set(prints_of(folder)):
            wrong.append('changed what it was given')
        shutil.rmtree(folder)
        return wrong, answer


def prints_of(folder):
    """The user's files in the project: name -> hash."""
    found = {}
    for path in folder.rglob('*'):
        name = str(path.relative_to(folder))
        if path.is_symlink() or not path.is_file() or name.startswith(('.keypose', 'out')):
            continue
        found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def described_stages(programs):
    listed = ('capture', 'sfm', 'masks', 'dense', 'mesh', 'refine', 'cleanup', 'unwrap', 'register', 'fit', 'bake', 'complete', 'interpolate', 'export', 'report')
    return {stage: json.loads(subprocess.run([programs / 'keypose', stage, '--describe'], stdout=subprocess.PIPE, check=True).stdout) for stage in listed}


def all_cases(programs):
    return [*pipeline_file.file_cases(), *pipeline_file.timeline_cases(),
            *pipeline_file.option_cases(described_stages(programs)), *commands.command_cases(),
            *photograph_files.photo_cases(), *photograph_files.few_cases(),
            *other_kinds.performance_cases(), *other_kinds.film_cases(), *commands.state_cases()]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--bin', type=pathlib.Path, required=True)
    parser.add_argument('--only', default='')
    parser.add_argument('--show', action='store_true', help='print every answer')
    parser.add_argument('--list', action='store_true', help='print the names of the cases and their number; run none')
    parser.add_argument('--jobs', type=int, default=2)
    given = parser.parse_args()
    programs = given.bin.resolve()
    cases = [case for case in all_cases(programs) if given.only in case.name]
    if given.list:
        print(*[case.name for case in cases], f'{len(cases)} wrong projects', sep='\n')
        return 0
    with tempfile.TemporaryDirectory(prefix='wrong_projects_') as work:
        bench = Bench(programs, pathlib.Path(work).resolve())
        with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            answers = list(pool.map(bench.run, range(len(cases)), cases))
    failures = 0
    for case, (wrong, answer) in zip(cases, answers):
        failures += bool(wrong)
        if wrong or given.show:
            print(f'{"FAILED " if wrong else ""}{case.name}: {"; ".join(wrong)}\n    ' + '\n    '.join(answer.strip().splitlines()[-8:]))
    print(f'{len(cases)} wrong projects, {failures} answered wrongly')
    return 1 if failures or not cases else 0


if __name__ == '__main__':
    sys.exit(main())
