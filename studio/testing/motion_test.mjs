// A performance on the studio's page: films of a generated actor, "Run until the motion", the moving
// mesh played, scrubbed and stepped; then painted from the films, its colours in step with the
// frames; then a scan that moves with it and has a texture of its own.
//
//   node motion_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import { appendFileSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng } from './png.mjs';
import { check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('motion', 'dance');
const world = join(scratch, 'world');
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
    '--video3d',
  ]);
  // Larger than a machine without a graphics card plays.
  const pipelineFile = join(folder, 'pipeline.yaml');
  const larger = 'video3d: {enabled: true, options: {texture_size: 1024}}';
  const text = readFileSync(pipelineFile, 'utf8').replace('video3d: {enabled: true}', larger);
  check(text.includes(larger), `init --video3d has written:\n${text}`);
  writeFileSync(pipelineFile, text);
  page = await openPage();
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

/** Where the figure is, without what lies over it. */
const kFigure = { x: 300, y: 80, width: 680, height: 500 };
const drawn = async () => (await page.screenshot({ clip: kFigure })).toString('base64');

/** Share of the figure's pixels that a test of [red, green, blue] is true of. */
async function shareOf(test) {
  const { rgb } = readPng(await page.screenshot({ clip: kFigure }));
  const ground = rgb[0];
  const apart = (one) => Math.max(...one.map((value, k) => Math.abs(value - ground[k])));
  const figure = rgb.filter((one) => apart(one) > 24);
  check(figure.length > 2000, `a figure of ${figure.length} pixels`);
  return figure.filter(test).length / figure.length;
}
const isColoured = (one) => Math.max(...one) - Math.min(...one) > 36;
const isMagenta = ([red, green, blue]) => red > 150 && blue > 150 && green < 90;

const shownWords = () => page.locator('.motion-shown').textContent();
const colour = (name) =>
  page.getByRole('group', { name: 'Colours of the figure' }).getByRole('button', { name });

/** The picture of a figure that has come to rest; '' while something changes. */
async function still() {
  await shareOf(isColoured);
  const one = await drawn();
  await page.waitForTimeout(500);
  return (await drawn()) === one ? one : '';
}

async function play() {
  const first = await until('the figure is drawn and rests', still);
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
  check((await shownWords()).startsWith('Grey'), await shownWords());
  check((await colour('From the video').isDisabled()) && (await colour('Scan').isDisabled()), 'on');
  check((await shareOf(isColoured)) < 0.01, 'a grey figure has colours');
}

/** What the films are painted with, over the frames. */
async function paint() {
  await page.getByText('No colours of the video: not painted yet').waitFor();
  await record(page, 'motion_unpainted', options.pictures);
  await button('Paint from the films').click();
  await until('it is painted', () => colour('From the video').isEnabled(), 300);
  await until('its texture is there', async () => /the texture of frame/.test(await shownWords()));
  await button('First frame').click();
  const whole = /^From the video: the texture of frame 0, 1024 × 1024$/;
  await until('all of its pixels', async () => whole.test(await shownWords()));
  await record(page, 'motion', options.pictures);
  await colour('Grey').click();
  await until('it is grey', async () => (await shareOf(isColoured)) < 0.01);
  await page.keyboard.press('c');
  await until('it has colours', async () => (await shareOf(isColoured)) > 0.5);
  console.log(`    ${await shownWords()}; ${((await shareOf(isColoured)) * 100).toFixed(0)} % coloured`);
}

/** The last frame that each repaint showed, and the words beside it. */
const watchPlaying = (ms) =>
  page.evaluate(async (length) => {
    const seen = [];
    const text = (name) => document.querySelector(name).textContent;
    for (const end = performance.now() + length; performance.now() < end; ) {
      await new Promise(requestAnimationFrame);
      seen.push([Number(text('.motion-reading').split(' /')[0]), text('.motion-shown')]);
    }
    return seen;
  }, ms);

async function playInColours() {
  await button('First frame').click();
  await button('Play').click();
  await until('it plays', async () => (await frame()) > 0);
  const seen = await watchPlaying(3000);
  await button('Pause').click();
  const late = seen.filter(([, words]) => !/512 × 512 while it plays: a texture for each frame/.test(words));
  const frames = new Set(seen.map(([number]) => number));
  console.log(
    `    ${seen.length} repaints, ${frames.size} frames, ${late.length} with a late texture; ` +
      `${seen.at(-1)[1]}`,
  );
  check(late.length === 0, `textures were late: ${late[0]?.[1]}`);
  check(frames.size === kFrames, `only frames ${[...frames]} were shown`);
  const whole = /^From the video: the texture of frame (\d+), /;
  await until('the whole texture', async () => whole.test(await shownWords()));
  check(Number((await shownWords()).match(whole)[1]) === (await frame()), 'of another frame');
}

/** The tracked body itself as a scan with a texture: what a person would do with the actor's. */
async function ownTexture() {
  const template = join(folder, 'out/walk/template.ply');
  const scan = join(folder, 'hero.obj');
  run('keypose', ['unwrap', '--clean', template, '--unwrapped', scan]);
  const faces = readFileSync(scan, 'utf8').split('\nf ').length - 1;
  const pairs = Array.from({ length: 120 }, (_, i) => {
    const place = { face: Math.floor((i * faces) / 120), barycentric: [0.4, 0.3, 0.3] };
    return { name: `m${i}`, source: place, target: place };
  });
  writeFileSync(join(folder, 'marks.json'), JSON.stringify({ schema: 2, pairs }));
  writeFileSync(join(folder, 'hero.png'), plainPng(64, [220, 30, 220]));
  appendFileSync(join(folder, 'pipeline.yaml'), 'scan: hero.obj\ntexture: hero.png\n');
  await page.getByText('These were painted before something changed').waitFor();
  await button('Paint from the films').click();
  const isDone = async () => {
    const { steps } = await (await page.request.get(new URL('/api/steps', page.url()).href)).json();
    return steps.find((one) => one.id === 'video3d/walk').state === 'done';
  };
  await until('the scan is painted', isDone, 300);
  await until('its own texture is there', () => colour('Scan').isEnabled());
  await colour('Scan').click();
  await until('it wears its own', async () => (await shareOf(isMagenta)) > 0.9);
  check((await shownWords()).startsWith('The scan’s own texture'), await shownWords());
  await button('A frame on').click();
  check((await shareOf(isMagenta)) > 0.9, 'not in the next frame');
  await record(page, 'motion_own', options.pictures);
  await colour('From the video').click();
  await until('it wears the films', async () => (await shareOf(isMagenta)) < 0.1);
}

await walkThrough({ prepare, findMotion, play, paint, playInColours, ownTexture });
