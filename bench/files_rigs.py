"""Calibrations of rigs, and motion clips: cases of files_table.py."""
import json
import re

import cv2
import numpy as np

from files_cases import Outcome, cases, tool
from files_meshes import read_ply
from files_cameras import outline, ring

BODY = ([((0, 0, 1.62), 0.13), ((0, 0, 1.5), 0.08)] + [((0, 0, z), 0.19) for z in np.arange(0.9, 1.45, 0.05)] +
        [((0, s * 0.12, 0.9 - 0.06 * k), 0.085) for s in (1, -1) for k in range(15)] + [((0.04 + 0.02 * k, s * 0.12, 0.06), 0.06) for s in (1, -1) for k in range(8)] +
        [((0, s * (0.2 + 0.055 * k), 1.4 - 0.03 * k), 0.055) for s in (1, -1) for k in range(12)])
RIG = ring(4, 3.5, 1.2, (0, 0, 0.9))
K = np.array([[900, 0, 639.5], [0, 900, 359.5], [0, 0, 1.0]])


def rig_matrices(file):
    """@return {camera: {name: matrix}} of a calibration that Keypose wrote"""
    rig = {}
    for line in file.read_text().splitlines():
        if line[0] not in ' %-' and line.endswith(':'):
            camera = rig.setdefault(line[:-1].strip('"'), {})
        elif 'opencv-matrix' in line:
            word = line.split(':')[0].strip()
        elif 'rows:' in line:
            rows = int(line.split(':')[1])
        elif 'data:' in line:
            camera[word] = np.array(line.split('[')[1].strip(' ]').split(','), float).reshape(rows, -1)
    return rig


