// A filmed shot on the studio's page: a film is added with its mattes, frames get their poses, the
// set-up is changed and changed back, four clicks beside the textured mesh and the outlines that
// they give at once, undo, the camera, the finished pictures played, an editor's change, markup in a
// folder's name. The shot is generated, and so is what it is compared with.
//
//   node shot_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  cpSync,
  existsSync,
  mkdirSync,
  readFileSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { plainPng } from './png.mjs';
import { filmedProject } from './projects.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';
import { meshOf } from './walk_geometry.mjs';

const { bin, options, scratch, folder, browser, openPage, walkThrough } =
  withStudio('shot', 'dance');
const world = join(scratch, 'world');
const truth = join(world, 'truth/shot');
let page;
let mesh;

const kWidth = 480;
/** Film frame that shows the second pose; the truth has two meshes a filmed frame. */
const kWave = 2;
const kMarkup = '<img src=x onerror=alert(1)>';
const kComment = '# A dance, as it was filmed.';

const pipelineFile = join(folder, 'pipeline.yaml');
const clicksFile = join(folder, 'clicks.json');
const pipelineText = () => readFileSync(pipelineFile, 'utf8');
const clicks = () => JSON.parse(readFileSync(clicksFile, 'utf8')).clicks;
const button = (name) => page.getByRole('button', { name, exact: true });
const ask = async (path) =>
  (await page.request.get(new URL(path, page.url()).href)).json();
/** Labels will not do: that of a choice has the names of all folders in it. */
const part = (name) => page.locator(`select[aria-describedby="part-${name}"]`);
const frameSheet = () => page.locator('.frame-sheet');
const meshCanvas = () => page.locator('.shot-pose canvas');

async function prepare() {
  const words = ['shot', '--output', world, '--shows', `0=rest,${kWave}=wave,4=bow`];
  const more = ['--width', String(kWidth), '--no-photographs', '--meshes', '--clean-plate'];
  execFileSync(join(bin, 'keypose-synth'), [...words, ...more, '--spacing', '0.006'], {
    stdio: ['ignore', 'ignore', 'inherit'],
  });
  for (const part of ['meshes', 'photos/rest', 'photos/wave', `films/${kMarkup}`])
    mkdirSync(join(folder, part), { recursive: true });
  const copy = (from, to) => cpSync(from, join(folder, to), { recursive: true });
  copy(join(truth, 'meshes/frame_0000.ply'), 'meshes/rest.ply');
  copy(join(truth, `meshes/frame_000${2 * kWave}.ply`), 'meshes/wave.ply');
  copy(join(world, 'film'), 'films/take1');
  copy(join(world, 'film'), `films/${kMarkup}`);
  copy(join(truth, 'mattes'), 'films/mattes');
  copy(join(world, 'plate.png'), 'films/empty.png');
  const prop = 'v 0.3 0.3 0\nv 0.4 0.3 0\nv 0.3 0.3 0.1\nf 1 2 3\n';
  writeFileSync(join(folder, 'films/set.obj'), prop);
  writeFileSync(join(folder, 'texture.png'), plainPng(64, [176, 120, 84]));
  writeFileSync(pipelineFile, filmedProject(kComment));
  execFileSync(join(bin, 'keypose'), ['run', '-C', folder, '--until', 'interpolate'], {
    stdio: ['ignore', 'ignore', 'inherit'],
  });
  page = await openPage();
  await page.getByRole('link', { name: 'Shot', exact: true }).click();
}

async function addFilm() {
  const form = page.locator('.shot-form');
  await form.waitFor();
  const names = await form.locator('option').allTextContents();
  check(
    names.some((name) => name.includes(kMarkup)),
    `the folder with markup in its name is not shown as text: ${names}`,
  );
  await page.getByLabel('Filmed pictures a second').fill('7');
  check(await button('Add the film').isDisabled(), '24 is no multiple of 7, and was taken');
  await page.getByLabel('Filmed pictures a second').fill('12');
  await page.getByLabel('Folder of the film').selectOption('films/take1');
  await record(page, 'shot_setup', options.pictures);
  await page.getByText('Moving camera, empty set, mattes, props').click();
  await part('mattes').selectOption('films/mattes');
  await record(page, 'shot_setup_parts', options.pictures);
  await button('Add the film').click();
  await page.locator('.shot-strip').waitFor();
  const text = pipelineText();
  check(text.startsWith(kComment), 'the comment is gone');
  check(/film: films\/take1/.test(text) && /0: rest, 4: wave/.test(text), `written:\n${text}`);
  check(text.includes('\n  mattes: films/mattes\n'), `the mattes are not written:\n${text}`);
  check((await page.locator('.shot-strip li').count()) === 5, 'the strip has not five frames');
}

