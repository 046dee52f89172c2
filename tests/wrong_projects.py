#!/usr/bin/env python3
"""Faulty projects, one fault each: `keypose` must give the right exit code and the necessary words.

    wrong_projects.py --bin build/release/bin [--only TEXT] [--show] [--jobs 2]

Makes a project of two poses from rendered photographs, once. Each case copies it, introduces one fault, and runs
one command. Checks in each case:

    - the exit code, and that the output contains each of the case's words,
    - `error: ` in the output, but no "bug", and no message of a library that aborts,
    - no result below out/, unchanged photographs, no temporary file in .keypose/tmp.

Cases of options are made from `keypose STAGE --describe`. Exit code 1 if any case fails. Needs only Python.
"""
import argparse
import concurrent.futures
import dataclasses
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import typing

USAGE, INPUT, DISK, TOOL, GATE, LOCKED = 2, 3, 4, 5, 6, 7
POSES = 'poses:\n  rest: photos/rest\n  bent: photos/bent\n'
PATIENCE_S = 120 * float(os.environ.get('KEYPOSE_SLOWER', 1))
STATUS, CAPTURE = ('status',), ('run', '--until', 'capture')
NEVER = ('bug', 'terminate called', 'Traceback', 'std::', 'Assertion', 'what():', 'basic_string', 'json.exception', 'yaml-cpp', 'OpenCV', 'nan%')


@dataclasses.dataclass
class Case:
    name: str
    code: int
    words: tuple
    command: tuple = STATUS
    yaml: typing.Optional[str] = None  # replaces the project's pipeline.yaml
    spoil: typing.Optional[typing.Callable] = None  # gets the project's folder
    outside: bool = False  # the command gets no -C
    environment: dict = dataclasses.field(default_factory=dict)


