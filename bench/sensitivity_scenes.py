"""The scenes of sensitivity.py: what a stage makes of inputs with known truth, how far it is off.

A scene has rooms, whose constants it can measure, and a figure, of which smaller is better. Needs
python3-numpy.
"""
import json
import math
import re

import numpy as np

import locate_table
from sensitivity_inputs import read_ply, seconds, track_words


def mean_distance(first, second):
    """Of vertices in frames of one mesh, over the mesh's diagonal."""
    total = 0
    for a, b in zip(first, second):
        wanted = read_ply(b)[0]
        diagonal = np.linalg.norm(wanted.max(0) - wanted.min(0))
        total += np.linalg.norm(read_ply(a)[0] - wanted, axis=1).mean() / diagonal
    return float(total / len(first))


class Scene:
    """One figure.

    @param name  as in the table
    @param rooms  beginnings of the sources' paths whose constants it measures
    @param programs  whose builds decide whether a measurement is still good
    @param what  the figure, for the page
    @param measure  (inputs, programs, folder) -> figure; smaller is better
    @param needs_scorer  only measured with --scorer
    """

    def __init__(self, name, rooms, programs, what, measure, needs_scorer=False):
        self.name, self.rooms, self.programs = name, rooms, programs
        self.what, self.measure, self.needs_scorer = what, measure, needs_scorer


def camera_error(model, truth, programs):
    return json.loads(programs.python('tests/score_cameras.py', model, truth))['mean']


def sfm_scene(photographs, *words):
    """`sfm` with these words, on what `synth photos` makes with those of `photographs`."""
    def measure(inputs, programs, to):
        name = 'sfm_' + re.sub('[^a-z0-9]+', '_', photographs.replace('--', ''))
        clay = inputs.photographs(name, '--poses', 'rest', *photographs.split())
        programs.stage('sfm', '--images', clay / 'images/rest', '--model', to / 'model', *words)
        return camera_error(to / 'model', clay / 'truth/rest/cameras', programs)
    return measure


def board(inputs, programs, to):
    """`capture` finds the board, and `sfm` takes the cameras from it."""
    clay = inputs.photographs('board', '--poses', 'rest', '--views', 10, '--width', 640,
                              '--texture', 'none', '--charuco')
    truth = clay / 'truth/rest'
    programs.stage('capture', '--photos', clay / 'photos/rest', '--masks', truth / 'masks',
                   '--images', to / 'images')
    programs.stage('sfm', '--images', to / 'images', '--method', 'board', '--model', to / 'model')
    return camera_error(to / 'model', truth / 'cameras', programs)


def fit(inputs, programs, to):
    clay, template = inputs.clay(), inputs.template()
    programs.stage('fit', *inputs.fit_words(), '--fitted', to / 'wave.obj', '--model', to / 'model')
    truth = clay / 'truth/rest'
    score = programs('keypose-synth', 'score', '--truth', clay / 'truth/wave', '--model',
                     to / 'model', '--mesh', to / 'wave.obj', '--registered', to / 'wave.obj',
                     '--template-truth', truth, '--template-model', truth / 'cameras',
                     '--template-mesh', template / 'mesh.obj')
    return json.loads(score)['correspondence']['mean']


def track(inputs, programs, to):
    film = inputs.film()
    programs.stage('track', *track_words(film, to))
    score = programs('keypose-synth', 'score-motion', '--performance', film, '--frames',
                     to / 'frames', '--motion', to / 'motion.bvh')
    return json.loads(score)['joint_mean_mm'] / 1000


def follow(inputs, programs, to):
    performance = inputs.performance()
    programs.stage('follow', '--frames', performance / 'frames', '--video', performance / 'shot',
                   '--calibration', performance / 'calibration.yml', '--vertices', 1000,
                   '--followed', to / 'followed')
    score = programs('keypose-synth', 'score-surface', '--performance', performance, '--frames',
                     to / 'followed', '--every', 5)
    return json.loads(score)['mean_mm'] / 1000


def transfer(inputs, programs, to):
    frames, other = inputs.performance() / 'frames', inputs.another_pose()
    programs.stage('transfer', '--template', frames, '--target', other / 'target.ply', '--marks',
                   other / 'marks.json', '--space', 'template', '--frames', to / 'frames')
    return mean_distance(sorted((to / 'frames').glob('frame_*.ply')),
                         sorted(frames.glob('frame_*.ply')))


def locate(inputs, programs, to):
    programs.stage('locate', *inputs.locate_words(), '--shot', to / 'shot.json')
    truth = inputs.shot() / 'truth/shot/shot.json'
    return place_error(json.loads((to / 'shot.json').read_text()), json.loads(truth.read_text()))


