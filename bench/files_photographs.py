"""Photographs, masks and boards: cases of files_table.py."""
import math
import shutil
import struct

import cv2
import numpy as np
from PIL import Image
from PIL.TiffImagePlugin import IFDRational as R

from files_cases import Outcome, Skip, case, cases
from files_cameras import HEIGHT, VIEWS, WIDTH, capture, ring, ring_photographs
from files_rigs import rig_matrices

CAPTURE = '`keypose capture`'


def photographs(b, save, masks=True):
    """Copies of the ring's photographs. @param save  (picture RGB, path without ending, number) writes one"""
    source, folder = b.once(ring_photographs)[0] / 'photos', b.folder('photos')
    if masks:
        (folder / 'masks').mkdir()
    for i in range(VIEWS):
        save(cv2.imread(str(source / f'IMG_{i}.png'))[..., ::-1], folder / f'IMG_{i}', i)
        if masks:
            shutil.copy(source / f'masks/IMG_{i}.png.png', folder / f'masks/IMG_{i}.png')
    return folder


def exif_focal(b, tags, right, turned=False):
    def save(picture, path, _):
        exif = Image.Exif()
        exif.update({tag: value for tag, value in tags.items() if tag < 0x8769})
        exif[0x8769] = {tag: value for tag, value in tags.items() if tag > 0x8769}
        Image.fromarray(np.ascontiguousarray(np.rot90(picture) if turned else picture)).save(f'{path}.jpg', quality=95, exif=exif)
    code, text, images, _ = capture(b, photographs(b, save))
    if code != 0:
        return Outcome(code, text)
    return Outcome(code, text, [('px off', max(abs(i['focal_px'] - right) for i in images['images']), 0.1), ('sizes', sum(i['width'] != WIDTH for i in images['images']), 0)])


@case('EXIF', CAPTURE, '22 35 mm of 4:3')
def report_focal(b):
    code, text, images, _ = capture(b, b.report('22_exif_focal/equivalent_35mm_of_4_to_3'))
    return Outcome(code, text, [('px off', abs(images['images'][0]['focal_px'] - 795), 0.1)] if code == 0 else [])


DIAGONAL = math.hypot(WIDTH, HEIGHT)
FOCAL_MM, EQUIVALENT, PITCH_X, PITCH_Y, UNIT, ORIENTATION = 0x920A, 0xA405, 0xA20E, 0xA20F, 0xA210, 0x0112
cases('EXIF', CAPTURE, [
    ('35 mm equivalent', '', 'right', {EQUIVALENT: 26}, 26 / math.hypot(36, 24) * DIAGONAL),
    ('sensor in cm', '', 'right', {FOCAL_MM: R(50, 1), PITCH_X: R(WIDTH * 10, 36), PITCH_Y: R(WIDTH * 10, 36), UNIT: 3}, 50 * WIDTH / 36),
    ('sensor in inches', '', 'right', {FOCAL_MM: R(50, 1), PITCH_X: R(WIDTH * 254, 360), PITCH_Y: R(WIDTH * 254, 360), UNIT: 2}, 50 * WIDTH / 36),
    ('turned, Orientation 6', '', 'right', {EQUIVALENT: 26, ORIENTATION: 6}, 26 / math.hypot(36, 24) * DIAGONAL, True),
    ('equivalent of 0', '', 'right', {EQUIVALENT: 0}, 0)], exif_focal)

PROFILES = {  # columns of D50 XYZ of red, green, blue; gamma
    'sRGB': ([[0.43607, 0.38515, 0.14307], [0.22249, 0.71687, 0.06061], [0.01392, 0.09708, 0.71410]], 0),
    'P3': ([[0.51512, 0.29198, 0.15710], [0.24120, 0.69225, 0.06657], [-0.00105, 0.04189, 0.78407]], 563 / 256),
    'Adobe RGB': ([[0.60974, 0.20528, 0.14919], [0.31111, 0.62567, 0.06322], [0.01947, 0.06087, 0.74457]], 563 / 256),
    'ProPhoto': ([[0.79767, 0.13519, 0.03135], [0.28804, 0.71188, 0.00009], [0.0, 0.0, 0.82491]], 461 / 256)}


