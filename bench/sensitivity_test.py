#!/usr/bin/env python3
"""Tests sensitivity.py with scenes and programs whose figures are known.

    sensitivity_test.py
"""
import json
import math
import pathlib
import sys
import tempfile
import time
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import sensitivity
import sensitivity_page
from sensitivity_inputs import Inputs, Programs, Refused, TooLong, marks_text, read_ply
from sensitivity_scenes import Scene, mean_distance, place_error

import numpy as np

# Notes its call, tells which constants it read, and prints the figure: 1, plus what the setting is.
PROGRAM = '''#!/bin/sh
echo "$KEYPOSE_TUNED" >> {calls}
if [ -n "$KEYPOSE_TUNED_READ" ]; then for name in {reads}; do echo "../src/$name" >> "$KEYPOSE_TUNED_READ"; done; fi
case "$KEYPOSE_TUNED" in
  *kRefuses=*) echo "nothing to see" >&2; exit 3;;
  *kHangs=*) while true; do :; done;;
  *=*) echo "1 + ${{KEYPOSE_TUNED#*=}}";;
  *) echo 1;;
esac
'''


def constant(file, name, value, whole=False):
    return {'id': f'{file}:{name}', 'file': file, 'name': name, 'struct': 'T', 'value': value, 'whole': whole,
            'comment': 'of a test'}


KNOWN = [constant('a/x.cpp', 'kRead', 4.0), constant('a/x.cpp', 'kUnread', 1.0), constant('a/x.cpp', 'kWhole', 1.0, True),
         constant('b/y.cpp', 'kElsewhere', 2.0)]
READS = 'a/x.cpp:kRead a/x.cpp:kWhole'