def file_cases():
    """Faults in pipeline.yaml as a whole, its poses, template and steps; each word list starts with the line."""
    def case(name, line, words, yaml, code=USAGE):
        return Case(f'file: {name}', code, ((f'pipeline.yaml:{line}',) if line else ()) + words, yaml=yaml)
    step = lambda text: POSES + 'steps:\n' + text  # noqa: E731
    return [
        case('empty', 0, ('names no pose', 'rest: photos/rest'), ''),
        case('only a comment', 0, ('names no pose',), '# nothing yet\n'),
        case('a list', 1, ('must be a map',), '- rest\n- bent\n'),
        case('one word', 1, ('must be a map',), 'rest\n'),
        case('tab for blanks', 2, ('not YAML',), 'poses:\n\trest: photos/rest\n'),
        case('bracket left open', 0, ('pipeline.yaml:', 'not YAML'), 'poses: {rest: photos/rest\n'),
        case('quote left open', 2, ('photos/rest', 'does not exist'), 'poses:\n  rest: "photos/rest\n', INPUT),
        case('two documents', 0, ('pipeline.yaml:4', 'second document'), POSES + '---\nposes: {rest: photos/rest}\n'),
        case('bytes of a picture', 0, ('pipeline.yaml',), '\xff\xd8\xff\xe0 JFIF'),
        case('letter that is not UTF-8', 2, ('UTF-8',), 'poses:\n  b\xe4r: photos/rest\n'),
        case('letter in the timeline that is not UTF-8', 4, ('UTF-8',), POSES + 'timeline: [{pose: rest, at: 0, ease: "\xdf"}, bent]\n'),
        case('bracket that nothing opened', 0, ('pipeline.yaml:',), '!oSSSSest, rest]\n'),
        case('unknown key', 4, ("no key 'tmeplate'", "'template'"), POSES + 'tmeplate: rest\n'),
        case('unknown key far from all', 4, ("no key 'x'",), POSES + 'x: 1\n'),
        case('key twice', 4, ('twice',), POSES + 'poses: {rest: photos/rest}\n'),
        case('alias of itself', 0, ('alias',), POSES + 'timeline: &t [*t]\n'),
        case('unknown alias', 0, ('pipeline.yaml:4',), POSES + 'template: *none\n'),
        case('fps of words', 4, ("fps is 'fast'", 'number'), POSES + 'fps: fast\n'),
        case('fps of none', 4, ('fps is 0', 'more than 0'), POSES + 'fps: 0\n'),
        case('fps negative', 4, ('fps is -24',), POSES + 'fps: -24\n'),
        case('fps too large', 4, ('at most 1000',), POSES + 'fps: 1e9\n'),
        case('fps not finite', 4, ("fps is 'nan'",), POSES + 'fps: nan\n'),
        case('fps a list', 4, ('fps must be a single value',), POSES + 'fps: [24]\n'),
        case('poses a list', 1, ('poses must be a map',), 'poses: [rest, bent]\n'),
        case('poses none', 0, ('names no pose',), 'poses:\ntemplate: rest\n'),
        case('pose twice', 3, ("'rest' twice",), 'poses:\n  rest: photos/rest\n  rest: photos/bent\n'),
        case('pose named with a slash', 2, ("'a/b'", 'letters'), 'poses:\n  a/b: photos/rest\n'),
        case('pose named with a blank', 2, ("'at rest'", 'letters'), 'poses:\n  at rest: photos/rest\n'),
        case('pose named ..', 2, ("'..'",), 'poses:\n  ..: photos/rest\n'),
        case('pose without a name', 2, ('letters',), "poses:\n  '': photos/rest\n"),
        case('pose is a list', 2, ("pose 'rest' must be a map",), 'poses:\n  rest: [photos/rest]\n'),
        case('key of a pose', 3, ("no key 'photo'", "'photos'"), 'poses:\n  rest:\n    photo: photos/rest\n'),
        case('photographs a list', 2, ('photos must be a single value',), 'poses:\n  rest: {photos: [a, b]}\n'),
        case('folder that is not there', 2, ('photos/wave', 'does not exist', 'put it at'), 'poses:\n  rest: photos/wave\n', INPUT),
        case('folder named like a pose is not there', 2, ('photos/wave', 'does not exist'), 'poses:\n  wave:\n', INPUT),
        case('photograph for a folder', 2, ('is a file', 'must be a folder'), 'poses:\n  rest: pipeline.yaml\n', INPUT),
        case('home of somebody else', 2, ('~nobody', 'home folder'), 'poses:\n  rest: ~nobody/photos\n'),
        case('same folder for two poses', 3, ('same photographs', 'a folder of its own'), 'poses:\n  rest: photos/rest\n  bent: photos/rest\n'),
        case('folder in the folder of another', 0, ('pipeline.yaml', 'photos'), 'poses:\n  rest: photos\n  bent: photos/bent\n'),
        case('masks that are not there', 2, ('masks/rest', 'does not exist'), 'poses:\n  rest: {photos: photos/rest, masks: masks/rest}\n', INPUT),
        case('masks are a file', 2, ('is a file', 'must be a folder'), 'poses:\n  rest: {photos: photos/rest, masks: pipeline.yaml}\n', INPUT),
        case('background is a folder', 2, ('is a folder', 'must be a file'), 'poses:\n  rest: {photos: photos/rest, background: photos}\n', INPUT),
        case('background that is not there', 2, ('empty.jpg', 'does not exist'), 'poses:\n  rest: {photos: photos/rest, background: empty.jpg}\n', INPUT),
        case('cameras that are not there', 2, ('cameras/rest', 'does not exist'), 'poses:\n  rest: {photos: photos/rest, cameras: cameras/rest}\n', INPUT),
        case('landmarks that are not there', 3, ('marks.json', "'bent'", 'put them there'),
             'poses:\n  rest: photos/rest\n  bent: {photos: photos/bent, landmarks: marks.json}\n', INPUT),
        case('template unknown', 4, ("'rset' is not among the poses", "'rest'"), POSES + 'template: rset\n'),
        case('template a list', 4, ('template must be a single value',), POSES + 'template: [rest]\n'),
        case('options a list', 4, ('options must be a map',), POSES + 'options: [cleanup]\n'),
        case('options of no step', 5, ("'clenup', which does not exist", "'cleanup'"), POSES + 'options:\n  clenup: {faces: 9000}\n'),
        case('options of a step are a number', 5, ('must be a map',), POSES + 'options:\n  cleanup: 9000\n'),
        case('option is a list', 5, ('must be a single value',), POSES + 'options:\n  cleanup: {faces: [9000]}\n'),
        case("pose's options of no step", 2, ("'dens', which does not exist", "'dense'"),
             'poses:\n  rest: {photos: photos/rest, options: {dens: {levels: 3}}}\n'),
        case("pose's option unknown", 0, ("no option 'levls'", "'levels'"), 'poses:\n  rest: {photos: photos/rest, options: {dense: {levls: 3}}}\n'),
        case('steps a list', 5, ('steps must be a map',), step('  - capture\n')),
        case('key of a step', 5, ("no key 'option'", "'options'"), step('  dense: {option: {levels: 3}}\n')),
        case('step switched off that others need', 0, ('switched off', 'pipeline.yaml:5'), step('  dense: {enabled: false}\n')),
        case('enabled is a word', 5, ("is 'perhaps'", 'true or false'), step('  report: {enabled: perhaps}\n')),
        case('step without for', 5, ('needs `for:`',), step('  smooth: {stage: cleanup, inputs: {surface: cleanup.clean}}\n')),
        case('step without stage', 5, ('neither a `stage:` nor a `program:`',), step('  smooth: {for: pose}\n')),
        case('step of an unknown stage', 5, ("no stage 'clenup'", "'cleanup'"), step('  smooth: {stage: clenup, for: pose}\n')),
        case('step of a program that is not there', 5, ('there is no program', 'tools/none'), step('  smooth: {program: tools/none, for: pose}\n')),
        case('for of an unknown word', 5, ('`for: poses` is not known', "'pose'"), step('  smooth: {stage: cleanup, for: poses}\n')),
        case('step named with a slash', 5, ("'a/b'", 'letters'), step('  a/b: {stage: cleanup, for: pose}\n')),
        case('input of no step', 5, ("no step 'refin'", "'refine'"), step('  cleanup: {inputs: {surface: refin.refined}}\n')),
        case('input of no port', 5, ("no output 'refned'", "'refined'"), step('  cleanup: {inputs: {surface: refine.refned}}\n')),
        case('port unknown', 5, ("no input 'surfce'", "'surface'"), step('  cleanup: {inputs: {surfce: refine.refined}}\n')),
        case('folder for a file', 5, ('is a folder', 'takes a file'), step('  cleanup: {inputs: {surface: sfm.model}}\n')),
        case('file for a folder', 5, ('is a file', 'takes a folder'), step('  dense: {inputs: {model: refine.refined}}\n')),
        case('two things for one', 5, ('takes one thing, not 2',), step('  cleanup: {inputs: {surface: [mesh.surface, refine.refined]}}\n')),
        case('nothing for a port', 5, ("nothing for the input 'surface'",), step('  cleanup: {inputs: {surface: }}\n')),
        case('unknown source', 5, ("'$photo' is not known", "'$photos'"), step('  capture: {inputs: {photos: $photo}}\n')),
        case('source of a pose for the project', 5, ('is not of one pose',), step('  smooth: {stage: cleanup, for: project, inputs: {surface: $photos}}\n')),
        case('one of many', 5, ('@template', '@all'), step('  smooth: {stage: cleanup, for: project, inputs: {surface: cleanup.clean}}\n')),
        case('selector unknown', 5, ("'@first' is not known",), step('  smooth: {stage: cleanup, for: project, inputs: {surface: cleanup.clean@first}}\n')),
        case('neither template nor others', 5, ("no key 'other'", "'others'"), step('  bake: {inputs: {mesh: {template: unwrap.unwrapped, other: register.registered}}}\n')),
        case('file of the project that is not there', 5, ('mesh.ply', 'does not exist'), step('  cleanup: {inputs: {surface: ./mesh.ply}}\n'), INPUT),
        case('cycle', 0, ('cycle', 'first/rest -> '), step('  first: {stage: cleanup, for: pose, inputs: {surface: second.clean}}\n'
                                                          '  second: {stage: cleanup, for: pose, inputs: {surface: first.clean}}\n')),
        case('step needs itself', 0, ('cycle',), step('  cleanup: {inputs: {surface: cleanup.clean}}\n')),
        case('result outside of out', 5, ('must lie inside out/',), step('  cleanup: {out: {clean: ../../clean.ply}}\n')),
        case('result at the root', 5, ('must lie inside out/',), step('  cleanup: {out: {clean: /clean.ply}}\n')),
        case('result of no port', 5, ("no output 'claen'", "'clean'"), step('  cleanup: {out: {claen: clean.ply}}\n')),
        case('one result of two poses', 0, ('two steps write one result', 'clean.ply'), step('  cleanup: {out: {clean: clean.ply}}\n')),
        case('result inside of a result', 0, ('two steps write one result',), step('  cleanup: {out: {clean: "{pose}/model/clean.ply"}}\n')),
        case('shows what is no result', 5, ('not among its results',), step('  export: {show: {elsewhere/none.glb: it}}\n')),
        case('cost of an unknown kind', 5, ("no key 'pixel'", 'megapixel'), step('  dense: {cost: {pixel: 2}}\n')),
        case('cost negative', 5, ('must not be negative',), step('  dense: {cost: {fixed: -2}}\n')),
        case('program in place of a stage that answers nothing', 0, ('--describe',), step('  dense: {program: /bin/true}\n'), TOOL),
        case('program that is a text', 0, ('notes.txt',), step('  dense: {program: photos/notes.txt}\n'), TOOL),
    ]