def icc(name):
    """A matrix profile of ICC version 2.1."""
    columns, gamma = np.array(PROFILES[name][0]).T, PROFILES[name][1]
    xyz = lambda v: b'XYZ \0\0\0\0' + b''.join(struct.pack('>i', round(x * 65536)) for x in v)
    words = name.encode() + b'\0'
    tags = {b'desc': b'desc\0\0\0\0' + struct.pack('>I', len(words)) + words + bytes(78), b'cprt': b'text\0\0\0\0CC0\0', b'wtpt': xyz((0.9642, 1, 0.8249))}
    for letter, column in zip(b'rgb', columns):
        tags[bytes([letter]) + b'XYZ'] = xyz(column)
        tags[bytes([letter]) + b'TRC'] = b'curv\0\0\0\0' + struct.pack('>IH', 1, round(gamma * 256)) + b'\0\0'
    table, body, at = b'', b'', 132 + 12 * len(tags)
    for tag, data in tags.items():
        data += bytes(-len(data) % 4)
        table += tag + struct.pack('>II', at + len(body), len(data))
        body += data
    head = struct.pack('>I4sI4s4s4s', at + len(body), bytes(4), 0x02100000, b'mntr', b'RGB ', b'XYZ ') + bytes(12) + b'acsp' + bytes(28) + struct.pack('>3i', 63190, 65536, 54061)
    return head + bytes(128 - len(head)) + struct.pack('>I', len(tags)) + table + body


def srgb_of(picture, name):
    matrix, gamma = PROFILES[name]
    linear = (picture / 255.0) ** gamma @ np.array(matrix).T @ np.linalg.inv(np.array(PROFILES['sRGB'][0])).T
    linear = np.clip(linear, 0, 1)
    return 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def patches(seed):
    colors = np.random.default_rng(seed).integers(60, 200, (6, 8, 3), np.uint8)
    return np.repeat(np.repeat(colors, 40, 0), 40, 1)


def patch_levels(b, save, right):
    """Patches of 40 pixels, written by `capture --max_size` at half the size: mean difference in their middles."""
    folder = b.folder('patches')
    (folder / 'masks').mkdir()
    for i in range(8):
        save(patches(i), folder / f'IMG_{i}')
        cv2.imwrite(str(folder / f'masks/IMG_{i}.png'), cv2.circle(np.zeros((240, 320), np.uint8), (160, 120), 60, 255, -1))
    code, text, images, out = capture(b, folder, '--max_size', 160, '--min_sharpness', 0)
    if code != 0:
        return Outcome(code, text)
    off = [np.abs(cv2.imread(str(out / f['name']))[10::20, 10::20, ::-1].astype(float) - right(patches(i)[20::40, 20::40])).mean() for i, f in enumerate(images['images'])]
    return Outcome(code, text, [('levels', float(max(off)), 1.5)])


def with_pil(ending, name, **how):
    return lambda picture, path: Image.fromarray(picture).save(f'{path}.{ending}', icc_profile=icc(name), **how)


@case('colour profiles, 16 bits', CAPTURE, '24 Display P3')
def report_profile(b):
    shown = []
    for name in ('srgb', 'display_p3'):
        code, text, images, out = capture(b, b.report('24_color_profiles/' + name), '--max_size', 320)
        if code != 0:
            return Outcome(code, text)
        shown.append([cv2.imread(str(out / f['name'])).astype(float) for f in images['images']])
    return Outcome(code, text, [('levels', max(float(np.abs(p - q).mean()) for p, q in zip(*shown)), 1.5)])


cases('colour profiles, 16 bits', CAPTURE, [
    ('P3 in PNG', '', 'right', with_pil('png', 'P3'), lambda p: srgb_of(p, 'P3')),
    ('Adobe RGB in JPEG', '', 'right', with_pil('jpg', 'Adobe RGB', quality=100, subsampling=0), lambda p: srgb_of(p, 'Adobe RGB')),
    ('ProPhoto in TIFF', '', 'right', with_pil('tif', 'ProPhoto'), lambda p: srgb_of(p, 'ProPhoto')),
    ('16 bit PNG', '', 'right', lambda picture, path: cv2.imwrite(f'{path}.png', picture[..., ::-1].astype(np.uint16) * 257), lambda p: p),
    ('16 bit TIFF', '', 'right', lambda picture, path: cv2.imwrite(f'{path}.tif', picture[..., ::-1].astype(np.uint16) * 257), lambda p: p)], patch_levels)


def masks_off(images, out, right):
    return max(int((cv2.imread(str(out / f['mask']), 0) != r).sum()) for f, r in zip(images['images'], right))


