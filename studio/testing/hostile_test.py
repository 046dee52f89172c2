#!/usr/bin/env python3
"""Sends 1,000 hostile requests to a studio and checks that nothing changes and that it goes on
answering.

    hostile_test.py BIN_DIR

Kinds: paths that lead out of the project, no or wrong cookies, other origins and host names, wrong
tokens, changes without the page's header, unknown methods, JSON that is malformed or nested too
deep, texts of other types than asked, bodies larger than allowed, heads without end, clients that
stop in mid-request, 200 connections at once. Each kind has the statuses that it must get. Needs
only Python.
"""
import hashlib
import json
import os
import pathlib
import random
import socket
import subprocess
import sys
import tempfile
import time

COUNT = 1000


class Studio:
    def __init__(self, bin_dir, folder):
        self.program = subprocess.Popen(
            [str(pathlib.Path(bin_dir) / 'keypose'), 'studio', '-C', str(folder), '--no-browser'],
            stdout=subprocess.PIPE,
            env={**os.environ, 'KEYPOSE_HOME': str(folder.parent / '.keypose')},
            text=True,
        )
        address = self.program.stdout.readline().strip()
        self.left_open = set()
        self.port = int(address.split(':')[2].split('/')[0])
        self.token = address.split('token=')[1]
        answer = self.ask('GET', f'/enter?token={self.token}', cookie='')
        assert answer[0] == 302, answer
        self.cookie = next(
            line.split(': ', 1)[1].split(';')[0]
            for line in answer[1].split('\r\n')
            if line.lower().startswith('set-cookie')
        )

    def raw(self, data, wait=90.0, ends=False):
        """Status, head and body of the answer to these bytes; status 0: the connection was closed
        without one. A busy machine or a sanitized studio needs longer than the usual half second.
        ends: nothing more is sent, and the studio sees that."""
        with socket.create_connection(('127.0.0.1', self.port), timeout=wait) as connection:
            got = b''
            try:
                connection.sendall(data)
                if ends:
                    connection.shutdown(socket.SHUT_WR)
                while chunk := connection.recv(65536):
                    got += chunk
                    head, _, body = got.partition(b'\r\n\r\n')
                    length = [
                        line
                        for line in head.split(b'\r\n')
                        if line.lower().startswith(b'content-length:')
                    ]
                    if b'\r\n\r\n' in got and length and len(body) >= int(length[0].split(b':')[1]):
                        break
            except (TimeoutError, ConnectionError):
                pass
        if not got.startswith(b'HTTP/1.1 '):
            return 0, '', b''
        head, _, body = got.partition(b'\r\n\r\n')
        return int(head[9:12]), head.decode('latin-1'), body

    def ask(self, method, path, cookie=None, body=b'', **headers):
        lines = {
            'Host': f'127.0.0.1:{self.port}',
            'Cookie': self.cookie if cookie is None else cookie,
            'X-Keypose': '1',
            'Content-Length': str(len(body)),
        }
        lines.update({name.replace('_', '-'): value for name, value in headers.items()})
        head = f'{method} {path} HTTP/1.1\r\n' + ''.join(
            f'{name}: {value}\r\n' for name, value in lines.items() if value is not None
        )
        return self.raw(head.encode('latin-1', 'replace') + b'\r\n' + body)

    def alive(self):
        return self.program.poll() is None and self.ask('GET', '/api/project')[0] == 200


def contents(folder):
    """Hashes of all files of the project, but the studio's own notes."""
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob('*'))
        if path.is_file() and '.keypose' not in path.parts
    }


