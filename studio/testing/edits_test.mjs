// Edits that must not get lost: a page that is closed at once after one, a studio that is away, a
// mask whose photograph is shot again.
//
//   node edits_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  chmodSync,
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  renameSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng } from './png.mjs';
import { stageScript } from './projects.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, browser, studio, openPage, walkThrough } = withStudio('edits', 'dance');
let page;

const pipeline = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const key = () => page.locator('.tl-block[data-key="1"]');
const where = () => key().getAttribute('aria-label');
const toTimeline = () => page.getByRole('link', { name: 'Timeline', exact: true }).click();

async function begin() {
  for (const pose of ['rest', 'bent']) mkdirSync(join(folder, 'photos', pose), { recursive: true });
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    'name: dance\nposes: {rest: photos/rest, bent: photos/bent}\ntemplate: rest\n',
  );
  page = await openPage();
  await toTimeline();
}

async function closedAtOnce() {
  await key().press('Shift+ArrowRight');
  await until('the key is written', () => pipeline().includes('pose: bent, at: '));
  const before = pipeline();
  await key().press('Shift+ArrowRight');
  await page.close({ runBeforeUnload: true });
  await until('where the key was moved last is written', () => pipeline() !== before, 10);
  page = await browser.tab();
  await page.goto(`http://127.0.0.1:${studio.port}/`);
  await toTimeline();
}

async function whileAway() {
  await key().waitFor();
  browser.away = true;
  await studio.end('SIGKILL');
  const [before, written] = [await where(), pipeline()];
  await key().press('Shift+ArrowRight');
  await page.getByText('Not saved').waitFor();
  check((await where()) !== before, 'the key has not moved');
  check(pipeline() === written, 'nobody was there to write it');
  browser.stays = true;
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await key().waitFor();
  check(browser.questions.join() === 'confirm', `asked before leaving: ${browser.questions}`);
  browser.stays = false;
  await studio.start();
  await until('the move is written once the studio is back', () => pipeline() !== written, 30);
  browser.away = false;
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await key().waitFor({ state: 'detached' });
  check(browser.questions.length === 1, 'what is saved is asked about');
}

/** A second of a tone, in one channel of 16 bits. Source: the WAVE format of RIFF. */
function wav() {
  const rate = 8000;
  const bytes = Buffer.alloc(44 + 2 * rate);
  bytes.write('RIFF\0\0\0\0WAVEfmt ', 'latin1');
  bytes.writeUInt32LE(bytes.length - 8, 4);
  const numbers = [
    [16, 4], [1, 2], [1, 2], [rate, 4], [2 * rate, 4], [2, 2], [16, 2],
  ];
  let at = 16;
  for (const [value, size] of numbers) at = bytes.writeUIntLE(value, at, size);
  bytes.write('data', at);
  bytes.writeUInt32LE(2 * rate, at + 4);
  for (let i = 0; i < rate; ++i)
    bytes.writeInt16LE(Math.round(20000 * Math.sin((2 * Math.PI * 220 * i) / rate)), 44 + 2 * i);
  return bytes;
}

/** The sound is a file of the project, and is still there in another tab. */
async function sound() {
  await toTimeline();
  const chooser = page.locator('.tl-sound input[type=file]');
  await chooser.setInputFiles({ name: 'notes.wav', mimeType: 'audio/wav', buffer: Buffer.from('a') });
  await page.getByText('notes.wav is no sound that this browser can read').waitFor();
  await chooser.setInputFiles({ name: 'line.wav', mimeType: 'audio/wav', buffer: wav() });
  await until('the sound is named', () => pipeline().includes('sound: sound/line.wav'));
  check(readFileSync(join(folder, 'sound/line.wav')).equals(wav()), 'the file is another');
  const begins = page.getByLabel('Frame at which the sound begins');
  await begins.fill('12');
  await begins.press('Enter');
  await until('its time is written', () => pipeline().includes('sound_at: 0.5'));
  await page.reload();
  await page.locator('.tl-file', { hasText: 'line.wav' }).waitFor();
  await until('its time is still there', async () => (await begins.inputValue()) === '12');
  if (process.env.KEYPOSE_PICTURES)
    await page.screenshot({ path: join(process.env.KEYPOSE_PICTURES, 'sound.png') });
  await page.getByRole('button', { name: 'Remove the sound' }).click();
  await until('the file does not name it', () => !pipeline().includes('sound'));
}

