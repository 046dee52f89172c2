#!/usr/bin/env python3
"""Who comes in, and how again: addresses that let one browser in once, Enter at the terminal, a page that asks, a second start; and
a run that goes on when the studio has ended, which the next studio sees.

    addresses_test.py BIN_DIR

Needs only Python.
"""
import http.client
import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import tempfile
import time

PATIENCE = 120  # seconds, on a busy machine


class Studio:
    """At a terminal of its own."""

    def __init__(self, bin_dir, place, *words):
        self.terminal, inner = pty.openpty()
        self.program = subprocess.Popen(
            [str(pathlib.Path(bin_dir).resolve() / 'keypose'), 'studio', '--no-browser', *words],
            stdin=inner, stdout=inner, cwd=place,
            env={**os.environ, 'HOME': str(place.parent), 'KEYPOSE_HOME': str(place.parent / 'state')})
        os.close(inner)
        self.said = ''

    def hears(self, pattern):
        """What the studio says next that looks so."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if found := re.search(pattern, self.said):
                self.said = self.said[found.end():]
                return found
            try:
                self.said += os.read(self.terminal, 4096).decode()
            except OSError:  # its program has ended
                time.sleep(0.05)
        raise AssertionError(f'the studio does not say {pattern}: {self.said}')

    def address(self):
        found = self.hears(r'http://127\.0\.0\.1:(\d+)(/enter\?token=[0-9a-f]{32})\s')
        self.port = int(found[1])
        return found[2]

    def ask(self, method, path, cookie='', body=None, **headers):
        connection = http.client.HTTPConnection('127.0.0.1', self.port, timeout=PATIENCE)
        connection.request(method, path, body, {'Cookie': cookie, 'X-Keypose': '1', **headers})
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, text, (answer.getheader('Set-Cookie') or '').split(';')[0]

    def ends(self):
        self.program.send_signal(signal.SIGTERM)
        code = self.program.wait(PATIENCE)
        assert code == 0, code


def check_addresses(bin_dir, root):
    place = root / 'here'
    place.mkdir()
    (place / 'a.txt').write_text('it is not empty')
    studio = Studio(bin_dir, place, '--port', '0')
    first = studio.address()
    assert studio.port > 0
    status, _, cookie = studio.ask('GET', first)
    assert status == 302 and cookie.startswith(f'keypose_{studio.port}=')
    # A browser that is in comes in again by the same address; another does not.
    assert studio.ask('GET', first, cookie)[0] == 302
    status, page, _ = studio.ask('GET', first, Accept='text/html')
    assert status == 403 and '/enter?again=1' in page, page
    os.write(studio.terminal, b'\n')
    second = studio.address()
    assert second != first
    status, _, other = studio.ask('GET', second)
    assert status == 302 and other == cookie
    # Asked for by the page that keeps a browser out; not by a link of another site.
    assert studio.ask('GET', '/enter?again=1', **{'Sec-Fetch-Site': 'cross-site'})[0] == 403
    assert studio.ask('GET', '/enter?again=1')[0] == 403
    third = studio.address()
    assert studio.ask('GET', second)[0] == 403 and studio.ask('GET', third)[0] == 302
    # From the page of a browser that is in.
    status, text, _ = studio.ask('POST', '/api/door/address', cookie, '{}')
    fourth = json.loads(text)['address']
    assert status == 200 and studio.ask('GET', fourth[fourth.index('/enter'):])[0] == 302
    assert studio.ask('POST', '/api/door/address', '', '{}')[0] == 403
    # Who starts it once more, without a project, comes to this one.
    again = Studio(bin_dir, place)
    fifth, again_port = again.address(), again.port
    assert again.program.wait(PATIENCE) == 0 and again_port == studio.port
    assert studio.ask('GET', fifth)[0] == 302
    # No project is open, and the page says so.
    assert json.loads(studio.ask('GET', '/api/door', cookie)[1])['open'] == ''
    assert studio.ask('GET', '/api/project', cookie)[0] == 404
    studio.ends()
    # The session outlives the studio.
    studio = Studio(bin_dir, place, '--port', str(studio.port))
    studio.address()
    assert studio.ask('GET', '/api/door', cookie)[0] == 200
    assert studio.ask('POST', '/api/door/end', cookie, '{}')[0] == 200
    assert studio.program.wait(PATIENCE) == 0


def slow_project(folder):
    """One step, which takes as long as a file is not there."""
    (folder / 'tools').mkdir(parents=True)
    (folder / 'photos/rest').mkdir(parents=True)
    about = {'schema': 1, 'stage': 'wait', 'version': '1', 'summary': 'for this test', 'title': 'Waits', 'inputs': [],
             'outputs': [{'name': 'made', 'kind': 'file', 'file': 'made.txt'}], 'options': []}
    (folder / 'tools/wait.json').write_text(json.dumps(about))
    program = folder / 'tools/wait'
    program.write_text(f'''#!/bin/sh
if [ "$1" = --describe ]; then cat "{folder}/tools/wait.json"; exit; fi
while [ ! -e "{folder}/go" ]; do sleep 0.1; done
while [ $# -gt 1 ]; do [ "$1" = --made ] && echo made > "$2"; shift; done
''')
    program.chmod(0o755)
    off = 'capture sfm masks dense mesh refine cleanup unwrap bake complete register interpolate export report'.split()
    steps = ''.join(f'  {name}: {{enabled: false}}\n' for name in off)
    (folder / 'pipeline.yaml').write_text(f'poses: {{rest: photos/rest}}\nsteps:\n{steps}'
                                          '  wait: {program: tools/wait, for: project, out: {made: made.txt}}\n')


def check_run_goes_on(bin_dir, root):
    folder = root / 'slow'
    slow_project(folder)
    studio = Studio(bin_dir, folder)
    _, _, cookie = studio.ask('GET', studio.address())
    status, text, _ = studio.ask('POST', '/api/run', cookie, '{}')
    assert status == 200, text
    studio.ends()
    studio.hears('the run goes on; to see or stop it: keypose studio -C ')
    studio = Studio(bin_dir, folder)
    _, _, cookie = studio.ask('GET', studio.address())
    assert studio.ask('GET', '/api/project', cookie)[0] == 200
    assert json.loads(studio.ask('GET', '/api/steps', cookie)[1])['running'], 'the next studio does not see the run'
    assert json.loads(studio.ask('GET', f'/api/door/card?folder={folder}', cookie)[1])['state'] == 'running'
    (folder / 'go').write_text('')
    end = time.monotonic() + PATIENCE
    while json.loads(studio.ask('GET', '/api/steps', cookie)[1])['running'] and time.monotonic() < end:
        time.sleep(0.1)
    assert (folder / 'out/made.txt').read_text() == 'made\n'
    assert json.loads(studio.ask('GET', f'/api/door/card?folder={folder}', cookie)[1])['state'] == 'done'
    studio.ends()


def main():
    with tempfile.TemporaryDirectory() as temporary:
        root = pathlib.Path(temporary).resolve()
        check_addresses(sys.argv[1], root)
        check_run_goes_on(sys.argv[1], root)
    print('addresses let one browser in, once; a run goes on without its studio')


if __name__ == '__main__':
    main()
