"""Meshes of other programs: cases of files_table.py."""
import json
import math
import re
import shutil
import struct
import zipfile

import cv2
import numpy as np

from files_cases import Outcome, Skip, case, cases, tool


def star():
    """A star-shaped closed figure, z up, whose colour at p is 127.5 + 102 p / |p|. @return points, faces, uv of each corner"""
    rows, columns = 32, 64
    grid = [(u / columns, v / rows) for v in range(rows + 1) for u in range(columns + 1)]
    points, index = [], {}
    for u, v in grid:
        d = direction(np.array(u % 1.0), np.array(v))
        key = tuple(np.round(d, 9))
        if key not in index:
            index[key] = len(points)
            points.append(d * (1 + 0.3 * d[0] * d[2] + 0.2 * d[1] + 0.1 * d[2]))
    at = lambda u, v: index[tuple(np.round(direction(np.array((u / columns) % 1.0), np.array(v / rows)), 9))]
    faces, uvs = [], []
    for v in range(rows):
        for u in range(columns):
            for corners in (((u, v), (u + 1, v), (u + 1, v + 1)), ((u, v), (u + 1, v + 1), (u, v + 1))):
                ids = [at(*c) for c in corners]
                if len(set(ids)) == 3:
                    faces.append(ids)
                    uvs.append([(a / columns, b / rows) for a, b in corners])
    return np.array(points), np.array(faces), np.array(uvs)


def direction(u, v):
    polar = math.pi * (v - 0.5)
    return np.stack([np.cos(2 * math.pi * u) * np.cos(polar), np.sin(2 * math.pi * u) * np.cos(polar), np.sin(polar)], -1)


def color_of(d):
    return 127.5 + 102 * d


def star_files(b):
    """The figure as scan.obj with scan.mtl and scan.png (z up), and scan.json for Blender."""
    folder = b.folder('star')
    points, faces, uvs = star()
    u, v = np.meshgrid((np.arange(1024) + 0.5) / 1024, 1 - (np.arange(512) + 0.5) / 512)
    cv2.imwrite(str(folder / 'scan.png'), np.round(color_of(direction(u, v)))[..., ::-1].astype(np.uint8))
    (folder / 'scan.mtl').write_text('newmtl skin\nKd 1 1 1\nmap_Kd scan.png\n')
    write_obj(folder / 'scan.obj', 'mtllib scan.mtl\nusemtl skin\n')
    (folder / 'scan.json').write_text(json.dumps({'points': points.tolist(), 'faces': faces.tolist(), 'uvs': uvs.tolist()}))
    return folder


def write_obj(path, head, uv=lambda uvs: uvs, vertex='v {0[0]:.9g} {0[1]:.9g} {0[2]:.9g}', face='f {}/{} {}/{} {}/{}', shift=lambda i, n: i + 1):
    points, faces, uvs = star()
    lines = [vertex.format(p, c=color_of(p / np.linalg.norm(p)) / 255, k=color_of(p / np.linalg.norm(p)).round().astype(int)) for p in points]
    flat = uv(uvs.reshape(-1, 2))
    lines += [f'vt {a:.9g} {c:.9g}' for a, c in flat] + [head.rstrip()]
    for i, ids in enumerate(faces):
        corners = [n for k in range(3) for n in (shift(ids[k], len(points)), shift(3 * i + k, len(flat)))]
        lines.append(face.format(*corners))
    path.write_text('\n'.join(lines) + '\n')


def read_ply(path):
    """Keypose's own PLY: points, faces, colours or None."""
    data = path.read_bytes()
    at = data.index(b'end_header\n') + 11
    head = data[:at].decode()
    count = lambda kind: int(re.search(rf'element {kind} (\d+)', head)[1])
    kinds = {'double': '<f8', 'float': '<f4', 'uchar': 'u1'}
    fields = [(name, kinds[kind]) for kind, name in re.findall(r'property (double|float|uchar) (\w+)', head.split('element face')[0])]
    vertices = np.frombuffer(data, fields, count('vertex'), at)
    face = [('n', 'u1'), ('v', '<i4', 3)] + ([('m', 'u1'), ('uv', '<f8', 6)] if 'texcoord' in head else [])
    faces = np.frombuffer(data, face, count('face'), at + vertices.nbytes)['v']
    points = np.stack([vertices[a] for a in 'xyz'], 1)
    colors = np.stack([vertices[a] for a in ('red', 'green', 'blue')], 1).astype(float) if 'red' in head else None
    return points, faces, colors