OUTSIDE = [
    '../secret.txt',
    '../../etc/passwd',
    '/etc/passwd',
    '..%2f..%2fetc/passwd',
    '....//secret.txt',
    '%2e%2e/%2e%2e/secret.txt',
    'a/../../secret.txt',
    '..\\secret.txt',
    'rest/../../secret.txt',
    '\x00secret',
    '%00',
    'link/secret.txt',
]
CHANGES = [
    ('POST', '/api/run'),
    ('POST', '/api/stop'),
    ('POST', '/api/options'),
    ('PUT', '/api/mask?pose=rest&name=a.jpg'),
    ('POST', '/api/masks/hold'),
    ('PUT', '/api/figure?pose=rest'),
    ('PUT', '/api/calibration'),
    ('POST', '/api/calibration/run'),
    ('POST', '/api/calibration/use'),
    ('PUT', '/api/timeline'),
    ('PUT', '/api/landmarks?pose=rest'),
    ('PUT', '/api/landmarks?pose=few'),
    ('POST', '/api/landmarks/import?pose=rest'),
    ('POST', '/api/project'),
    ('POST', '/api/reveal'),
    ('PUT', '/api/photos?pose=rest&name=b.jpg'),
    ('PUT', '/api/stiffness'),
    ('PUT', '/api/regions'),
    ('POST', '/api/shoot/start'),
    ('POST', '/api/shoot/command'),
    ('PUT', '/api/shot'),
    ('PUT', '/api/shot/clicks'),
    ('POST', '/api/shot/quick'),
    ('POST', '/api/armature/start'),
    ('POST', '/api/armature/command'),
    ('POST', '/api/armature/bake'),
    ('POST', '/api/armature/calibration/start'),
    ('PUT', '/api/upload?place=armature&name=a.exe&at=0&size=9'),
    ('PUT', '/api/marks'),
    ('POST', '/api/marks/scan'),
    ('POST', '/api/marks/suggest'),
    ('POST', '/api/films/shot'),
    ('POST', '/api/shot/cut'),
    ('POST', '/api/upkeep'),
    ('POST', '/api/armature/take/open'),
    ('POST', '/api/armature/take/draft'),
    ('POST', '/api/armature/take/save'),
    ('PUT', '/api/armature/take/use'),
    ('POST', '/api/door/open'),
    ('POST', '/api/door/new'),
    ('POST', '/api/door/forget'),
    ('POST', '/api/door/example'),
    ('POST', '/api/door/address'),
    ('POST', '/api/door/end'),
]
LOOKS = [
    '/api/project',
    '/api/steps',
    '/api/timeline',
    '/api/results',
    '/',
    '/studio.js',
    '/api/events',
    '/results/a.txt',
    '/api/door',
    '/api/door/card',
]


def path_tricks(studio, pick):
    path = pick.choice(OUTSIDE)
    ways = [
        ('GET', f'/results/{path}'),
        ('GET', f'/report/{path}'),
        ('GET', f'/{path}'),
        ('GET', f'/api/photo?pose=rest&name={path}'),
        ('GET', f'/api/photo?pose={path}&name=a.jpg'),
        ('GET', f'/api/mask?pose=rest&name={path}'),
        ('GET', f'/api/figure?pose={path}'),
        ('GET', f'/api/mesh?pose={path}&what=mesh'),
        ('GET', f'/api/log?step={path}'),
        ('GET', f'/api/shoot/picture?path={path}'),
        ('GET', f'/api/shoot/picture?path=photos/rest/{path}'),
        ('GET', f'/api/shot/frame?frame={path}'),
        ('GET', f'/api/shot/picture?what={path}'),
        ('GET', f'/api/shot/picture?what=result&number={path}'),
        ('GET', f'/api/shot/picture?what=quick&number={path}'),
        ('GET', f'/api/films?shot={path}'),
        ('GET', f'/api/films/frame?shot=rest&camera={path}&frame=0'),
        ('GET', f'/api/films/frame?shot={path}&camera=cam1&frame=0'),
        ('GET', f'/api/films/mask?shot=rest&camera=cam1&frame={path}'),
        ('GET', f'/api/calibration/picture?camera={path}'),
        ('GET', f'/api/failed?step={path}&picture=a.failed.jpg'),
        ('GET', f'/api/failed?step=capture/rest&picture={path}'),
        ('GET', f'/api/frames/texture?shot={path}'),
        ('GET', f'/api/frames/texture?shot=rest&frame={path}'),
        ('GET', f'/api/armature/plate?index={path}'),
        ('GET', f'/api/armature/mesh?what={path}'),
        ('GET', f'/api/armature/frames?from={path}'),
        ('GET', f'/api/armature/view?take={path}'),
        ('GET', f'/api/armature/take/setup?take={path}'),
        ('GET', f'/api/armature/take/use?take={path}'),
        ('GET', f'/api/armature/mesh?take={path}'),
        ('GET', f'/api/confidence?pose={path}'),
        ('GET', f'/api/landmarks/fit?pose={path}'),
        ('GET', f'/api/landmarks/photographs?pose={path}'),
        ('GET', f'/api/door/card?folder={path}'),
        ('GET', f'/api/door/picture?folder={path}'),
    ]
    status, _, body = studio.ask(*pick.choice(ways))
    return status in (400, 404) and b'TOP SECRET' not in body and b'root:' not in body


