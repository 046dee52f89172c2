#!/usr/bin/env python3
"""Counts the house: functions, types, tokens, words, files a folder, tests beside their units. One column a folder.

    house_table.py FOLDER [FOLDER ...]     e.g. an older checkout beside this one; prints a Markdown table

Counted are sources (.h .cpp .inc) outside of build folders and node_modules. A function is a block in braces at the level of
a namespace or class whose head has parentheses. A unit is a .cpp file that is no test, benchmark, program or help of tests.
Prose is counted by tests/prose_words.py of this checkout. Needs only Python.
"""
import collections
import pathlib
import re
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / 'tests'))
import prose_words  # noqa: E402

LEFT_OUT = {'node_modules', 'build', '.git'}
STAGES = [(stage, [room]) for stage, room in (
    ('sfm', 'reconstruct'), ('dense', 'reconstruct'), ('refine', 'reconstruct'), ('cleanup', 'cleanup'), ('unwrap', 'texture'),
    ('track', 'fit'), ('silhouettes', 'capture'), ('video3d', 'motion'))]
SOURCE = {'.h', '.cpp', '.inc'}
TOKEN = re.compile(r'[A-Za-z_]\w*|\d[\w.]*|::|->|<<|>>|[-+*/%&|^!=<>]=|&&|\|\||\+\+|--|[^\s\w]')
NOT_A_FUNCTION = re.compile(r'\b(namespace|class|struct|union|enum|extern)\b[^()]*$|=\s*$|\b(if|for|while|switch|catch)\s*\(')
TYPE = re.compile(r'\b(?:class|struct|enum class|enum|union)\s+[A-Z]\w*(?:\s+final)?(?:\s*:[^;{()]*)?\s*\{')
COMMA = re.compile(r'^[ \t]*(?!(?:for|const|auto|int|double|float|bool|char|case|return|using|template|static|std::|if)\b)'
                   r'[\w.\[\]>*()-]+(?:\+\+|--|\s*[-+*/]?=[^=;{}(]*),\s*[\w.\[\]>*()-]+\s*[-+*/]?=[^=;{}]*;\s*$', re.MULTILINE)
TERNARY = re.compile(r'\?[^;?{}]*:[^;?{}]*\?[^;{}]*:')


def without_comments(text):
    text = re.sub(r'R"(\w*)\((.*?)\)\1"', '""', text, flags=re.DOTALL)
    text = re.sub(r'"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|//[^\n]*|/\*.*?\*/',
                  lambda m: '""' if m[0][0] == '"' else '0' if m[0][0] == "'" else '\n' * m[0].count('\n'), text, flags=re.DOTALL)
    return re.sub(r'^[ \t]*#[^\n]*', '', text, flags=re.MULTILINE)


def function_lengths(text):
    """Lines of each function, from its head to its closing brace."""
    lengths, stack, head = [], [], 0  # stack: (whether a function, line of its head)
    for match in re.finditer(r'[{};]', text):
        if match[0] == '{':
            told = text[head:match.start()].strip()
            inside = any(is_function for is_function, _ in stack)
            is_function = not inside and '(' in told and not NOT_A_FUNCTION.search(told)
            stack.append((is_function, text.count('\n', 0, match.start() - len(told.lstrip()))))
            if is_function:
                stack[-1] = (True, text.count('\n', 0, head + len(text[head:match.start()]) - len(text[head:match.start()].lstrip())))
        elif match[0] == '}' and stack:
            is_function, first = stack.pop()
            if is_function:
                lengths.append(text.count('\n', 0, match.start()) - first + 1)
        head = match.end()
    return lengths


def sources_of(root):
    found = []
    for path in sorted(root.rglob('*')):
        parts = path.relative_to(root).parts
        if path.suffix in SOURCE and not LEFT_OUT.intersection(parts) and not parts[0].startswith('build'):
            found.append(path.relative_to(root))
    return found


