"""Numbered pictures and films: cases of files_table.py."""
import json
import shutil

import cv2
import numpy as np

from files_cases import Outcome, case, cases, tool
from files_cameras import outline
from files_rigs import BODY, RIG, TRACK, opencv_rig
from files_photographs import patches, put

FILM, SET = (160, 96), (60, 80, 70)
COUNT = 30


def film_picture(number):
    """An L before an even set, 4 pixels further right in each picture."""
    picture = np.zeros((FILM[1], FILM[0], 3), np.uint8) + np.array(SET, np.uint8)
    x = 8 + 4 * number
    picture[20:52, x:x + 24] = picture[52:84, x:x + 8] = (230, 200, 190)
    return picture


def encode(path, pictures, *options, rate=30, codec=('-c:v', 'libx264', '-crf', '10', '-pix_fmt', 'yuv420p'), before=()):
    height, width = pictures[0].shape[:2]
    tool('ffmpeg', '-loglevel', 'error', '-y', *before, '-f', 'rawvideo', '-pix_fmt', 'rgb24', '-s', f'{width}x{height}', '-r', rate, '-i', '-', *options, *codec, path,
         data=b''.join(np.ascontiguousarray(p).tobytes() for p in pictures))
    return path


def silhouettes(b, shot):
    for camera in {p.stem for p in shot.iterdir()}:
        (shot / 'background').mkdir(exist_ok=True)
        put((np.zeros((FILM[1], FILM[0], 3), np.uint8) + np.array(SET, np.uint8))[..., ::-1], shot / f'background/{camera}.png')
    out = b.folder('masked') / 'out'
    code, text = b.keypose('silhouettes', '--video', shot, '--masked', out, '--network', 'false')
    masks = {camera.name: [cv2.imread(str(f), 0) for f in sorted(camera.iterdir())] for camera in sorted((out / 'masks').iterdir())} if code == 0 else {}
    return code, text, masks


def number_shown(mask):
    across = np.flatnonzero((mask > 0).sum(0) > 10)
    return (across[0] - 8) / 4 if len(across) else -99


def off_by(masks, right):
    """Largest difference of the numbers that masks show and these; a number of masks that differs counts too."""
    return float(max([abs(number_shown(m) - r) for m, r in zip(masks, right)] + [abs(len(masks) - len(right))]))


def folder_numbers(b, names):
    shot = b.folder('numbered') / 'shot'
    (shot / 'cam1').mkdir(parents=True)
    for number, name in enumerate(names):
        put(film_picture(number)[..., ::-1], shot / 'cam1' / name)
    code, text, masks = silhouettes(b, shot)
    return Outcome(code, text, [('places off', off_by(masks['cam1'], range(len(names))), 0.3)] if code == 0 else [])


def report_names(b, key):
    return folder_numbers(b, json.loads(b.report('26_film_names/order.json').read_text())[key])


SILHOUETTES = '`keypose silhouettes`'
NAMES = ('from_1001', 'not_padded', 'underscore_9999', 'five_digits_from_99998', 'version_after_the_number', 'version_before', 'resolution_after', 'gap', 'letters_after', 'negative',
         'two_digits_twice', 'date_and_time')
cases('numbered pictures', SILHOUETTES, [(f'26 {key}', 'has the frame number of', 'named', key) if key == 'two_digits_twice' else (f'26 {key}', '', 'right', key) for key in NAMES], report_names)
cases('numbered pictures', SILHOUETTES, [
    ('counter ran over', '', 'right', ['DSC_9998.png', 'DSC_9999.png', 'DSC_0001.png', 'DSC_0002.png']),
    ('phone, milliseconds', '', 'right', [f'PXL_20240503_14035{s}{m}.png' for s, m in ((8, '990'), (9, '123'), (9, '456'), (9, '789'))]),
    ('noon', '', 'right', [f'Screenshot 2024-05-03 at {t}.png' for t in ('11.59.58 AM', '11.59.59 AM', '12.00.01 PM', '1.00.00 PM')]),
    ('two exposures', 'more than one number', 'named', ['DF_0001_X1.png', 'DF_0001_X2.png', 'DF_0002_X1.png', 'DF_0002_X2.png'])], folder_numbers)