/** Frames get their poses; what an editor adds beside is taken up, and is left alone. */
async function showPoses() {
  await page.getByLabel(`Pose of frame ${kWave}`).selectOption('wave');
  await until('it is written', () => /2: wave, 4: wave/.test(pipelineText()));
  await page.getByLabel('Pose of frame 4').selectOption('');
  await until('it is written', () => /\{0: rest, 2: wave\}/.test(pipelineText()));
  await page.getByLabel('Pose of frame 0').selectOption('');
  await page.getByText('Say of two frames or more').waitFor();
  check(/\{0: rest, 2: wave\}/.test(pipelineText()), 'one frame alone was written');
  check((await page.getByLabel('Pose of frame 0').inputValue()) === 'rest', 'the choice stays');
  await page.getByRole('button', { name: 'Dismiss' }).first().click();
  const mattes = '\n  mattes: films/mattes\n';
  check(pipelineText().includes(mattes), `they have no line of their own:\n${pipelineText()}`);
  const more = '\n  mattes: films/mattes  # by hand\n  plate: films/empty.png\n';
  writeFileSync(pipelineFile, pipelineText().replace(mattes, more));
  await page.getByText('empty set films/empty.png').waitFor();
}

const setUpIs = async (words, test) => {
  await button('Save the set-up').click();
  await until(words, () => test(pipelineText()));
  check(pipelineText().includes('# by hand'), 'the comment of the editor is gone');
};

/** A camera that moves, props, and back again. */
async function setUp() {
  await page.getByRole('button', { name: 'Set-up', exact: true }).click();
  const before = pipelineText();
  check(await button('Save the set-up').isDisabled(), 'nothing has changed, and may be saved');
  await button('moves').click();
  await page.getByText('one picture of the empty set is not enough').waitFor();
  check(await button('Save the set-up').isDisabled(), 'one plate for a moving camera may be saved');
  await part('plate').selectOption(`films/${kMarkup}`);
  await part('set').selectOption('films/set.obj');
  await record(page, 'shot_setup_moving', options.pictures);
  await setUpIs('all of it is written', (text) =>
    /set: films\/set\.obj/.test(text) && /locate: \{camera: moving\}/.test(text),
  );
  await page.getByText('moving camera').waitFor();
  await button('stands still').click();
  await part('plate').selectOption('films/empty.png');
  await part('set').selectOption('');
  await setUpIs('it is as before', (text) => text === before);
  await button('Film').click();
}

const turned = ([w, x, y, z], [a, b, c]) => {
  const [tx, ty, tz] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [
    a + w * tx + y * tz - z * ty,
    b + w * ty + z * tx - x * tz,
    c + w * tz + x * ty - y * tx,
  ];
};
const plus = (one, two) => one.map((value, k) => value + two[k]);

/** Where the true camera sees a click's place on the mesh. */
function truePixel(click, frame) {
  const shot = JSON.parse(readFileSync(join(truth, 'shot.json'), 'utf8'));
  const { camera } = shot;
  // The true surfaces lie in the world.
  const { camera_from_world: c } = shot.frames.find((one) => one.frame === frame);
  const corners = mesh.corners(click.face);
  const place = [0, 1, 2].map((k) =>
    click.barycentric.reduce((sum, share, corner) => sum + share * corners[corner][k], 0),
  );
  const [x, y, z] = plus(turned(c.rotation, place), c.translation);
  const [u, v] = [x / z, y / z];
  const bent = 1 + camera.k1 * (u * u + v * v);
  return [camera.fx * u * bent + camera.cx, camera.fy * v * bent + camera.cy];
}

/** The place in the window of a pixel of the frame. */
async function windowOf([x, y]) {
  const box = await boxOf(frameSheet());
  const { width, height } = (await ask('/api/shot')).shot;
  return [box.x + (x / width) * box.width, box.y + (y / height) * box.height];
}

async function drag(from, to) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
  await page.mouse.move(...to);
  await page.mouse.up();
}

/** Clicks the mesh, then the frame somewhere, and drags the mark to where the place is seen. */
async function addClick(share, [x, y], meshFirst) {
  const before = existsSync(clicksFile) ? clicks().length : 0;
  const box = await boxOf(meshCanvas());
  const onMesh = () => page.mouse.click(box.x + x * box.width, box.y + y * box.height);
  const about = [kWidth * (0.2 + 0.15 * share), 40];
  const onFrame = async () => page.mouse.click(...(await windowOf(about)));
  await (meshFirst ? onMesh() : onFrame());
  await page.getByText('now click the same place').waitFor();
  await (meshFirst ? onFrame() : onMesh());
  await until('the click is in the file', () => existsSync(clicksFile) && clicks().length > before);
  const click = clicks().at(-1);
  await drag(await windowOf(click.pixel), await windowOf(truePixel(click, 0)));
  await until('it has moved', () => clicks().at(-1).pixel[1] !== click.pixel[1]);
  const [near, right] = [clicks().at(-1).pixel, truePixel(click, 0)];
  const off = Math.hypot(near[0] - right[0], near[1] - right[1]);
  check(off < 1, `the mark was dragged to ${near}, and not to ${right}`);
}