def read_obj(path):
    lines = [line.split() for line in path.read_text().splitlines()]
    points = np.array([list(map(float, w[1:4])) for w in lines if w and w[0] == 'v'])
    uvs = np.array([list(map(float, w[1:3])) for w in lines if w and w[0] == 'vt'])
    corners = np.array([[c.split('/')[:2] for c in w[1:4]] for w in lines if w and w[0] == 'f'], int) - 1
    return points, corners[..., 0], uvs[corners[..., 1]]


def volume(points, faces):
    a, b, c = (points[faces[:, k]] for k in range(3))
    return float(np.einsum('ij,ij->', a, np.cross(b, c)) / 6)


def scan_numbers(b, file, colors=True, of=None, size=None, goal=None):
    """`keypose init`, then what a project has of the file: colours against the formula, volume and extent against `of` (points, faces).

    @param goal  instead of the formula: the colour of each face
    """
    work = b.folder('scan')
    code, text = b.keypose('init', work / 'project', '--pose', f'rest={file}')
    if code != 0:
        return Outcome(code, text)
    entry = re.search(r'rest: \{mesh: ([^,}]+)(?:, texture: ([^,}]+))?', (work / 'project/pipeline.yaml').read_text())
    mesh, numbers = work / 'project' / entry[1], []
    if entry[2]:
        code, more = b.keypose('unwrap', '--clean', mesh, '--unwrapped', work / 'u.obj', '--keep', 'true')
        if code != 0:
            return Outcome(code, text + more)
        points, faces, uvs = read_obj(work / 'u.obj')
        texture = cv2.imread(str(work / 'project' / entry[2]))[..., ::-1].astype(float)
        uv = uvs.mean(1)
        x = np.clip((uv[:, 0] * texture.shape[1]).astype(int), 0, texture.shape[1] - 1)
        y = np.clip(((1 - uv[:, 1]) * texture.shape[0]).astype(int), 0, texture.shape[0] - 1)
        shown = texture[y, x]
    else:
        code, more = b.keypose('cleanup', '--surface', mesh, '--clean', work / 'c.ply', '--support', 'keep')
        if code != 0:
            return Outcome(code, text + more)
        points, faces, per_vertex = read_ply(work / 'c.ply')
        shown = per_vertex[faces].mean(1) if per_vertex is not None else np.full((len(faces), 3), 128.0)
    if colors:
        middle = points[faces].mean(1)
        right = color_of(middle / np.linalg.norm(middle, axis=1)[:, None]) if goal is None else goal
        numbers.append(('levels', float(np.abs(shown - right).mean()), 1.5))
    if of is not None:
        v = volume(*of)
        numbers.append(('volume off', abs(volume(points, faces) / v - 1), 1e-4))
        numbers.append(('places', float(max(np.abs(points.min(0) - of[0].min(0)).max(), np.abs(points.max(0) - of[0].max(0)).max())), 1e-4))
    if size:
        numbers.append(('volume off', abs(volume(points, faces) / size - 1), 1e-5))
    return Outcome(0, text, numbers)