def place_error(found, truth):
    """Mean of turn [rad] plus the camera's way over its distance, from the character."""
    frames = {frame['picture']: frame for frame in truth['frames']}
    total = 0
    for frame in found['frames']:
        turn, move = locate_table.found_view(frame)
        true_turn, true_move = locate_table.found_view(frames[frame['picture']])
        place = locate_table.center(true_turn, true_move)
        way = locate_table.distance(locate_table.center(turn, move), place)
        total += math.radians(locate_table.angle(turn, true_turn))
        total += way / locate_table.distance(place, [0, 0, 0])
    return total / len(found['frames'])


def composite(inputs, programs, to):
    shot = inputs.shot()
    programs.stage('composite', '--frames', inputs.animation() / 'frames', '--textures',
                   inputs.template() / 'texture.png', '--shot', inputs.located() / 'shot.json',
                   '--plate', shot / 'plate.png', '--filmed', shot / 'film', '--follow', 'true',
                   '--samples', 2, '--video', 'false', '--compare', 'false', '--blender', 'false',
                   '--pictures', to / 'pictures')
    score = json.loads(programs('keypose-synth', 'score-shot', '--shot', shot, '--pictures',
                                to / 'pictures'))
    return 10 ** (-score['mean_psnr_db'] / 20)


def surface_error(inputs, programs, mesh):
    truth = inputs.clay() / 'truth/rest'
    score = programs('keypose-synth', 'score', '--truth', truth, '--model', truth / 'cameras',
                     '--mesh', mesh)
    return json.loads(score)['surface']['mean_over_diag']


def view_score(inputs, programs, to, mesh, masked, *texture):
    programs('score_views', '--mesh', mesh, '--model', inputs.clay() / 'truth/rest/cameras',
             '--photographs', masked, '--masks', masked / 'masks', '--json', to / 'score.json',
             *texture)
    return json.loads((to / 'score.json').read_text())['all']


def masks(inputs, programs, to):
    clay = inputs.clay()
    programs.stage('capture', '--photos', clay / 'photos/rest', '--images', to / 'images')
    programs.stage('masks', '--images', to / 'images', '--model', clay / 'truth/rest/cameras',
                   '--masked', to / 'masked')
    return 1 - view_score(inputs, programs, to, clay / 'truth/rest/surface.ply',
                          to / 'masked')['iou']


def camera_words(inputs):
    clay = inputs.clay()
    return ['--model', clay / 'truth/rest/cameras', '--images', clay / 'images/rest']


def stereo(inputs, programs, to):
    words = camera_words(inputs)
    programs.stage('dense', *words, '--cloud', to / 'cloud.ply')
    programs.stage('mesh', *words, '--cloud', to / 'cloud.ply', '--surface', to / 'surface.ply')
    programs.stage('refine', *words, '--surface', to / 'surface.ply', '--refined',
                   to / 'refined.ply')
    return surface_error(inputs, programs, to / 'refined.ply')


def cleanup(inputs, programs, to):
    words = camera_words(inputs)

    def make(folder):
        inputs.programs.stage('dense', *words, '--cloud', folder / 'cloud.ply')
        inputs.programs.stage('mesh', *words, '--cloud', folder / 'cloud.ply', '--surface',
                              folder / 'surface.ply')
    raw = inputs.folder('raw', make) / 'surface.ply'
    programs.stage('cleanup', *words, '--surface', raw, '--clean', to / 'clean.ply', '--faces',
                   8000)
    return surface_error(inputs, programs, to / 'clean.ply')


def unwrap(inputs, programs, to):
    programs.stage('unwrap', '--clean', inputs.template() / 'clean.ply', '--unwrapped',
                   to / 'mesh.obj', '--report', to / 'unwrap.json')
    report = json.loads((to / 'unwrap.json').read_text())
    return 1 - report['measurements']['utilisation']


def bake(inputs, programs, to):
    mesh, images = inputs.template() / 'mesh.obj', inputs.clay() / 'images/rest'
    programs.stage('bake', '--mesh', mesh, *camera_words(inputs), '--texture_size', 1024,
                   '--hold_out', 0, '--texture', to / 'texture.png')
    score = view_score(inputs, programs, to, mesh, images, '--texture', to / 'texture.png')
    return 10 ** (-score['psnr_db'] / 20)


def register(scorer, data):
    """Bent limbs, and with `data` real pairs: by register_table.py."""
    commands = [['tentacle', '--angles', '180', '--landmarks', '7,0', '--seeds', '0-1']]
    if data:
        commands.append(['pairs', '--data', data + '/pairs', '--only', 'cheb_rest_01', '--only',
                         'wolf', '--landmarks', '12,0'])

    def measure(_, programs, to):
        errors = []
        for i, command in enumerate(commands):
            out = to / f'register_{i}.json'
            programs.python('bench/register_table.py', *command, '--scorer', scorer, '--methods',
                            'auto', '--bin', programs.folder, '--json', out)
            errors += [row['err_mean'] for row in rows_of(json.loads(out.read_text()))]
        return sum(errors) / len(errors)
    return measure


