// Two runs beside each other: a pose in 3D, its picture and a film before and after a change, by
// slider and as differences; what was said of a result stays, until that is another one.
//
//   node review_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync, spawnSync } from 'node:child_process';
import { chmodSync, copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng } from './png.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('review', 'hero');
let page;

const kCorners = [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1], [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]];
const kFaces = [[0, 3, 2], [0, 2, 1], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]];
const cubeObj = [
  ...kCorners.map((corner) => `v ${corner.join(' ')}`),
  'vt 0.5 0.5',
  ...kFaces.map((face) => `f ${face.map((i) => `${i + 1}/1`).join(' ')}`),
].join('\n');
const cubePly = (size) => [
  'ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z',
  'element face 12\nproperty list uchar int vertex_indices\nend_header',
  ...kCorners.map((corner) => corner.map((value) => value * size).join(' ')),
  ...kFaces.map((face) => `3 ${face.join(' ')}`),
].join('\n') + '\n';

/** Of one colour each: what is seen of them is known. */
const kBefore = [100, 120, 140];
const kAfter = [110, 120, 140];

/** A stage as a shell script, with its options and ports as variables. */
function addStage(name, about, act) {
  const program = `#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
if [ "$1" = --describe ]; then cat "$here/${name}.json"; exit; fi
while [ $# -gt 1 ]; do eval "$(echo "$1" | cut -c3-)=\\$2"; shift 2; done
${act}`;
  mkdirSync(join(folder, 'tools'), { recursive: true });
  writeFileSync(join(folder, `tools/${name}`), program);
  chmodSync(join(folder, `tools/${name}`), 0o755);
  const all = { schema: 1, stage: name, version: '1', summary: 'for this test', ...about };
  writeFileSync(join(folder, `tools/${name}.json`), JSON.stringify(all));
}

function addStages() {
  addStage(
    'unwrap',
    {
      title: 'Texture layout',
      measurements: [{ key: 'size', label: 'how large', unit: 'm', good: { max: 1.05 } }],
      inputs: [{ name: 'clean', kind: 'file' }],
      outputs: [{ name: 'unwrapped', kind: 'file', file: 'unwrapped.obj' }],
      options: [{ name: 'size', type: 'double', default: 1 }],
    },
    `awk -v s="$size" '$1 == "v" { print "v", $2 * s, $3 * s, $4 * s; next } { print }' "$clean" > "$unwrapped"
echo "{\\"schema\\": 1, \\"measurements\\": {\\"size\\": $size}}" > "$report"`,
  );
  const chosen = { name: 'choice', type: 'string', default: 'before' };
  addStage(
    'bake',
    {
      title: 'Texture',
      inputs: [
        { name: 'mesh', kind: 'file' },
        { name: 'images', kind: 'folder', optional: true },
        { name: 'model', kind: 'folder', optional: true },
      ],
      outputs: [{ name: 'texture', kind: 'file', file: 'texture.png' }],
      options: [chosen],
    },
    'cp "$here/$choice.png" "$texture"',
  );
  addStage(
    'film',
    {
      title: 'Film',
      inputs: [{ name: 'mesh', kind: 'file' }],
      outputs: [{ name: 'animation', kind: 'folder', file: 'animation' }],
      options: [chosen],
    },
    'mkdir "$animation"; cp "$here/$choice.mp4" "$animation/character.mp4"',
  );
  writeFileSync(join(folder, 'tools/before.png'), plainPng(64, kBefore));
  writeFileSync(join(folder, 'tools/after.png'), plainPng(64, kAfter));
}

/** Two real films, of one export: as it moves, and turned. */
function addFilms() {
  const frames = join(scratch, 'frames');
  mkdirSync(frames);
  for (let i = 0; i < 6; ++i)
    writeFileSync(join(frames, `frame_000${i}.ply`), cubePly(0.1 + 0.01 * i));
  const made = join(scratch, 'films');
  const words = ['--frames', frames, '--animation', made, '--formats', 'video', '--fps', '12',
    '--video_width', '320', '--video_height', '240'];
  execFileSync(join(bin, 'keypose-export'), words, { stdio: 'ignore' });
  copyFileSync(join(made, 'character.mp4'), join(folder, 'tools/before.mp4'));
  copyFileSync(join(made, 'character_turntable.mp4'), join(folder, 'tools/after.mp4'));
}

