#!/usr/bin/env python3
"""Counts the words of prose in README.md and docs/: what a person reads line by line.

    prose_words.py [--each] [--most WORDS]

Not counted: tables, code (fenced, or indented by four spaces), comments, and the targets of links. Two sums are printed:
the first rooms, from photographs to animation and report, and what came later. --each also lists every page. With --most
the exit code is 1 when the first rooms have more words than that (docs/decisions/how-much-prose.md). Needs only Python.
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Pages, and sections of pages, that came with later rooms: studio, shooting, exports, fit, motion, armature, composite.
LATER_PAGES = {
    'docs': ('armature-protocol', 'shoot', 'studio', 'studio-api', 'twelve-become-twenty-four',
             'vertex-animation-textures', 'wire-puppet'),
    'docs/stages': ('animate', 'armature', 'armature-live', 'calibrate', 'composite', 'fit', 'locate', 'silhouettes',
                    'track', 'transfer', 'video3d'),
    'docs/algorithms': ('armature', 'fit', 'locate', 'track', 'transfer', 'video3d'),
    'docs/results': ('armature', 'fit', 'formats', 'shot', 'studio', 'track', 'transfer', 'video3d'),
    'docs/decisions': ('3d-video-in-textures', 'blender-by-one-curve', 'caches-with-y-up', 'coarse-bends-by-features',
                       'directions-carried-by-the-armature', 'fbx-by-hand', 'few-morph-targets', 'follow-when-asked',
                       'light-from-filmed-frames', 'matching-parts-of-a-curve', 'outlines-before-textures',
                       'places-of-marks-too', 'positions-in-two-precisions', 'serial-port-by-termios',
                       'shadow-in-stored-values', 'stuck-encoders-by-their-neighbours', 'studio-changes-files',
                       'turned-hands', 'turns-of-marks-over-time'),
}
LATER_SECTIONS = {
    'README.md': ('The studio', 'A second pose', 'A scan that dances', 'Into the shot'),
    'docs/file-formats.md': ('Pins', 'Clips, rigs', 'The shot', 'Clicks', 'The finished shot', 'Textures of frames',
                             'Armatures'),
    'docs/pipeline.md': ('A filmed shot', 'A performance'),
    'docs/stages/export.md': ('A texture for each frame', 'Blender by the add-on', 'FBX', 'Point caches', 'USD', 'The film', 'Few morph targets',
                              'Numbered files'),
}


def is_later(page, heading):
    """Whether this section of this page came with a later room; the heading without its marks."""
    folder, _, name = page.rpartition('/')
    if name.removesuffix('.md') in LATER_PAGES.get(folder, ()):
        return True
    return heading.startswith(LATER_SECTIONS.get(page, ()) or ('\n',))


def words_of(page, text):
    """@return words of prose in the sections of the first rooms, and in the later ones"""
    first, later = 0, 0
    heading = ''
    in_code = False
    for line in re.sub(r'<!--.*?-->', '', text, flags=re.DOTALL).splitlines():
        if line.lstrip().startswith('```'):
            in_code = not in_code
            continue
        if in_code or line.startswith('    ') or line.lstrip().startswith('|'):
            continue
        if line.startswith('## '):
            heading = line[3:]
        count = len(re.sub(r'\]\([^)]*\)', ']', line).split())
        if is_later(page, heading):
            later += count
        else:
            first += count
    return first, later


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--each', action='store_true', help='also list every page')
    parser.add_argument('--most', type=int, metavar='WORDS', help='most words that the first rooms may have')
    arguments = parser.parse_args()
    sums = [0, 0]
    for path in [ROOT / 'README.md', *sorted((ROOT / 'docs').rglob('*.md'))]:
        page = path.relative_to(ROOT).as_posix()
        counts = words_of(page, path.read_text(encoding='utf-8'))
        sums = [total + count for total, count in zip(sums, counts)]
        if arguments.each:
            print(f'{counts[0]:6} {counts[1]:6}  {page}')
    print(f'{sums[0]:6} first rooms\n{sums[1]:6} later rooms\n{sum(sums):6} in all')
    if arguments.most is not None and sums[0] > arguments.most:
        print(f'more than {arguments.most} words: cut, or write why (docs/decisions/how-much-prose.md)', file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