/** A mask by lasso, fill and as a whole; and taken from the photograph before. */
async function lassoAndFill() {
  for (const name of ['a.png', 'b.png'])
    writeFileSync(join(folder, 'photos/bent', name), plainPng(48, [80, 80, 80]));
  await page.getByRole('link', { name: 'Poses', exact: true }).click();
  await page.locator('.side .list button', { hasText: 'bent' }).click();
  await page.locator('.sheet .tile', { hasText: 'b.png' }).waitFor();
  await page.locator('.sheet .tile', { hasText: 'a.png' }).click();
  const surface = page.getByRole('application', { name: /^a.png with its mask/ });
  const box = await boxOf(surface);
  // The photograph is square, and fills 0.96 of the view's height.
  const side = 0.96 * box.height;
  const at = (x, y) => [
    box.x + box.width / 2 + (x / 48 - 0.5) * side,
    box.y + box.height / 2 + (y / 48 - 0.5) * side,
  ];
  const line = async (points) => {
    await page.mouse.move(...at(...points[0]));
    await page.mouse.down();
    for (const point of points.slice(1)) await page.mouse.move(...at(...point));
    await page.mouse.up();
  };
  const saved = async (name) => {
    const unsaved = page.getByText('Strokes not saved yet.');
    await unsaved.waitFor();
    await page.keyboard.press('Control+s');
    const file = join(folder, `masks/bent/${name}.png`);
    await unsaved.waitFor({ state: 'detached' });
    const { rgb } = readPng(readFileSync(file));
    return rgb.reduce((sum, [value]) => sum + (value > 127 ? 1 : 0), 0);
  };
  await page.keyboard.press('l');
  await line([[10, 10], [30, 10], [30, 30], [10, 30]]);
  check((await saved('a.png')) === 400, 'not 20 x 20 pixels');
  await page.keyboard.press('r');
  await line([[15, 15], [25, 15], [25, 25], [15, 25]]);
  await page.keyboard.press('a');
  await record(page, 'brush_lasso', options.pictures);
  check((await saved('a.png')) === 300, 'no hole of 10 x 10');
  await page.keyboard.press('f');
  await page.mouse.click(...at(20, 20));
  check((await saved('a.png')) === 400, 'the hole is not filled');
  await page.keyboard.press('i');
  check((await saved('a.png')) === 48 * 48 - 400, 'not inverted');
  await page.keyboard.press('Control+z');
  check((await saved('a.png')) === 400, 'not taken back');
  await page.keyboard.press('PageDown');
  await page.getByRole('application', { name: /^b.png with its mask/ }).waitFor();
  await page.getByRole('button', { name: 'As before' }).click();
  check((await saved('b.png')) === 400, 'not the mask of the photograph before');
  await page.getByRole('button', { name: /Photographs of bent/ }).click();
}