BLENDER = '''
import bpy, json, math, sys, mathutils
source, out = sys.argv[-2:]
data = json.load(open(source + '/scan.json'))
def clear():
    bpy.ops.wm.read_factory_settings(use_empty=True)
def build(mapped=False, colors=False, textured=True):
    clear()
    mesh = bpy.data.meshes.new('scan')
    mesh.from_pydata(data['points'], [], data['faces'])
    layer = mesh.uv_layers.new(name='UVMap')
    for f, corners in zip(mesh.polygons, data['uvs']):
        for loop, (u, v) in zip(f.loop_indices, corners):
            layer.data[loop].uv = ((u - 0.1) / 2, (v - 0.2) / 0.5) if mapped else (u, v)
    if colors:
        layer = mesh.color_attributes.new(name='Col', type='BYTE_COLOR', domain='CORNER')
        for loop in mesh.loops:
            d = mathutils.Vector(data['points'][loop.vertex_index]).normalized()
            layer.data[loop.index].color_srgb = [0.5 + 0.4 * c for c in d] + [1]
    material = bpy.data.materials.new('my skin')
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    if textured:
        image = nodes.new('ShaderNodeTexImage')
        image.image = bpy.data.images.load(source + '/scan.png')
        links.new(image.outputs['Color'], nodes['Principled BSDF'].inputs['Base Color'])
        if mapped:
            place, coordinates = nodes.new('ShaderNodeMapping'), nodes.new('ShaderNodeTexCoord')
            place.inputs['Scale'].default_value, place.inputs['Location'].default_value = (2, 0.5, 1), (0.1, 0.2, 0)
            links.new(coordinates.outputs['UV'], place.inputs['Vector'])
            links.new(place.outputs['Vector'], image.inputs['Vector'])
    mesh.materials.append(material)
    thing = bpy.data.objects.new('scan', mesh)
    bpy.context.scene.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    return thing
def gltf(name, **more):
    bpy.ops.export_scene.gltf(filepath=out + '/' + name, **more)
build(); gltf('plain.glb', export_format='GLB')
gltf('embedded.gltf', export_format='GLTF_EMBEDDED'); gltf('separate.gltf', export_format='GLTF_SEPARATE', export_image_format='JPEG')
bpy.ops.wm.obj_export(filepath=out + '/plain.obj', forward_axis='Y', up_axis='Z', path_mode='COPY')
bpy.ops.export_mesh.stl(filepath=out + '/plain.stl', axis_forward='Y', axis_up='Z')
bpy.ops.export_scene.fbx(filepath=out + '/plain.fbx'); bpy.ops.export_scene.x3d(filepath=out + '/plain.x3d')
bpy.ops.wm.save_as_mainfile(filepath=out + '/plain.blend')
build(mapped=True); gltf('mapped.glb', export_format='GLB')
bpy.ops.wm.obj_export(filepath=out + '/mapped.obj', forward_axis='Y', up_axis='Z', path_mode='COPY')
build(colors=True, textured=False)
bpy.ops.export_mesh.ply(filepath=out + '/colors_ascii.ply', use_ascii=True, axis_forward='Y', axis_up='Z')
bpy.ops.export_mesh.ply(filepath=out + '/colors.ply', axis_forward='Y', axis_up='Z')
thing = build()
thing.shape_key_add(name='Basis'); key = thing.shape_key_add(name='fat')
for point in key.data: point.co = point.co * 1.1
key.value = 1
gltf('shape.glb', export_format='GLB')
thing = build()
thing.location, thing.rotation_euler, thing.scale = (3, -2, 1), (0.4, 0.2, 1.1), (-2, 2, 2)
gltf('moved.glb', export_format='GLB')
corners = [thing.matrix_world @ v.co for v in thing.data.vertices]
json.dump([list(c) for c in corners], open(out + '/moved.json', 'w'))
thing = build()
armature = bpy.data.objects.new('rig', bpy.data.armatures.new('rig'))
bpy.context.scene.collection.objects.link(armature)
bpy.context.view_layer.objects.active = armature
bpy.ops.object.mode_set(mode='EDIT')
bone = armature.data.edit_bones.new('bone'); bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
bpy.ops.object.mode_set(mode='OBJECT')
thing.parent = armature
thing.modifiers.new('skin', 'ARMATURE').object = armature
thing.vertex_groups.new(name='bone').add(range(len(thing.data.vertices)), 1, 'REPLACE')
armature.scale, armature.location = (0.5, 0.5, 0.5), (0, 0, 2)
pose = armature.pose.bones['bone']; pose.rotation_mode = 'XYZ'; pose.rotation_euler = (math.pi / 2, 0, 0)
pose.keyframe_insert('rotation_euler', frame=1); bpy.context.scene.frame_set(1)
thing.select_set(True); armature.select_set(True)
gltf('skin.glb', export_format='GLB', export_current_frame=True)
done = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
json.dump([list(done.matrix_world @ v.co) for v in done.data.vertices], open(out + '/skin.json', 'w'))
'''


def blender_files(b):
    folder = b.folder('blender')
    (folder / 'make.py').write_text(BLENDER)
    said = tool('blender', '-b', '--factory-startup', '--python', folder / 'make.py', '--', b.once(star_files), folder)
    if not (folder / 'skin.json').exists():
        raise Skip('Blender failed: ' + said[-400:])
    return folder


