"""Cameras and calibrations of other programs: cases of files_table.py."""
import json
import math
import os
import struct

import cv2
import numpy as np

from files_cases import Outcome, case, cases, tool


def look_at(eye, target=(0, 0, 0)):
    """@return R, t of camera from world: x right, y down, z forwards; z of the world is up"""
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, (0, 0, 1.0))
    right /= np.linalg.norm(right)
    turn = np.stack([right, np.cross(forward, right), forward])
    return turn, -turn @ eye


def ring(count, radius, height, target=(0, 0, 0)):
    angles = 2 * math.pi * np.arange(count) / count + 0.3
    return [look_at(np.array([radius * math.cos(a), radius * math.sin(a), height + 0.3 * (i % 2)]), target) for i, a in enumerate(angles)]


def outline(parts, pose, focal, size):
    """255 where the balls (centre, radius) are, seen by a pinhole"""
    mask, ball = np.zeros((size[1], size[0]), np.uint8), np.random.default_rng(0).normal(size=(600, 3))
    ball /= np.linalg.norm(ball, axis=1)[:, None]
    for middle, radius in parts:
        x = (np.array(middle) + radius * ball) @ pose[0].T + pose[1]
        cv2.fillConvexPoly(mask, cv2.convexHull(np.round(x[:, :2] / x[:, 2:] * focal + np.array(size) / 2 - 0.5).astype(np.int32)), 255)
    return mask


LUMPS = [((0, 0, 0), 0.5), ((0.5, 0.1, 0.3), 0.3), ((-0.2, -0.4, 0.5), 0.25)]
WIDTH, HEIGHT, FOCAL, VIEWS = 320, 240, 300.0, 8


