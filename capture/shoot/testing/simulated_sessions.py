"""Simulated sessions of `keypose shoot` on a project named fox, for sessions_test.py.

Takes the folder of the programs, and how many angles a ring has, off the command line's arguments.
"""
import json
import os
import queue
import subprocess
import sys
import tempfile
import threading
import time

BIN = os.path.abspath(sys.argv.pop(1))
POSES = ["rest", "bent", "wave"]
ANGLES = int(sys.argv.pop(1))
# Exit codes of docs/shoot.md.
USAGE, INPUT, TOOL, LOCKED, INTERRUPTED = 2, 3, 5, 7, 130
# Says how the table stands: after `again` not where a ring ends.
STAND = ".keypose/shoot/stand.json"
SCRATCH = tempfile.TemporaryDirectory(prefix="keypose_shoot_")
DRAWN = os.path.join(SCRATCH.name, "drawn")


def setUpModule():
    subprocess.run(
        [
            f"{BIN}/keypose-synth",
            "photos",
            "--output",
            DRAWN,
            "--poses",
            ",".join(POSES),
            "--views",
            str(ANGLES),
            "--elevations",
            "12",
            "--width",
            "160",
            "--spacing",
            "0.01",
        ],
        check=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )


def tearDownModule():
    for process in Conversation.all:  # those of tests that failed
        process.kill()
        process.wait()
    SCRATCH.cleanup()


def shoot_command(project, pose, *flags, turntable="simulated"):
    # The set stands beside the project: its table keeps its angle when the program is killed.
    return [
        f"{BIN}/keypose-shoot",
        "-C",
        project,
        "--pose",
        pose,
        "--camera",
        f"simulated:{DRAWN}",
        "--turntable",
        turntable,
        "--rings",
        "12",
        "--angles",
        str(ANGLES),
        "--world",
        project + "_set",
        *flags,
    ]


def shoot(project, pose, *flags, expect=0, **more):
    done = subprocess.run(
        shoot_command(project, pose, *flags, **more),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == expect, (done.returncode, done.stdout, done.stderr)
    return done.stdout + done.stderr


def contents(project):
    """Every file of the project, hidden ones too."""
    files = {}
    for folder, _, names in os.walk(project):
        for name in names:
            path = os.path.join(folder, name)
            with open(path, "rb") as file:
                files[os.path.relpath(path, project)] = file.read()
    return files


class Folder:
    """A project named fox, so that projects differ by nothing but what was shot."""

    def __init__(self, name):
        self.path = os.path.join(SCRATCH.name, name, "fox")
        os.makedirs(self.path)


class Undisturbed:
    """One project for each turntable, whose content is kept after each pose."""

    projects = {}

    @classmethod
    def of(cls, poses, turntable="simulated"):
        """@param poses  the first ones of POSES"""
        assert poses == POSES[: len(poses)]
        if turntable not in cls.projects:
            cls.projects[turntable] = (Folder(f"undisturbed_{len(cls.projects)}").path, [])
        project, after = cls.projects[turntable]
        for pose in POSES[len(after) : len(poses)]:
            shoot(project, pose, turntable=turntable)
            after.append(contents(project))
        return after[len(poses) - 1]


class Conversation:
    """`keypose shoot --commands` as a program drives it."""

    all = []

    def __init__(self, project, pose, *flags, **more):
        self.process = subprocess.Popen(
            shoot_command(project, pose, "--commands", *flags, **more),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.events, self.lines = [], queue.Queue()
        threading.Thread(target=self.read, daemon=True).start()
        Conversation.all.append(self.process)

    def read(self):
        for line in self.process.stdout:
            self.lines.put(json.loads(line))
        self.lines.put(None)

    def say(self, command, **fields):
        self.process.stdin.write(json.dumps({"command": command, **fields}) + "\n")
        self.process.stdin.flush()

    def until(self, event, **fields):
        """The next event of this kind with these fields. What is asked for meanwhile is done."""
        deadline = time.time() + 30
        while True:
            assert time.time() < deadline, f"no {event} {fields}: {self.events[-3:]}"
            got = self.lines.get(timeout=30)
            assert got is not None, f"ended before {event} {fields}: {self.events[-3:]}"
            self.events.append(got)
            if got["event"] == event and all(got.get(k) == v for k, v in fields.items()):
                return got
            if got["event"] == "ask":
                self.say("done")

    def end(self):
        self.say("end")
        ended = self.until("ended")
        self.process.stdin.close()
        assert self.process.wait(timeout=30) == 0
        self.process.stdout.close()
        return ended


def angle(index):
    """Of the photograph with that number in the ring, from 0 on [deg]."""
    return index * 360 // ANGLES


def photograph(index):
    return f"r1_a{angle(index):03}"


def landed(project, pose):
    """Inode of each photograph that has its final name: shooting it again would change it."""
    folder = os.path.join(project, "photos", pose)
    if not os.path.isdir(folder):
        return {}
    return {
        name: os.stat(os.path.join(folder, name)).st_ino
        for name in os.listdir(folder)
        if name.startswith("r")
    }


def wait_for_photographs(project, pose, count):
    until = time.time() + 60
    while len(landed(project, pose)) < count:
        assert time.time() < until, "no photographs"
        time.sleep(0.002)
