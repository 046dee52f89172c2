// Edits that must not get lost: a page that is closed at once after one, a studio that is away, a
// mask whose photograph is shot again.
//
//   node edits_test.mjs BIN_DIR [--pictures DIR] [--keep]
import {
  mkdirSync,
  readdirSync,
  readFileSync,
  renameSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng } from './png.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { options, scratch, folder, browser, studio, openPage, walkThrough } = withStudio('edits', 'dance');
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

await walkThrough([
  ['a project of two poses', begin],
  ['a page that is closed at once', closedAtOnce],
  ['a studio that is away', whileAway],
  ['a sound', sound],
  ['a mask by lasso and fill', lassoAndFill],
  ['a photograph that is shot again', shotAgain],
]);
