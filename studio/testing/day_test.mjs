// A day of somebody who has never seen a terminal: given the address and folders of photographs (a
// ring with a stranger and a blurred one in it, six of a second pose), from the first page to a
// film, a GLB and a mended mask. Tells how long each part took.
//
//   node day_test.mjs BIN_DIR [--pictures DIR] [--data DATA] [--keep]
//
// DATA keeps the photographs that `keypose synth` makes.
import { execFileSync } from 'node:child_process';
import { copyFileSync, cpSync, existsSync, mkdirSync, readFileSync, readdirSync, statSync } from 'node:fs';
import { join, resolve } from 'node:path';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, browser, studio, openPage, walkThrough } = withStudio('day', 'home/Keypose/fox', {
  data: { type: 'string' },
});
const kBlurred = 'IMG_0011.jpg';
const kPatience = { timeout: 120_000 };
const kRunSeconds = 1800;
let page;
let stranger;

const button = (name) => page.getByRole('button', { name, exact: true });
const link = (name) => page.getByRole('link', { name, exact: true });
const file = (path) => readFileSync(join(folder, path), 'utf8');

function synth(out, ...more) {
  const words = ['synth', 'photos', '--output', out, '--seed', '4', '--width', '640', ...more];
  execFileSync(join(bin, 'keypose'), words, { stdio: 'ignore' });
}

/** What the person has in hand: two folders. */
function photographs() {
  const data = resolve(options.data ?? join(scratch, 'data'));
  if (!existsSync(join(data, 'sharp')))
    synth(join(data, 'sharp'), '--poses', 'rest', 'bent', '--views', '24', '--stray', '1');
  if (!existsSync(join(data, 'blurred'))) synth(join(data, 'blurred'), '--poses', 'rest', '--views', '24', '--blur', '7');
  const world = JSON.parse(readFileSync(join(data, 'sharp/truth/rest/world.json'), 'utf8'));
  stranger = world.mishaps.stray.photographs[0];
  cpSync(join(data, 'sharp/photos/rest'), join(scratch, 'fox'), { recursive: true });
  check(stranger !== kBlurred, 'choose another photograph to be blurred');
  copyFileSync(join(data, 'blurred/photos/rest', kBlurred), join(scratch, 'fox', kBlurred));
  mkdirSync(join(scratch, 'fox bows'));
  for (const [i, name] of readdirSync(join(data, 'sharp/photos/bent')).sort().entries())
    if (i % 4 === 0) copyFileSync(join(data, 'sharp/photos/bent', name), join(scratch, 'fox bows', name));
}

async function theAddress() {
  mkdirSync(join(scratch, 'home'));
  studio.words = ['--port', '0'];
  // What programs say of themselves is kept, as asking all of them takes long.
  const cache = process.env.XDG_CACHE_HOME ?? join(process.env.HOME ?? scratch, '.cache');
  const own = { HOME: join(scratch, 'home'), KEYPOSE_HOME: join(scratch, 'state'), XDG_CACHE_HOME: cache };
  studio.place = { cwd: join(scratch, 'home'), env: { ...process.env, ...own } };
  page = await openPage();
  await page.getByRole('heading', { name: 'Welcome', exact: true }).waitFor();
  await page.getByLabel('Its name').fill('fox');
  await button('Make it').first().click();
  await button('Make project').waitFor(kPatience);
}

async function twoFolders() {
  const choose = async (name, what) => {
    const [dialog] = await Promise.all([page.waitForEvent('filechooser'), button(name).click()]);
    await dialog.setFiles(what);
  };
  await choose('Choose a folder for pose 1', join(scratch, 'fox'));
  await choose('Choose a folder for pose 2', join(scratch, 'fox bows'));
  await page.getByText('2 poses, 30 photographs').waitFor();
  await record(page, 'day_folders', options.pictures);
  await button('Make project').click();
  await page.locator('.notices').getByText('The project is made.').waitFor(kPatience);
}

/** Until nothing is left to do, or what is told to do. @return  seconds */
async function run() {
  const began = Date.now();
  await page.locator('header').getByRole('button', { name: 'Run', exact: true }).click();
  const bar = page.getByRole('button', { name: 'Stop', exact: true });
  await bar.waitFor(kPatience);
  await until('the run ends', async () => (await bar.count()) === 0, kRunSeconds);
  return Math.round((Date.now() - began) / 1000);
}

const tile = (name) => page.locator('.sheet .tile').filter({ hasText: name });

/** The first run ends, and its warnings name both by their true reason. */
async function firstRun() {
  console.log(`    the first run took ${await run()} s`);
  await link('Poses').click();
  await page.getByRole('list', { name: 'Photographs of fox' }).waitFor();
  await page.waitForTimeout(1500);
  await record(page, 'day_warned', options.pictures);
}

async function leaveOutBoth() {
  for (const name of [stranger, kBlurred]) {
    await button(`Leave out ${name}`).first().click();
    await until(`${name} is left out`, () => file('pipeline.yaml').includes(name));
    await tile(name).getByText('left out: no step reads it').waitFor();
  }
}

async function mendAMask() {
  const name = 'IMG_0001.jpg';
  await tile(name).click();
  const surface = page.getByRole('application', { name: new RegExp(`^${name} with its mask`) });
  const box = await boxOf(surface);
  await page.getByRole('button', { name: /^Add/ }).click();
  for (let i = 0; i < 4; ++i) await page.keyboard.press('[');
  // Over the edge of the right hand.
  await page.mouse.move(box.x + 0.72 * box.width, box.y + 0.49 * box.height);
  await page.mouse.down();
  for (let i = 0; i <= 6; ++i)
    await page.mouse.move(box.x + (0.72 + 0.001 * i) * box.width, box.y + (0.49 + 0.01 * i) * box.height);
  await page.mouse.up();
  await page.getByText('Strokes not saved yet.').waitFor();
  await record(page, 'day_mask', options.pictures);
  await button('Save').click();
  await until('the mask is there', () => existsSync(join(folder, `masks/fox/${name}.png`)));
}

async function secondRun() {
  console.log(`    the second run took ${await run()} s`);
  await link('Run').click();
  await page.locator('.run-summary').getByText('All is up to date.').waitFor(kPatience);
  await record(page, 'day_done', options.pictures);
}

async function filmAndGlb() {
  await link('Report & export').click();
  for (const [name, least, most] of [
    ['character.glb', 1e5, 4e6],
    ['character.mp4', 2e4, 2e7],
  ]) {
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.locator('.export-results').getByRole('link', { name: new RegExp(name.replace('.', '\\.')) }).first().click(),
    ]);
    const { size } = statSync(await download.path());
    console.log(`    ${name}: ${(size / 1e6).toFixed(2)} MB`);
    check(size > least && size < most, `${name} has ${size} bytes`);
  }
  await page.waitForTimeout(1500);
  await record(page, 'day_results', options.pictures);
  const report = JSON.parse(file('out/report/report.json'));
  for (const { about, grade, why } of report.verdicts) {
    console.log(`    ${about}: ${grade}: ${why}`);
    check(grade !== 'wrong', `${about}: ${why}`);
  }
}

await walkThrough([
  ['what the person has in hand', photographs],
  ['the address', theAddress],
  ['two folders', twoFolders],
  ['the first run', firstRun],
  ['the stranger and the blurred one are left out', leaveOutBoth],
  ['a mask is mended', mendAMask],
  ['the second run', secondRun],
  ['a film and a GLB', filmAndGlb],
]);
