// Recorded takes on their page: one of the command line before any session; curves and puppet, a
// level pulled, frames held, moved, taken out, ones and twos, undo, played as baked, a page that is
// loaded again, a new take that is saved and baked; a step of the project, run and taken out again.
//
//   node take_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng } from './png.mjs';
import { boxOf, check, record, until as untilWithin, withStudio } from './studio_driver.mjs';

const { bin, options, folder, browser, openPage, walkThrough } = withStudio('take', 'theropod');
const kFrames = 10;
const kJoint = 'leftKneeBend';
// Drawn by the processor, on a machine that does other things too.
const kPatience_s = 150;
const until = (words, probe) => untilWithin(words, probe, kPatience_s);
let page;

const button = (name) => page.getByRole('button', { name, exact: true });
const field = (name) => page.getByLabel(name, { exact: true });
const tab = (name) => page.getByRole('tab', { name });
const plot = () => page.locator('.take-plot');
const value = async () => Number(await plot().getAttribute('aria-valuenow'));
const curves = (take) =>
  JSON.parse(readFileSync(join(folder, 'armature', take, 'curves.json'), 'utf8'));
/** A joint's degrees in a take's file. */
const degrees = (take, joint) =>
  curves(take).joints[joint].values.map((one) => (180 / Math.PI) * one);
const near = (a, b) => Math.abs(a - b) < 1e-6;
/** What the canvas shows, as a text that differs when it does. */
const shown = async () =>
  (await page.locator('.armature-canvas canvas').screenshot()).toString('base64');
const still = () =>
  until('the puppet rests', async () => !(await page.getByText('Poses …').count()));
const pressed = async (name) => (await button(name).getAttribute('aria-pressed')) === 'true';

const program = (...words) =>
  execFileSync(join(bin, 'keypose'), words, { stdio: ['ignore', 'ignore', 'inherit'] });

/** A take of the command line, in a folder in which no session was held. */
async function early() {
  mkdirSync(join(folder, 'armature'), { recursive: true });
  const example = join(folder, 'armature/example');
  program('armature', 'example', '--folder', example, '--vertices', '3000');
  const from = ['--description', join(example, 'theropod.txt'), '--port', 'simulated'];
  const to = ['--session', join(folder, 'armature/early'), '--frames', '4', '--step', '2'];
  program('armature', 'record', ...from, ...to);
  page = await openPage((tab) => tab.setDefaultTimeout(1000 * kPatience_s));
  await page.getByRole('link', { name: 'Armature' }).click();
  await page.getByRole('link', { name: 'early' }).click();
  await page.locator('.take-page').waitFor();
  await page.getByText('/ 7').waitFor();
  check((await page.locator('.take-joints li').count()) === 74, 'not all joints are listed');
  // Its character, plate and set were found.
  await button('Set').waitFor();
  await page.getByAltText('Plate 1').waitFor();
  await record(page, 'take_early', options.pictures);
  await page.getByRole('link', { name: 'Armature' }).first().click();
}

async function enter() {
  await button('Use the example').click();
  await until('the form is filled', async () => (await field('Description').inputValue()) !== '');
  await field('Take').fill('walk');
  await button('Begin').click();
  await page.locator('.armature-page').waitFor();
  for (let frame = 0; frame < kFrames; ++frame) {
    await page.keyboard.press('Space');
    await page.getByText(`Frame ${frame + 1} is next`).waitFor();
  }
}

async function look() {
  await page.getByRole('link', { name: 'Edit the take' }).click();
  await page.locator('.take-page').waitFor();
  await page.getByText(`/ ${2 * kFrames - 1}`).waitFor();
  check((await page.locator('.take-joints li').count()) === 74, 'not all joints are listed');
  await field('Find a joint').fill('kneeb');
  check((await page.locator('.take-joints li').count()) === 2, 'the list is not filtered');
  await page.locator('.take-joints button', { hasText: kJoint }).click();
  await page.getByRole('heading', { name: kJoint }).waitFor();
  check(near(await value(), degrees('walk', kJoint)[0]), 'it is not the recorded value');
  const first = await shown();
  await page.keyboard.press('ArrowRight');
  await page.keyboard.press('.');
  await page.keyboard.press('ArrowRight');
  await page.getByText('in frame 3', { exact: false }).waitFor();
  check(near(await value(), degrees('walk', kJoint)[3]), 'the playhead is not at frame 3');
  await until('the puppet is posed as the frame', async () => (await shown()) !== first);
  await field('Find a joint').fill('');
  const others = page.locator('.take-joints li:not(:has([aria-pressed="true"])) input:checked');
  while (await others.count()) await others.first().uncheck();
}

