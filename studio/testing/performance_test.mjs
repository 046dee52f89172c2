// A performance without a command: a folder of films dropped into an empty project, its calibration
// sent, the actor found, a scan sent in, marks suggested, refused, accepted, picked, undone; a scan
// that nothing can be suggested on; the scan moved.
//
//   node performance_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

import { check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('performance', 'dance');
const world = join(scratch, 'world');
let page;

const run = (words) =>
  execFileSync(join(bin, 'keypose'), words, { stdio: ['ignore', 'ignore', 'inherit'] });
const button = (name) => page.getByRole('button', { name, exact: true });
const link = (name) => page.getByRole('link', { name, exact: true });
const pairs = () =>
  existsSync(join(folder, 'marks.json'))
    ? JSON.parse(readFileSync(join(folder, 'marks.json'), 'utf8')).pairs
    : [];
const marks = () => pairs().length;
const yaml = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const suggested = () => page.locator('.lm-suggested li').count();
const files = (scope = page) => scope.locator('.send-drop input[type=file]');

async function theFilms() {
  const sizes = ['--frames', '3', '--size', '240', '--cameras', '4', '--seed', '3'];
  run(['synth', 'performance', '--output', world, ...sizes]);
  mkdirSync(folder);
  page = await openPage();
  await button('Films of an actor').click();
  await page.getByText('Films of two cameras or more.').waitFor();
  // A folder with a folder of pictures for each camera, masks and the empty set beside them.
  await files().nth(1).setInputFiles(join(world, 'shot'));
  await page.getByText('cam4: 3 pictures', { exact: true }).waitFor();
  await record(page, 'performance_new', options.pictures);
  await button('Make project').click();
  await page.getByRole('heading', { name: 'Cameras', exact: true }).waitFor({ state: 'attached' });
  for (const name of ['cam1/000.jpg', 'masks/cam4', 'background/cam2.jpg'])
    check(existsSync(join(folder, 'shots/walk', name)), `${name} did not arrive`);
}

async function theCalibration() {
  await page.getByText('A calibration made elsewhere').click();
  await files().setInputFiles(join(world, 'calibration.yml'));
  await until('the calibration is there', () => existsSync(join(folder, 'calibration.yml')));
  await link('Films').click();
  await page.locator('.frame-caption').waitFor();
}

async function findTheActor() {
  await link('Marks').click();
  await page.getByText('Drop the mesh that shall move').waitFor();
  await record(page, 'marks_none', options.pictures);
  await button('Find the actor').click();
  await page.getByText('The actor is found.').waitFor({ timeout: 240000 });
}

/** The tracked body stands for a scan; a ball is none. */
async function sendScan() {
  await files().setInputFiles({
    name: 'hero.ply',
    mimeType: 'application/octet-stream',
    buffer: readFileSync(join(folder, 'out/walk/template.ply')),
  });
  await button('Suggest').waitFor();
  check(yaml().includes('scan: scan/hero.ply'), `pipeline.yaml names no scan:\n${yaml()}`);
  await until('both are shown', async () => (await page.locator('.lm canvas').count()) === 2);
}

async function suggest() {
  await button('Suggest').click();
  const offered = await until('suggestions are there', suggested, 120);
  check(offered >= 20, `only ${offered} suggestions`);
  check(marks() === 0, 'a suggestion is saved before it is accepted');
  await button('Accept suggestion 1').click();
  await until('one is saved', () => marks() === 1);
  await button('Refuse suggestion 1').click();
  await until('one less is offered', async () => (await suggested()) === offered - 2);
  await page.locator('[data-action="accept-sure"]').click();
  const all = await until('the sure ones are saved', () => marks() > 5 && marks());
  // From head to foot, not on one of the pieces that a tracked body is made of.
  const heights = pairs().map((one) => one.source.position[2]);
  const span = Math.max(...heights) - Math.min(...heights);
  check(span > 1.2, `the marks are on ${span.toFixed(2)} m of the body`);
  await record(page, 'marks', options.pictures);
  console.log(`    ${offered} suggested, ${all} saved`);
}

/** In the middle of both views, as by a click; undone and done again. */
async function pick() {
  const before = marks();
  for (const view of await page.locator('.lm canvas').all()) {
    await view.focus();
    await page.keyboard.press('Space');
  }
  await until('the pair is saved', () => marks() === before + 1);
  await page.keyboard.press('Control+z');
  await until('it is undone', () => marks() === before);
  await page.keyboard.press('Control+Shift+z');
  await until('it is done again', () => marks() === before + 1);
}

async function moveTheScan() {
  await button('Move the scan').click();
  await link('Look at the motion').waitFor({ timeout: 240000 });
  await record(page, 'marks_moved', null);
  await link('Look at the motion').click();
  await page.locator('.motion canvas').waitFor({ timeout: 60000 });
}

await walkThrough({ theFilms, theCalibration, findTheActor, sendScan, suggest, pick, moveTheScan });
