// The armature's page with the simulated puppet: no board, the example, frames recorded, a studio
// that is killed, the flipbook, a frame again, baked frames.
//
//   node armature_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { existsSync, mkdirSync, readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

import { check, record, until as untilWithin, withStudio } from './studio_driver.mjs';

const { options, folder, browser, studio, openPage, walkThrough } =
  withStudio('armature', 'theropod');
const kFrames = 5;
// Drawn by the processor, on a machine that does other things too.
const kPatience_s = 150;
const until = (words, probe) => untilWithin(words, probe, kPatience_s);
const take = join(folder, 'armature/walk');
let page;

const button = (name) => page.getByRole('button', { name, exact: true });
const field = (name) => page.getByLabel(name, { exact: true });
const frames = () => page.locator('.armature-page .side h2 + .number').textContent();
const curves = () => JSON.parse(readFileSync(join(take, 'curves.json'), 'utf8'));
/** What the canvas shows, as a text that differs when it does. */
const shown = async () =>
  (await page.locator('.armature-canvas canvas').screenshot()).toString('base64');

async function enter() {
  mkdirSync(folder);
  page = await openPage((tab) => tab.setDefaultTimeout(1000 * kPatience_s));
  await page.getByRole('link', { name: 'Armature' }).click();
  await field('Take').waitFor();
}

async function setUp() {
  await button('Begin').click();
  await page.getByText('Which file describes the armature?').waitFor();
  await record(page, 'armature_setup', null);
  await button('Use the example').click();
  await until(
    'the example fills the form',
    async () => (await field('Description').inputValue()) === 'armature/example/theropod.txt',
  );
  await field('Take').fill('walk');
}

/** As a conversation: it asks, the person says that the puppet stands so. */
async function calibrate() {
  const card = page.getByRole('region', { name: 'Calibrate' });
  await button('Set the zero position').click();
  await card.getByText(/^Put the puppet into its zero position/).waitFor();
  await record(page, 'armature_calibrate', options.pictures);
  await button('It stands so').click();
  await card.getByText('74 joints are at zero.').waitFor();
  await card.getByText('Done.').waitFor();
  check(
    existsSync(join(folder, 'armature/example/theropod.json')),
    'the calibration was not written',
  );
  await button('Has it drifted?').click();
  await button('It stands so').click();
  await card.getByText('0 of 74 joints are not at zero.').waitFor();
  await button('Which sensors answer?').click();
  await card.getByText(/^Move every joint to and fro/).waitFor();
  await button('Stop').click();
  await button('Stop').waitFor({ state: 'detached' });
  // A file of the person's own, sent to the puppet's folder.
  await page
    .locator('.send-drop input[type=file]')
    .setInputFiles({ name: 'known.txt', mimeType: 'text/plain', buffer: Buffer.from('x 1\n') });
  await until('it has arrived', () => existsSync(join(folder, 'armature/known.txt')));
}

/** A board that is not there: said in words, and the simulated puppet is offered. */
async function noBoard() {
  await field('Controller').selectOption('board');
  await field('Port').fill('/dev/keypose-no-such-board');
  await button('Begin').click();
  const fault = page.locator('.shoot-say.fault');
  await fault.getByText(/keypose-no-such-board/).waitFor();
  await record(page, 'armature_no_board', null);
  await button('Try it with a simulated puppet').click();
  await page.locator('.armature-page').waitFor();
  await until('the puppet is drawn', () =>
    page.locator('.armature-canvas canvas').evaluate((one) => one.width > 300),
  );
}

async function recordFrames() {
  for (let frame = 0; frame < kFrames; ++frame) {
    await page.keyboard.press(frame % 2 ? 'Enter' : 'Space');
    await until(
      `frame ${frame} is there`,
      async () => parseInt(await frames(), 10) === frame + 1,
    );
  }
  check(curves().frames === undefined || curves().frames >= kFrames, 'curves.json lacks frames');
  check(
    (await page.locator('.armature-sensors li').count()) === 74,
    'the page does not list 74 sensors',
  );
  await page.getByText('Answers.').waitFor();
  await record(page, 'armature', options.pictures);
}

/** The studio is killed in mid-session: what was recorded is there, and the session goes on. */
async function kill() {
  const before = readFileSync(join(take, 'journal.jsonl'), 'utf8');
  browser.away = true;
  await studio.end('SIGKILL');
  await page.getByText('The studio does not answer').first().waitFor();
  await studio.start();
  await button('Go on with walk').waitFor();
  browser.away = false;
  check(
    readFileSync(join(take, 'journal.jsonl'), 'utf8') === before,
    'the journal has changed while nobody recorded',
  );
  // The old session's program lets go of the take when its studio is gone.
  await until('the session goes on', async () => {
    if (await page.locator('.armature-page').count()) return true;
    const go = button('Go on with walk');
    // It is gone again as soon as the session begins.
    if (await go.count()) await go.click({ timeout: 1000 }).catch(() => undefined);
    await page.waitForTimeout(700);
    return false;
  });
  await until('all frames are there', async () => parseInt(await frames(), 10) === kFrames);
  await page.keyboard.press('Space');
  await until('it records on', async () => parseInt(await frames(), 10) === kFrames + 1);
}

async function flipbook() {
  await until('there is a flipbook', () => button('Flipbook F').isEnabled());
  await page.keyboard.press('f');
  const seen = new Set();
  await until('the flipbook turns its pages', async () => {
    const words = await page.getByText(/^Flipbook: frame/).textContent();
    seen.add(words);
    return seen.size >= 4;
  });
  const one = await shown();
  await until('the flipbook moves the puppet', async () => (await shown()) !== one);
  await page.keyboard.press('Escape');
  await page.getByText(/^Frame 6 is next/).waitFor();
}

async function again() {
  await page.keyboard.press('Backspace');
  await page.getByText(/^Frame 5 is next/).waitFor();
  await button('Record 5 again Space').click();
  await page.getByText(/^Frame 6 is next/).waitFor();
  check(parseInt(await frames(), 10) === kFrames + 1, 'a frame that is recorded again is added');
  await page.keyboard.press('Backspace');
  await page.getByText(/^Frame 5 is next/).waitFor();
  await button('Forget').click();
  await button('Forget 5 on?').click();
  await until('the last frame is forgotten', async () => parseInt(await frames(), 10) === kFrames);
  await page.keyboard.press('v');
  await page.locator('.armature-backdrop').waitFor();
  await page.keyboard.press('v');
}

async function bake() {
  await button('Bake').click();
  await page.getByText('The frames are baked.').waitFor();
  const baked = readdirSync(join(take, 'frames')).filter((name) => name.endsWith('.ply'));
  check(baked.length === 2 * kFrames, `${baked.length} frames on twos, not ${2 * kFrames}`);
  check(existsSync(join(take, 'motion.bvh')), 'there is no motion.bvh');
}

async function end() {
  await button('End').click();
  await button('Go on with walk').waitFor();
  await record(page, 'armature_ended', null);
}

await walkThrough({
  enter,
  'set up': setUp,
  calibrate, calibrate,
  'no board': noBoard,
  'record frames': recordFrames,
  kill,
  flipbook,
  again,
  bake,
  end,
});