/** Where the level of a recorded frame is: the pointer says so. */
async function levelOf(frame) {
  const box = await boxOf(plot());
  const wide = await page.locator('.tl-playhead').evaluate((one) => parseFloat(one.style.width));
  const x = box.x + (2 * frame + 1) * wide;
  for (let y = box.y + 4; y < box.y + box.height - 4; y += 4) {
    await page.mouse.move(x, y);
    const cursor = await plot().evaluate((one) => one.style.cursor);
    if (cursor === 'ns-resize') return { x, y: y + 8 };
  }
  throw new Error('no level can be taken hold of');
}

async function pull() {
  const before = await value();
  const puppet = await shown();
  const { x, y } = await levelOf(3);
  await page.mouse.down();
  await page.mouse.move(x, y + 20, { steps: 4 });
  await page.mouse.move(x, y + 45, { steps: 4 });
  await page.locator('.take-tip').waitFor();
  await until('the puppet follows the pull', async () => (await shown()) !== puppet);
  await page.mouse.up();
  await still();
  check((await value()) < before - 1, `the value was not pulled down: ${before}, ${await value()}`);
  await tab('1 change').waitFor();
  await record(page, 'take_pulled', options.pictures);
  const pulled = await value();
  await page.keyboard.press('Control+z');
  await until('it is undone', async () => near(await value(), before));
  await button('Redo').click();
  await until('it is done again', async () => near(await value(), pulled));
  await page.keyboard.press('Control+z');
  await until('it is undone again', async () => near(await value(), before));
}

/** A knee does not bend to the other side: said in words, and the value stops there. */
async function stops() {
  const number = field(`Value of ${kJoint} in recorded frame 3`);
  await number.fill('30');
  await number.press('Enter');
  await page.getByText(`${kJoint} stops at -150° and 0°.`).waitFor();
  await until('it stops at 0', async () => (await value()) === 0);
  await number.fill('-41.5');
  await number.press('Enter');
  await until('it is set', async () => (await value()) === -41.5);
  await plot().focus();
  for (const key of ['ArrowUp', 'ArrowUp', 'ArrowUp']) await page.keyboard.press(key);
  await until('it is nudged', async () => (await value()) === -38.5);
  await still();
  await page.keyboard.press('Control+z');
  await until('three presses are undone at once', async () => (await value()) === -41.5);
}

/** Frames 3 to 5 stand as 3, then go a frame later; 8 is taken out, 0 shown longer. */
async function dopeSheet() {
  const before = degrees('walk', kJoint);
  await page.keyboard.press('Shift+ArrowRight');
  await page.keyboard.press('Shift+ArrowRight');
  check((await field('Last frame that is changed').inputValue()) === '5', '5 is not selected');
  await page.keyboard.press('h');
  await still();
  await button('All joints').click();
  await page.keyboard.press(']');
  await still();
  check((await field('First frame that is changed').inputValue()) === '4', 'the selection stays');
  await page.keyboard.press('Escape');
  await field('First frame that is changed').fill('8');
  await field('First frame that is changed').press('Enter');
  await field('Last frame that is changed').fill('8');
  await field('Last frame that is changed').press('Enter');
  await button('Take out Del').click();
  await page.getByText(`/ ${2 * kFrames - 3}`).waitFor();
  await page.keyboard.press('Home');
  await page.getByText('in frame 0', { exact: false }).waitFor();
  await page.keyboard.press('d');
  await page.getByText(`/ ${2 * kFrames - 1}`).waitFor();
  await tab(/changes/).click();
  await page.getByText('all joints, frames 3-5: 1 later').waitFor();
  await record(page, 'take_changed', options.pictures);
  await tab('Joints').click();
  // Once more 0; 3 as 2, then what was pulled and held; without 8.
  return [before[0], ...before.slice(0, 3), before[2], -41.5, -41.5, -41.5, before[7], before[9]];
}

async function onesAndTwos() {
  await page.keyboard.press('1');
  await until('it is on ones', () => pressed('Ones'));
  await page.getByText(`/ ${2 * kFrames - 1}`).waitFor();
  await still();
  await button('Undo').click();
  await until('on twos again', () => pressed('Twos'));
}