class Case(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.calls, self.file = self.folder / 'calls.txt', self.folder / 'results.jsonl'
        self.inputs = Inputs(self.folder / 'work', Programs(self.folder))
        self.interrupt_at = math.inf
        self.write_program('stage-a', READS)

    def write_program(self, name, reads, more=''):
        path = self.folder / name
        path.write_text(PROGRAM.format(calls=self.calls, reads=reads) + more)
        path.chmod(0o755)

    def scene(self, name, program, rooms):
        def measure(_, programs, to):
            if len(self.settings()) + 1 == self.interrupt_at:
                raise KeyboardInterrupt
            return float(eval(programs.start([programs.folder / program])))
        return Scene(name, rooms, (program,), 'figure of ' + name, measure)

    def first(self):
        return [self.scene('first', 'stage-a', ('a/',))]

    def settings(self):
        return self.calls.read_text().splitlines() if self.calls.exists() else []

    def run_all(self, known=KNOWN, wanted=None, scenes=None, **more):
        scenes = scenes or self.first()
        results = sensitivity.Results(self.file)
        run = sensitivity.Run(scenes, known, results, self.inputs, self.folder, **more)
        run.all(wanted or {c['id'] for c in known})
        return sensitivity_page.read_results(self.file)


class Resuming(Case):
    def test_each_constant_that_the_scene_reads_is_halved_and_doubled(self):
        rows = self.run_all()
        self.assertEqual(self.settings(), ['', 'a/x.cpp:kRead=2.0', 'a/x.cpp:kRead=8.0', 'a/x.cpp:kWhole=1', 'a/x.cpp:kWhole=2'])
        self.assertEqual([row['error'] for row in rows], [1, 3, 9, 2, 3])
        self.assertEqual(rows[0]['read'], ['a/x.cpp:kRead', 'a/x.cpp:kWhole'])

    def test_an_interrupted_run_loses_nothing_and_goes_on(self):
        self.interrupt_at = 4
        with self.assertRaises(KeyboardInterrupt):
            self.run_all()
        self.assertEqual(len(sensitivity_page.read_results(self.file)), 3)
        self.interrupt_at = math.inf
        self.run_all()
        self.assertEqual(self.settings(), ['', 'a/x.cpp:kRead=2.0', 'a/x.cpp:kRead=8.0', 'a/x.cpp:kWhole=1', 'a/x.cpp:kWhole=2'])

    def test_a_line_that_was_cut_off_is_measured_again(self):
        self.run_all()
        self.file.write_text(self.file.read_text()[:-20])
        rows = self.run_all()
        self.assertEqual(self.settings()[5:], ['a/x.cpp:kWhole=2'])
        self.assertEqual([row['error'] for row in rows], [1, 3, 9, 2, 3])

    def test_another_value_or_another_build_is_measured_again(self):
        self.run_all()
        other = [constant('a/x.cpp', 'kRead', 6.0), *KNOWN[1:]]
        self.run_all(known=other)
        self.assertEqual(self.settings()[5:], ['a/x.cpp:kRead=3.0', 'a/x.cpp:kRead=12.0'])
        self.write_program('stage-a', READS, '# another build\n')
        self.run_all(known=other, any_build=True)
        self.assertEqual(len(self.settings()), 7)
        self.run_all(known=other)
        self.assertEqual(len(self.settings()), 12)

    def test_no_measurement_begins_after_the_deadline(self):
        with self.assertRaises(sensitivity.OutOfTime):
            self.run_all(deadline=time.monotonic() - 1)
        self.assertEqual(self.settings(), [])

    def test_a_constant_is_measured_by_the_first_scene_that_reads_it(self):
        self.write_program('stage-b', READS + ' a/x.cpp:kUnread b/y.cpp:kElsewhere')
        scenes = [self.scene('first', 'stage-a', ('a/',)), self.scene('second', 'stage-b', ('a/', 'b/')),
                  self.scene('absent', 'stage-c', ('b/',))]
        rows = self.run_all(scenes=scenes)
        self.assertEqual([(row['scene'], row['id']) for row in rows if row['kind'] == 'half'],
                         [('first', 'a/x.cpp:kRead'), ('first', 'a/x.cpp:kWhole'), ('second', 'a/x.cpp:kUnread'), ('second', 'b/y.cpp:kElsewhere')])

    def test_only_what_is_asked_for_is_measured(self):
        self.run_all(wanted={'a/x.cpp:kWhole'})
        self.assertEqual(self.settings(), ['', 'a/x.cpp:kWhole=1', 'a/x.cpp:kWhole=2'])

    def test_a_stage_that_refuses_or_hangs_is_said(self):
        known = [constant('a/x.cpp', 'kRefuses', 1.0), constant('a/x.cpp', 'kHangs', 1.0)]
        self.write_program('stage-a', 'a/x.cpp:kRefuses a/x.cpp:kHangs')
        limit, self.original = 1, sensitivity.Programs
        sensitivity.Programs = lambda folder, limit_s, *more: self.original(folder, limit if limit_s else 0, *more)
        self.addCleanup(setattr, sensitivity, 'Programs', self.original)
        rows = self.run_all(known=known)
        self.assertIn('nothing to see', rows[1]['refused'])
        self.assertEqual([row.get('over_s') for row in rows[3:]], [1, 1])
        page = sensitivity_page.page(known, rows, '', self.first())
        self.assertIn('| first | refused | refused |', page)
        self.assertIn('| first | over 1 s | over 1 s |', page)
        self.assertIn('`over N s`', page)

    def test_a_scene_that_fails_as_it_is_measures_nothing(self):
        (self.folder / 'stage-a').write_text('#!/bin/sh\necho no film >&2; exit 3\n')
        rows = self.run_all()
        self.assertEqual([row['kind'] for row in rows], ['scene'])
        self.assertEqual(sensitivity_page.left(KNOWN, rows, self.first()), [c['id'] for c in KNOWN])

    def test_inputs_that_were_interrupted_are_made_again(self):
        def fail(folder):
            (folder / 'half.txt').write_text('')
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            self.inputs.folder('world', fail)
        made = self.inputs.folder('world', lambda folder: (folder / 'whole.txt').write_text(''))
        self.assertEqual(sorted(path.name for path in made.iterdir()), ['made', 'whole.txt'])
        self.inputs.folder('world', fail)  # is there, and not made again


class Page(Case):
    OLD = ('| old* | 0.25 | what old was |\n'
           '| `b/y.cpp` | `kElsewhere` | 2 | old | - | +3.0 % |\n'
           '| `a/x.cpp` | `kRead` | 4 | old | - | +7.0 % |\n'
           '| `a/x.cpp` | `kUnread` | 3 | old | - | +8.0 % |\n')

    def test_changes_are_relative_to_the_figure_as_it_is(self):
        page = sensitivity_page.page(KNOWN, self.run_all(), '', self.first())
        self.assertIn('| `a/x.cpp` | `kRead` | 4 | first | +200.0 % | +800.0 % |', page)
        self.assertIn('| first | 1 | figure of first |', page)
        self.assertIn('2 of 4 are measured: 2 move their figure', page)
        words = ' '.join(page.split())
        self.assertIn('1 are read by no scene, 1 are left.', words)
        not_measured = page.split('## Not measured')[1]
        self.assertIn('`a/x.cpp:kUnread`', not_measured)
        self.assertNotIn('kElsewhere', page)

    def test_earlier_rows_stay_while_the_value_is_the_same(self):
        page = sensitivity_page.page(KNOWN, self.run_all(), self.OLD, self.first())
        self.assertIn('| `b/y.cpp` | `kElsewhere` | 2 | old* | - | +3.0 % |', page)
        self.assertIn('| old* | 0.25 | what old was |', page)
        self.assertNotIn('+7.0 %', page)  # measured anew
        self.assertNotIn('+8.0 %', page)  # its value was 3
        self.assertIn('3 of 4 are measured, 1 (*) by an earlier version:', ' '.join(page.split()))
        self.assertEqual(sensitivity_page.page(KNOWN, self.run_all(), page, self.first()), page)

    def test_a_constant_is_unread_only_if_all_scenes_of_its_room_ran(self):
        rows = self.run_all()
        scenes = [*self.first(), self.scene('second', 'stage-b', ('a/x', 'b/'))]
        self.assertEqual(sensitivity_page.left(KNOWN, rows, self.first()), ['b/y.cpp:kElsewhere'])
        self.assertEqual(sensitivity_page.left(KNOWN, rows, scenes), ['a/x.cpp:kUnread', 'b/y.cpp:kElsewhere'])

    def test_small_changes_are_none(self):
        base = {'error': 2.0}
        self.assertEqual(sensitivity_page.change_text({'error': 2.0009}, base), '-')
        self.assertEqual(sensitivity_page.change_text({'error': 1.9}, base), '-5.0 %')

    def test_summary_counts_each_constant_once(self):
        self.assertEqual(sensitivity_page.summary(KNOWN, self.run_all(), self.first()),
                         '2 of 4 constants are measured, 1 are read by no scene of their room, 1 are left')


class Constants(Case):
    def test_are_found_with_struct_value_and_meaning(self):
        (self.folder / 'room').mkdir()
        (self.folder / 'room/x.cpp').write_text(
            'struct One {\n  KEYPOSE_TUNED(double, kA, 15.0 / 255);  ///< grey levels\n'
            '  KEYPOSE_TUNED(double, kB,\n                0.008);  ///< px\n  KEYPOSE_TUNED(float, kC, 2.5F);\n};\n'
            'struct Two {\n  KEYPOSE_TUNED(int, kD, 3);  // rounds\n};\n')
        found = [(c['id'], c['struct'], c['value'], c['whole'], c['comment']) for c in sensitivity.constants(self.folder)]
        self.assertEqual(found, [('room/x.cpp:kA', 'One', 15 / 255, False, 'grey levels'), ('room/x.cpp:kB', 'One', 0.008, False, 'px'),
                                 ('room/x.cpp:kC', 'One', 2.5, False, ''), ('room/x.cpp:kD', 'Two', 3, True, 'rounds')])

    def test_of_the_sources_have_names_of_their_own_and_belong_to_a_scene_or_are_known_not_to(self):
        known = sensitivity.constants()
        self.assertGreater(len(known), 500)
        self.assertEqual(len({c['id'] for c in known}), len(known))
        rooms = tuple(room for scene in sensitivity.all_scenes() for room in scene.rooms)
        aside = {c['file'] for c in known if not c['file'].startswith(rooms)}
        self.assertLessEqual(aside, {'armature/controller/joint_tracker.h', 'motion/video3d/view_blender.cpp',
                                     'texture/bake/complete.cpp'})

    def test_whole_numbers_stay_whole_and_above_zero(self):
        self.assertEqual(sensitivity.changed(constant('', '', 1.0, True), 0.5), 1)
        self.assertEqual(sensitivity.changed(constant('', '', 5.0, True), 0.5), 2)


class Scoring(Case):
    def write_mesh(self, name, points):
        data = f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nelement face 1\nend_header\n'.encode()
        data += np.asarray(points, '<f8').tobytes() + b'\3' + np.array([0, 1, 2], '<i4').tobytes()
        (self.folder / name).write_bytes(data)
        return self.folder / name

    def test_distance_of_vertices_is_over_the_diagonal(self):
        a = self.write_mesh('a.ply', [[0, 0, 0], [3, 0, 0], [0, 4, 0]])
        b = self.write_mesh('b.ply', [[0, 0, 1], [3, 0, 1], [0, 4, 1]])
        self.assertAlmostEqual(mean_distance([a], [b]), 0.2)
        self.assertEqual(read_ply(a)[1].tolist(), [[0, 1, 2]])
        self.assertEqual(len(json.loads(marks_text(*read_ply(a), 1))['pairs']), 1)

    def test_place_of_a_camera_is_compared_from_the_character(self):
        still = {'rotation': [1, 0, 0, 0], 'translation': [0, 0, 0]}
        def shot(z, rotation):
            camera = {'rotation': rotation, 'translation': [0, 0, z]}
            return {'frames': [{'picture': '0', 'camera_from_world': camera, 'world_from_character': still}]}
        self.assertAlmostEqual(place_error(shot(2.1, [1, 0, 0, 0]), shot(2, [1, 0, 0, 0])), 0.05)
        turned = [math.cos(0.05), 0, 0, math.sin(0.05)]
        self.assertAlmostEqual(place_error(shot(2, turned), shot(2, [1, 0, 0, 0])), 0.1)

    def test_programs_tell_why_they_refuse_and_are_ended_when_too_slow(self):
        self.write_program('stage-a', '', 'echo more; exit 0')
        programs = Programs(self.folder, 1, {'KEYPOSE_TUNED': 'x:kRefuses=1'})
        with self.assertRaisesRegex(Refused, 'stage-a: nothing to see'):
            programs('stage-a')
        programs.environment['KEYPOSE_TUNED'] = 'x:kHangs=1'
        with self.assertRaises(TooLong):
            programs('stage-a')


if __name__ == '__main__':
    unittest.main()
