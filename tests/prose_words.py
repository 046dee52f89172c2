#!/usr/bin/env python3
"""Counts the words of prose in README.md and docs/: what a person reads line by line.

    prose_words.py [--each] [--most WORDS]

Not counted: tables, code (fenced, or indented by four spaces), comments, and the targets of links. The raw count of all
words, as by `wc -w`, is printed beside it. --each also lists every page. With --most the exit code is 1 when there are
more words of prose than that, or when README.md has more than 800 words in all (docs/decisions/how-much-prose.md).
Needs only Python.
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
README = ROOT / 'README.md'
README_MOST = 800  # words in all, tables and code too


def prose_of(text):
    """@return words of a page's prose"""
    count = 0
    in_code = False
    for line in re.sub(r'<!--.*?-->', '', text, flags=re.DOTALL).splitlines():
        if line.lstrip().startswith('```'):
            in_code = not in_code
        elif not (in_code or line.startswith('    ') or line.lstrip().startswith('|')):
            count += len(re.sub(r'\]\([^)]*\)', ']', line).split())
    return count


def counts():
    """@return {page: (words of prose, words in all)}"""
    found = {}
    for path in [README, *sorted((ROOT / 'docs').rglob('*.md'))]:
        text = path.read_text(encoding='utf-8')
        found[path] = prose_of(text), len(text.split())
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--each', action='store_true', help='also list every page')
    parser.add_argument('--most', type=int, metavar='WORDS', help='most words of prose that there may be')
    arguments = parser.parse_args()
    pages = counts()
    if arguments.each:
        for path, (prose, raw) in pages.items():
            print(f'{prose:6} {raw:6}  {path.relative_to(ROOT).as_posix()}')
    prose, raw = (sum(column) for column in zip(*pages.values()))
    print(f'{prose:6} words of prose\n{raw:6} words in all\n{pages[README][1]:6} words in all in README.md')
    if arguments.most is None:
        return 0
    faults = []
    if prose > arguments.most:
        faults.append(f'more than {arguments.most} words of prose')
    if pages[README][1] > README_MOST:
        faults.append(f'more than {README_MOST} words in README.md')
    for fault in faults:
        print(f'{fault}: cut, or write why (docs/decisions/how-much-prose.md)', file=sys.stderr)
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
