#!/usr/bin/env python3
"""Injects faults into runs at random moments. The next run must give the same bits as an undisturbed run.

    fault_matrix.py [--build build/release] [--count 1000] [--seed 1] [--jobs 4] [--kinds a,b,...]
                    [--work DIR] [--json FILE]

The runner and its guardians are the real ones. The stages are the small text programs of the runner's tests;
they write slowly, so that faults hit them while they write. Every injection has its own project with two poses
and five steps. An injection fails if

    - the run after the fault (or the disturbed run, if it should go on) does not end with exit code 0,
    - a file below out/ is missing, differs from the undisturbed run's, or does not belong there
      (NAME.mine is expected where the fault damaged NAME),
    - `keypose verify` then finds anything damaged,
    - two seconds later a process started by the project's stages is still alive, or temporary files are left.

Prints a table: fault, how it is made, what is promised, injections, failures. `disk full` is left out without
the right to mount a tmpfs. Exit code 1 on any failure. Needs only Python.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

PIPELINE = '''sources: {photos: {of: pose}}
steps:
  gather: {stage: gather, for: pose, inputs: {photos: $photos}}
  join: {stage: join, for: pose, inputs: {images: gather.images}, out: {text: "{pose}/text.txt"}}
  merge: {stage: merge, for: project, inputs: {texts: join.text@all}, out: {all: all}}
'''
POSES = ('rest', 'bent')
DELAY_MS = '12'


def text_of(pose, number, variant=''):
    return f'{pose} picture {number}{variant}\n'


class Project:
    """A separate installation with a project."""

    def __init__(self, build, root):
        self.root, self.folder = root, root / 'hero'
        (root / 'bin').mkdir(parents=True)
        (root / 'share/keypose').mkdir(parents=True)
        shutil.copy(build / 'bin/keypose', root / 'bin/keypose')
        for stage in ('gather', 'join', 'merge'):
            shutil.copy(build / 'bin/testing/pipeline_text_stage', root / f'bin/keypose-{stage}')
        (root / 'share/keypose/pipeline.yaml').write_text(PIPELINE)
        self.fill(self.folder)
        self.spoilt_results = set()

    def fill(self, folder):
        for pose in POSES:
            (folder / 'photos' / pose).mkdir(parents=True)
            for number in range(4):
                (folder / f'photos/{pose}/IMG_{number}.jpg').write_text(text_of(pose, number))
        (folder / 'pipeline.yaml').write_text('poses: {rest: photos/rest, bent: photos/bent}\n')

    def start(self, *more, delay=DELAY_MS):
        environment = {**os.environ, 'TEXT_STAGE_DELAY_MS': delay, 'TEXT_STAGE_SPAWN': '1'}
        return subprocess.Popen([self.root / 'bin/keypose', 'run', '-C', self.folder, '-j', '2', *more], env=environment, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, start_new_session=True)

    def run(self, *more, delay='0'):
        runner = self.start(*more, delay=delay)
        text, _ = runner.communicate(timeout=120)
        return runner.returncode, text

    def command(self, *words):
        return subprocess.run([self.root / 'bin/keypose', *words, '-C', self.folder], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120)

    def processes(self, prefix='keypose'):
        """Ids of processes whose program lies in this installation, by program name or guardian name."""
        found = {}
        for entry in pathlib.Path('/proc').iterdir():
            if not entry.name.isdigit():
                continue
            try:
                program = os.readlink(entry / 'exe')
                name = (entry / 'comm').read_text().strip()
            except OSError:
                continue
            if program.startswith(str(self.root / 'bin' / prefix)):
                found[int(entry.name)] = name
        return found

    def results(self):
        out = self.folder / 'out'
        return {str(path.relative_to(out)): path.read_bytes() for path in out.rglob('*') if path.is_file()} if out.exists() else {}

    def cache_files(self):
        return sorted(path for path in (self.folder / '.keypose/cache').rglob('*') if path.is_file())


def kill(pid, number=signal.SIGKILL):
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


def flip(path, chance):
    data = bytearray(path.read_bytes())
    if not data:
        return
    at = chance.randrange(len(data))
    data[at] ^= 1 << chance.randrange(8)
    with open(path, 'r+b') as file:  # in place, like a faulty disk
        file.write(data)


# Each fault disturbs a running run, or a project at rest. It returns after the disturbed run has ended.

def under_way(disturb, longest=0.45):
    def fault(project, chance):
        runner = project.start()
        time.sleep(chance.uniform(0.0, longest))
        disturb(project, chance, runner)
        runner.communicate(timeout=120)
    return fault


def at_rest(disturb, without_results=False):
    """@param without_results  delete out/ too, so that damage in the cache would reach it"""
    def fault(project, chance):
        code, text = project.run()
        assert code == 0, text
        disturb(project, chance)
        if without_results:
            shutil.rmtree(project.folder / 'out')
    return fault


def kill_named(names, also_runner):
    def disturb(project, chance, runner):
        for pid, name in project.processes().items():
            if name in names:
                kill(pid)
        if also_runner:
            kill(runner.pid)
    return under_way(disturb)


def signal_runner(number):
    return under_way(lambda project, chance, runner: kill(runner.pid, number))


def any_photo(project, chance):
    return project.folder / f'photos/{chance.choice(POSES)}/IMG_{chance.randrange(4)}.jpg'


def change_and_put_back(project, chance, runner):
    photo = any_photo(project, chance)
    text, stat = photo.read_text(), photo.stat()
    photo.write_text('something else\n')
    time.sleep(chance.uniform(0.0, 0.1))
    photo.write_text(text)
    if chance.random() < 0.5:
        os.utime(photo, ns=(stat.st_atime_ns, stat.st_mtime_ns))  # simulates a clock turned back, or a program that preserves times


def remove_and_put_back(project, chance, runner):
    photo = any_photo(project, chance)
    photo.rename(project.root / 'aside')
    time.sleep(chance.uniform(0.0, 0.1))
    (project.root / 'aside').rename(photo)


def swap_and_put_back(project, chance, runner):
    a, b = (project.folder / f'photos/rest/IMG_{number}.jpg' for number in chance.sample(range(4), 2))

    def swap():
        a.rename(project.root / 'aside')
        b.rename(a)
        (project.root / 'aside').rename(b)
    swap()
    time.sleep(chance.uniform(0.0, 0.1))
    swap()


def extra_for_a_moment(project, chance, runner):
    photo = project.folder / 'photos/rest/IMG_9.jpg'
    photo.write_text('a stranger\n')
    time.sleep(chance.uniform(0.0, 0.1))
    photo.unlink()


def replace_program(project, chance, runner):
    program = project.root / f'bin/keypose-{chance.choice(("gather", "join", "merge"))}'
    shutil.copy(program, project.root / 'new')
    os.replace(project.root / 'new', program)


def flip_cache_under_way(project, chance, runner):
    try:
        files = project.cache_files()
        if files:
            flip(chance.choice(files), chance)
    except FileNotFoundError:
        pass


def flip_cache(project, chance):
    flip(chance.choice(project.cache_files()), chance)


def remove_cache_file(project, chance):
    chance.choice(project.cache_files()).unlink()


def swap_artifacts(project, chance):
    folders = sorted({path.parent for path in (project.folder / '.keypose/cache').rglob('manifest.json')})
    a, b = chance.sample(folders, 2)
    a.rename(project.root / 'aside')
    b.rename(a)
    (project.root / 'aside').rename(b)


def spoil_result(project, chance):
    path = project.folder / 'out' / chance.choice(sorted(project.results()))
    project.spoilt_results.add(str(path.relative_to(project.folder / 'out')))
    if chance.random() < 0.3:
        path.unlink()
    else:
        flip(path, chance)


def spoil_state(project, chance):
    state = project.folder / '.keypose'
    files = [state / name for name in ('hashes.json', 'out.json', 'stages.json', 'lock')] + sorted((state / 'steps').rglob('*.json')) + sorted((state / 'runs').glob('*.json'))
    path = chance.choice([file for file in files if file.exists()])  # hashes of very new files are not stored
    damage = chance.randrange(4)
    if damage == 0:
        path.unlink()
    elif damage == 1:
        path.write_bytes(path.read_bytes()[:chance.randrange(40)])
    elif damage == 2:
        path.write_text(chance.choice(('null', '[]', '{"a": [1, 2]}', '7', '\x00' * 100, '{"schema": "x", "steps": 3, "pid": "p"}')))
    else:
        flip(path, chance)


def old_clock(project, chance):
    """Gives photographs past or future times, some with other content of the same size.

    The next run must use the new content.
    """
    photo = any_photo(project, chance)
    stat = photo.stat()
    text = photo.read_text()
    code, output = None, None
    photo.write_text(text.replace('picture', 'PICTURE'))
    os.utime(photo, ns=(stat.st_atime_ns, stat.st_mtime_ns))
    code, output = project.run()
    assert code == 0, output
    pose = photo.parent.name
    assert 'made' in output, 'the changed photograph was not noticed: ' + output
    photo.write_text(text)
    os.utime(photo, ns=(0, chance.choice((0, 10 ** 18, 4 * 10 ** 18))))


def two_runs(project, chance):
    first = project.start()
    time.sleep(chance.uniform(0.0, 0.45))
    second = project.start()
    text, _ = second.communicate(timeout=120)
    assert second.returncode in (0, 7), text
    first.communicate(timeout=120)
    assert first.returncode == 0


def disk_full(project, chance):
    small = project.root / 'small'
    small.mkdir()
    subprocess.run(['mount', '-t', 'tmpfs', '-o', f'size={chance.randrange(60, 200)}k', 'keypose-faults', small], check=True)
    project.mounted = small
    shutil.copytree(project.folder, small / 'hero')
    project.folder = small / 'hero'
    code, text = project.run()
    assert code in (0, 4), f'exit code {code} on a full disk: {text}'
    subprocess.run(['mount', '-o', 'remount,size=16m', small], check=True)


GUARDIANS = {'kp-guardian': 'guardian', 'kp-watcher': 'its guardian'}
KINDS = {
    'runner killed': ('kill -9', 'nothing half-made; no process left', kill_named((), True)),
    'stage killed': ('kill -9', 'the step fails, the next run makes it', kill_named(('keypose-gather', 'keypose-join', 'keypose-merge'), False)),
    'guardian killed': ('kill -9', 'the step fails; no process left', kill_named(('kp-guardian',), False)),
    'watcher killed': ('kill -9 of the guardian\'s guardian', 'the step fails; no process left', kill_named(('kp-watcher',), False)),
    'runner and guardian killed': ('kill -9', 'no process left', kill_named(('kp-guardian',), True)),
    'runner and watcher killed': ('kill -9', 'no process left', kill_named(('kp-watcher',), True)),
    'runner and stage killed': ('kill -9', 'no process left', kill_named(('keypose-gather', 'keypose-join', 'keypose-merge'), True)),
    'killall -9 keypose': ('all processes of that name', 'no process left', kill_named(('keypose',), True)),
    'SIGINT': ('to the runner', 'exit code 130, nothing half-made', signal_runner(signal.SIGINT)),
    'SIGTERM': ('to the runner', 'exit code 130, nothing half-made', signal_runner(signal.SIGTERM)),
    'SIGHUP': ('to the runner', 'exit code 130, nothing half-made', signal_runner(signal.SIGHUP)),
    'photograph changed and put back': ('under way; half of them with their old time', 'what was read is not kept', under_way(change_and_put_back, 0.2)),
    'photograph removed and put back': ('renamed away and back, under way', 'what was read is not kept', under_way(remove_and_put_back, 0.2)),
    'photographs swapped and put back': ('under way', 'what was read is not kept', under_way(swap_and_put_back, 0.2)),
    'photograph too many for a moment': ('under way', 'what was read is not kept', under_way(extra_for_a_moment, 0.2)),
    'stage program replaced': ('by a new file, under way', 'asked and run again', under_way(replace_program)),
    'cache bit flipped under way': ('in place', 'made anew', under_way(flip_cache_under_way)),
    'cache bit flipped': ('in place, at rest', 'made anew, and said', at_rest(flip_cache, True)),
    'cache file removed': ('at rest', 'made anew, and said', at_rest(remove_cache_file, True)),
    'cache folders swapped': ('at rest', 'made anew, and said', at_rest(swap_artifacts, True)),
    'result changed or removed': ('a bit flipped, or removed, at rest', 'put back; the changed one stays as NAME.mine', at_rest(spoil_result)),
    'state file damaged': ('cut, emptied, flipped, other types, at rest', 'a memory is lost, no result', at_rest(spoil_state)),
    'clock turned back': ('content changed with its old time; times of 1970 and 2096', 'the change is seen', at_rest(old_clock)),
    'two runs at once': ('at a random distance', 'one runs, the other ends with 7 or finds all done', two_runs),
    'disk full': ('a tmpfs of 60 to 200 kB', 'exit code 4; goes on when there is room', disk_full),
}


def inject(build, work, kind, number, seed, reference):
    """@return what went wrong, or None"""
    chance = random.Random(f'{seed} {kind} {number}')
    root = pathlib.Path(tempfile.mkdtemp(prefix='fault_', dir=work))
    project = Project(build, root)
    project.mounted = None
    try:
        KINDS[kind][2](project, chance)
        code, text = project.run()
        if code != 0:
            return f'the next run ended with {code}: {text[-500:]}'
        results = project.results()
        for name in project.spoilt_results:
            results.pop(name + '.mine', None)
        if results != reference:
            names = sorted(name for name in set(results) | set(reference) if results.get(name) != reference.get(name))
            return f'other results: {names[:5]}'
        verify = project.command('verify')
        if verify.returncode != 0:
            return f'verify: {verify.stdout[-500:]}'
        deadline = time.monotonic() + 2
        while project.processes() and time.monotonic() < deadline:
            time.sleep(0.05)
        if project.processes():
            return f'processes left: {project.processes()}'
        litter = [str(path.relative_to(project.folder)) for path in project.folder.rglob('*') if '.tmp' in path.name or '.partial' in path.name]
        return f'litter: {litter[:5]}' if litter else None
    except Exception as error:  # any exception is a failure of this injection, not of the matrix
        return f'{type(error).__name__}: {str(error)[-600:]}'
    finally:
        for pid in project.processes():
            kill(pid)
        if project.mounted:
            subprocess.run(['umount', '-l', project.mounted], check=False)
        shutil.rmtree(root, ignore_errors=True)


def can_mount(work):
    folder = pathlib.Path(tempfile.mkdtemp(dir=work))
    if subprocess.run(['mount', '-t', 'tmpfs', 'keypose-faults', folder], stderr=subprocess.DEVNULL).returncode != 0:
        return False
    subprocess.run(['umount', folder], check=True)
    return True


def reference_results(build, work):
    project = Project(build, pathlib.Path(tempfile.mkdtemp(prefix='reference_', dir=work)))
    code, text = project.run()
    assert code == 0, text
    return project.results()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--build', default='build/release')
    parser.add_argument('--count', type=int, default=1000)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--jobs', type=int, default=4)
    parser.add_argument('--kinds', default=','.join(KINDS))
    parser.add_argument('--work')
    parser.add_argument('--json')
    args = parser.parse_args()
    build = pathlib.Path(args.build).resolve()
    work = pathlib.Path(args.work or tempfile.mkdtemp(prefix='fault_matrix_'))
    work.mkdir(parents=True, exist_ok=True)
    kinds = args.kinds.split(',')
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        parser.error(f'unknown fault {unknown[0]}; there are {", ".join(KINDS)}')
    if 'disk full' in kinds and not can_mount(work):
        print('disk full is left out: no permission to mount a tmpfs', file=sys.stderr)
        kinds.remove('disk full')
    reference = reference_results(build, work)
    done, failures = {kind: 0 for kind in kinds}, {kind: [] for kind in kinds}
    # Processes, not threads: if a thread starts a program while another thread copies one, the copy stays open
    # in the child, and it cannot be executed.
    with concurrent.futures.ProcessPoolExecutor(args.jobs) as pool:
        waiting = {pool.submit(inject, build, work, kinds[i % len(kinds)], i // len(kinds), args.seed, reference): kinds[i % len(kinds)] for i in range(args.count)}
        for future in concurrent.futures.as_completed(waiting):
            kind, wrong = waiting[future], future.result()
            done[kind] += 1
            if wrong:
                failures[kind].append(wrong)
                print(f'{kind}: {wrong}', file=sys.stderr, flush=True)
    print('| fault | how | promised | injections | failures |\n|---|---|---|---|---|')
    for kind in kinds:
        print(f'| {kind} | {KINDS[kind][0]} | {KINDS[kind][1]} | {done[kind]} | {len(failures[kind])} |')
    bad = sum(len(wrong) for wrong in failures.values())
    print(f'\n{sum(done.values())} injections, {bad} failures')
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps({'done': done, 'failures': failures}, indent=1) + '\n')
    if not args.work:
        shutil.rmtree(work, ignore_errors=True)
    sys.exit(1 if bad else 0)


if __name__ == '__main__':
    main()
