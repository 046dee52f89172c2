#!/usr/bin/env python3
"""Recording sessions with a simulated puppet, through faults and SIGKILL, compared with an undisturbed one.

    sessions_test.py BIN [TEST ...]

BIN is the folder of the programs. Needs only Python.
"""
import json
import pathlib
import queue
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

BIN = pathlib.Path()
PATIENCE_S = 60


class Talker:
    """A program whose lines are read as they come."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen([str(BIN / 'keypose-armature'), *map(str, arguments)], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines, self.seen = queue.Queue(), []
        threading.Thread(target=self.read, daemon=True).start()

    def read(self):
        for line in self.process.stdout:
            self.lines.put(line.rstrip('\n'))
        self.lines.put(None)

    def say(self, line):
        self.process.stdin.write(line + '\n')
        self.process.stdin.flush()

    def until(self, wanted):
        """The next line for which wanted(line) is true."""
        end = time.monotonic() + PATIENCE_S
        while True:
            try:
                line = self.lines.get(timeout=max(0.01, end - time.monotonic()))
            except queue.Empty:
                line = None
            if line is None:
                raise AssertionError('it did not come; the last lines: ' + ' / '.join(self.seen[-8:]))
            self.seen.append(line)
            if wanted(line):
                return line

    def end(self, how=None):
        if how is not None:
            self.process.send_signal(how)
        elif self.process.poll() is None:
            self.process.stdin.close()
        code = self.process.wait(PATIENCE_S)
        self.process.stdout.close()
        return code


class Puppet(Talker):
    def __init__(self, folder, *more):
        self.port = folder / 'port'
        super().__init__('simulate', '--description', folder / 'theropod.txt', '--link', self.port, *more)
        self.until(lambda line: 'sensors on' in line)

    def move(self, command):
        self.say(command)
        self.until(lambda line: line == 'at rest')


class Recorder(Talker):
    def __init__(self, folder, port):
        super().__init__('record', '--description', folder / 'theropod.txt', '--port', port, '--calibration',
                         folder / 'zero.json', '--session', folder / 'take', '--fps', 24, '--step', 2, '--json')
        self.events = []
        self.begin = self.event('session')

    def event(self, name):
        def wanted(line):
            self.events.append(json.loads(line) if line.startswith('{') else {'event': line})
            return self.events[-1]['event'] == name
        self.until(wanted)
        return self.events[-1]

    def record(self):
        self.say('record')
        return self.event('recorded')['frame']

    def heard(self, name):
        return [event for event in self.events if event['event'] == name]


def run(*arguments, typed=''):
    done = subprocess.run([str(BIN / 'keypose-armature'), *map(str, arguments)], input=typed, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S)
    return done.returncode, done.stdout


class Sessions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.example = tempfile.TemporaryDirectory()
        assert run('example', '--folder', cls.example.name)[0] == 0

    @classmethod
    def tearDownClass(cls):
        cls.example.cleanup()

    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory()
        self.talkers = []

    def tearDown(self):
        for talker in self.talkers:
            if talker.process.poll() is None:
                talker.process.kill()
                talker.process.wait()
            talker.process.stdin.close()
            talker.process.stdout.close()
        self.scratch.cleanup()

    def keep(self, talker):
        self.talkers.append(talker)
        return talker

    def folder(self, name):
        folder = pathlib.Path(self.scratch.name) / name
        folder.mkdir()
        shutil.copy(pathlib.Path(self.example.name) / 'theropod.txt', folder)
        return folder

    def calibrate(self, folder, puppet, *more):
        code, said = run('calibrate', '--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration',
                         folder / 'zero.json', '--yes', *more)
        self.assertEqual(code, 0, said)
        return said

    def files(self, folder):
        return {name: (folder / 'take' / name).read_bytes() for name in ('curves.json', 'curves.csv', 'curves.bvh', 'flipbook.svg')}

    def undisturbed(self, frames):
        folder = self.folder('undisturbed')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        recorder = self.keep(Recorder(folder, puppet.port))
        for frame in range(frames):
            puppet.move(f'frame {frame}')
            self.assertEqual(recorder.record(), frame)
        recorder.say('end')
        recorder.event('ended')
        self.assertEqual(recorder.end(), 0)
        self.assertEqual([event for event in recorder.events if event['event'] not in ('session', 'recorded', 'ended')], [])
        puppet.say('end')
        puppet.end()
        return self.files(folder)

    def test_sixty_frames_through_five_faults_give_the_undisturbed_curves(self):
        self.disturb(60, 'drop@8,noise@12,glitch:tailBend3@16,drop@27,noise@33,unplug@50,glitch:rigLift@55', stuck=20, power=35, killed=45)

    def test_twelve_frames_through_five_faults_give_the_undisturbed_curves(self):
        self.disturb(12, 'drop@1,noise@2,glitch:tailBend3@3,unplug@11', stuck=4, power=8, killed=9)

    def disturb(self, frames, faults, stuck, power, killed):
        wanted = self.undisturbed(frames)
        folder = self.folder('disturbed')
        # Counters wrap from the start; the line loses and changes bytes; a counter shows nonsense.
        puppet = self.keep(Puppet(folder, '--faults', f'wrap@0,stuck:leftKneeBend@{stuck},{faults}'))
        self.calibrate(folder, puppet, '--keep-counters')
        recorder = self.keep(Recorder(folder, puppet.port))
        frame, named = 0, False
        while frame < frames:
            if frame == power:  # at rest, the box loses its power
                puppet.say('fault power')
                recorder.event('power-lost')
            if frame == killed:
                puppet.say(f'frame {frame}')  # killed while the puppet moves
                recorder.end(signal.SIGKILL)
                puppet.until(lambda line: line == 'at rest')
                recorder = self.keep(Recorder(folder, puppet.port))
                self.assertEqual(recorder.begin['at'], killed)
            else:
                puppet.move(f'frame {frame}')
            self.assertEqual(recorder.record(), frame)
            frame += 1
            if frame == stuck + 3 and not named:
                named = True
                # The stuck encoder is named; it is mended, zeroed, and its frames are taken again.
                still = recorder.event('still-joint')
                self.assertEqual((still['joint'], still['since']), ('leftKneeBend', stuck))
                puppet.say('mend leftKneeBend')
                puppet.move('put leftKneeBend 0')
                recorder.say('zero leftKneeBend')
                recorder.event('set')
                recorder.say(f"goto {still['since']}")
                self.assertEqual(recorder.event('at')['at'], stuck)
                frame = stuck
        self.assertTrue(named)
        self.assertEqual(len(recorder.heard('cable-out')), 1)
        self.assertEqual(len(recorder.heard('cable-back')), 1)
        recorder.say('end')
        self.assertEqual(recorder.event('ended')['event'], 'ended')
        for name, content in self.files(folder).items():
            self.assertEqual(content, wanted[name], name)

    def test_a_cut_off_journal_is_taken_up_at_its_last_whole_line(self):
        wanted = self.undisturbed(4)
        folder = self.folder('cut')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        recorder = self.keep(Recorder(folder, puppet.port))
        for frame in range(3):
            puppet.move(f'frame {frame}')
            recorder.record()
        recorder.end(signal.SIGKILL)
        journal = folder / 'take' / 'journal.jsonl'
        journal.write_bytes(journal.read_bytes()[:-40])
        recorder = self.keep(Recorder(folder, puppet.port))
        self.assertEqual(recorder.begin['at'], 2)
        self.assertIn('cut off', recorder.begin['words'])
        for frame in (2, 3):
            puppet.move(f'frame {frame}')
            self.assertEqual(recorder.record(), frame)
        recorder.say('end')
        recorder.event('ended')
        self.assertEqual(self.files(folder), wanted)

    def test_a_drifted_joint_is_named_after_a_restart(self):
        folder = self.folder('drift')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        puppet.move('frame 3')
        puppet.move('zero')
        verify = ('calibrate', '--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration',
                  folder / 'zero.json', '--yes', '--verify')
        code, said = run(*verify)
        self.assertEqual(code, 0, said)
        self.assertIn('0 of 74 joints are not at zero', said)
        puppet.move('put tailSide4 1.5')
        puppet.move('put leftHipBend 0.1')
        code, said = run(*verify)
        self.assertEqual(code, 6, said)
        self.assertIn('drifted by more than 0.5 degrees: tailSide4;', said)
        self.assertIn('2 of 74 joints are not at zero', said)

    def test_gears_are_found_and_written(self):
        folder = self.folder('gears')
        puppet = self.keep(Puppet(folder, '--gear-error', 0.02))
        self.calibrate(folder, puppet)
        (folder / 'known.txt').write_text('leftKneeBend 30 60 90  # by a square\njaw -20\n')
        calibrator = self.keep(Talker('calibrate', '--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration',
                                      folder / 'zero.json', '--known', folder / 'known.txt', '--written', folder / 'better.txt'))
        for joint, angle in (('leftKneeBend', 30), ('leftKneeBend', 60), ('leftKneeBend', 90), ('jaw', -20)):
            calibrator.until(lambda line: line.startswith(f'put {joint} to {angle} degrees'))
            puppet.move(f'put {joint} {angle}')
            calibrator.say('')
        self.assertEqual(calibrator.end(), 0)
        was, now = (folder / 'theropod.txt').read_text().splitlines(), (folder / 'better.txt').read_text().splitlines()
        changed = [(a, b) for a, b in zip(was, now) if a != b]
        self.assertEqual(len(was), len(now))
        self.assertEqual(len(changed), 2)
        for before, after in changed:
            ratio = float(after.split()[1]) / float(before.split()[1])
            self.assertTrue(0.98 <= ratio <= 1.02 and ratio != 1, (before, after))
        # With the better description the knee is read where it was put.
        puppet.move('put leftKneeBend 45')
        recorder = self.keep(Talker('record', '--description', folder / 'better.txt', '--port', puppet.port, '--calibration',
                                    folder / 'zero.json', '--session', folder / 'take', '--json'))
        recorder.say('record')
        recorder.until(lambda line: '"recorded"' in line)
        knee = json.loads((folder / 'take/curves.json').read_text())['joints']['leftKneeBend']['values'][0]
        self.assertAlmostEqual(knee * 180 / 3.141592653589793, 45, delta=0.02)

    def test_ports_that_cannot_be_used_are_named(self):
        folder = self.folder('ports')
        common = ('--description', folder / 'theropod.txt', '--calibration', folder / 'zero.json')
        code, said = run('calibrate', *common, '--yes', '--port', folder / 'nowhere')
        self.assertEqual(code, 5, said)
        self.assertIn('nowhere cannot be opened: No such file or directory; plug in', said)
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        recorder = self.keep(Recorder(folder, puppet.port))
        code, said = run('record', *common, '--port', puppet.port, '--session', folder / 'other')
        self.assertEqual(code, 5, said)
        self.assertIn('Device or resource busy; end the other program', said)
        self.assertFalse((folder / 'other').exists())
        code, said = run('record', *common, '--port', 'simulated', '--session', folder / 'take', '--step', 2)
        self.assertEqual(code, 7, said)
        recorder.say('end')
        recorder.event('ended')
        recorder.end()
        code, said = run('record', *common, '--port', puppet.port, '--session', folder / 'take', '--step', 1)
        self.assertEqual(code, 3, said)
        self.assertIn('journal.jsonl, line 1: the session was begun with 24.0 frames a second, step 2', said)

    def test_dead_sensors_are_named_by_a_wiggle(self):
        folder = self.folder('wiggle')
        puppet = self.keep(Puppet(folder, '--faults', 'stuck:jaw@1'))
        self.calibrate(folder, puppet)
        wiggle = self.keep(Talker('calibrate', '--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration',
                                  folder / 'zero.json', '--wiggle'))
        wiggle.until(lambda line: 'press Enter' in line)
        puppet.move('frame 1')
        puppet.move('frame 6')
        wiggle.until(lambda line: line.endswith(' 1 to go'))
        wiggle.say('')
        wiggle.until(lambda line: 'these sensors have not moved: jaw;' in line)
        self.assertEqual(wiggle.end(), 6)

    def test_a_wiggle_comes_before_the_first_zero_and_leaves_no_calibration(self):
        folder = self.folder('first')
        puppet = self.keep(Puppet(folder))
        common = ('--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration', folder / 'zero.json')
        wiggle = self.keep(Talker('calibrate', *common, '--wiggle'))
        wiggle.until(lambda line: 'press Enter' in line)
        puppet.move('frame 1')
        puppet.move('frame 6')
        self.assertEqual(wiggle.process.wait(PATIENCE_S), 0)
        self.assertFalse((folder / 'zero.json').exists())
        # A calibration that was begun and not ended is none.
        asking = self.keep(Talker('calibrate', *common))
        asking.until(lambda line: 'press Enter' in line)
        time.sleep(1.3)
        self.assertEqual(asking.end(signal.SIGINT), 130)
        self.assertFalse((folder / 'zero.json').exists())

    def test_calibrated_again_it_fits_a_description_with_another_sensor(self):
        folder = self.folder('moved')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        text = (folder / 'theropod.txt').read_text()
        for one, other in (('sensor 3\n', 'sensor X\n'), ('sensor 4\n', 'sensor 3\n'), ('sensor X\n', 'sensor 4\n')):
            self.assertEqual(text.count(one), 1)
            text = text.replace(one, other)
        (folder / 'theropod.txt').write_text(text)
        record = ('record', '--description', folder / 'theropod.txt', '--port', puppet.port, '--calibration', folder / 'zero.json',
                  '--session', folder / 'take')
        code, said = run(*record, typed='end\n')
        self.assertEqual(code, 3, said)
        self.assertIn('calibrate again', said)
        self.assertIn('new in the description, or on another sensor than before: ', self.calibrate(folder, puppet))
        code, said = run(*record, typed='end\n')
        self.assertEqual(code, 0, said)

    def test_a_simulated_puppet_leaves_the_calibration_of_a_real_one_alone(self):
        folder = self.folder('simulated')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        before = (folder / 'zero.json').read_bytes()
        code, said = run('record', '--description', folder / 'theropod.txt', '--port', 'simulated', '--calibration',
                         folder / 'zero.json', '--session', folder / 'take', '--frames', 2)
        self.assertEqual(code, 0, said)
        code, said = run('calibrate', '--description', folder / 'theropod.txt', '--port', 'simulated', '--calibration',
                         folder / 'zero.json', '--yes')
        self.assertEqual(code, 0, said)
        self.assertIn('stays as it is', said)
        self.assertEqual((folder / 'zero.json').read_bytes(), before)

    def test_a_puppet_that_does_not_come_to_rest_is_told_of(self):
        folder = self.folder('restless')
        puppet = self.keep(Puppet(folder))
        self.calibrate(folder, puppet)
        puppet.move('frame 0')
        recorder = self.keep(Recorder(folder, puppet.port))
        puppet.say('play 12')
        recorder.say('record')
        self.assertIn(' does not come to rest; the frame is taken when that is over', recorder.event('waiting')['words'])

    def test_it_records_by_itself_without_hardware(self):
        folder = self.folder('alone')
        code, said = run('record', '--description', folder / 'theropod.txt', '--port', 'simulated', '--session', folder / 'take',
                         '--frames', 5, '--step', 2)
        self.assertEqual(code, 0, said)
        curves = json.loads((folder / 'take/curves.json').read_text())
        self.assertEqual((curves['frames'], len(curves['joints'])), (5, 74))


if __name__ == '__main__':
    BIN = pathlib.Path(sys.argv[1])
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]], verbosity=2)
