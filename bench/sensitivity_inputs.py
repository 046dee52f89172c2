"""Starts the programs of sensitivity.py, and makes the inputs of its scenes.

Inputs are made once, with the constants as they are, and kept in the work folder. Needs
python3-numpy.
"""
import json
import math
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Refused(Exception):
    """A program ended with an error."""


class TooLong(Exception):
    """A program was ended after so many seconds of the processor, or of the clock."""

    def __init__(self, seconds):
        super().__init__(f'over {seconds:.0f} s')
        self.seconds = seconds


class Programs:
    """Starts programs with one setting of the constants, and ends those that take too long.

    @param folder  of the programs
    @param limit_s  of the processor, for each program, and a tenth of the clock's; 0: no limit
    @param environment  more variables
    @param scorers  folder of the programs that compare with the truth
    """

    def __init__(self, folder, limit_s=0, environment=None, scorers=None):
        self.folder, self.limit_s = pathlib.Path(folder), limit_s
        self.scorers = pathlib.Path(scorers or folder)
        self.environment = {**os.environ, **(environment or {})}

    def __call__(self, program, *words):
        """A program that makes inputs or scores."""
        return self.start([self.scorers / program, *words])

    def python(self, script, *words):
        return self.start([sys.executable, ROOT / script, *words])

    def stage(self, name, *words):
        return self.start([self.folder / f'keypose-{name}', *words, '--overwrite'])

    def start(self, command):
        words = [str(word) for word in command]
        child = subprocess.Popen(words, env=self.environment, stdout=subprocess.PIPE, text=True,
                                 stderr=subprocess.PIPE, start_new_session=True,
                                 preexec_fn=self.set_limit)
        try:
            out, err = child.communicate(timeout=10 * self.limit_s or None)
        except subprocess.TimeoutExpired:
            end(child)
            raise TooLong(10 * self.limit_s) from None
        except BaseException:
            end(child)
            raise
        if self.limit_s and child.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            raise TooLong(self.limit_s)
        if child.returncode != 0:
            said = (err.strip() or out.strip()).splitlines()
            name = pathlib.Path(words[1] if words[0] == sys.executable else words[0]).name
            raise Refused(f'{name}: {said[-1][-300:] if said else child.returncode}')
        return out

    def set_limit(self):
        if self.limit_s:
            limit = math.ceil(self.limit_s)
            resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))


def end(child):
    os.killpg(child.pid, signal.SIGKILL)
    child.communicate()


