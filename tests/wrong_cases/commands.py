"""Faults in commands, and in the state of a project."""
import os
import shutil

from wrong_cases.case import CAPTURE, Case, DISK, INPUT, STATUS, USAGE, write


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