def timeline_cases():
    def case(name, line, words, timeline):
        return Case(f'timeline: {name}', USAGE, (f'pipeline.yaml:{line}',) + words, yaml=POSES + 'timeline' + timeline)
    timed = lambda more: f':\n  keys:\n    - {{pose: rest, at: 0{more}}}\n    - {{pose: bent, at: 1}}\n'  # noqa: E731
    whole = lambda more: f':\n  {more}\n  keys: [{{pose: rest, at: 0}}, {{pose: bent, at: 1}}]\n'  # noqa: E731
    return [
        case('one key', 4, ('two keys or more',), ': [rest]\n'),
        case('no key', 4, ('two keys or more',), ': []\n'),
        case('a word', 4, ('must be a list of poses',), ': rest\n'),
        case('unknown pose', 4, ("'bend' is not among the poses", "'bent'"), ': [rest, bend]\n'),
        case('no list of keys', 5, ('no list `keys`',), ':\n  loop: true\n'),
        case('fps within', 5, ('`fps` does not belong',), ':\n  fps: 12\n  keys: [rest, bent]\n'),
        case('unknown field', 5, ("no field 'lop'", "'loop'"), whole('lop: true')),
        case('unknown field of a key', 6, ("no field 'eas'", "'ease'"), timed(', eas: in')),
        case('key without a pose', 4, ('needs a pose',), ': [{at: 0}, {pose: bent, at: 1}]\n'),
        case('time of a word', 4, ("'soon'", 'number'), ': [{pose: rest, at: soon}, {pose: bent, at: 1}]\n'),
        case('`time` for `at`', 4, ("no key 'time'", "'at'"), ': [{pose: rest, time: 0}, {pose: bent, time: 1}]\n'),
        case('times fall', 5, ('in the order of time',), ': [{pose: rest, at: 1},\n  {pose: bent, at: 0}]\n'),
        case('times the same', 4, ('each later',), ': [{pose: rest, at: 1}, {pose: bent, at: 1}]\n'),
        case('one key has a time', 4, ("all timeline keys have an 'at'",), ': [{pose: rest, at: 1}, bent]\n'),
        case('hold of a word', 6, ("'hold'", 'number'), timed(', hold: long')),
        case('hold negative', 6, ("'hold'", '-1'), timed(', hold: -1')),
        case('hold over the next key', 6, ("'hold' is 2 s", '1 s later'), timed(', hold: 2')),
        case('ease unknown', 6, ("'ease'", 'in-out'), timed(', ease: bouncy')),
        case('ease of three numbers', 6, ("'ease'", 'four numbers'), timed(', ease: [0, 0, 1]')),
        case('ease runs backwards', 6, ('backwards',), timed(', ease: [2, 0, 1, 1]')),
        case('interpolation unknown', 6, ("'interpolation'", 'stepped, linear or smooth'), timed(', interpolation: cubic')),
        case('twos and a half', 5, ("'step' is 2.5", 'whole number'), whole('step: 2.5')),
        case('on noughts', 5, ("'step' is 0",), whole('step: 0')),
        case('loop is a number', 5, ("'loop' is 3", 'true or false'), whole('loop: 3')),
        case('turn of no region', 6, ("'arm'", 'not among `regions`'), timed(', turns: {arm: 1}')),
        case('turn by halves', 6, ("'turns'", 'whole numbers'), timed(', turns: {arm: 0.5}')),
        case('region without a place', 5, ('region', 'vertices'), whole('regions: [{name: arm}]')),
        case('region without a name', 5, ('has no name',), whole('regions: [{center: [0, 0, 0], radius: 1}]')),
        case('region twice', 5, ("'arm' is there twice",), whole('regions: [{name: arm, center: [0, 0, 0], radius: 1}, {name: arm, center: [0, 0, 0], radius: 1}]')),
        case('ball without a size', 5, ('radius above 0',), whole('regions: [{name: arm, center: [0, 0, 0], radius: 0}]')),
        case('center of two numbers', 5, ('three numbers',), whole('regions: [{name: arm, center: [0, 0], radius: 1}]')),
        case('pin of no region', 5, ("'foot'", 'regions'), whole('pins: [{region: foot}]')),
        case('pin ends before it begins', 5, ('later than from',), whole('regions: [{name: arm, center: [0, 0, 0], radius: 1}]\n  pins: [{region: arm, from: 1, to: 0}]')),
        case('volume of a word', 5, ("'volume'",), whole('volume: kept')),
        case('table of a word', 5, ("'table'", 'number'), whole('table: oak')),
    ]