const film = () => page.locator('.tl-now').textContent();

/** With the pictures between, which are neither the one before nor the one after. */
async function asBaked() {
  await page.keyboard.press('b');
  await until('it is at even pace', () => pressed('Even'));
  await page.keyboard.press('b');
  await until('it is smooth', () => pressed('Smooth'));
  await page.getByText(`/ ${2 * (kFrames - 1)}`).waitFor();
  await still();
  await page.keyboard.press('Home');
  await page.keyboard.press('.');
  await until('frame 2', async () => (await film()) === '2');
  const pictures = [await shown()];
  for (const frame of ['3', '4']) {
    await button('A frame on').click();
    await until(`frame ${frame}`, async () => (await film()) === frame);
    await page.waitForTimeout(700);
    pictures.push(await shown());
  }
  check(new Set(pictures).size === 3, 'the picture between is one of those beside it');
  await record(page, 'take_smooth', options.pictures);
}

async function held() {
  await button('Held').click();
  await page.getByText(`/ ${2 * kFrames - 1}`).waitFor();
}

async function play() {
  await page.keyboard.press('Home');
  await page.locator('.take-page').click({ position: { x: 300, y: 300 } });
  const seen = new Set();
  await page.keyboard.press('Space');
  await until('it plays', async () => {
    seen.add(await page.locator('.tl-now').textContent());
    return seen.size > 4;
  });
  await page.keyboard.press('Space');
}

async function loadedAgain() {
  await page.reload();
  await page.locator('.take-page').waitFor();
  await tab('6 changes').waitFor();
}

async function save(wanted) {
  const before = readFileSync(join(folder, 'armature/walk/curves.json'), 'utf8');
  await page.keyboard.press('Control+s');
  await until('a name is offered', async () => (await field('New take').inputValue()) === 'walk_2');
  await field('New take').fill('walk');
  await page.getByText('There is a take walk already.').waitFor();
  await field('New take').fill('walk_2');
  await record(page, 'take_save', null);
  await page.keyboard.press('Enter');
  await page.getByRole('heading', { name: 'walk_2' }).waitFor();
  await tab('Changes').waitFor();
  check(
    readFileSync(join(folder, 'armature/walk/curves.json'), 'utf8') === before,
    'the recorded take was changed',
  );
  const made = degrees('walk_2', kJoint);
  check(
    made.length === wanted.length && made.every((one, f) => near(one, wanted[f])),
    `other values were saved:\n${made}\n${wanted}`,
  );
}

function bakedFrames(take) {
  const names = readdirSync(join(folder, 'armature', take, 'frames'));
  return names.filter((name) => name.endsWith('.ply')).length;
}

async function bakeAs(between) {
  await tab('Bake').click();
  await field('Baked, between recorded frames').selectOption(between);
  await button('Bake').click();
  await page.getByText('The frames are baked.').waitFor();
}

async function bake() {
  await bakeAs('smooth');
  const count = bakedFrames('walk_2');
  check(count === 2 * (kFrames - 1) + 1, `${count} frames are baked`);
  check(await pressed('Smooth'), 'what is played is not what was baked');
}

const pipelineFile = join(folder, 'pipeline.yaml');

/** Baked frames in the project: its file is made, a run makes the film, and the file goes again. */
async function project() {
  await button('Export with the project').click();
  await page.getByText('is a step of the project').waitFor();
  const text = readFileSync(pipelineFile, 'utf8');
  const step = /export_walk_2: .*frames: \.\/armature\/walk_2\/frames/;
  check(step.test(text), `written:\n${text}`);
  await page.getByRole('link', { name: 'Report & export' }).waitFor();
  check((await page.getByRole('link', { name: 'Timeline' }).count()) === 0, 'a page of poses');
  await button('Run export_walk_2').click();
  // A film is rendered.
  await page.getByText('Made:').waitFor({ timeout: 4000 * kPatience_s });
  for (const name of ['character.glb', 'character.mp4'])
    check(existsSync(join(folder, 'out/takes/walk_2', name)), `no ${name}`);
  await page.getByText('The run is done.').waitFor({ state: 'detached' });
  await record(page, 'take_project', options.pictures);
  await button('Take export_walk_2 out').click();
  await until('the file is gone', () => !existsSync(pipelineFile));
  await button('Export with the project').waitFor();
}