const kOff = 'capture sfm masks dense mesh refine cleanup register fit complete interpolate export report';
function runWith(more) {
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    `fps: 12
poses: {rest: photos/rest}
steps:
${kOff.split(' ').map((step) => `  ${step}: {enabled: false}`).join('\n')}
  unwrap: {program: tools/unwrap, inputs: {clean: ./cube.obj}}
  bake:
    program: tools/bake
    inputs: {mesh: unwrap.unwrapped, images: null, model: null}
    out: {texture: "{pose}/swatch.png"}
  film:
    program: tools/film
    for: project
    inputs: {mesh: unwrap.unwrapped@template}
    out: {animation: animation}
${more}`,
  );
  const { status, stderr } = spawnSync(join(bin, 'keypose'), ['run', '-C', folder], {
    encoding: 'utf8',
  });
  check(status === 0, stderr);
}

const button = (name) => page.getByRole('button', { name, exact: true });
const before = () => page.getByLabel('Before', { exact: true });
const mode = (name) => page.getByRole('group', { name: 'How both are shown' }).getByRole('button', { name });
const sight = () => page.getByLabel('What to look at', { exact: true }).and(page.locator('select'));

/** The colour at a place of what is shown, as shares of its width and height. */
async function colourAt(x, y) {
  const box = await boxOf(page.locator('.rv-pair'));
  const clip = { x: Math.round(box.x + x * box.width), y: Math.round(box.y + y * box.height), width: 1, height: 1 };
  return readPng(await page.screenshot({ clip })).rgb[0];
}
const isNear = (one, other) => one.every((value, k) => Math.abs(value - other[k]) <= 2);
async function shows(x, y, colour) {
  let seen;
  await until(`${colour} at ${x}, ${y}`, async () => isNear((seen = await colourAt(x, y)), colour)).catch((error) => {
    throw new Error(`${error.message}; it is ${seen}`);
  });
}

async function oneResult() {
  mkdirSync(join(folder, 'photos/rest'), { recursive: true });
  writeFileSync(join(folder, 'cube.obj'), cubeObj);
  addStages();
  addFilms();
  runWith('');
  page = await openPage();
  await page.getByRole('link', { name: 'Review', exact: true }).click();
  await page.getByText('There is no other result yet.').waitFor();
  await shows(0.5, 0.5, kBefore);
}

async function besideEachOther() {
  runWith('options: {unwrap: {size: 1.1}, bake: {choice: after}, film: {choice: after}}\n');
  await until('the page has both', async () => (await before().locator('option').count()) === 2);
  await shows(0.25, 0.5, kBefore);
  await shows(0.75, 0.5, kAfter);
  const changed = page.getByRole('region', { name: 'What was changed' });
  await changed.getByText('option size: 1 → 1.1').waitFor();
  await changed.getByText('option choice: before → after').waitFor();
  const row = page.getByRole('row', { name: /how large/ });
  check(/1 m.*1.1 m.*worse/s.test(await row.textContent()), await row.textContent());
  await record(page, 'review', options.pictures);
}

async function bySlider() {
  await mode('Slider').click();
  await shows(0.45, 0.5, kBefore);
  await shows(0.55, 0.5, kAfter);
  const edge = page.getByRole('slider', { name: 'Share of the result before' });
  await edge.focus();
  await page.keyboard.press('Home');
  await shows(0.45, 0.5, kAfter);
  await page.keyboard.press('End');
  await shows(0.55, 0.5, kBefore);
  await record(page, 'review_slider', options.pictures);
}