/** A mask that was painted, and then its photograph is shot again, twice. */
async function shotAgain() {
  const shoot = (grey) => {
    const file = join(scratch, 'a.png');
    writeFileSync(file, plainPng(48, [grey, grey, grey]));
    renameSync(file, join(folder, 'photos/rest/a.png')); // the studio must not see half of it
  };
  const masks = () => readdirSync(join(folder, 'masks/rest')).sort().join();
  const noted = () => readFileSync(join(folder, 'masks/rest/painted.json'), 'utf8');
  shoot(90);
  await page.getByRole('link', { name: 'Poses', exact: true }).click();
  await page.locator('.sheet button').first().click();
  const surface = page.getByRole('application', { name: /^a.png with its mask/ });
  await surface.focus();
  await page.keyboard.press('Enter');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  await page.getByText('own mask').waitFor();
  const before = noted();
  shoot(91);
  const older = page.getByRole('region', { name: 'Masks of older photographs' });
  await older.getByText('a.png was shot again after you painted its mask').waitFor();
  await older.getByRole('button', { name: 'It still holds' }).click();
  await older.waitFor({ state: 'detached' });
  await page.getByText('own mask').waitFor();
  check(noted() !== before, 'nothing is noted of the new photograph');
  await page.getByRole('button', { name: /Photographs of rest/ }).click();
  shoot(92);
  await page.getByText('older mask').waitFor();
  await older.getByRole('button', { name: 'Set aside' }).click();
  await older.waitFor({ state: 'detached' });
  check(masks() === 'a.png.png.old', `the mask is not set aside alone: ${masks()}`);
  // No run has made a mask, so that the brush finds none.
  browser.faults = browser.faults.filter((fault) => !/404 for GET \S+api\/mask/.test(fault));
}

/** Where the view looks from at first: the middle of the bite. */
const kBite = [0.35, -0.9, 0.28].map((one) => one / Math.hypot(0.35, 0.9, 0.28));
const kBiteWide = 0.3;

/** A ball of radius 1, bitten 0.25 deep, as OBJ; and the ball's radius at each of its vertices. */
function bittenBall(rows = 80) {
  const lines = ['v 0 0 1', 'v 0 0 -1'];
  const columns = 2 * rows;
  for (let row = 1; row < rows; ++row)
    for (let column = 0; column < columns; ++column) {
      const [down, round] = [(Math.PI * row) / rows, (2 * Math.PI * column) / columns];
      const p = [Math.sin(down) * Math.cos(round), Math.sin(down) * Math.sin(round), Math.cos(down)];
      const away = Math.hypot(...p.map((one, k) => one - kBite[k])) / kBiteWide;
      const radius = away < 1 ? 1 - 0.25 * Math.sqrt(1 - away * away) : 1;
      lines.push(`v ${p.map((one) => (radius * one).toFixed(6)).join(' ')}`);
    }
  const at = (row, column) => 3 + (row - 1) * columns + (column % columns);
  for (let column = 0; column < columns; ++column) {
    lines.push(`f 1 ${at(1, column)} ${at(1, column + 1)}`);
    for (let row = 1; row < rows - 1; ++row) {
      const [a, b] = [at(row, column), at(row, column + 1)];
      const [c, d] = [at(row + 1, column), at(row + 1, column + 1)];
      lines.push(`f ${a} ${c} ${d}`, `f ${a} ${d} ${b}`);
    }
    lines.push(`f 2 ${at(rows - 1, column + 1)} ${at(rows - 1, column)}`);
  }
  return lines.join('\n') + '\n';
}

/** A mesh that a stage of the test's own makes, and whose bite is to be filled. */
function bittenProject() {
  const tools = join(folder, 'tools');
  mkdirSync(tools);
  writeFileSync(join(folder, 'ball.obj'), bittenBall());
  const done = `cp "$here/../ball.obj" "$to"\necho '{"schema": 1, "measurements": {}}' > "$report"\n`;
  writeFileSync(join(tools, 'cleanup'), stageScript('cleanup', 'clean', done));
  chmodSync(join(tools, 'cleanup'), 0o755);
  const described = {
    schema: 1, stage: 'cleanup', version: '1', summary: 'copies',
    inputs: [
      { name: 'surface', kind: 'file' },
      { name: 'images', kind: 'folder', optional: true },
      { name: 'model', kind: 'folder', optional: true },
    ],
    outputs: [{ name: 'clean', kind: 'file', file: 'clean.ply' }], options: [],
  };
  writeFileSync(join(tools, 'cleanup.json'), JSON.stringify(described));
  const off = 'capture sfm masks dense mesh refine unwrap bake complete export report';
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    'name: ball\nposes: {rest: photos/rest}\ntemplate: rest\nsteps:\n' +
      off.split(' ').map((step) => `  ${step}: {enabled: false}\n`).join('') +
      '  cleanup: {program: tools/cleanup, inputs: {surface: ./ball.obj, images: null, model: null}}\n',
  );
}

