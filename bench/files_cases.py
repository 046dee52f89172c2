"""What a case of files_table.py is, and how it is run."""
import re
import shutil
import subprocess
import time

CASES = []  # (kind, read by, name, wanted, words, function)


class Skip(Exception):
    pass


class Outcome:
    """What a command did, and numbers (label, value, bound) that tell whether that is right."""

    def __init__(self, code, text, numbers=()):
        self.code, self.text, self.numbers = code, text, list(numbers)

    def says(self, words):
        """Whether the command names the feature: in its refusal, or in a line `stage: ...` (a warning, a note). Paths and names of files by their format say nothing."""
        if not words or not (self.code == 0 or 2 <= self.code <= 6):
            return False
        text = re.sub(r'\S*/\S+|\b\w+\.(fbx|x3d|blend|dae|3ds)\b', '', self.text)
        if self.code == 0:
            text = '\n'.join(line for line in text.splitlines() if re.match(r'[\w-]+: ', line))
        return bool(re.search(words, text, re.I))

    def judged(self, words, wanted):
        said = self.says(words)
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


def run_case(b, kind, by, name, wanted, words, function):
    """A row of the table. A case that stops in any way but by Skip ended badly."""
    row = {'kind': kind, 'by': by, 'name': name, 'wanted': wanted, 'got': 'skipped', 'numbers': [], 'said': ''}
    began = time.time()
    try:
        outcome = function(b)
        row.update(got=outcome.judged(words, wanted), numbers=[(label, float(value), bound) for label, value, bound in outcome.numbers], code=outcome.code, said=outcome.text.strip()[-600:])
    except Skip as why:
        row['said'] = str(why)
    except Exception as why:  # a command that does not end, or output that is not what the case reads
        row.update(got='badly', said=repr(why))
    row['seconds'] = round(time.time() - began, 1)
    return row


def tool(*words, data=None, cwd=None):
    if not shutil.which(str(words[0])):
        raise Skip(f'{words[0]} is not installed')
    done = subprocess.run(list(map(str, words)), input=data, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=cwd, timeout=300)
    if done.returncode != 0:
        raise Skip(f'{words[0]} failed: {done.stdout.decode(errors="replace")[-300:]}')
    return done.stdout.decode(errors='replace')
