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

# The pages of the first rooms. All others came with later ones: studio, shooting, exports, fit, motion, armature,
# composite.
FIRST_PAGES = {
    'docs': '''
        README architecture file-formats glossary pipeline reliability results stage-contract
    '''.split(),
    'docs/algorithms': '''
        bake capture cleanup dense interpolate landmarks masks mesh refine register sfm unwrap
    '''.split(),
    'docs/decisions': '''
        balanced-stretch board-corners-by-template clouds-are-not-fitted-to-outlines competing-starts
        confidence-is-weight content-fingerprints deterministic-colmap distances-to-landmarks
        edges-by-the-third-root-of-curvature elastic-packing even-normals-before-long-moves evidence-of-its-own
        flipped-face-repair frontier-points-and-silhouette-violations gap-fill-by-quadrics ground-by-outlines
        guardian-processes handles-seen-through how-much-prose join-by-outlines large-meshes
        least-cuts-by-two-libraries libraries-for-formats mask-holes-and-boundary-matting masks-twice
        narrow-windows-and-curvature nearest-neighbours-by-nanoflann no-volume-prior occluding-contour-terms
        one-evidence-for-all-cameras one-photograph-in-common-light one-view-against-the-rest ordered-memory
        own-intrinsic-map own-pixel-classifier own-remesher-and-repair own-thread-pool pairs-with-exact-truth
        picks-are-places planes-with-a-scalar-factor player-in-the-page profiles-not-gradients
        results-are-copies rigid-pieces ring-after-mapper rows-of-right-hand-sides scale-of-cut-targets
        sfm-coarse-features-and-patches single-blas-thread smooth-affine-maps smooth-sequences
        sources-in-batches stages-are-programs sub-rooms textures-over-time time-left-on-a-first-run
        turn-by-twist-and-swing two-decimations volume-along-one-field volumetric-mode
    '''.split(),
    'docs/results': '''
        cameras cleanup demo interpolation landmarks masks newcomers real-photographs reconstruction
        registration rings runner sensitivity tentacle texture
    '''.split(),
    'docs/stages': '''
        bake capture cleanup complete dense export interpolate landmarks masks mesh refine register report sfm
        synth unwrap
    '''.split(),
    '': ['README'],
}
# What later rooms have added to them.
LATER_SECTIONS = {
    'README.md': ('The studio', 'A second pose', 'A scan that dances', 'Into the shot'),
    'docs/file-formats.md': ('Pins', 'Clips, rigs', 'The shot', 'Clicks', 'The finished shot', 'Textures of frames',
                             'Armatures', 'Points of known place'),
    'docs/pipeline.md': ('Poses from meshes', 'A filmed shot', 'A performance', 'What the figure is'),
    'docs/stages/sfm.md': ('In a room',),
    'docs/stages/masks.md': ('In a room',),
    'docs/stages/export.md': ('A texture for each frame', 'Blender by the add-on', 'FBX', 'Point caches', 'USD', 'The film', 'Few morph targets',
                              'Numbered files'),
}


def is_later(page, heading):
    """Whether this section of this page came with a later room; the heading without its marks."""
    folder, _, name = page.rpartition('/')
    if name.removesuffix('.md') not in FIRST_PAGES.get(folder, ()):
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
