#!/usr/bin/env python3
"""A second pose from six photographs, from `keypose init` to the animation.

    few_photographs.py --bin build/release/bin [--work DIR] [--views 24] [--width 640]

Renders the clay creature, at rest from all round and waving in six photographs, makes a project, runs it, and checks:

    - `init` says that the pose will be fitted, and writes `method: fit`,
    - the run ends with an animation, and no verdict is "wrong",
    - the bent template has the template's faces, and is within --most of the diagonal from the exact pose (mean over
      its vertices),
    - with one of the six photographs taken again, only the pose's own steps and what takes them run,
    - photographs of another character are refused in words, with exit code 3 or by the verdict "wrong".

Prints what it measured. Exit code 1 if a check fails. With --work, the folder is kept and rendered photographs are
used again. Needs only Python.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time


class Walk:
    def __init__(self, programs, work, args):
        self.programs, self.work, self.args = programs, work, args
        self.project = work / 'puppet'
        self.failed = []

    def check(self, good, words):
        print(('ok      ' if good else 'FAILED  ') + words, flush=True)
        if not good:
            self.failed.append(words)

    def keypose(self, *words):
        done = subprocess.run([self.programs / 'keypose', *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout

    def must(self, *words):
        code, text = self.keypose(*words)
        if code:
            sys.exit(f'keypose {" ".join(map(str, words))}: exit code {code}\n{text}')
        return text

    def photograph(self, name, *more):
        """@return the folder with photos/ and truth/"""
        world = self.work / name
        if not (world / 'truth').is_dir():
            self.must('synth', 'photos', '--output', world, '--views', self.args.views, '--width', self.args.width, *more)
        return world

    def run(self):
        """@return exit code, ids of the steps that ran, verdicts by pose"""
        code, text = self.keypose('run', '-C', self.project, '--progress', 'jsonl')
        events = [json.loads(line) for line in text.splitlines() if line.startswith('{')]
        ran = sorted({event['step'] for event in events if event['event'] == 'start'})
        verdicts = {event['about']: event['grade'] for event in events if event['event'] == 'verdict'}
        if code:
            print(text[-2000:])
        return code, ran, verdicts

    def make(self, world):
        poses = [f'{pose}={world / "photos" / pose}' for pose in ('rest', 'wave')]
        text = self.must('init', self.project, '--pose', poses[0], '--pose', poses[1])
        self.check("'rest' will be bent into them" in text, 'init says that the pose will be fitted')
        self.check('wave: {photos: photos/wave, method: fit}' in (self.project / 'pipeline.yaml').read_text(), 'and writes it down')

    def first_run(self, world):
        start = time.monotonic()
        code, ran, verdicts = self.run()
        self.check(code == 0, f'the run ends well ({time.monotonic() - start:.0f} s)')
        self.check('fit/wave' in ran and not {'sfm/wave', 'dense/wave', 'register/wave'} & set(ran), 'the pose is fitted, not scanned')
        self.check((self.project / 'out/animation/character.glb').is_file(), 'there is an animation')
        self.check(set(verdicts) >= {'rest', 'wave'} and 'wrong' not in verdicts.values(), f'no verdict is wrong: {verdicts}')
        error = self.error(world)
        self.check(error < self.args.most, f'vertices are {100 * error:.2f} % of the diagonal from the exact pose (mean; at most {100 * self.args.most:.2f} %)')

    def error(self, world):
        """Mean distance of the bent template's vertices from their exact places, over the diagonal."""
        out = self.project / 'out'
        report = json.loads(self.must('synth', 'score', '--truth', world / 'truth/wave', '--model', out / 'wave/model', '--mesh', out / 'wave/mesh.obj',
                                      '--registered', out / 'wave/mesh.obj', '--template-truth', world / 'truth/rest', '--template-model', out / 'rest/model',
                                      '--template-mesh', out / 'rest/mesh.obj'))
        return report['correspondence_refined']['mean']

    def photograph_again(self):
        """The same camera, light and pose, with other noise: another file, nearly the same picture."""
        again = self.photograph('again', '--poses', 'wave', '--few', 'wave=6', '--noise', '1.5')
        shutil.copy(again / 'photos/wave/IMG_0003.jpg', self.project / 'photos/wave/IMG_0003.jpg')
        text = self.must('explain', '-C', self.project, 'fit/wave')
        self.check('photos/wave/IMG_0003.jpg changed' in text, 'explain names the photograph that was taken again')
        code, ran, _ = self.run()
        self.check(code == 0, 'the run with the new photograph ends well')
        own = {'capture/wave', 'fit/wave', 'bake/wave', 'complete/wave', 'complete/rest', 'interpolate', 'export', 'report'}
        self.check('fit/wave' in ran and set(ran) <= own, f'only the pose\'s own steps and what takes them ran: {", ".join(ran)}')
        code, ran, _ = self.run()
        self.check(code == 0 and not ran, 'a second run has nothing to do')

    def show_another(self):
        """Six photographs of another character in the pose's folder."""
        other = self.photograph('other', '--poses', 'bow', '--few', 'bow=6', '--seed', '5')
        for i in range(1, 7):
            shutil.copy(other / f'photos/bow/IMG_{i:04}.jpg', self.project / f'photos/wave/IMG_{i:04}.jpg')
        code, _, verdicts = self.run()
        refused = code == 3 or (code == 0 and verdicts.get('wave') == 'wrong')
        self.check(refused, f'photographs of another character are refused (exit code {code}, verdict {verdicts.get("wave", "none")})')

    def all(self):
        world = self.photograph('world', '--poses', 'rest,wave', '--few', 'wave=6')
        if self.project.exists():
            shutil.rmtree(self.project)
        self.make(world)
        self.first_run(world)
        self.photograph_again()
        self.show_another()
        return 1 if self.failed else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bin', type=pathlib.Path, required=True)
    parser.add_argument('--work', type=pathlib.Path)
    parser.add_argument('--views', type=int, default=24)
    parser.add_argument('--width', type=int, default=640)
    parser.add_argument('--most', type=float, default=0.005, help='largest mean error / diagonal')
    args = parser.parse_args()
    if args.work:
        return Walk(args.bin.resolve(), args.work.resolve(), args).all()
    with tempfile.TemporaryDirectory() as work:
        return Walk(args.bin.resolve(), pathlib.Path(work), args).all()


if __name__ == '__main__':
    sys.exit(main())