def puppet(**changed):
    """A set-up of an armature's session that could begin, but for what is changed."""
    return {
        'take': 'take1',
        'port': 'simulated',
        'calibration': '',
        'description': 'out/a.txt',
        'chains': 'out/a.txt',
        'fps': 24,
        'step': 2,
    } | changed


def saving(**changed):
    """What keeps a take as a new one, with another value for a field."""
    return {'take': 'take1', 'name': 'take2', 'edits': ['hold all 0-1']} | changed


def using(**changed):
    """What puts a take into the project, with another value for a field."""
    return {'take': 'take1', 'use': 'export', 'used': True, 'revision': ''} | changed


def shot(**changed):
    """What the page Shot would write, with other values for some fields."""
    shows = [{'frame': 0, 'pose': 'rest'}, {'frame': 4, 'pose': 'rest'}]
    return {'film': 'films', 'fps': 12, 'shows': shows, 'revision': '', 'clicks': [], **changed}


def photo_pick(**changed):
    """A change of picks in photographs, with another value for a field of the pick."""
    pick = {'name': 'a', 'image': 'a.jpg', 'pixel': [1, 2], **changed}
    return json.dumps({'pixels': [pick], 'revision': ''}).encode()


def writing_outside(studio, pick):
    path = pick.choice(OUTSIDE)
    ways = [
        ('PUT', f'/api/photos?pose=rest&name={path}', b'x'),
        ('PUT', f'/api/photos?pose={path}&name=a.jpg', b'x'),
        ('PUT', f'/api/mask?pose=rest&name={path}', b'\x89PNG'),
        ('PUT', f'/api/landmarks?pose={path}', b'{"picks": [], "revision": ""}'),
        ('PUT', '/api/landmarks?pose=few', photo_pick(image=path)),
        ('PUT', '/api/landmarks?pose=few', photo_pick(name=path)),
        ('POST', '/api/reveal', json.dumps({'path': path}).encode()),
        ('PUT', '/api/shot', json.dumps(shot(film=path)).encode()),
        ('PUT', '/api/shot/clicks', json.dumps(shot(clicks=[{'frame': path}])).encode()),
        ('POST', '/api/calibration/run', json.dumps({'lenses': path, 'square_mm': 22}).encode()),
        ('POST', '/api/calibration/use', json.dumps({'shot': path}).encode()),
        ('POST', '/api/run', json.dumps({'until': ['--set', path]}).encode()),
        ('POST', '/api/armature/start', json.dumps(puppet(description=path)).encode()),
        ('POST', '/api/armature/start', json.dumps(puppet(take=path)).encode()),
        ('POST', '/api/armature/start', json.dumps(puppet(plate=path)).encode()),
        ('POST', '/api/armature/start', json.dumps(puppet(port=f'/dev/{path}')).encode()),
        ('POST', '/api/armature/take/open', json.dumps({'take': path}).encode()),
        ('POST', '/api/armature/take/open', json.dumps({'take': 'take1', 'setup': puppet(mesh=path)}).encode()),
        ('POST', '/api/armature/take/draft', json.dumps({'take': path, 'edits': []}).encode()),
        ('PUT', '/api/armature/take/use', json.dumps(using(take=path)).encode()),
        ('PUT', '/api/armature/take/use', json.dumps(using(use=path)).encode()),
        ('POST', '/api/door/open', json.dumps({'folder': path}).encode()),
        ('POST', '/api/door/new', json.dumps({'name': path + '/'}).encode()),
        ('POST', '/api/door/example', json.dumps({'kind': path, 'base': path}).encode()),
        ('POST', '/api/armature/take/save', json.dumps(saving(name=path)).encode()),
        ('POST', '/api/armature/take/save', json.dumps(saving(edits=[path])).encode()),
    ]
    method, way, body = pick.choice(ways)
    status, _, words = studio.ask(method, way, body=body)
    if status not in (400, 404):
        print(method, repr(way), body, status, words[:200])
    return status in (400, 404)


