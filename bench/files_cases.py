"""What a case of files_table.py is, and how it is run."""
import re
import shutil
import subprocess

CASES = []  # (kind, read by, name, wanted, words, function)


class Skip(Exception):
    pass


class Outcome:
    """What a command did, and numbers (label, value, bound) that tell whether that is right."""

    def __init__(self, code, text, numbers=()):
        self.code, self.text, self.numbers = code, text, list(numbers)

    def judged(self, words, wanted):
        said = re.search(words, self.text, re.I) if words else None
        if said and wanted == 'named':
            return 'named'
        if self.code == 0 and self.numbers and all(value <= bound for _, value, bound in self.numbers):
            return 'right'
        if said:
            return 'named'
        return 'wrong' if self.code == 0 else 'badly'


def case(kind, by, name, words='', want='right'):
    def add(function):
        CASES.append((kind, by, name, want, words, function))
        return function
    return add


def cases(kind, by, table, function):
    """One case for each row (name, words, want, arguments...) of a table."""
    for name, words, want, *rest in table:
        CASES.append((kind, by, name, want, words, lambda b, rest=rest: function(b, *rest)))


class Bench:
    def __init__(self, bin_dir, reports, work):
        self.bin, self.reports, self.work, self.made = bin_dir, reports, work, {}
        self.count = 0

    def folder(self, name='case'):
        self.count += 1
        path = self.work / f'{self.count:03d}_{name}'
        path.mkdir(parents=True)
        return path

    def report(self, name):
        if not self.reports or not (self.reports / name).exists():
            raise Skip(f'reports/{name} is not here')
        return self.reports / name

    def keypose(self, *words, env=None):
        done = subprocess.run([str(self.bin / 'keypose'), *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, errors='replace', timeout=600, env=env)
        return done.returncode, done.stdout

    def once(self, function):
        """What a function makes, made once."""
        if function not in self.made:
            try:
                self.made[function] = function(self)
            except Skip as why:
                self.made[function] = why
        if isinstance(self.made[function], Skip):
            raise self.made[function]
        return self.made[function]


def tool(*words, data=None, cwd=None):
    if not shutil.which(str(words[0])):
        raise Skip(f'{words[0]} is not installed')
    done = subprocess.run(list(map(str, words)), input=data, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=cwd, timeout=300)
    if done.returncode != 0:
        raise Skip(f'{words[0]} failed: {done.stdout.decode(errors="replace")[-300:]}')
    return done.stdout.decode(errors='replace')
