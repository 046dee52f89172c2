#!/usr/bin/env python3
"""Runs the tests of a build folder, and says before how long that takes and afterwards which took longest.

    run_tests.py run BUILD [--full]     also the long tests with --full
    run_tests.py build-minutes BUILD    how long a build will take that has not begun; for ./dev test

Seconds of a test are those of its last run in this build folder, else the mean of the others. Needs only Python and ctest.
"""
import json
import pathlib
import subprocess
import sys
import xml.etree.ElementTree

# With an empty compiler cache, packages installed.
FIRST_BUILD_MINUTES = 35
# Of a test that never ran here.
UNKNOWN_SECONDS = 10
# Two at a time: a test's programs use all cores, but only for a part of its time.
AT_A_TIME = 2
SHOWN = 8


def names_of(build, full):
    command = ['ctest', '--test-dir', build, '--show-only=json-v1'] + ([] if full else ['-LE', 'full'])
    listed = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return [test['name'] for test in listed['tests']]


def seconds_of_last_runs(build):
    costs = pathlib.Path(build) / 'Testing/Temporary/CTestCostData.txt'
    seconds = {}
    for line in costs.read_text().splitlines() if costs.exists() else []:
        if line == '---':
            break
        name, runs, cost = line.rsplit(' ', 2)
        if int(runs) > 0:
            seconds[name] = float(cost)
    return seconds


def in_words(seconds):
    return f'{seconds:.0f} seconds' if seconds < 100 else f'{seconds / 60:.0f} minutes'


def announce(names, known):
    unknown = [name for name in names if name not in known]
    mean = sum(known.values()) / len(known) if known else UNKNOWN_SECONDS
    estimate = sum(known.get(name, mean) for name in names) / AT_A_TIME
    whence = 'a guess, they never ran here' if len(unknown) == len(names) else 'by their last runs'
    print(f'dev: {len(names)} tests, {AT_A_TIME} at a time: about {in_words(estimate)} ({whence})', flush=True)


def slowest(junit):
    tests = xml.etree.ElementTree.parse(junit).getroot().iter('testcase')
    timed = sorted(((float(test.get('time', 0)), test.get('name')) for test in tests), reverse=True)
    print('dev: the slowest: ' + ', '.join(f'{name} {seconds:.0f} s' for seconds, name in timed[:SHOWN]))


def run(build, full):
    announce(names_of(build, full), seconds_of_last_runs(build))
    junit = pathlib.Path(build).resolve() / 'Testing/tests.xml'
    junit.parent.mkdir(parents=True, exist_ok=True)
    command = ['ctest', '--test-dir', build, '--output-on-failure', '-j', str(AT_A_TIME), '--output-junit', str(junit)]
    code = subprocess.run(command + ([] if full else ['-LE', 'full'])).returncode
    if junit.exists():
        slowest(junit)
    return code


def build_minutes(build):
    """A build folder with objects needs a part of the time, which depends on what changed."""
    has_objects = (pathlib.Path(build) / '.ninja_log').exists()
    return f'0 to {FIRST_BUILD_MINUTES}' if has_objects else f'{FIRST_BUILD_MINUTES}'


def main(arguments):
    if len(arguments) == 2 and arguments[0] == 'build-minutes':
        print(build_minutes(arguments[1]))
        return 0
    if len(arguments) >= 2 and arguments[0] == 'run' and set(arguments[2:]) <= {'--full'}:
        return run(arguments[1], '--full' in arguments)
    print(__doc__, file=sys.stderr)
    return 2


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