def blender_scan(b, name, factor=1.0, places=None, colors=True):
    folder, (points, faces, _) = b.once(blender_files), star()
    if places:
        points = np.array(json.loads((folder / places).read_text()))
        faces = faces[:, ::-1] if volume(points, faces) < 0 else faces
    return scan_numbers(b, folder / name, colors, (points * factor, faces))


def assimp_scan(b, name, form, colors=True, turned=False):
    """assimp takes OBJ as it is: its glTF has the OBJ's z as z, which glTF calls the front."""
    source, folder = b.once(star_files), b.folder('assimp')
    for file in ('scan.obj', 'scan.mtl', 'scan.png'):
        shutil.copy(source / file, folder)
    tool('assimp', 'export', 'scan.obj', name, f'-f{form}', cwd=folder)
    points, faces, _ = star()
    if turned:
        points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], 1)
    return scan_numbers(b, folder / name, colors, (points, faces))


INIT = '`keypose init --pose`'
cases('glTF', INIT, [
    ('01 plain', '', 'right', '01_glb_texture_transform/plain.glb'),
    ('01 scaled', '', 'right', '01_glb_texture_transform/scaled.glb'),
    ('01 gltfpack', '', 'right', '01_glb_texture_transform/gltfpack.glb'),
    ('06 Draco', '', 'right', '06_glb_compressed/draco.glb'),
    ('07 WebP', '', 'right', '07_glb_texture_without_source/webp_used_only.glb'),
], lambda b, name: scan_numbers(b, b.report(name)))
cases('glTF', INIT, [('02 sparse', '', 'right', '02_glb_sparse/over_view.glb', 8.275254),
                     ('03 shape on', '', 'right', '03_glb_morph_weights/shape_on.glb', 8.272799)],
      lambda b, name, size: scan_numbers(b, b.report(name), colors=False, size=size))


@case('glTF', INIT, '33 skinned')
def skinned(b):
    lines = [line.split() for line in b.report('33_glb_skinned/at_rest_truth_z_up.obj').read_text().splitlines()]
    points = np.array([w[1:4] for w in lines if w and w[0] == 'v'], float)
    faces = np.array([[c.split('/')[0] for c in w[1:4]] for w in lines if w and w[0] == 'f'], int) - 1
    return scan_numbers(b, b.report('33_glb_skinned/at_rest.glb'), False, (points, faces))


cases('glTF', INIT, [
    ('Blender glb', '', 'right', 'plain.glb'), ('Blender embedded', '', 'right', 'embedded.gltf'),
    ('Blender separate, JPEG', '', 'right', 'separate.gltf'), ('Blender mapping node', '', 'right', 'mapped.glb'),
    ('Blender shape key', '', 'right', 'shape.glb', 1.1), ('Blender mirrored node', '', 'right', 'moved.glb', 1, 'moved.json', False),
    ('Blender skin, posed', '', 'right', 'skin.glb', 1, 'skin.json', False),
], blender_scan)
cases('glTF', INIT, [('assimp glb', '', 'right', 'a.glb', 'glb2', False, True), ('assimp gltf', '', 'right', 'a.gltf', 'gltf2', False, True)], assimp_scan)
cases('OBJ, MTL', INIT, [
    ('08 no usemtl', '', 'right', '08_obj_materials/no_usemtl/scan.obj'),
    ('09 weight and colour', '', 'right', '09_obj_partial_colors/w_and_rgb.obj')], lambda b, name: scan_numbers(b, b.report(name)))


@case('OBJ, MTL', INIT, '08 -o 0.25 -s 2')
def scaled_by_option(b):
    file = b.report('08_obj_materials/scaled_by_option/scan.obj')
    uv, texture = read_obj(file)[2].mean(1) * [2, 1] + [0.25, 0], cv2.imread(str(file.with_suffix('.png')))[..., ::-1].astype(float)
    rows, columns = texture.shape[:2]
    return scan_numbers(b, file, goal=texture[np.clip(((1 - uv[:, 1]) * rows).astype(int), 0, rows - 1), (uv[:, 0] % 1 * columns).astype(int) % columns])