/** A lamp from the left, in pipeline.yaml. */
async function lightIt() {
  await field('Lamp').fill('60');
  await field('Lamp').dispatchEvent('change');
  const dial = page.getByRole('slider', { name: 'Where the lamp stands' });
  const box = await boxOf(dial);
  await page.mouse.click(box.x + 0.2 * box.width, box.y + 0.5 * box.height);
  await page.getByText('The lamp from the left').waitFor();
  const said = () => readFileSync(pipelineFile, 'utf8');
  await until('the lamp is in pipeline.yaml', () => /lamp: 0.6.*lamp_from: -90/s.test(said()));
  await record(page, 'take_lamp', options.pictures);
}

/** The other take over its plate, under a lamp. */
async function overPlate() {
  const example = join(folder, 'armature/example');
  const [plain, unwrapped] = [join(example, 'theropod.ply'), join(example, 'it.obj')];
  program('unwrap', '--clean', plain, '--unwrapped', unwrapped);
  writeFileSync(join(example, 'skin.png'), plainPng(64, [120, 140, 90]));
  await page.goto(page.url().replace(/#.*/, '#/armature/early'));
  await page.locator('.take-page').waitFor();
  await button('Files…').click();
  await field('Character').fill('armature/example/it.obj');
  await field('Texture').fill('armature/example/skin.png');
  await record(page, 'take_files', options.pictures);
  await button('Open the take').click();
  await page.locator('.take-page').waitFor();
  await bakeAs('hold');
  await button('Put over its plate').click();
  await page.getByText('is a step of the project').waitFor();
  await lightIt();
  program('run', '-C', folder);
  await page.getByText('Made:').waitFor();
  const pictures = join(folder, 'out/takes/early_pictures');
  const made = readdirSync(pictures).filter((name) => /^\d+\.png$/.test(name));
  check(made.length === 8 && bakedFrames('early') === 8, `${made.length} pictures`);
  const before = readPng(readFileSync(join(example, 'plate.png')));
  const after = readPng(readFileSync(join(pictures, made[0])));
  const apart = (a, b) => Math.max(...a.map((value, k) => Math.abs(value - b[k])));
  const covered = before.rgb.filter((pixel, i) => apart(pixel, after.rgb[i]) > 25).length;
  const share = covered / before.rgb.length;
  console.log(`    the puppet covers ${(100 * share).toFixed(1)} % of its plate`);
  check(share > 0.02 && share < 0.5, 'the puppet is not over its plate');
  const darker = (pixel, now) => now.every((value, k) => value < 0.9 * pixel[k] && value * 3 > pixel[k]);
  const like = ([r, g, b]) => r > 1.4 * b && g < r; // the wooden table, also in shadow
  const dark = before.rgb.filter((pixel, i) => like(pixel) && like(after.rgb[i]) && darker(pixel, after.rgb[i]));
  console.log(`    its shadow covers ${((100 * dark.length) / before.rgb.length).toFixed(1)} %`);
  check(dark.length / before.rgb.length > 0.003, 'the puppet throws no shadow');
  await button('Take composite_early out').click();
  await until('the file is gone', () => !existsSync(pipelineFile));
}

async function takes() {
  await page.getByRole('link', { name: 'Armature' }).first().click();
  await button('End').click();
  await button('Go on with walk').waitFor();
  await page.getByRole('link', { name: 'walk_2' }).waitFor();
  await record(page, 'takes', options.pictures);
  browser.expected = /take\/(open|setup)/;
  await page.goto(page.url().replace(/#.*/, '#/armature/nobody'));
  await page.getByRole('heading', { name: 'nobody cannot be shown' }).waitFor();
  await page.getByRole('link', { name: 'Back to the armature' }).click();
  await page.getByRole('link', { name: 'walk', exact: true }).click();
  await page.locator('.take-page').waitFor();
}

let wanted = [];
await walkThrough({
  early,
  enter,
  look,
  pull,
  stops,
  'dope sheet': async () => {
    wanted = await dopeSheet();
  },
  'ones and twos': onesAndTwos,
  'as baked': asBaked,
  play,
  held,
  'loaded again': loadedAgain,
  save: () => save(wanted),
  bake,
  project,
  'over its plate': overPlate,
  takes,
});