def composited(b, film, count, size, rate):
    """`keypose composite` with all frames filmed writes the film's pictures as it reads them. @return code, text, {number: picture}"""
    work = b.folder('composite')
    (work / 'frames').mkdir()
    for i in range(count):
        (work / f'frames/frame_{i:04d}.ply').write_text('ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\nproperty list uchar int '
                                                        'vertex_indices\nend_header\n0 0 0\n.02 0 0\n0 .02 0\n0 0 .02\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n')
    same = {'area': 1, 'volume': 1, 'linear_area': 1, 'linear_volume': 1}
    (work / 'frames/distortion.json').write_text(json.dumps({'schema': 2, 'method': 'arap', 'fps': rate, 'key_frames': [0, count - 1], 'frames': [{'t': i / (count - 1), **same} for i in range(count)]}))
    still = {'rotation': [1, 0, 0, 0], 'translation': [0, 0, 1]}
    frames = [{'frame': f, 'picture': f'{f}.png', 'pose': 'rest', 'camera_from_world': still, 'world_from_character': {'rotation': [1, 0, 0, 0], 'translation': [0, 0.1, 0], 'scale': 1}, 'method': 'given'}
              for f in (0, count - 1)]
    (work / 'shot.json').write_text(json.dumps({'schema': 1, 'width': size[0], 'height': size[1], 'fps': rate, 'still': True, 'frames': frames, 'camera': {
        'model': 'OPENCV', 'fx': 200, 'fy': 200, 'cx': size[0] / 2, 'cy': size[1] / 2, 'k1': 0, 'k2': 0, 'p1': 0, 'p2': 0, 'focal': 'given', 'focal_uncertainty': 0}}))
    code, text = b.keypose('composite', '--frames', work / 'frames', '--shot', work / 'shot.json', '--plate', film, '--filmed', film, '--pictures', work / 'out')
    if code != 0:
        return code, text, {}
    plan = json.loads((work / 'out/composite.json').read_text())['pictures']
    return code, text, {p['picture']: cv2.imread(str(work / f'out/{p["picture"]:04d}.png'))[..., ::-1].astype(float) for p in plan if p['kind'] == 'filmed'}


def report_turn(b, name):
    upright = [cv2.imread(str(f))[..., ::-1].astype(float) for f in sorted(b.report('27_video_rotation/upright').glob('*.png'))]
    code, text, shown = composited(b, b.report('27_video_rotation/' + name), 12, upright[0].shape[1::-1], 30)
    if code != 0 or len(shown) != 12 or shown[0].shape != upright[0].shape:
        return Outcome(code, text)
    return Outcome(code, text, [('levels', max(float(np.abs(shown[i] - upright[i]).mean()) for i in range(12)), 4)])


def own_turn(b, turns, ending):
    """Stored turned, with the turn that shows it upright in its header."""
    shot = b.folder('turned') / 'shot'
    shot.mkdir()
    encode(shot / f'a.{ending}', [np.rot90(film_picture(n), turns) for n in range(12)])
    tool('ffmpeg', '-loglevel', 'error', '-i', shot / f'a.{ending}', '-c', 'copy', '-metadata:s:v:0', f'rotate={360 - 90 * turns}', shot / f'cam1.{ending}')
    (shot / f'a.{ending}').unlink()
    code, text, masks = silhouettes(b, shot)
    if code != 0:
        return Outcome(code, text)
    right = [(film_picture(n) != SET).any(-1) for n in range(12)]
    overlap = [((m > 0) & r).sum() / ((m > 0) | r).sum() if m.shape == r.shape else 0 for m, r in zip(masks['cam1'], right)]
    return Outcome(code, text, [('overlap lacks', 1 - float(min(overlap)), 0.03), ('pictures missing', abs(len(overlap) - 12), 0)])