def option_cases(stages):
    """Per stage of the default pipeline: an unknown option, and an invalid value for each kind of option."""
    cases = []
    for stage, described in stages.items():
        kinds = {}
        for option in described['options']:
            kinds.setdefault('choice' if option.get('choices') else option['type'], option)
        def case(option, text, words, stage=stage):
            cases.append(Case(f'option: {stage}.{option} {text}', USAGE, ('pipeline.yaml:5', f"step '{stage}'") + words,
                              yaml=POSES + f'options:\n  {stage}: {{{option}: {text}}}\n'))
        first = next(iter(kinds.values()))['name']
        case(first + 'x', 1, (f"no option '{first}x'", f"'{first}'"))
        for kind, option in kinds.items():
            name = option['name']
            if kind == 'choice':
                case(name, 'nothing', (f"'{name}'", 'must be one of', *option['choices']))
            elif kind == 'bool':
                case(name, 'perhaps', (f"'{name}' is 'perhaps'", 'true or false'))
            elif kind in ('int', 'double'):
                case(name, 'many', (f"'{name}' is 'many'", 'whole number' if kind == 'int' else 'number'))
                case(name, 'nan', (f"'{name}'", 'number'))
                if option.get('min') is not None:
                    case(name, int(option['min']) - 1, (f"'{name}' is {int(option['min']) - 1}", 'must be'))
                if option.get('max') is not None:
                    case(name, int(option['max']) + 1, (f"'{name}'", 'must be'))
    return cases


def command_cases():
    def case(name, words, *command, code=USAGE, outside=False, spoil=None, environment=None):
        return Case(f'command: {name}', code, words, command=command, outside=outside, spoil=spoil, environment=environment or {})
    return [
        case('unknown', ('rnu',), 'rnu', outside=True),
        case('unknown flag', ('--untill',), 'run', '--untill', 'mesh'),
        case('until nothing', ("no step 'msh'", "'mesh'"), 'run', '--until', 'msh'),
        case('until a pose that is not there', ("no step 'mesh/wave'",), 'run', '--until', 'mesh/wave'),
        case('force nothing', ("no step 'bke'", "'bake'"), 'run', '--force', 'bke'),
        case('only nothing', ("no step 'bke'", "'bake'"), 'run', '--only', 'bke'),
        case('from what was never made', ('has not been made yet', 'keypose run --until sfm'), 'run', '--from', 'mesh'),
        case('no cores', ('--jobs', '1'), 'run', '-j', '0'),
        case('cores of words', ('two',), 'run', '-j', 'two'),
        case('progress unknown', ('bars', 'lines', 'jsonl'), 'run', '--progress', 'dots'),
        case('slurm', ('one machine',), 'run', '--executor', 'slurm'),
        case('executor unknown', ('local',), 'run', '--executor', 'moon'),
        case('set without a value', ('STEP.OPTION=VALUE',), 'run', '--set', 'cleanup.faces'),
        case('set without a step', ('STEP.OPTION=VALUE',), 'run', '--set', 'faces=9000'),
        case('set of no step', ("'clenup'", "'cleanup'"), 'run', '--set', 'clenup.faces=9000'),
        case('set of no option', ("'facse'", "'faces'"), 'run', '--set', 'cleanup.facse=9000'),
        case('set of words', ("'many'", 'whole number'), 'run', '--set', 'cleanup.faces=many'),
        case('set of a pose that is not there', ('cleanup/wave',), 'run', '--set', 'cleanup/wave.faces=9000'),
        case('explain nothing', ("no step 'msh'", "'mesh'"), 'explain', 'msh'),
        case('log of nothing', ("no step 'msh'", "'mesh'"), 'log', 'msh'),
        case('log of what never ran', ('mesh/rest has never run',), 'log', 'mesh', code=0),
        case('no report yet', ('there is no report yet', 'keypose run'), 'report', code=INPUT),
        case('folder that is not there', ('nowhere',), 'run', '-C', 'nowhere', outside=True),
        case('folder without a project', ('pipeline.yaml', 'keypose init'), 'run', '-C', 'photos/rest', outside=True,
             spoil=lambda folder: (folder / 'pipeline.yaml').unlink()),
        case('folder without -C', ('-C',), 'run', '.', outside=True),
        case('init of nothing', ('--pose',), 'init', 'new', outside=True),
        case('init without =', ('NAME=PHOTO_DIR',), 'init', 'new', '--pose', 'rest', outside=True),
        case('init of no folder', ('nowhere is not a folder',), 'init', 'new', '--pose', 'rest=nowhere', outside=True, code=INPUT),
        case('init of a photograph', ('is not a folder',), 'init', 'new', '--pose', 'rest=pipeline.yaml', outside=True, code=INPUT),
        case('init of an empty folder', ('no photographs',), 'init', 'new', '--pose', 'rest=empty', outside=True, code=INPUT,
             spoil=lambda folder: (folder / 'empty').mkdir()),
        case('init of raw photographs of a kind that is not read', ('no photographs that can be read', 'CRW'), 'init', 'new', '--pose', 'rest=raw', outside=True, code=INPUT,
             spoil=lambda folder: write(folder / 'raw/IMG_1.CRW', b'raw')),
        case('init over a project', ('exists already',), 'init', '.', '--pose', 'rest=photos/rest', outside=True),
        case('init of a pose twice', ('two poses of that name',), 'init', 'new', '--pose', 'rest=photos/rest', '--pose', 'rest=photos/bent', outside=True),
        case('init of one folder twice', ('same photographs',), 'init', 'new', '--pose', 'rest=photos/rest', '--pose', 'bent=photos/rest', outside=True),
        case('init with a pose named ../x', ("may have letters",), 'init', 'new', '--pose', '../x=photos/rest', outside=True),
        case('init with an unknown template', ('no pose of that name',), 'init', 'new', '--pose', 'rest=photos/rest', '--template', 'bent', outside=True),
        case('stage unknown flag', ('--surfce',), 'cleanup', '--surfce', 'a.ply', '--clean', 'b.ply', outside=True),
        case('stage without its input', ('--surface',), 'cleanup', '--clean', 'b.ply', outside=True),
        case('stage of no file', ('a.ply', 'does not exist'), 'cleanup', '--surface', 'a.ply', '--clean', 'b.ply', outside=True, code=INPUT),
        case('stage of a text', ('pipeline.yaml',), 'cleanup', '--surface', 'pipeline.yaml', '--clean', 'b.ply', outside=True, code=INPUT),
        case('stage over its input', ('photos/rest',), 'capture', '--photos', 'photos/rest', '--images', 'photos/rest', outside=True, code=DISK),
        case('home not known', ('HOME',), 'status', environment={'HOME': ''}, spoil=lambda folder: write(folder / 'pipeline.yaml', b'poses: {rest: ~/photos}\n')),
    ]


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def photographs(folder, pose='rest'):
    return sorted((folder / 'photos' / pose).glob('*.jpg'))