async function addClicks() {
  await button('Frame 0, rest').click();
  mesh = meshOf(
    await (
      await page.request.get(new URL('/api/mesh?pose=rest&what=mesh', page.url()).href)
    ).body(),
  );
  await until('the mesh is shown', async () => (await page.locator('.shot-wait').count()) === 0);
  await page.waitForTimeout(1000);
  const places = [
    [0.5, 0.28],
    [0.45, 0.5],
    [0.58, 0.55],
    [0.5, 0.68],
  ];
  for (const [i, place] of places.entries()) await addClick(i, place, i % 2 === 0);
  check(/clicks: clicks\.json/.test(pipelineText()), 'pipeline.yaml does not name the clicks');
  check(pipelineText().includes('# by hand'), 'the comment of the editor is gone');
  check((await page.locator('.frame-mark').count()) === 4, 'not four marks');
  await outlinesAtOnce();
  await record(page, 'shot', options.pictures);
}

const outlines = () => page.locator('.frame-over image');
const quickWords = async () => (await page.locator('.shot-hint p').textContent()) ?? '';

/** Four clicks give the camera and the mesh's outlines; another place of a click, others. */
async function outlinesAtOnce() {
  const overlap = async () => Number(/overlap ([\d.]+) %/.exec(await quickWords())?.[1] ?? 0);
  await until('the outlines are there', async () => (await overlap()) > 90);
  const first = await outlines().getAttribute('href');
  // A mark by a pixel, and what it takes until the new outlines are loaded.
  await page.locator('.shot-clicks li').first().getByRole('button').first().click();
  await frameSheet().focus();
  await page.evaluate(() => {
    const image = document.querySelector('.frame-over image');
    globalThis.began = performance.now();
    const told = () => (globalThis.took ??= performance.now() - globalThis.began);
    image.addEventListener('load', told, { once: true });
  });
  await page.keyboard.press('ArrowRight');
  const took = await until('other outlines', () => page.evaluate(() => globalThis.took));
  check((await outlines().getAttribute('href')) !== first, 'the outlines are the same ones');
  console.log(
    `    outlines ${(took / 1000).toFixed(2)} s after a click was moved; ` +
      (await quickWords()).split('Rough: ')[1],
  );
  await frameSheet().focus();
  await page.keyboard.press('ArrowLeft');
  await until('it is back', async () => (await overlap()) > 90);
  await page.keyboard.press('o');
  check((await outlines().count()) === 0, 'outlines that were switched off are shown');
  await page.keyboard.press('o');
  await outlines().waitFor();
  await frameSheet().evaluate((one) => one.blur());
}

async function undoAndDelete() {
  const all = clicks();
  await page.locator('.shot-clicks li').first().getByRole('button').first().click();
  await page.keyboard.press('Delete');
  await until('one is gone', () => clicks().length === 3);
  await page.keyboard.press('Control+z');
  await until('it is back', () => JSON.stringify(clicks()) === JSON.stringify(all));
  await page.keyboard.press('Control+Shift+z');
  await until('it is gone again', () => clicks().length === 3);
  await page.keyboard.press('Control+z');
  await until('it is back again', () => clicks().length === 4);
  // By keyboard: a mark in the middle, nudged, and given up.
  await frameSheet().focus();
  await page.keyboard.press('Space');
  await page.keyboard.press('ArrowRight');
  check((await page.locator('.frame-mark.pending').count()) === 1, 'Space set no mark');
  await page.keyboard.press('Escape');
  check((await page.locator('.frame-mark').count()) === 4, 'Escape left the mark');
  // An editor's change is taken up.
  const named = all.map((click, i) => (i === 0 ? { ...click, name: kMarkup } : click));
  writeFileSync(clicksFile, JSON.stringify({ schema: 1, clicks: named }));
  await page.locator('.shot-clicks').getByText(kMarkup).waitFor();
  check(await button('Undo').isDisabled(), "undo would write over the editor's change");
  await frameSheet().evaluate((one) => one.blur());
}