def no_cookie(studio, pick):
    wrong = pick.choice(
        [
            '',
            'keypose=1',
            studio.cookie[:-1],
            studio.cookie + '0',
            studio.cookie.replace('=', '=x'),
            'a=b; c=d',
            studio.token,
        ]
    )
    method, path = pick.choice(CHANGES + [('GET', look) for look in LOOKS])
    return studio.ask(method, path, cookie=wrong, body=b'{}')[0] == 403


def other_origin(studio, pick):
    origin = pick.choice(
        [
            'http://evil.example',
            'null',
            f'http://localhost:{studio.port + 1}',
            f'https://127.0.0.1:{studio.port}',
            'file://',
        ]
    )
    method, path = pick.choice(CHANGES)
    return studio.ask(method, path, body=b'{}', Origin=origin)[0] == 403


def other_site(studio, pick):
    return (
        studio.ask(
            'GET', pick.choice(LOOKS), Sec_Fetch_Site=pick.choice(['cross-site', 'same-site'])
        )[0]
        == 403
    )


def other_host(studio, pick):
    host = pick.choice(
        [
            'evil.example',
            f'evil.example:{studio.port}',
            '127.0.0.1',
            f'127.0.0.1:{studio.port + 1}',
            '',
            f'[::1]:{studio.port}',
            f'127.0.0.1:{studio.port}.evil.example',
        ]
    )
    method, path = pick.choice(CHANGES + [('GET', look) for look in LOOKS])
    return studio.ask(method, path, body=b'{}', Host=host)[0] in (400, 403)


def wrong_token(studio, pick):
    token = pick.choice(['', studio.token, studio.token[:-1], '0' * 32, 'x' * 4000, '%00', '../..'])
    return studio.ask('GET', f'/enter?token={token}', cookie='')[0] == 403


def no_header(studio, pick):
    method, path = pick.choice(CHANGES)
    return (
        studio.ask(method, path, body=b'{}', X_Keypose=pick.choice([None, '', '0', '2']))[0] == 403
    )


def odd_method(studio, pick):
    method = pick.choice(
        ['DELETE', 'PATCH', 'TRACE', 'CONNECT', 'OPTIONS', 'get', 'FOO', 'PROPFIND']
    )
    return studio.ask(method, pick.choice(LOOKS), body=b'{}')[0] in (0, 400, 403, 404, 405)


def bad_json(studio, pick):
    body = pick.choice(
        [
            b'',
            b'{',
            b'[]',
            b'null',
            b'{"a": 1}',
            b'[' * 150,
            b'{"poses": ' + b'[' * 150 + b']' * 150 + b'}',
            b'\xff\xfe{}',
            b'{"picks": 5, "revision": 7}',
            b'{"step": [], "option": {}, "pose": 1, "value": {}, "revision": null}',
            b'{"keys": "no"}',
            b'1e999',
            b'{"picks": [{"name": "a", "face": 1e300, "barycentric": "x"}], "revision": ""}',
            b'{"pixels": [{"name": "a", "image": "a.jpg", "pixel": [1e999, {}]}], "revision": ""}',
            b'{"pixels": {"a": [[]]}, "revision": ""}',
            b'{"strokes": [{"picture": "../secret.txt", "figure": true, "points": [[0, 0]]}], "revision": ""}',
            b'{"strokes": [{"text": "a.jpg:1e999,1"}, {"picture": 1, "points": [[]]}], "revision": ""}',
            b'{"until": {"a": 1}}',
            b'{"path": 3}',
        ]
    )
    method, path = pick.choice(
        [
            change
            for change in CHANGES
            if change[1].split('?')[0]
            not in (
                '/api/mask',
                '/api/photos',
                '/api/stop',
                '/api/run',
                '/api/door/address',
                '/api/door/end',
            )
        ]
    )
    return studio.ask(method, path, body=body)[0] in (400, 404, 409)