def photo_cases():
    """Faults in photographs and the files beside them, found by `run --until capture` at the latest."""
    def case(name, words, spoil, code=INPUT, yaml=None, command=CAPTURE):
        return Case(f'photographs: {name}', code, words, command=command, spoil=spoil, yaml=yaml)

    def first(change):
        def spoil(folder):
            change(photographs(folder)[0])
        return spoil

    def each(change):
        def spoil(folder):
            for photo in photographs(folder):
                change(photo)
        return spoil

    def replace_by_pipe(path):
        path.unlink()
        os.mkfifo(path)

    def replace_by_link(target):
        def change(path):
            path.unlink()
            path.symlink_to(target)
        return change

    def masks_of(data, names=lambda photo: photo.name + '.png'):
        def spoil(folder):
            for photo in photographs(folder):
                write(folder / 'masks/rest' / names(photo), data)
        return spoil

    with_masks = POSES.replace('rest: photos/rest', 'rest: {photos: photos/rest, masks: masks/rest}')
    with_background = POSES.replace('rest: photos/rest', 'rest: {photos: photos/rest, background: empty.jpg}')
    with_cameras = POSES.replace('rest: photos/rest', 'rest: {photos: photos/rest, cameras: cameras}')
    with_transforms = POSES.replace('rest: photos/rest', 'rest: {photos: photos/rest, cameras: cameras/transforms.json}')
    return [
        case('none', ('photos/rest', 'no photographs'), each(lambda photo: photo.unlink())),
        case('one', ('photos/rest', '1 photograph'), lambda folder: [photo.unlink() for photo in photographs(folder)[1:]]),
        case('two', ('photos/rest', '2 photographs'), lambda folder: [photo.unlink() for photo in photographs(folder)[2:]]),
        case('empty file', ('FIRST', '0 bytes', 'copy it'), first(lambda photo: photo.write_bytes(b''))),
        case('text named .jpg', ('FIRST', 'JPEG'), first(lambda photo: photo.write_bytes(b'this is a letter to my aunt'))),
        case('cut short', ('FIRST', 'truncated'), first(lambda photo: photo.write_bytes(photo.read_bytes()[:9000]))),
        case('without its last bytes', ('FIRST', 'truncated'), first(lambda photo: photo.write_bytes(photo.read_bytes()[:-200]))),
        case('raw named .jpg', ('FIRST',), first(lambda photo: photo.write_bytes(b'II*\0\x10\0\0\0CR\x02\0' + bytes(1000)))),
        case('a program named .jpg', ('FIRST',), first(lambda photo: photo.write_bytes(b'\x7fELF' + bytes(1000)))),
        case('a pipe is none', ('only 9 photographs',), first(replace_by_pipe), code=0),
        case('a link to nowhere', ('FIRST',), first(replace_by_link('nowhere.jpg'))),
        case('a link to a device is none', ('only 9 photographs',), first(replace_by_link('/dev/zero')), code=0),
        case('a folder that links to itself', ('photos/rest',), lambda folder: [photo.unlink() for photo in photographs(folder)] + [(folder / 'photos/rest/again').symlink_to('.')]),
        case('a folder named .jpg', ('photos/rest',), lambda folder: [photo.unlink() for photo in photographs(folder)] + [(folder / 'photos/rest/a.jpg').mkdir()]),
        case('in folders below only', ('2 made',), lambda folder: [(write(folder / 'photos/rest/camera1' / photo.name, photo.read_bytes()), photo.unlink()) for photo in photographs(folder)] and None, code=0),
        case('name that is not UTF-8', ('UTF-8',), lambda folder: os.rename(os.fsencode(photographs(folder)[0]), os.fsencode(folder / 'photos/rest') + b'/\xff.jpg')),
        case('a gif', ('FIRST', 'JPEG'), first(lambda photo: photo.write_bytes(b'GIF89a' + bytes(500)))),
        case('PNG that claims 100,000 pixels a side', ('FIRST', '100000'), first(lambda photo: photo.write_bytes(png(100000, 100000)))),
        case('PNG without pixels', ('FIRST',), first(lambda photo: photo.write_bytes(png(0, 10)))),
        case('PNG cut short', ('FIRST',), first(lambda photo: photo.write_bytes(png(10, 10)[:40]))),
        case('one of another size', ('different sizes', 'FIRST'), first(lambda photo: photo.write_bytes(whole_png(64, 48, 90)))),
        case('one pixel each', ('pixel',), each(lambda photo: photo.write_bytes(whole_png(1, 1, number_of(photo))))),
        case('one pixel wide', ('pixel',), each(lambda photo: photo.write_bytes(whole_png(1, 2000, number_of(photo))))),
        case('all of one colour', ('rest',), each(lambda photo: photo.write_bytes(whole_png(320, 240, 90 + number_of(photo))))),
        case('all the same', ('byte for byte', 'delete the copies'), each(lambda photo: photo.write_bytes(whole_png(320, 240, 0)))),
        case('masks all black', ('black', 'FIRST'), masks_of(whole_png(320, 240, 0)), yaml=with_masks),
        case('masks of another size', ('mask', 'FIRST', '64 x 48'), masks_of(whole_png(64, 48, 255)), yaml=with_masks),
        case('masks of no photograph', ('masks/rest', 'FIRST'), masks_of(whole_png(320, 240, 255), lambda photo: 'x' + photo.name + '.png'), yaml=with_masks),
        case('masks that are texts', ('mask', 'FIRST'), masks_of(b'white'), yaml=with_masks),
        case('masks empty', ('masks/rest', 'no mask in it'), lambda folder: (folder / 'masks/rest').mkdir(parents=True), yaml=with_masks, code=0),
        case('background a text', ('empty.jpg',), lambda folder: write(folder / 'empty.jpg', b'nothing'), yaml=with_background),
        case('background of another size', ('clean plate', '64 x 48'), lambda folder: write(folder / 'empty.jpg', whole_png(64, 48, 90)), yaml=with_background),
        case('cameras of an empty folder', ('cameras', 'COLMAP'), lambda folder: (folder / 'cameras').mkdir(), yaml=with_cameras, command=('run', '--until', 'sfm/rest')),
        case('cameras cut short', ('cameras.bin', 'truncated'), lambda folder: [write(folder / f'cameras/{n}.bin', b'\x05\0\0\0\0\0\0\0\x01') for n in ('cameras', 'images', 'points3D')],
             yaml=with_cameras, command=('run', '--until', 'sfm/rest')),
        case('transforms.json that is none', ('transforms.json',), lambda folder: write(folder / 'cameras/transforms.json', b'{"frames": 3}'), yaml=with_transforms,
             command=('run', '--until', 'sfm/rest')),
    ]