/** @throws Error if the step fails */
async function runEnds(name) {
  const state = await until(
    `${name} has ended`,
    async () => {
      const { steps } = await ask('/api/steps');
      const step = steps.find((one) => one.step === name);
      return ['done', 'failed'].includes(step.state) && `${step.state} ${step.error}`;
    },
    300,
  );
  check(state.startsWith('done'), `${name} ${state}`);
}

async function findCamera() {
  await button('Find the camera').click();
  await runEnds('locate');
  const { located } = await ask('/api/shot');
  for (const { frame, method, contour_px, iou } of located.frames) {
    console.log(
      `    frame ${frame}: found by ${method}, outlines ${contour_px.toFixed(2)} px apart, ` +
        `overlap ${(100 * iou).toFixed(1)} %`,
    );
    check(contour_px < 1 && iou > 0.97, `frame ${frame} does not fit`);
  }
  check(located.frames[0].method === 'clicks', `found by ${located.frames[0].method}`);
  const { steps } = await ask('/api/steps');
  check(steps.find((one) => one.step === 'composite').state !== 'done', 'composite ran, too');
  await button('Camera').click();
  await until('the outlines are drawn', () =>
    page.locator('.shot-outlines img').evaluate((one) => one.naturalWidth > 0),
  );
  await page.getByText('The run is done.').waitFor({ state: 'detached' });
  await record(page, 'shot_camera', options.pictures);
}

async function makePictures() {
  await button('Result').click();
  await button('Make the pictures').click();
  await runEnds('composite');
  await page.locator('.shot-cells button').first().waitFor();
  const { finished } = await ask('/api/shot');
  check((await page.locator('.shot-cells button').count()) === finished.pictures.length, 'cells');
  const made = finished.pictures.filter((one) => one.kind === 'between').length;
  check(made > 0, 'no in-between was made');
  await until('all are loaded', async () => (await page.getByText(/^loading/).count()) === 0);
  await page.keyboard.press('Home');
  await page.keyboard.press('.');
  await page.locator('.shot-kind.between').waitFor();
  await page.getByText('in-between, made: from 0000.png to 0001.png').waitFor();
  await page.getByText('The run is done.').waitFor({ state: 'detached' });
  await record(page, 'shot_result', options.pictures);
  await page.keyboard.press('Space');
  await button('Pause').waitFor();
  await page.waitForTimeout(700);
  await page.keyboard.press('Space');
  await page.keyboard.press('Home');
  await page.keyboard.press('c');
  await page.getByAltText('Filmed, rendered').waitFor();
  const link = page.getByRole('link', { name: 'MP4' });
  const film = await page.request.get(new URL(await link.getAttribute('href'), page.url()).href);
  check(film.ok() && (await film.body()).length > 1000, 'the film cannot be fetched');
  const join = finished.joins[0];
  console.log(
    `    ${finished.pictures.length} pictures, ${made} made; join at frame 0: ` +
      `${join.psnr_db.toFixed(1)} dB, edges ${join.edge_px.toFixed(2)} px`,
  );
}

/** The card tells of a camera that moves, as soon as it was looked for so. */
async function movingCamera() {
  await page.getByRole('button', { name: 'Set-up', exact: true }).click();
  await button('moves').click();
  await part('plate').selectOption('');
  await page.getByText('no pictures can be made').waitFor();
  await setUpIs('it moves', (text) => /camera: moving/.test(text));
  await button('Camera').click();
  await page.getByText('The set-up now says that it moves').waitFor();
  await button('Find the camera').or(button('Find the camera again')).click();
  await runEnds('locate');
  await page.locator('.shot-camera').getByText('moving').waitFor();
  const { located } = await ask('/api/shot');
  console.log(`    moving: ${located.frames.length} frames, ${JSON.stringify(located.measured)}`);
  check(!located.still && located.frames.length === 3, 'not a camera for each frame between keys');
  await page.getByText('its jitter cannot be told').waitFor();
  await record(page, 'shot_moving', options.pictures);
}

/** The last click takes the file and its name in pipeline.yaml along. */
async function deleteAll() {
  await button('Film').click();
  for (let left = 4; left > 0; --left) {
    await page.locator('.shot-clicks li').first().getByRole('button').nth(1).click();
    await until('one is gone', () =>
      left > 1 ? clicks().length === left - 1 : !existsSync(clicksFile),
    );
  }
  await until('its name is gone', () => !/clicks:/.test(pipelineText()));
  check(pipelineText().startsWith(kComment), 'the comment is gone');
}

// One frame alone is refused, as it should be.
browser.expected = /\/api\/shot$/;
await walkThrough({
  prepare,
  addFilm,
  showPoses,
  setUp,
  addClicks,
  undoAndDelete,
  findCamera,
  makePictures,
  movingCamera,
  deleteAll,
});