def rows_of(value):
    """All objects with err_mean below a JSON value."""
    if isinstance(value, dict):
        parts = value.values()
        return [value] if 'err_mean' in value else [row for part in parts for row in rows_of(part)]
    return [row for part in value for row in rows_of(part)] if isinstance(value, list) else []


def bend(_, programs, to):
    programs.python('bench/interpolation_table.py', programs.folder, '--json', to / 'bend.json')
    pairs = json.loads((to / 'bend.json').read_text())['pairs']
    errors = [row['middle'] for row in pairs
              if row['method'] in ('arap', 'volumetric') and row.get('middle') is not None]
    return sum(errors) / len(errors)


CAMERAS = ('mean distance of the cameras from the true ones, moved, turned and scaled onto them, '
           'over their distance')
QUICK = ('--detail', 'coarse', '--affine_shape', 'false')
SFM = ('reconstruct/sfm', 'reconstruct/turntable', 'reconstruct/matching', 'reconstruct/bundle',
       'reconstruct/join', 'reconstruct/evidence', 'views/hull')
BAKE = tuple(f'texture/bake/{part}' for part in (
    'bake', 'colour', 'gain', 'labels', 'paint', 'seam', 'view'))  # not complete.cpp
FIT = ('fit/', 'deform/levels', 'views/placement', 'views/atlas')


def all_scenes(scorer='', data=''):
    """In the order of measuring: a constant is measured by the first scene that reads it.

    A scene that gets other inputs or options gets another name too: results are kept by it.
    """
    return [
        Scene('ring', SFM, ('keypose-sfm',), f'{CAMERAS}: 16 photographs of 640 px, by turntable',
              sfm_scene('--views 16 --width 640', *QUICK)),
        Scene('fit', FIT, ('keypose-fit',),
              'distance of vertices from their true places, over the diagonal: six photographs',
              fit),
        Scene('transfer', ('motion/fields', 'motion/root', 'deform/volume'), ('keypose-transfer',),
              'distance of vertices from the template\'s, over the diagonal: the target is the '
              'template in another pose', transfer),
        Scene('locate', ('composite/locating',), ('keypose-locate',),
              'turn [rad] plus way over the distance of the camera: two frames of a film', locate),
        Scene('composite', ('composite/',), ('keypose-composite',),
              'error of rendered in-betweens (root mean square, 0 to 1)', composite),
        Scene('track', ('motion/tracking',), ('keypose-track',),
              'distance of joints from the true ones [m]: four frames of eight cameras', track),
        Scene('follow', FIT, ('keypose-follow',),
              'distance of the surface from the true one [m]: ten frames of eight cameras', follow),
        Scene('flip', SFM, ('keypose-sfm',), f'{CAMERAS}: 16 photographs, and 16 on its back',
              sfm_scene('--views 16 --width 640 --flip')),
        Scene('board', ('capture/board', *SFM), ('keypose-capture', 'keypose-sfm'),
              f'{CAMERAS}: 10 photographs with a printed board', board),
        Scene('masks', ('capture/',), ('keypose-capture', 'keypose-masks'),
              '1 - IoU of the masks, by the true surface', masks),
        Scene('unwrap', ('texture/unwrap', 'texture/charts', 'texture/packing'),
              ('keypose-unwrap',),
              'share of the texture\'s square that the charts leave empty', unwrap),
        Scene('bake', (*BAKE, 'views/'), ('keypose-bake',),
              'error of the photographs shown again by the textured mesh (root mean square, 0 to '
              '1)',
              bake),
        Scene('cleanup', ('cleanup/', 'views/'), ('keypose-cleanup',),
              'distance of the cleaned surface to the true one, over the diagonal', cleanup),
        Scene('stereo', ('reconstruct/stereo', 'reconstruct/meshing', 'reconstruct/refinement',
                         'views/'), ('keypose-dense', 'keypose-mesh', 'keypose-refine'),
              'distance of the refined surface to the true one, over the diagonal', stereo),
        Scene('bend', ('interpolate/', 'deform/', 'core/'), ('keypose-interpolate',),
              'distance of the middle frame of a tube, bent and twisted by 150 to 450 degrees, '
              'from the ideal pose', bend),
        Scene('register', ('register/', 'deform/', 'core/'), ('keypose-register',),
              'mean error of a limb bent by 180 degrees, with 7 landmarks and none'
              + (', and of two real pairs' if data else ''), register(scorer, data), True),
    ]


def timed(measure, inputs):
    """The figure, and the processor's and the clock's seconds, without those for making inputs."""
    before, made = seconds(), (inputs.cpu_s, inputs.wall_s)
    error = measure()
    after = seconds()
    return (error, after[0] - before[0] - (inputs.cpu_s - made[0]),
            after[1] - before[1] - (inputs.wall_s - made[1]))