def own_masks(b, save, least=0):
    """@param save  (true mask, path without ending) writes one as another program does"""
    folder = photographs(b, lambda picture, path, _: cv2.imwrite(f'{path}.png', picture[..., ::-1]), masks=False)
    (folder / 'masks').mkdir()
    source = b.once(ring_photographs)[0] / 'photos/masks'
    right = [cv2.imread(str(source / f'IMG_{i}.png.png'), 0) for i in range(VIEWS)]
    for i, mask in enumerate(right):
        save(mask, folder / f'masks/IMG_{i}')
    code, text, images, out = capture(b, folder)
    return Outcome(code, text, [('pixels off', masks_off(images, out, right), least)] if code == 0 else [])


@case('masks', CAPTURE, '25 inverted')
def report_inverted(b, kind='inverted'):
    done = [capture(b, b.report('25_mask_kinds/' + name)) for name in ('plain_names', kind)]
    if any(code != 0 for code, *_ in done):
        return Outcome(max(d[0] for d in done), done[1][1])
    right = [cv2.imread(str(done[0][3] / f['mask']), 0) for f in done[0][2]['images']]
    return Outcome(0, done[1][1], [('pixels off', masks_off(done[1][2], done[1][3], right), 0)])


def put(mask, path):
    cv2.imwrite(str(path), mask)


case('masks', CAPTURE, '25 levels 0 and 1')(lambda b: report_inverted(b, 'levels_0_and_1'))
cases('masks', CAPTURE, [
    ('16 bits', '', 'right', lambda m, p: put(m.astype(np.uint16) * 257, f'{p}.png')),
    ('alpha', '', 'right', lambda m, p: put(np.dstack([np.full((*m.shape, 3), 90, np.uint8), m]), f'{p}.png')),
    ('_mask, inverted', '', 'right', lambda m, p: put(255 - m, f'{p}_mask.png')),
    ('half the size', '', 'right', lambda m, p: put(cv2.resize(m, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_NEAREST), f'{p}.png'), 700),
    ('labels', 'levels', 'named', lambda m, p: put(np.where(m > 0, 1, np.arange(m.shape[1], dtype=np.uint8) % 2 * 2).astype(np.uint8), f'{p}.png')),
    ('trimap', 'undecided', 'named', lambda m, p: put(np.where(cv2.dilate(m, np.ones((25, 25))) == cv2.erode(m, np.ones((25, 25))), m, 128).astype(np.uint8), f'{p}.png')),
], own_masks)


