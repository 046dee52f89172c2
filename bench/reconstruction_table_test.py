#!/usr/bin/env python3
"""Tests reconstruction_table.py with programs whose results are known: the true surface, a part of it, and programs that fail.

    reconstruction_table_test.py BIN_DIR
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import reconstruction_table

BIN = 'build/release/bin'
VIEWS = 14


class ReconstructionTable(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.temporary.name)
        subprocess.run([f'{BIN}/keypose-synth', 'photos', '--output', cls.folder, '--poses', 'rest', '--views', str(VIEWS), '--width', '240', '--height', '180',
                        '--spacing', '0.004'], check=True, stdout=subprocess.DEVNULL)
        images = cls.folder / 'set/images'
        images.parent.mkdir()
        (cls.folder / 'photos/rest').rename(images)
        (cls.folder / 'truth/rest/masks').rename(images / 'masks')
        (cls.folder / 'truth/rest/cameras').rename(cls.folder / 'set/model')
        names = sorted(path.name for path in images.glob('*.jpg'))
        (images / 'capture.json').write_text(json.dumps({'schema': 1, 'camera_model': '', 'images': [
            {'name': name, 'mask': f'masks/{name}.png', 'width': 240, 'height': 180} for name in names]}))
        cls.truth = cls.folder / 'truth/rest/surface.ply'
        peer = {'mask_suffix': '.mask.png',
                'steps': {'note': ['sh', '-c', 'ls {images} > {work}/images.txt; ls {masks} > {work}/masks.txt; echo {max_size} "$@" > {work}/words.txt', 'sh'],
                          'copy': ['cp', str(cls.truth), '{work}/mesh.ply'],
                          'burn': ['sh', '-c', 'i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done']},
                'prepare': ['burn'], 'masked': {'note': ['with masks']},
                'results': {'truth': {'steps': ['burn', 'note', 'copy'], 'mesh': '{work}/mesh.ply'}, 'again': {'steps': ['copy', 'burn'], 'mesh': '{work}/mesh.ply'}}}
        cls.peer = cls.write('peer.json', peer)
        cls.command = [sys.executable, str(HERE / 'reconstruction_table.py'), 'measure', '--set', f'clay={cls.folder}/set', '--bin', BIN, '--tools', BIN,
                       '--ours-name', '']
        cls.markdown = cls.measure('--views', str(VIEWS - 2), '--peer', cls.peer, '--max-size', '77', '--runs', '2', '--work', str(cls.folder / 'work'),
                                   '--json', str(cls.folder / 'rows.json')).stdout
        cls.rows = json.loads((cls.folder / 'rows.json').read_text())
        cls.work = cls.folder / 'work/clay_12_masked'

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    @classmethod
    def write(cls, name, content):
        (cls.folder / name).write_text(json.dumps(content))
        return str(cls.folder / name)

    @classmethod
    def measure(cls, *words, check=True):
        done = subprocess.run(cls.command + list(words), capture_output=True, text=True)
        if check and done.returncode != 0:
            raise AssertionError(done.stderr)
        return done

    def test_the_true_surface_fills_the_true_masks(self):
        for row in self.rows:
            self.assertGreater(row['iou'], 0.98)
            self.assertGreater(row['precision'], 0.985)
            self.assertGreater(row['recall'], 0.985)
            self.assertIsNone(row['psnr_db'])  # it has no colours

    def test_every_sixth_view_is_held_out_of_everything(self):
        held_out = (self.work / 'held_out.txt').read_text().split()
        self.assertEqual(len(held_out), 2)
        shown = (self.work / 'peer0/0/images.txt').read_text().split()
        self.assertEqual(len(shown), 10)
        self.assertFalse(set(shown) & set(held_out))
        self.assertEqual({(row['views'], row['held_out']) for row in self.rows}, {(12, 2)})

    def test_masks_and_size_reach_the_peer(self):
        masks = (self.work / 'peer0/0/masks.txt').read_text().split()
        images = (self.work / 'peer0/0/images.txt').read_text().split()
        self.assertEqual(masks, [name.replace('.jpg', '.mask.png') for name in images])
        self.assertEqual((self.work / 'peer0/0/words.txt').read_text(), '77 with masks\n')

    def test_a_shared_step_runs_once_and_preparation_does_not_count(self):
        truth, again = self.rows[:2]
        self.assertEqual(truth['steps']['copy'], again['steps']['copy'])
        self.assertGreater(truth['steps']['burn']['cpu_s'], 0.1)
        self.assertAlmostEqual(truth['cpu_s'], truth['steps']['note']['cpu_s'] + truth['steps']['copy']['cpu_s'], 12)
        self.assertLess(truth['cpu_s'], truth['steps']['burn']['cpu_s'])
        self.assertIn('burn (not counted)', self.markdown)

    def test_medians_and_the_same_table_again(self):
        self.assertEqual(len(self.rows), 4)
        self.assertIn('| clay | 12 (2) | yes | 77 | truth | 2 |', self.markdown)
        again = subprocess.run([sys.executable, str(HERE / 'reconstruction_table.py'), 'show', str(self.folder / 'rows.json')], check=True, capture_output=True,
                               text=True)
        self.assertEqual(again.stdout, self.markdown)
        row = {'set': 'a', 'views': 1, 'masked': True, 'max_size': 1, 'program': 'p', 'steps': {'s': {'cpu_s': 1.}}}
        merged = reconstruction_table.medians([{**row, 'iou': value} for value in (0.1, 0.9, 0.8)])
        self.assertEqual((merged['iou'], merged['runs']), (0.8, 3))

    def test_peers_are_reused_where_nothing_differs(self):
        fails = self.write('fails.json', {'steps': {'a': ['false']}, 'results': {name: {'steps': ['a'], 'mesh': 'none'} for name in ('truth', 'again')}})
        words = ['--peer', fails, '--reuse', str(self.folder / 'rows.json'), '--work', str(self.folder / 'work')]
        self.assertIn('| truth | 2 |', self.measure('--views', '12', '--max-size', '77', *words).stdout)
        other = self.measure('--views', '12', '--max-size', '78', *words, check=False)
        self.assertNotEqual(other.returncode, 0)
        self.assertIn('false ended with 1', other.stderr)

    def test_our_own_stages(self):
        rows = self.folder / 'ours.json'
        self.measure('--views', '14', '--max-size', '240', '--ours-name', 'ours', '--ours-only', '--peer', self.peer, '--json', str(rows),
                     '--ours-option', 'cleanup.faces=1500', '--ours-option', 'bake.texture_size=128')
        (row,) = json.loads(rows.read_text())
        self.assertEqual(list(row['steps']), ['dense', 'mesh', 'refine', 'cleanup', 'unwrap', 'bake'])
        self.assertAlmostEqual(row['cpu_s'], sum(step['cpu_s'] for step in row['steps'].values()), 9)
        self.assertGreater(row['iou'], 0.8)
        self.assertGreater(row['gained_psnr_db'], 15)
        self.assertGreaterEqual(row['gained_psnr_db'], row['psnr_db'] - 0.01)

    def test_a_stopped_run_goes_on(self):
        peer = self.write('stops.json', {'steps': {'first': ['sh', '-c', f'echo once >> {{work}}/runs.txt; cp {self.truth} {{work}}/mesh.ply'],
                                                   'second': ['test', '-e', '{work}/now']},
                                         'results': {'late': {'steps': ['first', 'second'], 'mesh': '{work}/mesh.ply'}}})
        words = ['--views', '13', '--peer', peer, '--work', str(self.folder / 'work')]
        self.assertIn('test ended with 1', self.measure(*words, check=False).stderr)
        work = self.folder / 'work/clay_13_masked/peer0/0'
        (work / 'now').touch()
        self.assertIn('| late | 1 |', self.measure(*words, '--resume').stdout)
        self.assertEqual((work / 'runs.txt').read_text(), 'once\n')

    def test_without_masks_none_are_given(self):
        self.measure('--views', '12', '--masks', 'neither', '--peer', self.peer, '--work', str(self.folder / 'work'))
        folder = self.folder / 'work/clay_12_unmasked/peer0/0'
        self.assertEqual((folder / 'masks.txt').read_text(), '')
        self.assertEqual((folder / 'words.txt').read_text(), '1000\n')

    def test_more_views_than_there_are(self):
        done = self.measure('--views', '15', check=False)
        self.assertIn('15 views were asked for, the model places 14', done.stderr)
        self.assertNotEqual(done.returncode, 0)

    def test_views_are_spread_evenly(self):
        self.assertEqual(reconstruction_table.evenly(list(range(10)), 5), [0, 2, 4, 6, 8])
        self.assertEqual(reconstruction_table.evenly(list(range(3)), 3), [0, 1, 2])


if __name__ == '__main__':
    if len(sys.argv) > 1:
        BIN = sys.argv.pop(1)
    unittest.main()