COMPOSITE = '`keypose composite`'
cases('films that are turned', COMPOSITE, [('27 rotate 0', '', 'right', 'rotate_0.mov'), ('27 rotate 90', '', 'right', 'rotate_90.mov')], report_turn)
cases('films that are turned', SILHOUETTES, [(f'{90 * k} in {e}', '', 'right', k, e) for k, e in ((1, 'mp4'), (2, 'mov'), (3, 'mp4'))], own_turn)


def report_times(b, name, right):
    if right is None:
        right = json.loads(b.report('28_video_time/truth.json').read_text())['variable_dropped_shows']
    code, text, shown = composited(b, b.report('28_video_time/' + name), 120, (280, 160), 30)
    if code != 0:
        return Outcome(code, text)
    read = {n: sum((p[20, 20 + 40 * k].mean() > 127) << (6 - k if shown[1][20, 260].mean() > 127 else k) for k in range(7)) for n, p in shown.items()}
    return Outcome(code, text, [('numbers off', max(abs(n - number) for n, number in read.items()), 0), ('pictures missing', len(set(right) ^ set(read)), 0)])


cases('films by their times', COMPOSITE, [('28 constant', '', 'right', 'constant_30.mp4', range(120)), ('28 no index', '', 'right', 'no_index.webm', range(120)),
                                          ('28 dropped', '', 'right', 'variable_dropped.mp4', None)], report_times)
X264, VP9 = ('-c:v', 'libx264', '-crf', '10', '-pix_fmt', 'yuv420p'), ('-c:v', 'libvpx-vp9', '-crf', '10', '-b:v', '2M', '-deadline', 'realtime', '-cpu-used', '8', '-pix_fmt', 'yuv420p')
LOST = (7, 12, 13, 20)
HELD = [max(k for k in range(n + 1) if k not in LOST) for n in range(COUNT)]
DROP = ('-vf', 'select=not(' + '+'.join(f'eq(n\\,{n})' for n in LOST) + ')', '-vsync', 'vfr')


def own_times(b, name, right, *options, codec=X264, rate=30):
    shot = b.folder('times') / 'shot'
    shot.mkdir()
    encode(shot / name, [film_picture(n) for n in range(COUNT)], *options, codec=codec, rate=rate)
    code, text, masks = silhouettes(b, shot)
    return Outcome(code, text, [('pictures off', off_by(masks['cam1'], right), 0.3)] if code == 0 else [])


cases('films by their times', SILHOUETTES, [
    ('variable MP4', '', 'right', 'cam1.mp4', HELD, *DROP), ('variable Matroska', '', 'right', 'cam1.mkv', HELD, *DROP), ('fragmented MP4', '', 'right', 'cam1.mp4', range(COUNT), '-movflags', 'frag_keyframe+empty_moov'),
    ('MPEG-TS', '', 'right', 'cam1.ts', range(COUNT)), ('B-frames in AVI', '', 'right', 'cam1.avi', range(COUNT), '-bf', '3')], own_times)
case('films by their times', SILHOUETTES, 'live WebM')(lambda b: own_times(b, 'cam1.webm', range(COUNT), '-live', '1', codec=VP9))
case('films by their times', SILHOUETTES, 'variable WebM')(lambda b: own_times(b, 'cam1.webm', HELD, *DROP, codec=VP9))
case('films by their times', SILHOUETTES, '29.97')(lambda b: own_times(b, 'cam1.mov', range(COUNT), rate='30000/1001'))


def contained(b, ending, *codec):
    return own_times(b, f'cam1.{ending}' if ending else 'cam1', range(COUNT), codec=codec)