def too_large(studio, pick):
    method, path = pick.choice(
        [
            change
            for change in CHANGES
            if change[1].split('?')[0] not in ('/api/mask', '/api/photos')
        ]
    )
    return studio.ask(
        method, path, body=b'{}', Content_Length=pick.choice(['40000000', '99999999999', '9' * 30])
    )[0] in (0, 400, 413)


def endless_head(studio, pick):
    head = f'GET / HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\n'.encode()
    tricks = [
        head + b'X: ' + b'a' * 100000 + b'\r\n\r\n',
        b'GET /' + b'a' * 100000 + b' HTTP/1.1\r\n\r\n',
        b'\x00' * 1000,
        b'GET\r\n\r\n',
        b'GET / HTTP/9.9\r\n\r\n',
        head + b'X: b\r\n' * 5000 + b'\r\n',
        b'\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03',
    ]
    # Once each stays open, so that the studio waits until its patience ends; then they hang up.
    trick = pick.choice(tricks)
    ends = trick in studio.left_open
    studio.left_open.add(trick)
    return studio.raw(trick, wait=8, ends=ends)[0] in (0, 400, 403, 404, 413, 414, 431)


KINDS = [
    path_tricks,
    writing_outside,
    no_cookie,
    other_origin,
    other_site,
    other_host,
    wrong_token,
    no_header,
    odd_method,
    bad_json,
    too_large,
    endless_head,
]


def stop_in_the_middle(studio):
    """Clients that begin and go silent, and many at once: others are still answered."""
    silent = []
    for i in range(200):
        connection = socket.create_connection(('127.0.0.1', studio.port), timeout=90)
        if i % 2:
            connection.sendall(
                f'POST /api/run HTTP/1.1\r\nHost: 127.0.0.1:{studio.port}\r\nContent-Le'.encode()
            )
        silent.append(connection)
    begin = time.monotonic()
    answered = studio.alive()
    seconds = time.monotonic() - begin
    for connection in silent:
        connection.close()
    return answered and seconds < 30


def sent_as_it_is(studio):
    """The page's program takes seconds to compress, and the loopback needs none of it."""
    for path in ['/', '/studio.js', '/api/project']:
        status, head, body = studio.ask('GET', path, Accept_Encoding='gzip, deflate, br')
        if status != 200 or not body or 'content-encoding' in head.lower():
            return False
    return True


def make_project(folder):
    (folder / 'photos/rest').mkdir(parents=True)
    (folder / 'photos/wave').mkdir()
    (folder / 'photos/few').mkdir()
    (folder / 'photos/rest/a.jpg').write_bytes(b'no photograph')
    (folder / 'out').mkdir()
    (folder / 'out/a.txt').write_text('a result')
    (folder / 'out/link').symlink_to(folder.parent)
    (folder / 'pipeline.yaml').write_text(
        'name: "<img src=x onerror=alert(1)>"\nposes:\n  rest: photos/rest\n  wave: '
        'photos/wave\n  few: {photos: photos/few, method: fit}\ntemplate: rest\ntimeline: [rest, wave]\n'
    )
    (folder.parent / 'secret.txt').write_text('TOP SECRET')


def main():
    wrong = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary) / 'project'
        make_project(folder)
        before = contents(folder.parent)
        studio = Studio(sys.argv[1], folder)
        try:
            if not sent_as_it_is(studio):
                wrong.append('what is sent over the loopback is compressed')
            pick = random.Random(1)
            for i in range(COUNT):
                kind = KINDS[i % len(KINDS)]
                if not kind(studio, pick):
                    wrong.append(f'request {i}: {kind.__name__}')
                if i % 100 == 99 and not studio.alive():
                    wrong.append(f'after request {i} the studio does not answer')
            if not stop_in_the_middle(studio):
                wrong.append('200 silent connections kept the studio from answering')
            if contents(folder.parent) != before:
                wrong.append('files were changed')
            if not studio.alive():
                wrong.append('the studio does not answer at the end')
        finally:
            studio.program.terminate()
            code = studio.program.wait(20)
        if code != 0:
            wrong.append(f'the studio ended with exit code {code}')
    print(
        '\n'.join(wrong)
        or f'{COUNT} hostile requests of {len(KINDS)} kinds and 200 silent connections: '
        'nothing changed, all refused'
    )
    return 1 if wrong else 0


if __name__ == '__main__':
    sys.exit(main())