def speckled(mask, seed):
    noise = np.random.default_rng(seed).integers(0, 120, (*mask.shape, 3), np.uint8)
    return cv2.GaussianBlur(np.where(mask[..., None] > 0, noise + 100, 60 + noise // 12), (3, 3), 0)


def ring_photographs(b):
    """Eight photographs of a figure of balls, with masks. @return folder of `photos`, the cameras"""
    folder, cameras = b.folder('ring'), ring(VIEWS, 4, 1.2)
    (folder / 'photos/masks').mkdir(parents=True)
    for i, pose in enumerate(cameras):
        mask = outline(LUMPS, pose, FOCAL, (WIDTH, HEIGHT))
        cv2.imwrite(str(folder / f'photos/IMG_{i}.png'), speckled(mask, i))
        cv2.imwrite(str(folder / f'photos/masks/IMG_{i}.png.png'), mask)
    return folder, cameras


def capture(b, photos, *options):
    """@return code, text, capture.json, its folder"""
    images = b.folder('capture') / 'images'
    code, text = b.keypose('capture', '--photos', photos, '--images', images, *options)
    return code, text, json.loads((images / 'capture.json').read_text()) if code == 0 else {}, images


def captured_ring(b):
    return capture(b, b.once(ring_photographs)[0] / 'photos')[3]


def turn_of(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def quaternion(turn):
    axis = cv2.Rodrigues(turn)[0][:, 0]
    angle = np.linalg.norm(axis)
    return (math.cos(angle / 2), *(axis * (math.sin(angle / 2) / max(angle, 1e-12))))


def read_model(folder):
    """COLMAP's binary model. @return {photograph: (R, t, kind of lens, parameters)}"""
    counts, cameras, views = {0: 3, 1: 4, 2: 4, 3: 5, 4: 8, 5: 8, 6: 12}, {}, {}
    data, at = (folder / 'cameras.bin').read_bytes(), 8
    for _ in range(struct.unpack_from('<Q', data)[0]):
        number, kind, _, _ = struct.unpack_from('<iiQQ', data, at)
        cameras[number] = kind, struct.unpack_from(f'<{counts[kind]}d', data, at + 24)
        at += 24 + 8 * counts[kind]
    data, at = (folder / 'images.bin').read_bytes(), 8
    for _ in range(struct.unpack_from('<Q', data)[0]):
        _, *pose, camera = struct.unpack_from('<i7di', data, at)
        end = data.index(b'\0', at + 64)
        views[data[at + 64:end].decode()] = turn_of(*pose[:4]), np.array(pose[4:]), *cameras[camera]
        at = end + 9 + 24 * struct.unpack_from('<Q', data, end + 1)[0]
    return views


def lens(kind, p, rays):
    """Pixels of rays x/z, y/z by a COLMAP camera: PINHOLE, OPENCV, OPENCV_FISHEYE."""
    r2 = (rays ** 2).sum(-1, keepdims=True)
    if kind == 5:
        r = np.maximum(np.sqrt(r2), 1e-12)
        theta = np.arctan(r)
        bent = rays * theta / r * (1 + sum(p[4 + k] * theta ** (2 * k + 2) for k in range(4)))
    else:
        k1, k2, p1, p2 = p[4:8] if kind == 4 else (0, 0, 0, 0)
        x, y = rays[..., :1], rays[..., 1:]
        bent = rays * (1 + k1 * r2 + k2 * r2 ** 2) + np.concatenate([2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y], -1)
    return bent * p[:2] + p[2:4]


def centres_off(views, right):
    if set(views) != set(right):
        return 9.0
    return float(max(np.linalg.norm(-views[n][0].T @ views[n][1] - right[n]) for n in right))


def sfm(b, images, poses):
    model = b.folder('sfm') / 'model'
    code, text = b.keypose('sfm', '--images', images, '--model', model, '--poses', poses)
    return code, text, read_model(model) if code == 0 else None


RING16 = '16_colmap_text/truth.json'


def report_sfm(b, photos, poses, name='IMG {:02d}.jpg'):
    """Of reports 16 to 19, whose six cameras are the same."""
    truth = [np.array(t['center']) for t in json.loads(b.report(RING16).read_text())]
    poses = b.report(poses)
    code, text, _, images = capture(b, b.report(photos), '--min_images', 3)
    if code == 0:
        code, text, views = sfm(b, images, poses)
    if code != 0:
        return Outcome(code, text)
    numbers = [('centres', centres_off(views, {name.format(i): c for i, c in enumerate(truth)}), 1e-6)]
    if (poses / 'cameras.bin').exists():
        x, y = np.meshgrid(np.linspace(-0.38, 0.38, 9), np.linspace(-0.28, 0.28, 7))
        rays, given = np.stack([x, y], -1), read_model(poses)
        numbers.append(('lens px', max(float(np.abs(lens(*views[n][2:], rays) - lens(*given[n][2:], rays)).max()) for n in views), 0.1))
    return Outcome(code, text, numbers)


def own_sfm(b, write):
    """@param write  (folder, cameras) makes a file of the ring's cameras and returns its path"""
    folder, cameras = b.once(ring_photographs)
    code, text, views = sfm(b, b.once(captured_ring), write(b, b.folder('cameras'), cameras))
    if code != 0:
        return Outcome(code, text)
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, 9), np.linspace(-0.4, 0.4, 7))
    pinhole = np.stack([x, y], -1) * FOCAL + [WIDTH / 2, HEIGHT / 2]
    off = max(float(np.abs(lens(*v[2:], np.stack([x, y], -1)) - pinhole).max()) for v in views.values())
    right = {f'IMG_{i}.png': -turn.T @ t for i, (turn, t) in enumerate(cameras)}
    return Outcome(code, text, [('centres', centres_off(views, right), 1e-6), ('lens px', off, 0.1)])


def colmap_text(folder, cameras, camera, blank=''):
    folder.mkdir(exist_ok=True)
    (folder / 'cameras.txt').write_text(f'# Camera list\n{blank}1 {camera}\n')
    rows = [f'{i + 1} ' + ' '.join(f'{x:.17g}' for x in (*quaternion(turn), *t)) + f' 1 IMG_{i}.png\n\n' for i, (turn, t) in enumerate(cameras)]
    (folder / 'images.txt').write_text('# Image list\n' + blank + ''.join(rows))
    (folder / 'points3D.txt').write_text('# 3D point list\n')
    return folder


def by_colmap(camera, form):
    """The model, written anew by COLMAP's own program."""
    def write(b, folder, cameras):
        colmap_text(folder / 'in', cameras, camera)
        (folder / 'out').mkdir()
        tool('colmap', 'model_converter', '--input_path', folder / 'in', '--output_path', folder / 'out', '--output_type', form)
        return folder / 'out'
    return write


def utf16_colmap(b, folder, cameras):
    """As an editor of Windows may write it."""
    colmap_text(folder, cameras, PLAIN)
    for file in folder.iterdir():
        file.write_bytes(file.read_text().encode('utf-16'))
    return folder


PLAIN = f'PINHOLE {WIDTH} {HEIGHT} {FOCAL} {FOCAL} {WIDTH / 2} {HEIGHT / 2}'
SIZE = f'{WIDTH} {HEIGHT} {FOCAL} {FOCAL} {WIDTH / 2} {HEIGHT / 2} '
TANGENT = f'{1 / 3} {2 / 15} {17 / 315} {62 / 2835}'  # a fisheye with these is a pinhole, to 0.02 px
SFM = '`keypose sfm --poses`'
cases('COLMAP', SFM, [('16 plain', '', 'right', '16_colmap_text/photos', '16_colmap_text/plain'), ('16 blank line', '', 'right', '16_colmap_text/photos', '16_colmap_text/blank_first_line'),
                      ('17 OPENCV', '', 'right', '18_transforms_json/photos', '17_colmap_models/OPENCV', 'IMG{}.jpg'),
                      ('17 OPENCV_FISHEYE', '', 'right', '18_transforms_json/fisheye_photos', '17_colmap_models/OPENCV_FISHEYE', 'IMG{}.jpg')], report_sfm)
cases('COLMAP', SFM, [
    ('COLMAP text', '', 'right', by_colmap(PLAIN, 'TXT')), ('COLMAP binary', '', 'right', by_colmap(PLAIN, 'BIN')),
    ('fisheye that is a pinhole', '', 'right', by_colmap('OPENCV_FISHEYE ' + SIZE + TANGENT, 'BIN')),
    ('FULL_OPENCV that is a pinhole', '', 'right', by_colmap('FULL_OPENCV ' + SIZE + '0.2 0.1 0 0 0.05 0.2 0.1 0.05', 'BIN')),
    ('wide THIN_PRISM_FISHEYE', 'THIN_PRISM_FISHEYE', 'named', by_colmap('THIN_PRISM_FISHEYE ' + SIZE + '0.2 0.1 0 0 0.3 0.2 0.01 0.01', 'TXT')),
    ('FOV', 'FOV', 'named', by_colmap('FOV ' + SIZE + '1.2', 'BIN')),
    ('empty lines', '', 'right', lambda b, folder, cameras: colmap_text(folder, cameras, PLAIN, '\n  \n')),
    ('UTF-16', '', 'right', utf16_colmap),
    ('EQUIRECTANGULAR', 'EQUIRECTANGULAR', 'named', lambda b, folder, cameras: colmap_text(folder, cameras, f'EQUIRECTANGULAR {WIDTH} {HEIGHT}'))], own_sfm)


def transforms(change=lambda root: None):
    def write(b, folder, cameras):
        root = {'w': WIDTH, 'h': HEIGHT, 'fl_x': FOCAL, 'fl_y': FOCAL, 'cx': WIDTH / 2, 'cy': HEIGHT / 2, 'frames': []}
        for i, (turn, t) in enumerate(cameras):
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = turn.T @ np.diag([1, -1, -1]), -turn.T @ t
            root['frames'].append({'file_path': f'images/IMG_{i}.png', 'transform_matrix': matrix.tolist()})
        change(root)
        (folder / 'transforms.json').write_text(json.dumps(root))
        return folder / 'transforms.json'
    return write


def each_its_own(root):
    for k in ('fl_x', 'fl_y', 'cx', 'cy', 'w', 'h'):
        for frame in root['frames']:
            frame[k] = root[k]
        root[k] = 999 if k in 'wh' else 77.0


cases('transforms.json', SFM, [
    ('18 plain', '', 'right', '18_transforms_json/photos', '18_transforms_json/plain.json', 'IMG{}.jpg'),
    ('18 backslashes', '', 'right', '18_transforms_json/photos', '18_transforms_json/backslashes.json', 'IMG{}.jpg'),
    ('18 is_fisheye', '', 'right', '18_transforms_json/fisheye_photos', '18_transforms_json/is_fisheye.json', 'IMG{}.jpg')], report_sfm)
cases('transforms.json', SFM, [
    ('nerfstudio', '', 'right', transforms(lambda root: root.update(camera_model='OPENCV', k1=0, k2=0, p1=0, p2=0, applied_transform=[[0, 1, 0, 0], [1, 0, 0, 0], [0, 0, -1, 0]]))),
    ('lenses of frames', '', 'right', transforms(each_its_own)),
    ('instant-ngp, camera_angle_x', '', 'right', transforms(lambda root: (root.update(camera_angle_x=2 * math.atan(WIDTH / 2 / FOCAL), aabb_scale=4), root.pop('fl_x'), root.pop('fl_y')))),
    ('OPENCV_FISHEYE', '', 'right', transforms(lambda root: root.update(camera_model='OPENCV_FISHEYE', **dict(zip(('k1', 'k2', 'k3', 'k4'), map(float, TANGENT.split())))))),
    ('EQUIRECTANGULAR', 'EQUIRECTANGULAR', 'named', transforms(lambda root: root.update(camera_model='EQUIRECTANGULAR'))),
    ('distortion_params', '', 'right', transforms(lambda root: root.update(camera_model='OPENCV_FISHEYE', distortion_params=[*map(float, TANGENT.split()), 0, 0]))),
    ('x_fov', '', 'right', transforms(lambda root: (root.update(x_fov=math.degrees(2 * math.atan(WIDTH / 2 / FOCAL))), root.pop('fl_x'), root.pop('fl_y')))),
    ('three rows', '', 'right', transforms(lambda root: [frame.update(transform_matrix=frame['transform_matrix'][:3]) for frame in root['frames']])),
    ('an angle in degrees', 'in radians', 'named', transforms(lambda root: (root.update(camera_angle_x=40.), root.pop('fl_x'), root.pop('fl_y')))),
    ('mirrored', 'mirrors', 'named', transforms(lambda root: [row.__setitem__(0, -row[0]) for frame in root['frames'] for row in frame['transform_matrix'][:3]])),
    ('rolling_shutter', 'rolling_shutter', 'named', transforms(lambda root: root.update(rolling_shutter=[0, 0, 0.03, 0]))),
    ('from_na', 'from_na', 'named', transforms(lambda root: root.update(from_na=True)))], own_sfm)


def metashape(version, kind='frame', extra='', cx=0.0):
    def write(b, folder, cameras):
        lens_of = lambda c, f: f'<calibration type="{kind}" class="{c}"><resolution width="{WIDTH}" height="{HEIGHT}"/><f>{f}</f><cx>{cx}</cx><cy>0</cy>{extra}</calibration>'
        rows = []
        for i, (turn, t) in enumerate(cameras):
            matrix = np.eye(4)
            matrix[:3, :3], matrix[:3, 3] = turn.T, -turn.T @ t
            rows.append(f'<camera id="{i}" sensor_id="0" label="IMG_{i}" enabled="true"><transform>{" ".join(f"{x:.17g}" for x in matrix.ravel())}</transform></camera>')
        (folder / 'cameras.xml').write_text(
            f'<?xml version="1.0" encoding="UTF-8"?>\n<document version="{version}"><chunk label="a"><sensors><sensor id="0" label="b" type="{kind}"><resolution width="{WIDTH}" height="{HEIGHT}"/>'
            f'{lens_of("initial", 280)}{lens_of("adjusted", FOCAL)}</sensor></sensors><cameras>{"".join(rows)}</cameras><reference>LOCAL_CS</reference></chunk></document>')
        return folder / 'cameras.xml'
    return write


cases('Metashape', SFM, [('19', '', 'right', '18_transforms_json/photos', '19_metashape_xml/cameras.xml', 'IMG{}.jpg')], report_sfm)
cases('Metashape', SFM, [('version 1.4', '', 'right', metashape('1.4.0')), ('version 2.1', '', 'right', metashape('2.1.0')),
                         ('fisheye that is a pinhole', '', 'right', metashape('2.0.0', 'fisheye', ''.join(f'<k{k + 1}>{x}</k{k + 1}>' for k, x in enumerate(TANGENT.split())))),
                         ('spherical', 'spherical', 'named', metashape('2.0.0', 'spherical'))], own_sfm)


@case('COLMAP: names of options', SFM, '30')
def new_options(b):
    """A stand-in for COLMAP 4.1, first in PATH: the same cameras as without."""
    path = str(b.report('30_colmap_new_options'))
    models = []
    for env in (None, {**os.environ, 'PATH': path + os.pathsep + os.environ['PATH']}):
        model = b.folder('sfm') / 'model'
        code, text = b.keypose('sfm', '--images', b.once(captured_ring), '--model', model, '--poses', transforms()(b, b.folder('cameras'), b.once(ring_photographs)[1]), env=env)
        if code != 0:
            return Outcome(code, text)
        models.append(read_model(model))
    off = max(float(np.abs(models[0][n][1] - models[1][n][1]).max()) for n in models[0]) if set(models[0]) == set(models[1]) else 9.0
    return Outcome(code, text, [('centres', off, 1e-9)])