cases('films: containers', SILHOUETTES, [
    ('FLV', '', 'right', 'flv', '-c:v', 'flv', '-q:v', 2), ('Ogg', '', 'right', 'ogv', '-c:v', 'libtheora', '-q:v', 9, '-pix_fmt', 'yuv420p'), ('APNG', '', 'right', 'apng', '-f', 'apng'),
    ('Y4M', '', 'right', 'y4m', '-pix_fmt', 'yuv420p'), ('3GP', '', 'right', '3gp', *X264), ('VOB', '', 'right', 'vob', '-c:v', 'mpeg2video', '-q:v', 2), ('ASF', '', 'right', 'asf', '-c:v', 'wmv2', '-q:v', 2),
    ('NUT', '', 'right', 'nut', '-c:v', 'ffv1'), ('IVF', '', 'right', 'ivf', *VP9), ('M2TS', '', 'right', 'm2ts', *X264), ('bare HEVC', '', 'right', 'hevc', '-c:v', 'libx265', '-x265-params', 'log-level=none', '-pix_fmt', 'yuv420p'),
    ('bare H.264', '', 'right', 'h264', *X264), ('no ending', '', 'right', '', *X264, '-f', 'mp4'), ('another ending', '', 'right', 'dat', *X264, '-f', 'matroska'),
    ('bare JPEGs: no rate', 'no times and no rate', 'named', 'mjpeg', '-c:v', 'mjpeg', '-q:v', 2, '-pix_fmt', 'yuvj420p'), ('bare pixels', 'without their size', 'named', 'yuv', '-pix_fmt', 'yuv420p', '-f', 'rawvideo'),
    ('animated WebP', 'animated WebP', 'named', 'webp', '-c:v', 'libwebp_anim'), ('a playlist', 'is a playlist', 'named', 'm3u8', *X264, '-f', 'hls')], contained)


case('films: containers', SILHOUETTES, 'GIF')(lambda b: own_times(b, 'cam1.gif', range(COUNT), '-vf', 'split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none', codec=(), rate=25))


def again(b, change, right):
    """Two cameras; the second film is cut or put later by ffmpeg without encoding anew. @param right  the numbers that (cam1, cam2) show"""
    shot = b.folder('again') / 'shot'
    shot.mkdir()
    encode(shot / 'cam1.mp4', [film_picture(n) for n in range(COUNT)], '-g', 10, '-bf', 2)
    tool('ffmpeg', '-loglevel', 'error', *change[0], '-i', shot / 'cam1.mp4', '-c', 'copy', *change[1], shot / f'cam2.{change[2]}')
    code, text, masks = silhouettes(b, shot)
    if code != 0:
        return Outcome(code, text)
    return Outcome(code, text, [('pictures off', max(off_by(masks[c], r) for c, r in zip(('cam1', 'cam2'), right)), 0.3)])


cases('films by their times', SILHOUETTES, [
    ('edit list', '', 'right', (('-ss', '0.5'), (), 'mp4'), (range(30), range(15, 30))),
    ('edit list on a key picture', '', 'right', (('-ss', '0.33333'), (), 'mov'), (range(30), range(10, 30))),
    ('begins 0.2 s later', '', 'right', (('-itsoffset', '0.2'), (), 'mkv'), (range(6, 30), range(30)))], again)


def color_levels(b, name, *options, codec=X264):
    pictures = [patches(3)[:, :, :]] * 4
    film = encode(b.folder('colours') / name, pictures, *options, codec=codec)
    code, text, shown = composited(b, film, 4, (320, 240), 30)
    if code != 0:
        return Outcome(code, text)
    off = [np.abs(p[20::40, 20::40] - pictures[0][20::40, 20::40])[2:].mean() for p in shown.values()]
    return Outcome(code, text, [('levels', float(max(off)), 2.0), ('pictures missing', abs(4 - len(shown)), 0)])


def matrix(name, spread='tv'):
    return ('-vf', f'scale=out_color_matrix={name}:out_range={spread}:flags=accurate_rnd+full_chroma_int', '-colorspace', {'bt601': 'smpte170m'}.get(name, name), '-color_range', spread)


