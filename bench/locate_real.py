#!/usr/bin/env python3
"""Locates photographs of a project as if they were filmed frames, with their cameras withheld.

    locate_real.py --mesh mesh.obj --texture texture.png --images IMAGES --model MODEL [--every 6] [--bin DIR]
                   [--no-texture] [--focal_35mm MM] [--json FILE] [--picture FILE.png]

IMAGES is the folder with photographs and masks that the stages capture and masks write, MODEL the cameras that sfm
found, mesh and texture what the pipeline made of them. The chosen photographs are located together, as the
frames of a moving camera with one lens, from EXIF or --focal_35mm. Prints how far the found camera is from sfm's own. Needs only Python.
"""
import argparse
import json
import pathlib
import tempfile

from locate_table import angle, call, center, distance, found_view, read_cameras, read_vertices


def locate(args, views, middle, scratch):
    """One film of a moving camera whose frames are the photographs."""
    (scratch / 'film').mkdir()
    (scratch / 'mattes').mkdir()
    for number, name in enumerate(views):
        (scratch / 'film' / f'{number:04}{pathlib.Path(name).suffix}').symlink_to((args.images / name).resolve())
        (scratch / 'mattes' / f'{number:04}.png').symlink_to((args.images / 'masks' / (name + '.png')).resolve())
    look = [] if args.no_texture else ['--textures', args.texture]
    lens = ['--focal_35mm', args.focal_35mm] if args.focal_35mm else []
    done = call([args.bin / 'keypose-locate', '--mesh', args.mesh, *look, '--plate', scratch / 'film', '--matte', scratch / 'mattes', '--camera', 'moving', *lens,
                 '--min_iou', 0, '--shot', scratch / 'shot.json', '--report', scratch / 'report.json', '--picture', args.picture or scratch / 'p.png'])
    report = json.loads((scratch / 'report.json').read_text())
    shot = json.loads((scratch / 'shot.json').read_text())
    rows = []
    for frame, measured, (name, view) in zip(shot['frames'], report['measurements']['frames'], views.items()):
        rotation, translation = found_view(frame)
        truth = center(*view[:2])
        rows.append({'name': name, 'turn_deg': angle(rotation, view[0]), 'center': distance(center(rotation, translation), truth) / distance(truth, middle),
                     **{key: measured[key] for key in ('contour_px', 'iou', 'method', 'inliers', 'correlation')}})
        print(json.dumps(rows[-1]))
    print('focal length over that of sfm', shot['camera']['fx'] / view[2][3][0], report['measurements']['focal'],
          'said to be right to', report['measurements']['focal_uncertainty'], 'k1', shot['camera']['k1'],
          'seconds', report['seconds'], done.stdout.strip().splitlines()[-1] if done.stdout.strip() else '')
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ('mesh', 'texture', 'images', 'model'):
        parser.add_argument('--' + name, type=pathlib.Path, required=True)
    parser.add_argument('--every', type=int, default=6)
    parser.add_argument('--bin', type=pathlib.Path, default=pathlib.Path('build/release/bin'))
    parser.add_argument('--no-texture', action='store_true')
    parser.add_argument('--focal_35mm', type=float, default=0)
    parser.add_argument('--json', type=pathlib.Path)
    parser.add_argument('--picture', type=pathlib.Path)
    args = parser.parse_args()
    vertices = read_vertices(args.mesh)
    middle = [sum(v[k] for v in vertices) / len(vertices) for k in range(3)]
    views = dict(sorted(read_cameras(args.model).items())[::args.every])
    with tempfile.TemporaryDirectory() as scratch:
        rows = locate(args, views, middle, pathlib.Path(scratch))
    if args.json:
        args.json.write_text(json.dumps({'rows': rows}, indent=1) + '\n')
    good = sum(row['turn_deg'] < 0.3 and row['center'] < 0.005 for row in rows)
    print(f'{good} of {len(rows)} within 0.3 degrees and 0.5 % of the distance')


if __name__ == '__main__':
    main()
