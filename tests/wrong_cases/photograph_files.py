"""Faults in photographs and the files beside them."""
import os

from wrong_cases.case import CAPTURE, Case, INPUT, POSES, STATUS, USAGE, photographs, png, whole_png, write


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
        case('in folders below only', ('1 made',), lambda folder: [(write(folder / 'photos/rest/camera1' / photo.name, photo.read_bytes()), photo.unlink()) for photo in photographs(folder)] and None, code=0),
        case('name that is not UTF-8', ('UTF-8',), lambda folder: os.rename(os.fsencode(photographs(folder)[0]), os.fsencode(folder / 'photos/rest') + b'/\xff.jpg')),
        case('a gif', ('FIRST', 'JPEG'), first(lambda photo: photo.write_bytes(b'GIF89a' + bytes(500)))),
        case('PNG that claims 20,000 pixels a side', ('FIRST', '20000'), first(lambda photo: photo.write_bytes(png(20000, 20000)))),
        case('PNG without pixels', ('FIRST',), first(lambda photo: photo.write_bytes(png(0, 10)))),
        case('PNG cut short', ('FIRST',), first(lambda photo: photo.write_bytes(png(10, 10)[:40]))),
        case('one of another size', ('different sizes', 'FIRST'), first(lambda photo: photo.write_bytes(whole_png(64, 48, 90))), code=0),
        case('one pixel each', ('pixel',), each(lambda photo: photo.write_bytes(whole_png(1, 1, number_of(photo))))),
        case('one pixel wide', ('pixel',), each(lambda photo: photo.write_bytes(whole_png(1, 2000, number_of(photo))))),
        case('all of one colour', ('rest',), each(lambda photo: photo.write_bytes(whole_png(320, 240, 90 + number_of(photo))))),
        case('all the same', ('byte for byte', 'delete the copies'), each(lambda photo: photo.write_bytes(whole_png(320, 240, 0)))),
        case('masks all black', ('black', 'FIRST'), masks_of(whole_png(320, 240, 0)), yaml=with_masks),
        case('masks of another size', ('mask', 'FIRST', '64 x 64'), masks_of(whole_png(64, 64, 255)), yaml=with_masks),
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
        case('two sizes', 0, ('different sizes', '64 x 48'), capture, spoil=lambda folder: photographs(folder, 'bent')[0].write_bytes(whole_png(64, 48, 90)) and None),
        case('masks all black', INPUT, ('black', 'IMG_0001.jpg', '--background'), capture, few_masked, black_masks),
        init('init of the template', ("--few rest: 'rest' is the template", '--template'), '--few', 'rest'),
        init('init of no pose', ('--few wave', 'no pose of that name'), '--few', 'wave'),
        init('init both ways', ('--few bent and --scan bent',), '--few', 'bent', '--scan', 'bent'),
    ]


def number_of(photo):
    return int(photo.stem.rsplit('_', 1)[1])