cases('OBJ, MTL', INIT, [('Blender', '', 'right', 'plain.obj'), ('Blender mapping node', '', 'right', 'mapped.obj')], blender_scan)
cases('OBJ, MTL', INIT, [('assimp', '', 'right', 'a.obj', 'obj')], assimp_scan)


def own_obj(b, mtl, head='mtllib a b.mtl\nusemtl my skin\n', **how):
    folder = b.folder('obj')
    shutil.copy(b.once(star_files) / 'scan.png', folder / 'my scan.png')
    (folder / 'a b.mtl').write_text(mtl)
    write_obj(folder / 'scan.obj', head, **how)
    points, faces, _ = star()
    return scan_numbers(b, folder / 'scan.obj', of=(points, faces))


SKIN = 'newmtl my skin\nKd 0.8 0.8 0.8\nmap_Kd {}my scan.png\n'
cases('OBJ, MTL', INIT, [
    ('names with spaces', '', 'right', SKIN.format('')),
    ('-o and -s', '', 'right', SKIN.format('-o 0.1 0.2 0 -s 2 0.5 1 '), 'mtllib a b.mtl\nusemtl my skin\n', lambda uv: (uv - [0.1, 0.2]) / [2, 0.5]),
    ('-mm', r'-mm', 'named', SKIN.format('-mm 0.3 0.5 ')),
    ('texture is not there', r'my scan\.tga', 'named', 'newmtl my skin\nmap_Kd my scan.tga\n'),
], lambda b, mtl, head='mtllib a b.mtl\nusemtl my skin\n', uv=lambda uvs: uvs: own_obj(b, mtl, head, uv=uv))
cases('OBJ, MTL', INIT, [
    ('indices backwards', '', 'right', {'shift': lambda i, n: i - n}),
    ('lines joined by a backslash', '', 'right', {'face': 'f {}/{} \\\n{}/{} {}/{}'}),
    ('colours to 255', '', 'right', {'head': 'o plain', 'vertex': 'v {0[0]:.9g} {0[1]:.9g} {0[2]:.9g} {k[0]} {k[1]} {k[2]}', 'face': 'f {} {2} {4}'}),
], lambda b, how: own_obj(b, SKIN.format(''), **{**how, 'face': how.get('face', 'f {}/{} {}/{} {}/{}').replace('f {} {2} {4}', 'f {0} {2} {4}')}))


def own_ply(b, kind, most, encoding='ascii'):
    points, faces, _ = star()
    colors = color_of(points / np.linalg.norm(points, axis=1)[:, None]) / 255 * most
    colors = colors if kind == 'float' else np.round(colors).astype(int)
    head = f'ply\nformat {encoding} 1.0\ncomment made by hand\nelement vertex {len(points)}\n' + ''.join(f'property double {a}\n' for a in 'xyz')
    head += ''.join(f'property {kind} {a}\n' for a in ('red', 'green', 'blue')) + f'element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n'
    file = b.folder('ply') / 'scan.ply'
    if encoding == 'ascii':
        rows = [' '.join(f'{x:.9g}' for x in [*p, *c]) for p, c in zip(points, colors)] + [f'3 {f[0]} {f[1]} {f[2]}' for f in faces]
        file.write_text(head + '\n'.join(rows) + '\n')
    else:
        form = {'float': 'f', 'ushort': 'H', 'uchar': 'B'}[kind] * 3
        rows = [struct.pack('>3d' + form, *p, *c) for p, c in zip(points, colors.tolist())] + [struct.pack('>B3i', 3, *f) for f in faces]
        file.write_bytes(head.encode() + b''.join(rows))
    return scan_numbers(b, file, of=(points, faces))


cases('PLY', INIT, [('12 float colours', '', 'right', '12_ply_kinds/color_float.ply')], lambda b, name: scan_numbers(b, b.report(name)))
cases('PLY', INIT, [('Blender', '', 'right', 'colors.ply'), ('Blender ASCII', '', 'right', 'colors_ascii.ply')], blender_scan)
cases('PLY', INIT, [('assimp', '', 'right', 'a.ply', 'ply', False), ('assimp binary', '', 'right', 'a.ply', 'plyb', False)], assimp_scan)
cases('PLY', INIT, [('16 bit colours', '', 'right', 'ushort', 65535), ('big endian, float', '', 'right', 'float', 1.0, 'binary_big_endian')], own_ply)
OTHER = 'ZIP, STL, others'
cases(OTHER, INIT, [('Blender STL', '', 'right', 'plain.stl', 1, None, False)] +
      [(f'Blender {name}', name, 'named', f'plain.{ending}') for name, ending in
       (('FBX', 'fbx'), ('X3D', 'x3d'), ('Blender', 'blend'))], blender_scan)