def few_cases():
    """Faults of poses from few photographs (`method: fit`)."""
    few = 'poses:\n  rest: photos/rest\n  bent: {photos: photos/bent, method: fit}\n'
    few_masked = few.replace('method', 'masks: masks/bent, method')
    capture = ('run', '--until', 'capture/bent')

    def keep(count):
        return lambda folder: [photo.unlink() for photo in photographs(folder, 'bent')[count:]] and None

    def black_masks(folder):
        for photo in photographs(folder, 'bent'):
            write(folder / 'masks/bent' / (photo.name + '.png'), whole_png(320, 240, 0))

    def case(name, code, words, command=STATUS, yaml=few, spoil=None):
        return Case(f'few: {name}', code, words, command=command, yaml=yaml, spoil=spoil)

    def init(name, words, *flags):
        return Case(f'few: {name}', USAGE, words, ('init', 'new', '--pose', 'rest=photos/rest', '--pose', 'bent=photos/bent', *flags), outside=True)

    return [
        case('method unknown', USAGE, ('pipeline.yaml:3', '`method: fitt` is not known', "'fit'"), yaml=few.replace('fit}', 'fitt}')),
        case('method a list', USAGE, ('pipeline.yaml:3', 'method must be a single value'), yaml=few.replace('fit}', '[fit]}')),
        case('of the template', USAGE, ('pipeline.yaml:3', "'bent' is the template", 'needs a scan', 'another pose the template'), yaml=few + 'template: bent\n'),
        case('of the only pose', USAGE, ('pipeline.yaml:2', "'rest' is the template"), yaml='poses:\n  rest: {method: fit}\n'),
        case('a step that needs a scan', USAGE, ('pipeline.yaml:5', 'no step cleanup/bent', 'few photographs', '`method: scan`'),
             yaml=few + 'steps:\n  smooth: {stage: cleanup, for: pose, inputs: {surface: cleanup.clean}}\n'),
        case('a step of an unknown method', USAGE, ('pipeline.yaml:5', '`method: few` is not known'), yaml=few + 'steps:\n  dense: {method: few}\n'),
        case('an option of an unknown method', USAGE, ('pipeline.yaml:5', "no key 'few'"), yaml=few + 'steps:\n  capture: {options: {min_images: {few: 3}}}\n'),
        case('no step of a scan', USAGE, ("no step 'register/bent'",), ('explain', 'register/bent')),
        case('no photographs', INPUT, ('photos/bent', 'no photographs'), capture, spoil=keep(0)),
        case('one photograph', INPUT, ('photos/bent', '1 photograph', 'at least 2', '6 or more from different sides'), capture, spoil=keep(1)),
        case('two photographs are taken', 0, ('1 made',), capture, spoil=keep(2)),
        case('two sizes', INPUT, ('different sizes', '64 x 48'), capture, spoil=lambda folder: photographs(folder, 'bent')[0].write_bytes(whole_png(64, 48, 90)) and None),
        case('masks all black', INPUT, ('black', 'IMG_0001.jpg', '--background'), capture, few_masked, black_masks),
        init('init of the template', ("--few rest: 'rest' is the template", '--template'), '--few', 'rest'),
        init('init of no pose', ('--few wave', 'no pose of that name'), '--few', 'wave'),
        init('init both ways', ('--few bent and --scan bent',), '--few', 'bent', '--scan', 'bent'),
    ]


