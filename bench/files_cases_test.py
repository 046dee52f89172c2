#!/usr/bin/env python3
"""Tests how files_table.py judges what commands say and how they end.

    files_cases_test.py
"""
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from files_cases import Outcome, Skip, run_case

REFUSAL = 'init: an HLG film is not read; convert it\n'


def judged(code, text, numbers=(), words='HLG', wanted='named'):
    return Outcome(code, text, numbers).judged(words, wanted)


def row_of(function, words='HLG', wanted='named'):
    return run_case(None, 'films', 'init', 'a case', wanted, words, function)


class Judged(unittest.TestCase):
    def test_only_exit_codes_of_refusals_name(self):
        self.assertEqual([judged(code, REFUSAL) for code in (2, 3, 6)], ['named'] * 3)
        self.assertEqual([judged(code, REFUSAL) for code in (1, 7, 130, -11)], ['badly'] * 4)

    def test_of_a_success_only_lines_of_a_stage_name(self):
        self.assertEqual(judged(0, 'done\ninit: warning: HLG is taken as SDR\n'), 'named')
        self.assertEqual(judged(0, 'done, HLG\n'), 'wrong')

    def test_names_of_files_do_not(self):
        self.assertEqual(judged(3, 'init: cannot read /tmp/012_HLG/shot\n'), 'badly')
        self.assertEqual(judged(3, 'init: a.fbx cannot be read\n', words='FBX'), 'badly')
        self.assertEqual(judged(3, 'init: a.fbx is an FBX file\n', words='FBX'), 'named')

    def test_without_words_nothing_is_named(self):
        self.assertEqual(judged(3, REFUSAL, words=''), 'badly')

    def test_numbers_are_held_against_their_bounds(self):
        self.assertEqual(judged(0, '', [('off', 0.2, 0.3), ('more', 1, 1)], wanted='right'), 'right')
        self.assertEqual(judged(0, '', [('off', 0.4, 0.3)], wanted='right'), 'wrong')
        self.assertEqual(judged(0, '', wanted='right'), 'wrong')
        self.assertEqual(judged(0, 'init: HLG', [('off', 0.2, 0.3)], wanted='right'), 'right')


class RunCase(unittest.TestCase):
    def test_a_row_has_what_came_out(self):
        row = row_of(lambda b: Outcome(0, 'read\n', [('off', 0.2, 0.3)]), wanted='right')
        self.assertEqual((row['got'], row['numbers'], row['code'], row['said']), ('right', [('off', 0.2, 0.3)], 0, 'read'))

    def test_any_fault_of_a_case_ends_it_badly_and_not_the_table(self):
        def stops(b):
            return {}['masks']
        row = row_of(stops)
        self.assertEqual((row['got'], row['said']), ('badly', "KeyError('masks')"))
        self.assertEqual(row_of(lambda b: Outcome(0, '', [('off', None, 1)]))['got'], 'badly')

    def test_a_case_may_leave_itself_out(self):
        def skips(b):
            raise Skip('no assimp')
        self.assertEqual((row_of(skips)['got'], row_of(skips)['said']), ('skipped', 'no assimp'))


if __name__ == '__main__':
    unittest.main()
