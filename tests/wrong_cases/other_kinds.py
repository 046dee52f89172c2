"""Faults of projects of filmed performances, and of poses that were filmed."""
from wrong_cases.case import Case, INPUT, POSES, STATUS, USAGE, write


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
        Case('performance: calibration without the kind', USAGE, ('--calibration', 'need --kind performance'), ('init', 'new', '--pose', 'rest=photos/rest', '--calibration', 'pipeline.yaml'), outside=True),
        Case('performance: nothing but shots without the kind', USAGE, ('need --kind performance',), ('init', 'new', '--shot', 'walk=photos'), outside=True),
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