def board_numbers(b, photos, board, square, distance, focal=None):
    """Corners that `capture --board` found: on one plane, and the cameras by OpenCV's own calibration of them at this distance of the board's middle."""
    folder = b.folder('board')
    (folder / 'masks').mkdir()
    for file in sorted(photos.glob('*.png')):
        picture = cv2.imread(str(file))
        shutil.copy(file, folder)
        put(cv2.circle(np.zeros(picture.shape[:2], np.uint8), (picture.shape[1] // 2, picture.shape[0] // 2), 20, 255, -1), folder / 'masks' / file.name)
    code, text, images, _ = capture(b, folder, '--min_images', 3, '--min_sharpness', 0, *(['--board', board] if board else []))
    if code != 0 or not images.get('board'):
        return Outcome(code, text)
    columns, rows = images['board']['columns'] - 1, images['board']['rows'] - 1
    found = [np.array(i['board_corners']) for i in images['images'] if i['board_corners']]
    places = [np.stack([f[:, 0] % columns, f[:, 0] // columns, 0 * f[:, 0]], 1).astype(np.float32) * square for f in found]
    pixels = [f[:, 1:].astype(np.float32) for f in found]
    fixed = cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_FIX_K1 | cv2.CALIB_FIX_K2 | cv2.CALIB_FIX_K3
    error, matrix, _, turns, shifts = cv2.calibrateCamera(places, pixels, picture.shape[1::-1], np.array([[900, 0, picture.shape[1] / 2 - 0.5], [0, 900, picture.shape[0] / 2 - 0.5], [0, 0, 1.0]]),
                                                          None, flags=fixed | cv2.CALIB_USE_INTRINSIC_GUESS)
    middle = np.array([(columns - 1) / 2 * square, (rows - 1) / 2 * square, 0])
    away = [np.linalg.norm(cv2.Rodrigues(r)[0] @ middle + t[:, 0]) for r, t in zip(turns, shifts)]
    numbers = [('px', error, 0.3), ('distance off', float(max(abs(a / distance - 1) for a in away)), 0.01), ('boards missing', len(images['images']) - len(found), 0)]
    return Outcome(code, text, numbers + ([('focal length off', abs(matrix[0, 0] / focal - 1), 0.01)] if focal else []))


def board_pictures(b, columns, rows, square, marker, dictionary, inverted=False, count=8):
    """OpenCV's own drawing of a ChArUco board (layout of its version), seen from 0.4 m by a pinhole of 900 px."""
    if not hasattr(cv2, 'aruco'):
        raise Skip('OpenCV for Python has no aruco')
    family = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, dictionary))
    make = getattr(cv2.aruco, 'CharucoBoard_create', None) or (lambda c, r, s, m, f: cv2.aruco.CharucoBoard((c, r), s, m, f))
    board, scale = make(columns, rows, square, marker, family), 40
    size = (columns * scale, rows * scale)
    drawn = board.draw(size) if hasattr(board, 'draw') else board.generateImage(size)
    drawn = 255 - drawn if inverted else drawn
    folder = b.folder('board_pictures')
    for i, (turn, t) in enumerate(ring(count, 0.24, 0.32)):
        t, middle = t * 0.4 / np.linalg.norm(t), np.array([size[0] / 2 - 0.5, size[1] / 2 - 0.5])
        from_drawn = np.array([[square / scale, 0, -middle[0] * square / scale], [0, -square / scale, middle[1] * square / scale], [0, 0, 1]])
        seen = np.array([[900, 0, 319.5], [0, 900, 239.5], [0, 0, 1]]) @ np.column_stack([turn[:, :2], t]) @ from_drawn
        big = np.diag([4.0, 4.0, 1]) @ np.array([[1, 0, 0.375], [0, 1, 0.375], [0, 0, 1]]) @ seen  # four samples a pixel each way
        shown = cv2.warpPerspective(drawn, big, (2560, 1920), flags=cv2.INTER_LINEAR, borderValue=0 if inverted else 255)
        put(cv2.resize(shown, (640, 480), interpolation=cv2.INTER_AREA), folder / f'view{i}.png')
    return folder


BOARDS = [('OpenCV 7 x 5, 4x4', 7, 5, 0.03, 0.022, 'DICT_4X4_50'), ('OpenCV 6 x 8, 6x6', 6, 8, 0.025, 0.018, 'DICT_6X6_250'), ('OpenCV 9 x 6, AprilTag', 9, 6, 0.022, 0.016, 'DICT_APRILTAG_36h11')]
cases('boards', CAPTURE, [('29 since 4.6', '', 'right', 'since_4.6', None), ('29 before 4.6', '', 'right', 'before_4.6', '11x8:22mm:DICT_5X5_50:legacy'),
                          ('29 before 4.6, not said', 'before 4.6', 'named', 'before_4.6', None), ('29 4x4', '', 'right', 'other_dictionary_4x4', '11x8:22mm:DICT_4X4_50'),
                          ('29 4x4, not said', 'DICT_4X4_50', 'named', 'other_dictionary_4x4', None)],
      lambda b, name, board: board_numbers(b, b.report('29_charuco_layouts/' + name), board, 0.022, 0.35))
cases('boards', CAPTURE, [(name, '', 'right', *board) for name, *board in BOARDS],
      lambda b, c, r, s, m, d: board_numbers(b, board_pictures(b, c, r, s, m, d), f'{c}x{r}:{1000 * s:g}/{1000 * m:g}mm:{d}', s, 0.4, 900))


def lens_of_board(b, *board, inverted=False):
    folder = b.folder('lenses')
    shutil.copytree(board_pictures(b, *board, inverted, 14), folder / 'shot/cam1')
    code, text = b.keypose('calibrate', '--lenses', folder / 'shot', '--calibration', folder / 'rig.yml', '--board_square_mm', 1000 * board[2])
    if code != 0:
        return Outcome(code, text)
    matrix = rig_matrices(folder / 'rig.yml')['cam1']['camera_matrix']
    return Outcome(code, text, [('focal length off', abs(matrix[0, 0] / 900 - 1), 0.01), ('centre px', float(np.abs(matrix[:2, 2] - [319.5, 239.5]).max()), 10)])


cases('boards', '`keypose calibrate`', [(name, '', 'right', *board) for name, *board in BOARDS], lens_of_board)
case('boards', '`keypose calibrate`', 'printed inverted')(lambda b: lens_of_board(b, *BOARDS[0][1:], inverted=True))