def performance_cases():
    """Faults of projects with `kind: performance`."""
    head = 'kind: performance\nshots:\n'

    def case(name, code, words, yaml, command=STATUS, spoil=None):
        return Case(f'performance: {name}', code, words, command=command, yaml=yaml, spoil=spoil)

    def init(name, code, words, *flags):
        return Case(f'performance: {name}', code, words, ('init', 'new', '--kind', 'performance', *flags), outside=True)

    return [
        case('kind unknown', USAGE, ('pipeline.yaml:1', '`kind: dance` is not known'), 'kind: dance\n'),
        case('no shots', USAGE, ('names no shot', 'walk: shots/walk'), 'kind: performance\n'),
        case('with poses', USAGE, ('pipeline.yaml:2', '`poses` belongs to a project of poses'), 'kind: performance\n' + POSES),
        case('marks without the kind', USAGE, ('pipeline.yaml:4', 'add `kind: performance`'), POSES + 'marks: marks.json\n'),
        case('key of a shot', USAGE, ('pipeline.yaml:3', "shot 'walk' has no key 'films'"), head + '  walk: {films: photos}\n'),
        case('films that are not there', INPUT, ('pipeline.yaml:3', 'films/walk', 'does not exist'), head + '  walk: {video: films/walk, calibration: pipeline.yaml}\n'),
        case('no calibration', USAGE, ('pipeline.yaml:3', "shot 'walk' has no calibration", 'calibration.*'), head + '  walk: photos\n'),
        case('scan that is not there', INPUT, ('pipeline.yaml:4', 'hero.obj', 'does not exist'),
             head + '  walk: {video: photos, calibration: pipeline.yaml}\nscan: hero.obj\nmarks: pipeline.yaml\n'),
        case('no films in the folder', INPUT, ('the shot again has no camera',), head + '  walk: {video: photos/rest/again, calibration: pipeline.yaml}\n',
             ('run', '--until', 'track'), lambda folder: write(folder / 'photos/rest/again/notes.txt', b'none')),
        init('init of no shot', USAGE, ('--shot NAME=FOLDER',)),
        init('init of no folder', INPUT, ('nowhere is not a folder',), '--shot', 'walk=nowhere'),
        init('init of a shot twice', USAGE, ('two shots of that name',), '--shot', 'walk=photos', '--shot', 'walk=photos/rest'),
        init('init with poses', USAGE, ('do not belong to --kind performance',), '--shot', 'walk=photos', '--pose', 'rest=photos/rest'),
        init('init of no scan', INPUT, ('--scan-mesh hero.obj', 'there is no'), '--shot', 'walk=photos', '--scan-mesh', 'hero.obj'),
        Case('performance: 3D video without the kind', USAGE, ('--video3d need --kind performance',), ('init', 'new', '--pose', 'rest=photos/rest', '--video3d'), outside=True),
        Case('performance: surface without the kind', USAGE, ('--surface and --video3d need',), ('init', 'new', '--pose', 'rest=photos/rest', '--surface'), outside=True),
        Case('performance: shots without the kind', USAGE, ('need --kind performance',), ('init', 'new', '--pose', 'rest=photos/rest', '--shot', 'walk=photos'), outside=True),
    ]


def film_cases():
    """Faults of projects whose poses were filmed (`shot:`)."""
    def case(name, code, words, shot, command=STATUS, spoil=None):
        return Case(f'film: {name}', code, words, command=command, yaml=POSES + 'shot: ' + shot + '\n', spoil=spoil)

    def init(name, code, words, *flags):
        return Case(f'film: {name}', code, words, ('init', 'new', '--pose', 'rest=photos/rest', '--pose', 'bent=photos/bent', *flags), outside=True)

    shows = 'shows: {0: rest, 4: bent}'
    return [
        case('no film', USAGE, ('pipeline.yaml:4', 'the shot has no film', 'film: film'), '{' + shows + '}'),
        case('shows nothing', USAGE, ('pipeline.yaml:4', 'fewer than two frames', 'shows: {0: rest'), '{film: photos/rest}'),
        case('shows no pose', USAGE, ('pipeline.yaml:4', "the shown pose 'bend'", "'bent'"), '{film: photos/rest, shows: {0: rest, 4: bend}}'),
        case('frame of words', USAGE, ('pipeline.yaml:4', "'first'", 'number'), '{film: photos/rest, shows: {first: rest, 4: bent}}'),
        case('frame twice', USAGE, ('pipeline.yaml:4', 'twice'), '{film: photos/rest, shows: {0: rest, 0: bent}}'),
        case('rates that do not fit', USAGE, ('pipeline.yaml:4', 'multiple', '24 of 12'), '{film: photos/rest, fps: 10, ' + shows + '}'),
        case('key of a shot', USAGE, ('pipeline.yaml:4', "no key 'plates'", "'plate'"), '{film: photos/rest, plates: plate.png, ' + shows + '}'),
        case('film that is not there', INPUT, ('pipeline.yaml:4', 'film', 'does not exist'), '{film: film, ' + shows + '}'),
        case('plate that is not there', INPUT, ('pipeline.yaml:4', 'plate.png', 'does not exist'), '{film: photos/rest, plate: plate.png, ' + shows + '}'),
        Case('film: with a performance', USAGE, ('pipeline.yaml:2', '`shot` belongs to a project of poses'),
             yaml='kind: performance\nshot: {film: photos, shows: {0: rest, 4: bent}}\nshots: {walk: photos}\n'),
        init('init without shows', USAGE, ('--shows', '0=rest,4=wave'), '--film', 'photos/rest'),
        init('init without film', USAGE, ('need --film',), '--shows', '0=rest,4=bent'),
        init('init of no folder', INPUT, ('there is no',), '--film', 'nowhere', '--shows', '0=rest,4=bent'),
        init('init that shows no pose', USAGE, ('no pose of that name',), '--film', 'photos/rest', '--shows', '0=rest,4=wave'),
        init('init of a pose as frame', USAGE, ('FRAME=POSE',), '--film', 'photos/rest', '--shows', 'rest=0,4=bent'),
        init('init of a frame beyond the film', INPUT, ('999=bent', 'last frame'), '--film', 'photos/rest', '--shows', '0=rest,999=bent'),
        init('init of no plate', INPUT, ('--plate', 'there is no'), '--film', 'photos/rest', '--shows', '0=rest,4=bent', '--plate', 'plate.png'),
    ]


def state_cases():
    """Faults outside the photographs: locks, links, landmark folders."""
    def case(name, code, words, spoil, command=STATUS, yaml=None):
        return Case(f'state: {name}', code, words, command=command, spoil=spoil, yaml=yaml)

    def outside_of(folder):
        return folder.parent / (folder.name + '_elsewhere')

    def file_for_folder(folder):
        shutil.rmtree(folder / '.keypose')
        write(folder / '.keypose', b'')

    def folder_for_lock(folder):
        (folder / '.keypose/lock').mkdir(parents=True)

    def yaml_is_a_folder(folder):
        (folder / 'pipeline.yaml').unlink()
        (folder / 'pipeline.yaml').mkdir()

    def yaml_is_a_pipe(folder):
        (folder / 'pipeline.yaml').unlink()
        os.mkfifo(folder / 'pipeline.yaml')

    def tmp_leads_away(name):
        def spoil(folder):
            write(outside_of(folder) / 'mine.txt', b'mine')
            shutil.rmtree(folder / '.keypose' / name, ignore_errors=True)
            (folder / '.keypose' / name).symlink_to(outside_of(folder))
        return spoil

    def keypose_leads_away(folder):
        outside_of(folder).mkdir()
        shutil.rmtree(folder / '.keypose')
        (folder / '.keypose').symlink_to(outside_of(folder))

    return [
        case('.keypose is a file', DISK, ('.keypose',), file_for_folder, CAPTURE),
        case('lock is a folder', DISK, ('lock',), folder_for_lock, CAPTURE),
        case('pipeline.yaml is a folder', DISK, ('pipeline.yaml', 'folder'), yaml_is_a_folder),
        case('pipeline.yaml is a pipe', DISK, ('pipeline.yaml', 'pipe'), yaml_is_a_pipe),
        *[case(f'.keypose/{name} leads elsewhere', DISK, (f'.keypose/{name}', 'link', 'elsewhere'), tmp_leads_away(name), CAPTURE)
          for name in ('tmp', 'writing', 'cache', 'steps', 'runs', 'failed')],
        case('.keypose leads elsewhere', DISK, ('.keypose', 'link'), keypose_leads_away, CAPTURE),
    ]