def seconds():
    """Of the processor, used by programs that have ended; and of the clock."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime, time.monotonic()


class Inputs:
    """Worlds with known truth, each made when it is first asked for."""

    def __init__(self, work, programs):
        self.work, self.programs = pathlib.Path(work), programs
        self.cpu_s = self.wall_s = 0.0  # that making them took
        self.making = 0

    def folder(self, name, make):
        """The folder `name`, which make(folder) fills; again, if that was interrupted."""
        folder = self.work / name
        if not (folder / 'made').exists():
            print(f'sensitivity: makes {name}', file=sys.stderr, flush=True)
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            self.count(lambda: make(folder))
            (folder / 'made').write_text('')
        return folder

    def count(self, make):
        """Calls make(), and adds the time that it takes unless another input waits for it."""
        self.making += 1
        before = seconds()
        try:
            make()
        finally:
            self.making -= 1
            if self.making == 0:
                after = seconds()
                self.cpu_s, self.wall_s = (self.cpu_s + after[0] - before[0],
                                           self.wall_s + after[1] - before[1])

    def photographs(self, name, *words):
        """Photographs of a clay character, with masks and cameras of the truth."""
        def make(folder):
            self.programs('keypose-synth', 'photos', '--output', folder, *words)
            for photos in (folder / 'photos').iterdir():
                self.programs.stage('capture', '--photos', photos, '--min_images', 2, '--images',
                                    folder / 'images' / photos.name, '--masks',
                                    folder / 'truth' / photos.name / 'masks')
        return self.folder(name, make)

    def clay(self):
        return self.photographs('clay', '--poses', 'rest', 'wave', '--few', 'wave=6', '--views', 16,
                                '--width', 480)

    def template(self):
        """The clay character's true surface with 8,000 faces, unwrapped, and its texture."""
        def make(folder):
            clay, call = self.clay(), self.programs.stage
            truth = clay / 'truth/rest'
            call('cleanup', '--surface', truth / 'surface.ply', '--faces', 8000, '--clean',
                 folder / 'clean.ply')
            call('unwrap', '--clean', folder / 'clean.ply', '--unwrapped', folder / 'mesh.obj')
            call('bake', '--mesh', folder / 'mesh.obj', '--images', clay / 'images/rest',
                 '--model', truth / 'cameras', '--texture_size', 1024, '--hold_out', 0,
                 '--texture', folder / 'texture.png')
        return self.folder('template', make)

    def fit_words(self):
        clay, template = self.clay(), self.template()
        return ['--template', template / 'mesh.obj', '--texture', template / 'texture.png',
                '--images', clay / 'images/wave', '--rig', clay / 'truth/rest/cameras']

    def animation(self):
        """The clay character from rest to its waving pose, as `fit` finds it, in five frames."""
        def make(folder):
            self.programs.stage('fit', *self.fit_words(), '--fitted', folder / 'wave.obj')
            self.programs.stage('interpolate', '--keys', self.template() / 'mesh.obj', '--keys',
                                folder / 'wave.obj', '--steps', 3, '--frames', folder / 'frames')
        return self.folder('animation', make)

    def shot(self):
        """A film of three frames: the first shows the first key, and the last the second."""
        def make(folder):
            self.programs('keypose-synth', 'shot', '--output', folder, '--shows', '0=rest',
                          '2=wave', '--width', 480, '--no-photographs', '--clean-plate',
                          '--spacing', 0.004)
        return self.folder('shot', make)

    def located(self):
        def make(folder):
            self.programs.stage('locate', *self.locate_words(), '--shot', folder / 'shot.json')
        return self.folder('located', make)

    def locate_words(self):
        shot, animation = self.shot(), self.animation()
        return ['--frames', animation / 'frames', '--textures', self.template() / 'texture.png',
                '--plate', shot / 'film', '--background', shot / 'plate.png',
                '--shows', '0=rest,2=wave', '--poses', 'rest,wave', '--focal_35mm', 50]

    def film(self):
        """A performer in four frames of eight cameras, as masks."""
        def make(folder):
            self.programs('keypose-synth', 'performance', '--output', folder, '--frames', 4,
                          '--every', 8, '--size', 160, '--noise', 0.4, '--seed', 7, '--masks-only')
        return self.folder('film', make)

    def performance(self):
        """A performer in ten frames with colours, the true surface, and the frames of `track`."""
        def make(folder):
            self.programs('keypose-synth', 'performance', '--output', folder, '--frames', 10,
                          '--every', 4, '--size', 200, '--noise', 0.4, '--seed', 7,
                          '--meshes', 0.03)
            self.programs.stage('track', *track_words(folder, folder))
        return self.folder('performance', make)

    def another_pose(self):
        """The last tracked frame as a mesh to move, with marks that pair each face with itself."""
        def make(folder):
            frame = self.performance() / 'frames/frame_0009.ply'
            points, faces = read_ply(frame)
            shutil.copy(frame, folder / 'target.ply')
            (folder / 'marks.json').write_text(marks_text(points, faces, 60))
        return self.folder('another_pose', make)


def track_words(film, to):
    return ['--video', film / 'shot', '--calibration', film / 'calibration.yml', '--actor_frames',
            1, '--sync_frames', 0, '--frames', to / 'frames', '--motion', to / 'motion.bvh']


def read_ply(path):
    """Points and faces of a binary mesh that Keypose wrote without colours."""
    data = pathlib.Path(path).read_bytes()
    at = data.index(b'end_header') + 11
    count = {}
    for line in data[:at].decode().splitlines():
        if line.startswith('element '):
            count[line.split()[1]] = int(line.split()[2])
    points = np.frombuffer(data, '<f8', 3 * count['vertex'], at).reshape(-1, 3)
    face = np.dtype([('corners', 'u1'), ('vertices', '<i4', 3)])
    return points, np.frombuffer(data, face, count['face'], at + points.nbytes)['vertices']


def marks_text(points, faces, count):
    """Landmark pairs of faces far from each other, each with itself."""
    centres = points[faces].mean(1)
    chosen = [0]
    away = np.linalg.norm(centres - centres[0], axis=1)
    while len(chosen) < count:
        chosen.append(int(away.argmax()))
        away = np.minimum(away, np.linalg.norm(centres - centres[chosen[-1]], axis=1))
    places = [{'face': face, 'barycentric': [0.2, 0.3, 0.5]} for face in chosen]
    mesh = {'vertices': len(points), 'faces': len(faces)}
    return json.dumps({'schema': 1, 'source': mesh, 'target': mesh, 'pairs': [
        {'name': f'mark-{i}', 'source': place, 'target': place} for i, place in enumerate(places)]})
