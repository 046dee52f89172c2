#!/usr/bin/env python3
"""Writes the table of all options into each stage's page, from `keypose STAGE --describe`.

    option_tables.py --bin build/release/bin [--write]

Each page docs/stages/STAGE.md has a table between two marks at the end of its options. Without --write the pages
are compared; if any is out of date, the exit code is 1 and the message names it. Needs only Python.
"""
import argparse
import json
import pathlib
import subprocess
import sys

DOCS = pathlib.Path(__file__).resolve().parent.parent / 'docs/stages'
BEGIN = '<!-- All options, written by tests/option_tables.py from `keypose {stage} --describe`; do not edit. -->\n'
END = '<!-- End of all options. -->\n'


def described_stages(programs):
    """What each program says of itself that follows the stage contract, by stage."""
    found = {}
    for program in sorted(programs.glob('keypose-*')):
        told = subprocess.run([program, '--describe'], capture_output=True)
        try:
            described = json.loads(told.stdout) if told.returncode == 0 else {}
        except json.JSONDecodeError:
            described = {}
        if 'stage' in described:
            found[described['stage']] = described
    return found


def number(value):
    return f'{value:g}' if value < 1e6 else f'{int(value):,}'


def values_of(option):
    """The allowed values of an option, as text."""
    if option['choices']:
        return ', '.join(f'`{choice}`' for choice in option['choices'])
    if option['type'] == 'bool':
        return '`true`, `false`'
    if option['type'] == 'string':
        return 'text'
    low, high, unit = option['min'], option['max'], option['unit']
    text = f'{number(low)} to {number(high)}' if low is not None and high is not None else 'any number'
    return text + (f' {unit}' if unit else '')


def default_of(option):
    value = option['default']
    if option['type'] == 'bool':
        return f'`{str(value).lower()}`'
    if isinstance(value, float):
        return f'`{value:g}`'
    return f'`{value}`' if value != '' else 'none'


def table(described):
    rows = ['| option | default | may be | what it does |', '|---|---|---|---|']
    # Commonly used options come first.
    for option in sorted(described['options'], key=lambda option: not option['common']):
        help_text = option['help'].replace('|', '\\|')
        rows.append(f"| `{option['name']}` | {default_of(option)} | {values_of(option)} | {help_text} |")
    return '\n'.join(rows) + '\n'


def page_with(text, stage, described):
    """@return the page with an updated table, or with a new section at its end"""
    begin = BEGIN.format(stage=stage)
    section = begin + '\n' + table(described) + '\n' + END
    if begin not in text:
        return text.rstrip('\n') + '\n\n## All options\n\n' + section
    head, rest = text.split(begin, 1)
    return head + section + rest.split(END, 1)[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--bin', type=pathlib.Path, required=True)
    parser.add_argument('--write', action='store_true')
    given = parser.parse_args()
    stale = []
    for stage, described in described_stages(given.bin).items():
        page = DOCS / f'{stage}.md'
        if ' ' in stage:  # a command of a program: its options stand in the program's page by hand
            continue
        if not page.exists():
            stale.append(f'docs/stages/{stage}.md (it is missing)')
            continue
        text = page.read_text(encoding='utf-8')
        wanted = page_with(text, stage, described)
        if wanted == text:
            continue
        stale.append(f'docs/stages/{stage}.md')
        if given.write:
            page.write_text(wanted, encoding='utf-8')
    if given.write:
        print('written: ' + (', '.join(stale) or 'nothing, all pages are up to date'))
        return 0
    if stale:
        print(f'out of date: {", ".join(stale)}; run tests/option_tables.py --bin {given.bin} --write')
    return 1 if stale else 0


if __name__ == '__main__':
    sys.exit(main())