PATCHES = {'codec': ('-c:v', 'libx264', '-crf', '4', '-pix_fmt', 'yuv444p')}
for label, arguments, how in (('BT.601', ('a.mp4', *matrix('bt601')), {}), ('BT.709', ('a.mp4', *matrix('bt709')), {}), ('full range', ('a.mov', *matrix('bt709', 'pc')), {}),
                              ('BT.2020 matrix, 10 bits', ('a.mp4', *matrix('bt2020nc')[:2], '-colorspace', 'bt2020nc'), {'codec': ('-c:v', 'libx264', '-crf', '4', '-pix_fmt', 'yuv444p10le')}),
                              ('ProRes', ('a.mov', *matrix('bt709')), {'codec': ('-c:v', 'prores_ks', '-profile:v', '4', '-pix_fmt', 'yuv444p10le', '-bsf:v', 'prores_metadata=color_primaries=bt709:color_trc=bt709:colorspace=bt709')}),
                              ('Animation', ('a.mov',), {'codec': ('-c:v', 'qtrle', '-pix_fmt', 'rgb24')})):
    case('films: colours, pixels', COMPOSITE, label)(lambda b, arguments=arguments, how=how: color_levels(b, *arguments, **{**PATCHES, **how}))
for label, words, arguments, how in (
        ('wide primaries', 'BT.2020|2020', ('a.mp4', *matrix('bt709'), '-color_primaries', 'bt2020'), {}), ('PQ', 'PQ', ('a.mp4', '-color_trc', 'smpte2084'), {}),
        ('HLG', 'HLG', ('a.mkv', '-color_trc', 'arib-std-b67'), {}), ('pixels 4:3', 'not square', ('a.mp4', '-vf', 'setsar=4/3'), {}),
        ('interlaced', 'interlaced', ('a.mkv', '-vf', 'setfield=tff', '-flags', '+ilme+ildct'), {'codec': X264}), ('YCgCo', 'YCgCo', ('a.mp4', '-colorspace', 'ycgco'), {})):
    case('films: colours, pixels', COMPOSITE, label, words, 'named')(lambda b, arguments=arguments, how=how: color_levels(b, *arguments, **{**PATCHES, **how}))


def alpha_film(b, name, *codec):
    """Masks as a film with alpha: the tracked body overlaps them as it does masks in PNG."""
    shot = b.folder('alpha') / 'shot'
    found = []
    for kind in ('png', 'film'):
        for i, pose in enumerate(RIG):
            mask = outline(BODY, pose, 225, (320, 180))
            for folder in (shot / kind / f'cam{i}', shot / kind / f'masks/cam{i}'):
                folder.mkdir(parents=True)
                for frame in range(2):
                    put(mask, folder / f'{frame:03d}.png')
            if kind == 'film':
                raw = np.dstack([np.full((*mask.shape, 3), 90, np.uint8), mask]).tobytes() * 2
                tool('ffmpeg', '-loglevel', 'error', '-f', 'rawvideo', '-pix_fmt', 'rgba', '-s', '320x180', '-r', '25', '-i', '-', *codec, shot / kind / f'masks/cam{i}{name}', data=raw)
                shutil.rmtree(shot / kind / f'masks/cam{i}')
        code, text = b.keypose('track', '--video', shot / kind, '--calibration', opencv_rig('yml', [0, 0, 0, 0.0])(b.folder('c')), '--frames', shot / f'f_{kind}', '--motion', shot / 'm.bvh',
                               '--actor_frames', 1, '--height_m', 1.75, '--report', shot / f'{kind}.json')
        if code != 0:
            return Outcome(code, text)
        found.append(json.loads((shot / f'{kind}.json').read_text())['measurements']['iou_mean'])
    return Outcome(code, text, [('overlap off', abs(found[0] - found[1]), 1e-9), ('overlap lacks', 1 - found[1], 0.25)])


cases('films: alpha', TRACK, [('Animation', '', 'right', '.mov', '-c:v', 'qtrle', '-pix_fmt', 'argb'), ('PNG in QuickTime', '', 'right', '.mov', '-c:v', 'png', '-pix_fmt', 'rgba'),
                              ('ProRes 4444', '', 'right', '.mov', '-c:v', 'prores_ks', '-pix_fmt', 'yuva444p10le', '-alpha_bits', '16')], alpha_film)