def number_of(photo):
    return int(photo.stem.rsplit('_', 1)[1])


def png(width, height, payload=b''):
    import struct
    import zlib

    def chunk(kind, data):
        return struct.pack('>I', len(data)) + kind + data + struct.pack('>I', zlib.crc32(kind + data))
    return (b'\x89PNG\r\n\x1a\n' + chunk(b'IHDR', struct.pack('>IIBBBBB', width, height, 8, 2, 0, 0, 0)) + chunk(b'IDAT', zlib.compress(payload))
            + chunk(b'IEND', b''))


def whole_png(width, height, grey):
    return png(width, height, (b'\0' + bytes([grey]) * 3 * width) * height)


class Bench:
    """Makes the project once, and runs cases on copies of it."""

    def __init__(self, programs, work):
        self.keypose, self.work = programs / 'keypose', work
        world = work / 'world'
        made = subprocess.run([programs / 'keypose-synth', 'photos', '--output', world, '--poses', 'rest,bent', '--views', '10', '--width', '320', '--height',
                               '240', '--spacing', '0.004'], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert made.returncode == 0, made.stdout
        self.project = work / 'project'
        for pose in ('rest', 'bent'):
            shutil.copytree(world / 'photos' / pose, self.project / 'photos' / pose)
        write(self.project / 'photos/notes.txt', b'shot on Monday')
        write(self.project / 'pipeline.yaml', POSES.encode())
        # Stores the output of --describe here; otherwise each copy would run the stages again, which takes a second.
        subprocess.run([self.keypose, 'status', '-C', self.project], stdout=subprocess.DEVNULL, check=True)

    def stages(self):
        listed = ('capture', 'sfm', 'masks', 'dense', 'mesh', 'refine', 'cleanup', 'unwrap', 'register', 'fit', 'bake', 'complete', 'interpolate', 'export', 'report')
        return {stage: json.loads(subprocess.run([self.keypose, stage, '--describe'], stdout=subprocess.PIPE, check=True).stdout) for stage in listed}

    def prepare(self, case, folder):
        shutil.copytree(self.project, folder)
        if case.yaml is not None:
            (folder / 'pipeline.yaml').write_bytes(case.yaml.encode('latin-1'))
        if case.spoil:
            case.spoil(folder)

    def run(self, number, case):
        """@return the faults of the output (empty: none), and the output"""
        folder = self.work / f'case_{number}'
        self.prepare(case, folder)
        before = prints_of(folder)
        first = photographs(folder)[0].name if photographs(folder) else ''
        command = [self.keypose, *case.command] + ([] if case.outside else ['-C', str(folder)])
        done = subprocess.run(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S,
                              env={**os.environ, **case.environment})
        answer = done.stdout.decode('utf-8', 'replace')
        wrong = [] if done.returncode == case.code else [f'exit code {done.returncode}, not {case.code}']
        wrong += [f'says no "{word}"' for word in case.words if (first if word == 'FIRST' else word) not in answer]
        wrong += [f'says "{word}"' for word in NEVER if word in answer]
        if case.code and 'error: ' not in answer:
            wrong.append('says no "error: "')
        if case.code and (folder / 'out').is_dir() and any((folder / 'out').rglob('*.ply')):
            wrong.append('left results')
        if case.code and (folder / '.keypose/tmp').is_dir() and not (folder / '.keypose/tmp').is_symlink() and any((folder / '.keypose/tmp').iterdir()):
            wrong.append('left temporary files')
        if any(after != before[name] for name, after in prints_of(folder).items() if name in before) or set(before) - set(prints_of(folder)):
            wrong.append('changed what it was given')
        shutil.rmtree(folder)
        return wrong, answer


def prints_of(folder):
    """The user's files in the project: name -> hash."""
    found = {}
    for path in folder.rglob('*'):
        name = str(path.relative_to(folder))
        if path.is_symlink() or not path.is_file() or name.startswith(('.keypose', 'out')):
            continue
        found[name] = hashlib.sha256(path.read_bytes()).hexdigest()
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.split('\n')[0])
    parser.add_argument('--bin', type=pathlib.Path, required=True)
    parser.add_argument('--only', default='')
    parser.add_argument('--show', action='store_true', help='print every answer')
    parser.add_argument('--jobs', type=int, default=2)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix='wrong_projects_') as work:
        bench = Bench(given.bin.resolve(), pathlib.Path(work).resolve())
        cases = [*file_cases(), *timeline_cases(), *option_cases(bench.stages()), *command_cases(), *photo_cases(), *few_cases(), *performance_cases(), *film_cases(), *state_cases()]
        cases = [case for case in cases if given.only in case.name]
        with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool:
            answers = list(pool.map(bench.run, range(len(cases)), cases))
    failures = 0
    for case, (wrong, answer) in zip(cases, answers):
        failures += bool(wrong)
        if wrong or given.show:
            print(f'{"FAILED " if wrong else ""}{case.name}: {"; ".join(wrong)}\n    ' + '\n    '.join(answer.strip().splitlines()[-8:]))
    print(f'{len(cases)} wrong projects, {failures} answered wrongly')
    return 1 if failures or not cases else 0


if __name__ == '__main__':
    sys.exit(main())
