"""Faults in pipeline.yaml: its keys, steps, timeline and options."""
from wrong_cases.case import Case, INPUT, POSES, TOOL, USAGE

# What only a run would come upon, an hour later.
DRY_RUN = ('run', '--dry-run')


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
        case('second document within quotes', 3, ('second document',), 'poses:\n  rest: "photos\n---\n  rest"\n'),
        case('unknown key', 4, ("no key 'tmeplate'", "'template'"), POSES + 'tmeplate: rest\n'),
        case('unknown key far from all', 4, ("no key 'x'",), POSES + 'x: 1\n'),
        case('key twice', 4, ('twice',), POSES + 'poses: {rest: photos/rest}\n'),
        case('lists in lists, 60 deep', 4, ('50 levels', 'alias'), POSES + 'timeline: ' + '[' * 60 + ']' * 60 + '\n'),
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
    def case(name, line, words, timeline, **more):
        return Case(f'timeline: {name}', USAGE, (f'pipeline.yaml:{line}',) + words, yaml=POSES + 'timeline' + timeline, **more)
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
        case('loop that does not close', 6, ("begins with pose 'rest' and ends with 'bent'",), whole('loop: true'), command=DRY_RUN),
        case('two keys in one frame', 4, ('same frame', '0.01 s'), ': [{pose: rest, at: 0}, {pose: bent, at: 0.01}]\n', command=DRY_RUN),
        case('pin where no key is', 7, ("the pin of 'arm'", '0.5 s', 'no key'), whole('regions: [{name: arm, center: [0, 0, 0], radius: 1}]\n  pins: [{region: arm, to: 0.5}]'), command=DRY_RUN),
    ]


def option_cases(stages):
    """Per stage of the default pipeline: an unknown option, and a number beyond its range. Once, whichever stage has it first: each kind of
    invalid value, since all stages' options are checked by one function, against what the stage says of itself."""
    cases = [
        Case('option: formats that are none', USAGE, ("options of step 'export'", "names 'mpp4'", 'video'),
             yaml=POSES + 'options:\n  export: {formats: "glb,mpp4"}\n', command=DRY_RUN),
        Case('option: two that contradict', USAGE, ("options of step 'register/bent'", 'good_fit must not be above poor_fit'),
             yaml=POSES + 'options:\n  register: {good_fit: 0.5}\n', command=DRY_RUN),
    ]
    seen = set()
    for number, (stage, described) in enumerate(stages.items()):
        def case(option, text, words, stage=stage):
            cases.append(Case(f'option: {stage}.{option} {text}', USAGE, ('pipeline.yaml:5', f"step '{stage}'") + words,
                              yaml=POSES + f'options:\n  {stage}: {{{option}: {text}}}\n'))
        first = described['options'][0]['name']
        case(first + 'x', 1, (f"no option '{first}x'", f"'{first}'"))
        case(*beyond_its_range(described['options'], above=number % 2 == 1))
        for option in described['options']:
            kind = 'choice' if option.get('choices') else option['type']
            if kind in seen:
                continue
            seen.add(kind)
            for text, words in invalid_values(kind, option):
                case(option['name'], text, words)
    return cases


def invalid_values(kind, option):
    """@return pairs of an invalid value and the words of the answer"""
    name = option['name']
    if kind == 'choice':
        return [('nothing', (f"'{name}'", 'must be one of', *option['choices']))]
    if kind == 'bool':
        return [('perhaps', (f"'{name}' is 'perhaps'", 'true or false'))]
    if kind in ('int', 'double'):
        return [('many', (f"'{name}' is 'many'", 'whole number' if kind == 'int' else 'number')), ('nan', (f"'{name}'", 'number'))]
    return []


def beyond_its_range(options, above):
    """@return of the stage's first number with a range: its name, a value just beyond the range, and the words of the answer"""
    bound = 'max' if above else 'min'
    option = next(one for one in options if one['type'] in ('int', 'double') and one.get(bound) is not None)
    name, value = option['name'], int(option[bound]) + (1 if above else -1)
    return name, value, (f"'{name}'", 'must be') if above else (f"'{name}' is {value}", 'must be')
