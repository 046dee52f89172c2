#!/usr/bin/env python3
"""Compares docs/studio-commands.md, the table of commands and the studio's pages, with what the programs say.

    command_table.py --bin build/release/bin

Every command of `keypose --help`, every stage, every subcommand of those that have some, and every flag of the
commands that are no stages must stand in the table, and nothing else. The exit code is 1 when one is missing or gone;
the message names it. Needs only Python.
"""
import argparse
import pathlib
import re
import subprocess
import sys

TABLE = pathlib.Path(__file__).resolve().parent.parent / 'docs/studio-commands.md'
# Programs whose words after their name are commands of their own.
WITH_SUBCOMMANDS = ['armature', 'landmarks', 'synth']
# Said once above the table, not in each row.
EVERYWHERE = {'--help', '--folder', '--version'}
# Stages: their inputs are wired, and all their options stand on the page Run.
FLAGS_OF = ['armature calibrate']


def help_of(programs, words):
    told = subprocess.run([programs / 'keypose', *words, '--help'], capture_output=True, text=True)
    if told.returncode != 0:
        sys.exit(f"keypose {' '.join(words)} --help ended with {told.returncode}: {told.stderr}")
    return told.stdout


def indented_words(text):
    """First words of lines such as '  init   make a project'."""
    return re.findall(r'^  ([a-z][a-z0-9-]*)  +\S', text, flags=re.MULTILINE)


def flags_in(text):
    """Flags that begin a line, with those behind a comma."""
    lines = re.findall(r'^ +(?:-\w,)?(!?--[a-z][^ ={]*)', text, flags=re.MULTILINE)
    return {flag for line in lines for flag in re.findall(r'--[a-z][a-z-]*', line)}


def commands(programs):
    """@return {command: its flags, or None for a stage}"""
    text = help_of(programs, [])
    head, stages = text.split('Stages, which can also be run alone')
    found = {name: None for name in stages.split(':')[1].split()}
    for name in indented_words(head.split('Subcommands:')[1]):
        told = help_of(programs, [name]).split('The stage of that name')[0]
        found[name] = flags_in(told) - EVERYWHERE
    for name in WITH_SUBCOMMANDS:
        found.pop(name, None)
        told = help_of(programs, [name])
        below = indented_words(told.split('Subcommands:')[-1])
        if name == 'landmarks':
            below = ['suggest', 'bind']
        for word in below:
            found[f'{name} {word}'] = None
    for name in FLAGS_OF:
        found[name] = flags_in(help_of(programs, name.split())) - EVERYWHERE
    return found


def rows():
    """@return {command: the rest of its row}; commands stand in backquotes in the first cell"""
    found = {}
    for line in TABLE.read_text(encoding='utf-8').splitlines():
        if not line.startswith('| `'):
            continue
        first, rest = line[1:].split('|', 1)
        for name in re.findall(r'`([^`]+)`', first):
            found[name] = rest
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--bin', type=pathlib.Path, required=True)
    programs = parser.parse_args().bin
    there, table = commands(programs), rows()
    faults = [f'`{name}` is missing' for name in there if name not in table]
    faults += [f'`{name}` is no command any more' for name in table if name not in there]
    for name, flags in there.items():
        if not flags or name not in table:
            continue
        named = set(re.findall(r'--[a-z][a-z-]*', table[name]))
        faults += [f'`{name}`: {flag} is missing' for flag in sorted(flags - named)]
        faults += [f'`{name}`: {flag} is no flag any more' for flag in sorted(named - flags)]
    for fault in faults:
        print(f'{TABLE.name}: {fault}; say on which page it is, or why on none', file=sys.stderr)
    print(f'{len(there)} commands')
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