cases(OTHER, INIT, [('assimp STL', '', 'right', 'a.stl', 'stlb', False), ('assimp Collada', 'Collada', 'named', 'a.dae', 'collada'),
                    ('assimp 3DS', '3DS|3D Studio', 'named', 'a.3ds', '3ds')], assimp_scan)


def colored_faces():
    """Points, faces, colour of each face: levels of its middle."""
    points, faces, _ = star()
    middle = points[faces].mean(1)
    return points, faces, np.round(color_of(middle / np.linalg.norm(middle, axis=1)[:, None])).astype(int)


def own_off(b, keyword, scale, of_faces=False, binary=False):
    """Colours of vertices or faces as whole levels or fractions of 1."""
    points, faces, face_colors = colored_faces()
    levels = np.round(color_of(points / np.linalg.norm(points, axis=1)[:, None])).astype(int)
    file = b.folder('off') / 'scan.off'
    if binary:
        data = f'{keyword} BINARY\n'.encode() + struct.pack('>3i', len(points), len(faces), 0)
        data += b''.join(struct.pack('>7f', *p, *c, 1) for p, c in zip(points, (levels / 255).tolist()))
        file.write_bytes(data + b''.join(struct.pack('>5i', 3, *f, 0) for f in faces.tolist()))
    else:
        said = lambda c: ' '.join(str(x) if scale == 1 else f'{x / scale:.6f}' for x in c)
        rows = [' '.join(f'{x:.9g}' for x in p) + ('' if of_faces else f' {said(c)} {said([255])}') for p, c in zip(points, levels)]
        rows += [f'3 {f[0]} {f[1]} {f[2]}' + (f' {said(c)}' if of_faces else '') for f, c in zip(faces, face_colors)]
        file.write_text(f'{keyword}\n{len(points)} {len(faces)} 0\n' + '\n'.join(rows) + '\n')
    return scan_numbers(b, file, of=(points, faces))


def own_stl(b, magics, tail=b'', set_bit=0):
    points, faces, levels = colored_faces()
    five = np.round(levels * 31 / 255).astype(int)
    bits = five[:, 0] | five[:, 1] << 5 | five[:, 2] << 10 | set_bit if magics else five[:, 2] | five[:, 1] << 5 | five[:, 0] << 10 | 0x8000
    normals = np.cross(points[faces[:, 1]] - points[faces[:, 0]], points[faces[:, 2]] - points[faces[:, 0]])
    rows = [struct.pack('<12fH', *n, *points[f].ravel(), a) for n, f, a in zip(normals / np.linalg.norm(normals, axis=1)[:, None], faces, bits.tolist())]
    file = b.folder('stl') / 'scan.stl'
    file.write_bytes((b'COLOR=\x80\x80\x80\xff' if magics else b'').ljust(80, b'\0') + struct.pack('<I', len(faces)) + b''.join(rows) + tail)
    # Five bits a channel are 8.2 levels apart.
    outcome = scan_numbers(b, file, of=(points, faces))
    outcome.numbers = [(label, value, 3 if label == 'levels' else bound) for label, value, bound in outcome.numbers]
    return outcome


def packed_ply(b, kind):
    points, faces, _ = star()
    c = np.round(color_of(points / np.linalg.norm(points, axis=1)[:, None])).astype(int).tolist()
    file = b.folder('ply') / 'scan.ply'
    head = f'ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n' + ''.join(f'property float {a}\n' for a in 'xyz')
    head += f'property {kind}\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n'
    rows = [struct.pack('<3f', *p) + bytes((k[2], k[1], k[0], 255)) for p, k in zip(points, c)] + [struct.pack('<B3i', 3, *f) for f in faces]
    file.write_bytes(head.encode() + b''.join(rows))
    return scan_numbers(b, file, of=(points, faces))