async function asDifference() {
  await mode('Difference').click();
  await shows(0.5, 0.5, [40, 0, 0]);
  await shows(0.02, 0.5, [0, 0, 0]);
  await button('× 16').click();
  await shows(0.5, 0.5, [160, 0, 0]);
  await sight().selectOption('rest/swatch.png');
  await shows(0.5, 0.5, [160, 0, 0]);
  await button('× 1').click();
  await shows(0.5, 0.5, [10, 0, 0]);
  await record(page, 'review_difference', options.pictures);
  await sight().selectOption('3d');
  await button('Distance').click();
  // A corner is 0.1 outside in each direction, of a diagonal of 2 sqrt(3).
  await page.getByText('5.00 % and more').waitFor();
  await record(page, 'review_distance', options.pictures);
}

/** Both views follow one drag: the same picture of the same thing, but for its size. */
async function oneCamera() {
  await mode('Side by side').click();
  const views = page.locator('.rv-pair canvas');
  /** Where it begins below the top, in one column [px]. */
  const top = async (across, colour) => {
    const box = await boxOf(page.locator('.rv-pair'));
    const x = Math.round(box.x + across * box.width);
    const { rgb } = readPng(await page.screenshot({ clip: { x, y: box.y, width: 1, height: box.height } }));
    return rgb.findIndex((one) => isNear(one, colour));
  };
  const first = [await top(0.25, kBefore), await top(0.75, kAfter)];
  await views.first().focus();
  for (let i = 0; i < 3; ++i) await page.keyboard.press('+');
  await until('both come closer', async () => {
    const now = [await top(0.25, kBefore), await top(0.75, kAfter)];
    return now[0] < first[0] && now[1] < first[1] && now[1] < now[0];
  });
}

const times = () =>
  page.locator('video').evaluateAll((films) => films.map((film) => Math.floor(film.currentTime * 12)));

async function films() {
  await button('The film').click();
  await until('both films are there', () =>
    page.locator('video').evaluateAll((all) => all.length === 2 && all.every((film) => film.readyState >= 2)),
  );
  await button('A frame on').click();
  await button('A frame on').click();
  await until('both show frame 2', async () => (await times()).join() === '2,2');
  await page.keyboard.press(',');
  await until('both show frame 1', async () => (await times()).join() === '1,1');
  await record(page, 'review_film', options.pictures);
  await button('Play').click();
  await until('it plays', async () => (await times())[1] > 2);
  await button('Pause').click();
  await mode('Difference').click();
  await record(page, 'review_film_difference', options.pictures);
}

const listed = (name) => page.getByRole('complementary', { name: 'What to look at' }).getByRole('button', { name });

async function sentBackAndApproved() {
  await listed('rest').click();
  check(await button('Send back').isDisabled(), 'sent back without a word');
  await page.getByRole('textbox').fill('the left ear is too large');
  await button('Send back').click();
  await listed('rest sent back').waitFor();
  await button('Approve').click();
  await listed('rest approved').waitFor();
  const kept = JSON.parse(readFileSync(join(folder, 'reviews.json'), 'utf8')).reviews;
  check(kept.length === 2 && kept[0].note === 'the left ear is too large', JSON.stringify(kept));
  await page.reload();
  await page.getByText('the left ear is too large').waitFor();
  await record(page, 'review_said', options.pictures);
}

async function changedSince() {
  runWith('options: {unwrap: {size: 1.2}, bake: {choice: after}, film: {choice: after}}\n');
  await listed('rest changed since').waitFor();
  await page.getByText('Approved, of an earlier result').waitFor();
  check((await before().locator('option').count()) === 3, 'not three results');
  await record(page, 'review_changed', options.pictures);
  // Not while the page shows what goes.
  const address = page.url();
  await page.goto('about:blank');
  spawnSync(join(bin, 'keypose'), ['gc', '-C', folder, '--keep-runs', '1']);
  await page.goto(address);
  await until('what was cleaned away is said', async () =>
    /cleaned away/.test(await before().locator('option').last().textContent()),
  );
  await page.getByText('not there any more').first().waitFor();
}

await walkThrough({
  'one result': oneResult,
  'two, beside each other': besideEachOther,
  'by slider': bySlider,
  'as difference and distance': asDifference,
  'one camera': oneCamera,
  films,
  'sent back, approved': sentBackAndApproved,
  'changed since, cleaned away': changedSince,
});
