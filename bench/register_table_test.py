#!/usr/bin/env python3
"""Tests register_table.py with programs whose results are known.

They return the truth or the unchanged source, or they fail.

    register_table_test.py BIN_DIR
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import register_table

BIN = 'build/release/bin'

MESHES = '''
import pathlib
import numpy as np
def read(path):
    data = pathlib.Path(path).read_bytes()
    at = data.index(b'end_header') + 11
    count = lambda kind: int(data[:at].decode().split('element ' + kind + ' ')[1].split()[0])
    points = np.frombuffer(data, '<f8', 3 * count('vertex'), at).reshape(-1, 3)
    faces = np.frombuffer(data, [('n', 'u1'), ('v', '<i4', 3)], count('face'), at + points.nbytes)['v']
    return points, faces
def diagonal(points):
    return float(np.linalg.norm(points.max(0) - points.min(0)))
'''
SCORER = '''
import json, sys
import meshes
source, registered = meshes.read(sys.argv[1]), meshes.read(sys.argv[2])
if source[0].shape != registered[0].shape:
    sys.exit('other vertices')
print(json.dumps({'finite': True, 'surface_mean': 0.0, 'hausdorff': 0.0, 'flipped': 0, 'degenerate': 0}))
'''


class RegisterTable(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        (cls.folder / 'meshes.py').write_text(MESHES)
        (cls.folder / 'scorer.py').write_text(SCORER)
        peers = {'truth': "sh -c 'cp $(dirname {source})/truth.ply {out}'", 'still': 'cp {source} {out}', 'fails': "sh -c 'exit 3'",
                 'silent': 'true', 'stranger': 'cp {target} {out}', 'slow': 'sleep 60', 'needs': 'cat {landmarks}',
                 'busy': "sh -c 'i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done; cp {source} {out}'"}
        command = [sys.executable, str(HERE / 'register_table.py'), 'tentacle', '--bin', BIN, '--scorer', str(cls.folder / 'scorer.py'), '--methods', '',
                   '--angles', '0,120', '--seeds', '2-3', '--landmarks', '0', '--noise', '0', '--holes', '0', '--timeout', '3',
                   '--json', str(cls.folder / 'rows.json'), '--work', str(cls.folder / 'work')]
        for name, template in peers.items():
            command += ['--peer', f'{name}={template}']
        cls.markdown = subprocess.run(command, check=True, capture_output=True, text=True).stdout
        cls.rows = json.loads((cls.folder / 'rows.json').read_text())

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def of(self, program, bend):
        return [row for row in self.rows if row['program'] == program and row['bend'] == bend]

    def test_truth_has_no_error_and_does_not_fail(self):
        for row in self.of('truth', 120):
            self.assertEqual((row['err_mean'], row['err_max'], row['flipped_against_truth'], row['failed']), (0, 0, 0, False))

    def test_unmoved_source_is_as_far_off_as_the_truth_moved(self):
        for row in self.of('still', 120):
            folder = self.folder / 'work/pairs' / f"tentacle_{row['seed']}_120_0_0_0_0.02_1_0"
            sys.path.insert(0, str(self.folder))
            import meshes
            source, target, truth = (meshes.read(folder / f'{name}.ply')[0] for name in ('source', 'target', 'truth'))
            error = np.linalg.norm(source - truth, axis=1) / meshes.diagonal(target)
            self.assertAlmostEqual(row['err_mean'], error.mean(), 12)
            self.assertAlmostEqual(row['err_max'], error.max(), 12)
            self.assertGreater(row['flipped_against_truth'], 100)
            self.assertTrue(row['failed'])
        for row in self.of('still', 0):
            self.assertLess(row['err_max'], 1e-15)
            self.assertFalse(row['failed'])

    def test_programs_that_fail_are_counted_and_say_why(self):
        why = {'fails': 'exit status 3', 'silent': 'wrote no mesh', 'slow': 'stopped after 3 s', 'stranger': 'the scorer said: other vertices'}
        for program, message in why.items():
            rows = self.of(program, 120)
            self.assertEqual([row['failure'] for row in rows], [message] * 2)
            self.assertIn(f'| 120 | 0 | {program} | 2 |', self.markdown)
            line = next(line for line in self.markdown.splitlines() if line.startswith(f'| 120 | 0 | {program} |'))
            self.assertIn('2 of 2', line)

    def test_program_that_needs_landmarks_is_left_out_without(self):
        self.assertEqual(self.of('needs', 120), [])

    def test_time_is_the_processor_time_of_the_program(self):
        self.assertGreater(self.of('busy', 120)[0]['cpu_s'], 10 * self.of('still', 120)[0]['cpu_s'])
        self.assertLess(self.of('slow', 120)[0]['cpu_s'], 0.5)

    def test_more_flips_than_the_truth_or_a_large_mean_fail(self):
        row = {'finite': True, 'err_mean': 0.009, 'flipped': 3, 'itself': 3}
        self.assertFalse(register_table.is_failure(row))
        self.assertTrue(register_table.is_failure({**row, 'flipped': 4}))
        self.assertTrue(register_table.is_failure({**row, 'itself': None}))
        self.assertTrue(register_table.is_failure({**row, 'err_mean': 0.011}))
        self.assertTrue(register_table.is_failure({**row, 'err_mean': float('nan')}))
        self.assertTrue(register_table.is_failure({**row, 'finite': False}))

    def test_show_prints_the_same_table_again(self):
        command = [sys.executable, str(HERE / 'register_table.py'), 'show', str(self.folder / 'rows.json')]
        self.assertEqual(subprocess.run(command, check=True, capture_output=True, text=True).stdout, self.markdown)

    def test_ranges_of_seeds(self):
        self.assertEqual(register_table.numbers('0-3,7'), [0, 1, 2, 3, 7])
        self.assertEqual(register_table.numbers('60,90.5', float), [60, 90.5])


if __name__ == '__main__':
    if len(sys.argv) > 1:
        BIN = sys.argv.pop(1)
    unittest.main()