/** How far a mesh of the ball is from it at most, over all vertices. */
function mostOffBall(file) {
  const mended = join(scratch, 'mended.obj');
  const words = ['mend', '--mesh', join(folder, 'ball.obj'), '--strokes', file, '--mended', mended];
  execFileSync(join(bin, 'keypose'), words, { stdio: 'pipe' });
  const vertices = readFileSync(mended, 'utf8').split('\n').filter((line) => line.startsWith('v '));
  const off = vertices.map((line) => Math.abs(Math.hypot(...line.split(' ').slice(1, 4).map(Number)) - 1));
  return Math.max(...off);
}

/** A bitten place is filled by the brush; taken back, done again, pulled, taken out. */
async function bittenMesh() {
  bittenProject();
  execFileSync(join(bin, 'keypose'), ['run', '-C', folder], { stdio: 'pipe' });
  const file = join(folder, 'mending/rest.json');
  const strokes = () => (existsSync(file) ? JSON.parse(readFileSync(file, 'utf8')).strokes : []);
  await page.goto(`http://127.0.0.1:${studio.port}/#/poses/rest/mend`);
  const canvas = page.locator('.view canvas');
  await page.getByText('Drag on the figure to mend it').waitFor();
  const box = await boxOf(canvas);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.keyboard.press('3');
  await page.getByRole('slider', { name: 'Radius' }).fill('0.11');
  await record(page, 'mend_before', options.pictures);
  await page.mouse.move(x - 5, y);
  await page.mouse.down();
  for (const [right, down] of [[0, 0], [5, 0], [0, 5], [0, -5]])
    await page.mouse.move(x + right, y + down);
  await page.mouse.up();
  await until('the stroke is written', () => strokes().length === 1);
  check(strokes()[0].tool === 'fill', 'not filled');
  await until('the page knows the step', () => page.getByText('The next run mends the mesh').isVisible());
  await record(page, 'mend_filled', options.pictures);
  await page.getByRole('button', { name: 'Run', exact: true }).waitFor();
  check(mostOffBall(file) < 0.01, `the bite is still ${mostOffBall(file)} deep of 0.25`);
  await page.getByRole('button', { name: 'Moved', exact: true }).click();
  await record(page, 'mend_moved', options.pictures);
  await page.keyboard.press('Control+z');
  await until('taken back', () => !existsSync(file));
  await page.keyboard.press('Control+Shift+z');
  await until('done again', () => strokes().length === 1);
  await page.keyboard.press('2');
  await page.mouse.click(x, y - 90);
  await until('a dab is a stroke', () => strokes().length === 2);
  const dab = strokes()[1];
  check(dab.tool === 'pull' && dab.places.length === 1, `not one place: ${JSON.stringify(dab)}`);
  await page.getByRole('button', { name: 'Take out stroke 2, Pull out' }).click();
  await until('taken out', () => strokes().length === 1);
  execFileSync(join(bin, 'keypose'), ['run', '-C', folder], { stdio: 'pipe' });
  await page.getByText('A change makes again what comes after the mesh').waitFor();
}

await walkThrough([
  ['a project of two poses', begin],
  ['a page that is closed at once', closedAtOnce],
  ['a studio that is away', whileAway],
  ['a sound', sound],
  ['a mask by lasso and fill', lassoAndFill],
  ['a photograph that is shot again', shotAgain],
  ['a bitten mesh', bittenMesh],
]);
