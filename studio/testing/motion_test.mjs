// A performance on the studio's page: films of a generated actor, "Run until the motion", the moving
// mesh played, scrubbed and stepped.
//
//   node motion_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import { mkdtempSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';

import {
  Browser,
  check,
  checkFaults,
  record,
  runParts,
  runTest,
  StudioProgram,
  until,
} from './studio_driver.mjs';

const { values: options, positionals } = parseArgs({
  allowPositionals: true,
  options: { pictures: { type: 'string' }, keep: { type: 'boolean' } },
});
if (positionals.length !== 1) {
  console.error('usage: node motion_test.mjs BIN_DIR [--pictures DIR] [--keep]');
  process.exit(2);
}
const bin = resolve(positionals[0]);
const scratch = mkdtempSync(join(tmpdir(), 'keypose_studio_motion_'));
const world = join(scratch, 'world');
const folder = join(scratch, 'dance');
const browser = new Browser();
const studio = new StudioProgram(bin, folder);
const kFrames = 8;
let page;

const run = (program, words) =>
  execFileSync(join(bin, program), words, { stdio: ['ignore', 'ignore', 'inherit'] });
const button = (name) => page.getByRole('button', { name, exact: true });
const reading = () => page.locator('.motion-reading').textContent();
const frame = async () => Number((await reading()).split(' /')[0]);

async function prepare() {
  const sizes = ['--frames', String(kFrames), '--size', '300', '--seed', '3'];
  run('keypose-synth', ['performance', '--output', world, ...sizes]);
  run('keypose', [
    'init',
    folder,
    '--kind',
    'performance',
    '--shot',
    `walk=${join(world, 'shot')}`,
    '--calibration',
    join(world, 'calibration.yml'),
  ]);
  await browser.start();
  const address = await studio.start();
  page = await browser.tab();
  await page.goto(address);
  await page.getByRole('link', { name: 'Motion', exact: true }).click();
}

async function findMotion() {
  await page.getByRole('heading', { name: 'No motion of walk yet' }).waitFor();
  await record(page, 'motion_none', options.pictures);
  await button('Run until the motion').click();
  await page.locator('.motion canvas').waitFor({ timeout: 240000 });
  await until('the first frame is told', async () => (await frame()) === 0);
  check((await reading()).includes(`/ ${kFrames - 1}`), `other frames: ${await reading()}`);
}

/** The picture of the figure, without the corner where messages come and go. */
const drawn = async () => {
  const clip = { x: 300, y: 80, width: 680, height: 500 };
  return (await page.screenshot({ clip })).toString('base64');
};

async function play() {
  const first = await until('the figure is drawn', drawn);
  await page.getByRole('slider', { name: 'Frame' }).fill(String(kFrames - 1));
  await until('the last frame', async () => (await frame()) === kFrames - 1);
  await until('another picture', async () => (await drawn()) !== first);
  await button('A frame back').click();
  check((await frame()) === kFrames - 2, 'not one frame back');
  await button('First frame').click();
  await until('the first picture again', async () => (await drawn()) === first);
  await button('Play').click();
  await until('it plays', async () => (await frame()) > 0);
  await button('Pause').click();
  await button('Play').waitFor();
  await record(page, 'motion', options.pictures);
}

async function walk() {
  await runParts(Object.entries({ prepare, findMotion, play }));
  checkFaults(browser);
}

await runTest({
  name: 'motion',
  walk,
  browser,
  studio,
  page: () => page,
  scratch,
  keep: options.keep && folder,
});