def rig_numbers(b, calibration, cameras, name='cam{0}', radial=None, shrunk=4):
    """`keypose track --rig` writes the cameras that it read, for films of a quarter of the size where the file tells a size."""
    work = b.folder('rig')
    names = [name.format(i, i + 1) for i in range(len(cameras))]
    for name, pose in zip(names, cameras):
        mask = outline(BODY, pose, 900 / shrunk, (1280 // shrunk, 720 // shrunk))
        for folder in (work / 'shot' / name, work / 'shot/masks' / name):
            folder.mkdir(parents=True)
            for frame in range(2):
                cv2.imwrite(str(folder / f'{frame:03d}.png'), mask)
    code, text = b.keypose('track', '--video', work / 'shot', '--calibration', calibration, '--frames', work / 'frames', '--motion', work / 'm.bvh', '--rig', work / 'rig.yml',
                           '--actor_frames', 1, '--height_m', 1.75)
    if code != 0:
        return Outcome(code, text)
    rig = rig_matrices(work / 'rig.yml')
    read = [[rig[name][word] for word in ('rotation', 'translation', 'camera_matrix', 'distortion_coefficients')] for name in names]
    world, centres = (np.stack([-c[0].T @ np.ravel(c[1]) for c in of]) for of in (cameras, read))
    world, centres = ((x - x[0]) @ of[0][0].T for x, of in ((world, cameras), (centres, read)))  # in the first camera
    scale = np.linalg.norm(centres[1]) / np.linalg.norm(world[1])
    numbers = [('centres', float(np.abs(centres / scale - world).max()), 1e-6), ('focal length off', max(abs(r[2][0, 0] * shrunk / 900 - 1) for r in read), 1e-6)]
    if radial is not None:
        numbers.append(('k1', max(abs(r[3].ravel()[0] - radial) for r in read), 1e-6))
    return Outcome(code, text, numbers)


def report_rig(b, name, camera='cam{0}', shrunk=4):
    truth = json.loads(b.report('20_rig_calibrations/truth.json').read_text())
    return rig_numbers(b, b.report('20_rig_calibrations/' + name), [(np.array(c['R_camera_from_world']), np.array(c['t'])) for c in truth.values()], camera, -0.12, shrunk)


def opencv_rig(ending, coefficients, model=''):
    def write(folder):
        storage = cv2.FileStorage(str(folder / f'rig.{ending}'), cv2.FILE_STORAGE_WRITE)
        for i, (turn, t) in enumerate(RIG):
            storage.startWriteStruct(f'cam{i}', cv2.FILE_NODE_MAP)
            for word, value in (('image_width', 1280), ('image_height', 720), ('camera_matrix', K), ('distortion_coefficients', np.array([coefficients])), ('rotation', turn), ('translation', t)):
                storage.write(word, value)
            if model:
                storage.write('distortion_model', model)
            storage.endWriteStruct()
        storage.release()
        return folder / f'rig.{ending}'
    return write


def kalibr(distortion='radtan', coefficients='[-0.05, 0.01, 0, 0]'):
    def write(folder):
        text, before = '', None
        for i, (turn, t) in enumerate(RIG):
            now = np.vstack([np.column_stack([turn, t]), [0, 0, 0, 1]])
            text += f'cam{i}:\n  camera_model: pinhole\n  intrinsics: [900, 900, 639.5, 359.5]\n  distortion_model: {distortion}\n  distortion_coeffs: {coefficients}\n  resolution: [1280, 720]\n'
            text += f'  T_cn_cnm1: {(now @ np.linalg.inv(before)).tolist()}\n' if i else ''
            before = now
        (folder / 'camchain.yaml').write_text(text)
        return folder / 'camchain.yaml'
    return write


def anipose(folder):
    text = ''
    for i, (turn, t) in enumerate(RIG):
        text += (f'[cam_{i}]\nname = "cam{i}"\nsize = [ 1280, 720,]\nmatrix = {K.tolist()}\ndistortions = [ -0.05, 0.01, 0.0, 0.0, 0.0,]\n'
                 f'rotation = {cv2.Rodrigues(turn)[0][:, 0].tolist()}\ntranslation = {t.tolist()}\nfisheye = false\n\n')
    (folder / 'calibration.toml').write_text(text + '[metadata]\nadjusted = false\nerror = 0.2\n')
    return folder / 'calibration.toml'


TRACK = '`keypose track`'
cases('rigs', TRACK, [('20 brown4', '', 'right', 'brown4.yml'), ('20 EasyMocap', '', 'right', 'easymocap', '0{1}', 1),
                      ('20 rational8', 'OpenCV.s with 8 coefficients', 'named', 'rational8.yml'), ('20 fisheye', 'equidistant', 'named', 'fisheye_named.yml')],
      report_rig)
cases('rigs', TRACK, [
    ('OpenCV YAML', '', 'right', opencv_rig('yml', [-0.05, 0.01, 0, 0, 0])), ('OpenCV JSON', '', 'right', opencv_rig('json', [-0.05, 0.01, 0, 0])),
    ('Kalibr', '', 'right', kalibr()), ('Kalibr, wide equidistant', 'equidistant', 'named', kalibr('equidistant', '[0.03, -0.01, 0.004, -0.0008]')), ('anipose', '', 'right', anipose),
    ('OpenCV, tilted', '14 coefficients', 'named', opencv_rig('yml', [-0.05, 0.01, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.1, 0.2])),
], lambda b, write: rig_numbers(b, write(b.folder('calibration')), RIG, radial=-0.05))


JOINTS = [('Hips', None, (0, 0, 0))] + [(s + n, p and (s + p if p != 'Hips' else p), (x * d, y, z)) for s, d in (('Left', 1), ('Right', -1)) for n, p, x, y, z in (
    ('UpLeg', 'Hips', 0.1, 0, 0), ('Leg', 'UpLeg', 0, -0.4, 0), ('Foot', 'Leg', 0, -0.4, 0), ('Arm', 'Hips', 0.2, 0.5, 0), ('ForeArm', 'Arm', 0.3, 0, 0), ('Hand', 'ForeArm', 0.3, 0, 0))]
FRAMES = 5


def clip_values():
    return np.random.default_rng(4).uniform(-40, 40, (FRAMES, 3 * len(JOINTS))), 1 + 0.2 * np.arange(FRAMES)[:, None] * np.array([1, -0.5, 0.3])


def clip_places():
    """Joints of each frame, y up, of channels ZXY."""
    angles, path = np.radians(clip_values()[0]), clip_values()[1]
    places = np.zeros((FRAMES, len(JOINTS), 3))
    number = {name: i for i, (name, *_) in enumerate(JOINTS)}
    for f in range(FRAMES):
        turns = []
        for j, (name, parent, offset) in enumerate(JOINTS):
            z, x, y = angles[f, 3 * j:3 * j + 3]
            own = cv2.Rodrigues(np.array([0, 0, z]))[0] @ cv2.Rodrigues(np.array([x, 0, 0]))[0] @ cv2.Rodrigues(np.array([0, y, 0]))[0]
            up = number.get(parent)
            places[f, j] = path[f] if up is None else places[f, up] + turns[up] @ offset
            turns.append(own if up is None else turns[up] @ own)
    return places


def clip_text(number='{:.6f}', channels='CHANNELS'):
    def part(name, depth):
        pad, offset = '  ' * depth, next(o for n, _, o in JOINTS if n == name)
        head = f'{pad}{"ROOT" if depth == 0 else "JOINT"} {name}\n{pad}{{\n{pad}  OFFSET {" ".join(map(number.format, offset))}\n'
        head += f'{pad}  {channels} ' + ('6 Xposition Yposition Zposition ' if depth == 0 else '3 ') + 'Zrotation Xrotation Yrotation\n'
        children = [n for n, p, _ in JOINTS if p == name]
        return head + (''.join(part(n, depth + 1) for n in children) or f'{pad}  End Site\n{pad}  {{\n{pad}    OFFSET 0 {number.format(-0.1)} 0\n{pad}  }}\n') + pad + '}\n'
    order = re.findall(r'(?:ROOT|JOINT) (\w+)', part('Hips', 0))
    angles, path = clip_values()
    at = [k for name in order for k in range(3 * [j[0] for j in JOINTS].index(name), 3 * [j[0] for j in JOINTS].index(name) + 3)]
    rows = [' '.join(map(number.format, [*p, *a])) for p, a in zip(path, angles[:, at])]
    return 'HIERARCHY\n' + part('Hips', 0) + f'MOTION\nFrames: {FRAMES}\nFrame Time: 0.041667\n' + '\n'.join(rows) + '\n'


def clip_numbers(b, clip, names, rest, right, fps=24, frames=None):
    """`keypose animate` moves small triangles that hang on the joints: where their middles are, against the joints' places up to one shift.

    @param rest  joints with all angles zero; @param right  frames x joints x 3, both with the axis up that the clip has
    """
    work = b.folder('bvh')
    triangle = 0.01 * np.array([[1, 0, 0], [-0.5, 0.8, 0.1], [-0.5, -0.8, -0.1]])
    (work / 'body.obj').write_text(''.join('v {} {} {}\n'.format(*(p + d)) for p in rest for d in triangle) + ''.join(f'f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n' for i in range(len(rest))))
    parents = {name: parent for name, parent in names}
    bones = {n: {'head': n, 'tail': n + ' end', 'parent': parents[n]} for n, _ in names}
    joints = {**{n: [3 * i, 3 * i + 1, 3 * i + 2] for i, (n, _) in enumerate(names)}, **{n + ' end': [3 * i] for i, (n, _) in enumerate(names)}}
    (work / 'body.mhskel').write_text(json.dumps({'bones': bones, 'joints': joints}))
    (work / 'body.mhw').write_text(json.dumps({'weights': {n: [[3 * i + k, 1.0] for k in range(3)] for i, (n, _) in enumerate(names)}}))
    (work / 'joints.json').write_text(json.dumps({'joints': {n: n for n, _ in names}}))
    code, text = b.keypose('animate', '--clip', clip, '--mesh', work / 'body.obj', '--skeleton', work / 'body.mhskel', '--weights', work / 'body.mhw', '--joints', work / 'joints.json',
                           '--all_parts', 'true', '--fps', fps, '--frames', work / 'out')
    if code != 0:
        return Outcome(code, text)
    files = sorted((work / 'out').glob('frame_*.ply'))
    if len(files) != (frames or len(right)):
        return Outcome(code, text, [('frames missing', abs(len(files) - (frames or len(right))), 0)])
    places = np.stack([read_ply(file)[0].reshape(-1, 3, 3).mean(1) for file in (files if not frames else [files[f] for f in right])])
    goal = np.stack(list(right.values()) if frames else list(right))
    if rest[:, 1].max() - rest[:, 1].min() > rest[:, 2].max() - rest[:, 2].min():  # y up becomes z up
        goal = np.stack([goal[..., 0], -goal[..., 2], goal[..., 1]], -1)
    shift = (places - goal).mean((0, 1)) if not frames else (places - goal)[:, 0].mean(0)
    size = np.linalg.norm(np.ptp(rest, 0))
    return Outcome(code, text, [('of the body', float(np.abs(places - goal - shift).max() / size), 1e-5)])


def report_clip(b, name):
    truth = {int(f): joints for f, joints in json.loads(b.report('21_bvh_kinds/truth_joint_places_y_up.json').read_text()).items()}
    stack, names, rest, joint = [], [], {}, None
    for words in map(str.split, b.report('21_bvh_kinds/plain.bvh').read_text().split('MOTION')[0].splitlines()):
        if words[0] in ('ROOT', 'JOINT', 'End'):
            joint = words[1]
        elif words[0] == '{':
            stack.append(joint)
        elif words[0] == '}':
            stack.pop()
        elif words[0] == 'OFFSET' and stack[-1] != 'Site':
            parent = stack[-2] if len(stack) > 1 else None
            names.append((joint, parent))
            rest[joint] = np.array(words[1:], float) + (rest[parent] if parent else 0)
    time_s = float(re.search(r'Frame Time:\s*(\S+)', b.report('21_bvh_kinds/plain.bvh').read_text())[1])
    return clip_numbers(b, b.report('21_bvh_kinds/' + name), names, np.stack(list(rest.values())), {f: np.array([truth[f][n] for n, _ in names]) for f in truth}, 1 / time_s, 40)


def own_clip(b, change):
    number = {name: i for i, (name, *_) in enumerate(JOINTS)}
    rest = np.zeros((len(JOINTS), 3))
    for j, (_, parent, offset) in enumerate(JOINTS):
        rest[j] = rest[number[parent]] + offset if parent else offset
    file = b.folder('clip') / 'clip.bvh'
    file.write_bytes(change(clip_text()).encode())
    return clip_numbers(b, file, [j[:2] for j in JOINTS], rest, clip_places())


def blender_clip(b, mode):
    """Blender reads the clip and writes it anew, z up; its own bones tell where the joints are."""
    folder = b.folder('blender')
    (folder / 'in.bvh').write_text(clip_text())
    (folder / 'make.py').write_text(f'''
import bpy, json
import addon_utils
addon_utils.enable("io_anim_bvh")
import io_anim_bvh.import_bvh as reader
reader.open = lambda path, mode: open(path)  # its mode 'rU' is not known to Python 3.11
bpy.ops.import_anim.bvh(filepath=r"{folder}/in.bvh", axis_forward="-Z", axis_up="Y", frame_start=1, update_scene_fps=True)
thing = bpy.context.object
bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = 24, 1
bpy.ops.export_anim.bvh(filepath=r"{folder}/out.bvh", frame_start=1, frame_end={FRAMES}, rotate_mode="{mode}")
rest = {{bone.name: list(thing.matrix_world @ bone.head_local) for bone in thing.data.bones}}
places = []
for f in range({FRAMES}):
    bpy.context.scene.frame_set(1 + f)
    places.append({{bone.name: list(thing.matrix_world @ bone.head) for bone in thing.pose.bones}})
json.dump([rest, places], open(r"{folder}/truth.json", "w"))
''')
    tool('blender', '-b', '--factory-startup', '--python', folder / 'make.py')
    rest, places = json.loads((folder / 'truth.json').read_text())
    names = [j[:2] for j in JOINTS]
    return clip_numbers(b, folder / 'out.bvh', names, np.array([rest[n] for n, _ in names]), np.array([[p[n] for n, _ in names] for p in places]))


ANIMATE = '`keypose animate`'
cases('BVH', ANIMATE, [('21 plain', '', 'right', 'plain.bvh'), ('21 brace on the line', '', 'right', 'brace_on_the_line.bvh'), ('21 plus signs', '', 'right', 'plus_signs.bvh')], report_clip)
cases('BVH', ANIMATE, [('Blender, native', '', 'right', 'NATIVE'), ('Blender, XYZ', '', 'right', 'XYZ'), ('Blender, ZYX', '', 'right', 'ZYX')], blender_clip)
cases('BVH', ANIMATE, [
    ('CRLF, tabs, comments', '', 'right', lambda s: '\ufeff# made by hand\r\n' + s.replace('  ', '\t').replace('MOTION', '// numbers\nMOTION').replace('\n', '\r\n')),
    ('capitals', '', 'right', lambda s: s.replace('Xposition', 'XPOSITION').replace('ROOT', 'Root').replace('JOINT', 'joint')),
    ('1e-3, no spaces', '', 'right', lambda s: re.sub(r'(?<![\w.])0\.(\d)', r'.\1', s).replace('Frames: ', 'Frames:').replace('OFFSET .100000', 'OFFSET 100e-3')),
    ('decimal commas', 'comma', 'named', lambda s: re.sub(r'(\d)\.(\d)', r'\1,\2', s)),
    ('a row that ends early', r'line \d+|row|frame', 'named', lambda s: s.rstrip().rsplit(' ', 2)[0] + '\n'),
    ('two frames too few', r'frames', 'named', lambda s: s.replace('Frames: 5', 'Frames: 7')),
], own_clip)