def is_unit(path):
    name, folders = path.name, path.parts
    aside = name.endswith(('_test.cpp', '_bench.cpp', '_stage.cpp', '_main.cpp')) or name == 'main.cpp'
    return path.suffix == '.cpp' and not aside and 'testing' not in folders and folders[0] not in ('tests', 'bench')


def prose_of(root):
    total = 0
    for page in sorted((root / 'docs').rglob('*.md')) + [root / 'README.md']:
        total += prose_words.prose_of(page.read_text(encoding='utf-8'))
    return total


def naming(root, texts, stage, rooms):
    """Files of the product that name a stage and are not of its room."""
    quoted = re.compile(f'(["\'`]){stage}\\1|\\b{stage}: \'')
    web = [path.relative_to(root) for path in (root / 'studio/web/src').rglob('*.ts*')]
    told = dict(texts) | {path: (root / path).read_text(encoding='utf-8') for path in web}
    aside = ('tests', 'bench', *rooms)
    return [path for path, text in told.items() if path.parts[0] not in aside and 'testing' not in path.parts
            and not path.name.endswith(('_test.cpp', '.test.ts')) and quoted.search(text)]


def count(root):
    root = pathlib.Path(root)
    files = sources_of(root)
    texts = {path: (root / path).read_text(encoding='utf-8') for path in files}
    bare = {path: without_comments(text) for path, text in texts.items()}
    product = [path for path in files if not path.name.endswith(('_test.cpp', '_bench.cpp')) and path.parts[0] not in ('tests', 'bench')
               and 'testing' not in path.parts]
    lengths = sorted(length for path in product for length in function_lengths(bare[path]))
    lines = sum(texts[path].count('\n') for path in product)
    folders = collections.Counter(str(path.parent) for path in files)
    units = [path for path in files if is_unit(path)]
    beside = [path for path in units if path.with_name(path.stem + '_test.cpp') in texts]
    headers = collections.Counter(path.name for path in files if path.suffix == '.h')
    largest = max(folders, key=folders.get)
    tokens = sum(len(TOKEN.findall(bare[path])) for path in product)
    return {
        'sources, lines of them': f'{len(files)}, {sum(text.count(chr(10)) for text in texts.values()):,}',
        'lines of the product': f'{lines:,}',
        'functions: median / 90 % / longest lines': f'{statistics.median(lengths):.0f} / {lengths[len(lengths) * 9 // 10]} / {lengths[-1]}',
        'types a 10,000 lines': f'{1e4 * sum(len(TYPE.findall(bare[path])) for path in product) / lines:.0f}',
        'tokens, a line': f'{tokens:,}, {tokens / lines:.1f}',
        'statements joined by commas': f'{sum(len(COMMA.findall(bare[path])) for path in product)}',
        'nested ternaries': f'{sum(len(TERNARY.findall(bare[path])) for path in product)}',
        'files a folder: median / most': f'{statistics.median(folders.values()):.0f} / {folders[largest]} ({largest})',
        'units with a test beside them': f'{100 * len(beside) / len(units):.0f} % of {len(units)}',
        'files that name a stage of another room (mean of 8 stages)': f"{statistics.mean(len(naming(root, texts, *of)) for of in STAGES):.1f}",
        'header names that occur twice': f'{sum(n > 1 for n in headers.values())}',
        'words of prose in docs and README': f'{prose_of(root):,}',
        'words of README': f"{len((root / 'README.md').read_text(encoding='utf-8').split()):,}",
        'pages of decisions': f"{len(list((root / 'docs/decisions').glob('*.md')))}",
    }


def main(roots):
    if not roots:
        print(__doc__, file=sys.stderr)
        return 2
    columns = [count(root) for root in roots]
    print('| what | ' + ' | '.join(pathlib.Path(root).resolve().name for root in roots) + ' |')
    print('|---' * (len(roots) + 1) + '|')
    for what in columns[0]:
        print(f'| {what} | ' + ' | '.join(column[what] for column in columns) + ' |')
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