def named_file(b, name, data):
    file = b.folder('named') / name
    file.write_bytes(data if isinstance(data, bytes) else data.encode())
    code, text = b.keypose('init', file.parent / 'project', '--pose', f'rest={file}')
    return Outcome(code, text)


cases(OTHER, INIT, [
    ('COFF, levels', '', 'right', 'COFF', 1), ('COFF, fractions', '', 'right', 'COFF', 255),
    ('OFF, faces in levels', '', 'right', 'OFF', 1, True), ('OFF, faces in fractions', '', 'right', 'OFF', 255, True),
    ('COFF, binary', '', 'right', 'COFF', 255, False, True)], own_off)
cases(OTHER, INIT, [('STL, VisCAM', '', 'right', False), ('STL, Magics', '', 'right', True), ('STL, MeshLab', '', 'right', True, b'', 0x8000),
                    ('STL with bytes behind', '', 'right', False, b'more')], own_stl)
cases('PLY', INIT, [(f'packed {kind}', '', 'right', kind) for kind in ('uint rgb', 'float rgb', 'uint rgba')], packed_ply)
cases('OBJ, MTL', INIT, [('map_basecolor', '', 'right', 'newmtl my skin\nmap_basecolor my scan.png\n'),
                         ('Kd xyz', 'Kd xyz', 'named', 'newmtl my skin\nKd xyz 0.4 0.2 0.1\n')], own_obj)
cases('glTF', INIT, [('minVersion 2.1', 'glTF 2.1', 'named', 'a.gltf', '{"asset": {"version": "2.1", "minVersion": "2.1"}}')], named_file)
cases(OTHER, INIT, [
    ('3MF', '3MF', 'named', 'a.3mf', 'nothing known'), ('AMF', 'an AMF file', 'named', 'a.amf', '<?xml version="1.0"?>\n<amf unit="inch"/>'),
    ('LAS', 'a LAS or LAZ', 'named', 'a.laz', b'LASF\0\0'), ('Gmsh', 'a Gmsh file', 'named', 'a.msh', '$MeshFormat\n4.1 0 8\n'),
    ('PCD', 'point cloud of PCL', 'named', 'a.pcd', '# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\n'), ('splats', 'Gaussian splats', 'named', 'a.splat', b'\1\2\3\4'),
    ('VTK', 'a VTK file', 'named', 'a.vtk', '# vtk DataFile Version 3.0\nm\nASCII\n'), ('VTP', 'a VTK file', 'named', 'a.vtp', '<VTKFile type="PolyData">'),
    ('points', 'a list of points', 'named', 'a.xyz', '0 1 2\n3 4 5\n'), ('E57', 'an E57', 'named', 'a.e57', b'ASTM-E57\1'),
    ('USD', 'a USD file', 'named', 'a.usd', b'PXR-USDC\0'), ('VRML', 'a VRML file', 'named', 'a.wrl', '#VRML V2.0 utf8\n'),
    ('UTF-16', 'UTF-16', 'named', 'a.obj', 'v 0 0 0\nv 1 0 0\n'.encode('utf-16'))], named_file)


@case(OTHER, INIT, 'zipped OBJ')
def zipped(b):
    folder, source = b.folder('zip'), b.once(star_files)
    with zipfile.ZipFile(folder / 'scan.zip', 'w', zipfile.ZIP_DEFLATED) as archive:
        for name in ('scan.obj', 'scan.mtl', 'scan.png'):
            archive.write(source / name, f'my scan/{name}')
    points, faces, _ = star()
    return scan_numbers(b, folder / 'scan.zip', of=(points, faces))


@case('units and axes apart', '`keypose register`', '11')
def units_apart(b):
    source, target = b.report('11_units_and_axes_apart/template_0.1.obj'), b.report('11_units_and_axes_apart/scan_micrometres_y_up.obj')
    out = b.folder('register') / 'r.ply'
    code, text = b.keypose('register', '--source', source, '--target', target, '--registered', out)
    if code != 0:
        return Outcome(code, text)
    truth = np.loadtxt(b.report('11_units_and_axes_apart/truth_micrometres.txt'))
    points = read_ply(out)[0]
    size = np.linalg.norm(truth.max(0) - truth.min(0))
    return Outcome(0, text, [('of the diagonal', float(np.linalg.norm(points - truth[:, -3:], axis=1).mean() / size), 0.01)])
