"""The page of sensitivity.py: docs/results/sensitivity.md from a file of results."""
import json
import re
import textwrap

NO_CHANGE = 5e-4  # relative; less is shown as none
KINDS = ('half', 'double')
ROW = re.compile(r'^\| `([^`]+)` \| `([^`]+)`' + 4 * r' \| ([^|]+)' + r' \|$',
                 re.MULTILINE)
SCENE = re.compile(r'^\| (\w+)\*? \| ([-+.e0-9]+) \| (.+) \|$', re.MULTILINE)

TEXT = '''# Sensitivity to tuned constants

Constants of `core/values/tuned.h`, halved and doubled:

    cmake --preset release -B build/sensitive -DKEYPOSE_SENSITIVITY=ON
    cmake --build build/sensitive --target programs score_views
    bench/sensitivity.py run --results FILE.jsonl --work DIR --budget 60  # goes on where it ended
    bench/sensitivity.py write FILE.jsonl

{counts}

Figures are errors (`+`: worse; `-`: below 0.05 %) of one set each; scatter is not measured. What a constant means stands beside it in its source.{slow}

| figure | as it is | what |
|---|---|---|
{scenes}

## Over 5 %

{large}

## Up to 5 %

{small}

## Not measured

All that stand in no row.{unread}
'''


def read_results(path):
    """The rows of a file of results; a last line that was cut off is left out."""
    rows = []
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            rows.append(json.loads(line))
        except json.JSONDecodeError:
            continue
    return rows


def measured(constant, rows):
    """(scene, row of half, row of double) of the last build, for the present value; or None."""
    found = {}
    for row in rows:
        if row.get('id') == constant['id'] and row['value'] == constant['value']:
            found[(row['scene'], row['build'], row['kind'])] = row
    for scene, build, _ in reversed(found):
        pair = [found.get((scene, build, kind)) for kind in KINDS]
        if all(pair):
            return scene, *pair
    return None


def base_of(row, rows):
    """The scene's row with all constants as they are, of the same build."""
    return [r for r in rows if r['kind'] == 'scene' and r['scene'] == row['scene']
            and r['build'] == row['build']][-1]


def change_text(row, base):
    if 'over_s' in row:
        return f"over {row['over_s']} s"
    if 'refused' in row:
        return 'refused'
    relative = row['error'] / base['error'] - 1
    return '-' if abs(relative) < NO_CHANGE else f'{100 * relative:+.1f} %'


def table_rows(known, rows, old_page):
    """(constant, figure, half, double) of all that were measured; with an asterisk: of old_page."""
    old = {f'{file}:{name}': (value, figure.rstrip('*'), half, double)
           for file, name, value, figure, half, double in ROW.findall(old_page)}
    found = []
    for constant in known:
        now = measured(constant, rows)
        if now:
            scene, *pair = now
            base = base_of(pair[0], rows)
            found.append((constant, scene, *(change_text(row, base) for row in pair)))
        elif old.get(constant['id'], ('',))[0] == f"{constant['value']:g}":
            _, figure, half, double = old[constant['id']]
            found.append((constant, figure + '*', half, double))
    return found


def scenes_of(rows):
    """The last row of each scene that gave a figure."""
    return {row['scene']: row for row in rows if row['kind'] == 'scene' and 'error' in row}


def unread(known, rows, shown, scenes):
    """Ids of the constants that no scene reads, although all scenes of their room ran."""
    ran = scenes_of(rows)
    read = {name for row in ran.values() for name in row['read']}
    found = []
    for constant in known:
        own = [scene for scene in scenes if constant['file'].startswith(tuple(scene.rooms))]
        if own and all(scene.name in ran for scene in own):
            found += {constant['id']} - read - shown
    return found


def left(known, rows, scenes):
    """Ids of the constants without a measurement, and not known to be unread."""
    shown = {c['id'] for c in known if measured(c, rows)}
    aside = shown | set(unread(known, rows, shown, scenes))
    return [c['id'] for c in known if c['id'] not in aside]


def summary(known, rows, scenes):
    shown = {c['id'] for c in known if measured(c, rows)}
    aside = unread(known, rows, shown, scenes)
    return (f'{len(shown)} of {len(known)} constants are measured, {len(aside)} are read by no '
            f'scene of their room, {len(left(known, rows, scenes))} are left')


def table(rows):
    lines = [f"| `{c['file']}` | `{c['name']}` | {c['value']:g} | {figure} | {half} | {double} |"
             for c, figure, half, double in rows]
    return '\n'.join(['| algorithm | constant | value | figure | half | double |', '|---' * 6 + '|'] + lines)


def unread_text(ids):
    names = ', '.join(f'`{constant}`' for constant in sorted(ids))
    return f' Read by no scene of their room: {names}.' if ids else ''


def largest(cells):
    """The largest change that a row shows, in percent."""
    return max(abs(float(cell[:-2])) if cell.endswith('%') else 0 if cell == '-' else 100
               for cell in cells)


def counts_text(known, shown, aside, rest):
    kept = sum(row[1].endswith('*') for row in shown)
    moved = sum(largest(row[2:]) > 5 for row in shown)
    still = sum(row[2:] == ('-', '-') for row in shown)
    earlier = f', {kept} (*) by an earlier version' if kept else ''
    text = (f'{len(shown)} of {len(known)} are measured{earlier}: {moved} move their figure by '
            f'over 5 % or end the stage, {still} not at all. {len(aside)} are read by no scene, '
            f'{len(rest)} are left.')
    return textwrap.fill(text, 100)


def page(known, rows, old_page, scenes):
    shown = table_rows(known, rows, old_page)
    names = {row[0]['id'] for row in shown}
    aside = unread(known, rows, names, scenes)
    rest = [c['id'] for c in known if c['id'] not in names | set(aside)]
    kept = {row[1].rstrip('*') for row in shown if row[1].endswith('*')}
    scenes = [f"| {name} | {row['error']:.4g} | {row['what']} |"
              for name, row in scenes_of(rows).items()]
    scenes += [f'| {name}* | {error} | {what} |' for name, error, what in SCENE.findall(old_page)
               if name in kept and f'| {name}* |' not in '\n'.join(scenes)]
    ordered = sorted(shown, key=lambda r: (r[1], r[0]['file']))
    slow = any(cell.startswith('over ') for row in shown for cell in row[2:])
    return TEXT.format(
        counts=counts_text(known, shown, aside, rest), scenes='\n'.join(scenes),
        slow=' `over N s`: ended after so much CPU time.' if slow else '',
        large=table([row for row in ordered if largest(row[2:]) > 5]),
        small=table([row for row in ordered if largest(row[2:]) <= 5]),
        unread=unread_text(aside))
