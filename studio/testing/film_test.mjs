// The film's dialogue: side, height, lens, light, background and size, with the figure as the film
// shows it; kept in pipeline.yaml, and what the export renders.
//
//   node film_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { spawnSync } from 'node:child_process';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { readPng } from './png.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('film', 'bean');
let page;

/** A round thing, longer along x by `stretch`. */
function beanObj(stretch) {
  const [around, along] = [24, 12];
  const lines = [`v ${-stretch} 0 0`];
  for (let i = 1; i < along; ++i)
    for (let k = 0; k < around; ++k) {
      const [a, b] = [(Math.PI * i) / along, (2 * Math.PI * k) / around];
      lines.push(`v ${-stretch * Math.cos(a)} ${Math.sin(a) * Math.cos(b)} ${Math.sin(a) * Math.sin(b)}`);
    }
  lines.push(`v ${stretch} 0 0`);
  const at = (i, k) => 2 + (i - 1) * around + (k % around);
  const last = 2 + (along - 1) * around;
  for (let k = 0; k < around; ++k) {
    lines.push(`f 1 ${at(1, k + 1)} ${at(1, k)}`, `f ${last} ${at(along - 1, k)} ${at(along - 1, k + 1)}`);
    for (let i = 1; i + 1 < along; ++i)
      lines.push(
        `f ${at(i, k)} ${at(i, k + 1)} ${at(i + 1, k + 1)}`,
        `f ${at(i, k)} ${at(i + 1, k + 1)} ${at(i + 1, k)}`,
      );
  }
  return lines.join('\n') + '\n';
}

const pipeline = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const dialog = () => page.getByRole('dialog', { name: 'The film' });

async function begin() {
  writeFileSync(join(scratch, 'rest.obj'), beanObj(1.5));
  const words = ['init', folder, '--pose', `rest=${join(scratch, 'rest.obj')}`];
  for (const one of [words, ['run', '-C', folder, '--until', 'unwrap']]) {
    const { status, stderr } = spawnSync(join(bin, 'keypose'), one, { encoding: 'utf8' });
    check(status === 0, stderr);
    if (one !== words) continue;
    check(!/^fps:/m.test(pipeline()), pipeline());
    writeFileSync(join(folder, 'pipeline.yaml'), `${pipeline()}\nfps: 4\n`); // few pictures
  }
  page = await openPage();
  await page.getByRole('link', { name: 'Report & export' }).click();
  await page.getByRole('button', { name: 'Set up the film …' }).click();
  await dialog().waitFor();
}

/** The share of the preview, across and down, that the figure covers. */
async function covered() {
  const box = await boxOf(dialog().locator('.film-frame'));
  const { rgb, width, height } = readPng(await page.screenshot({ clip: box }));
  const ground = rgb[5 * width + 5];
  const is = (i) => rgb[i].some((value, k) => Math.abs(value - ground[k]) > 12);
  const across = [...Array(width).keys()].filter((x) => x > 3 && x < width - 3).filter((x) => {
    for (let y = 4; y < height - 4; ++y) if (is(y * width + x)) return true;
    return false;
  });
  return { across: across.length / width, ground };
}

async function setUp() {
  // rest is 3 long and 2 high: seen from the side it fills nine tenths across, without its shadow.
  await dialog().getByLabel('A shadow on the table').uncheck();
  await until('the side is shown', async () => Math.abs((await covered()).across - 0.9) < 0.03);
  await dialog().getByLabel('Side', { exact: true }).fill('90');
  await until('the end is shown', async () => (await covered()).across < 0.75);
  await dialog().getByLabel('Height', { exact: true }).fill('30');
  await dialog().getByLabel('Background', { exact: true }).selectOption('green');
  await until('the ground is green', async () => (await covered()).ground.join() === '0,177,64');
  await dialog().getByLabel('Size', { exact: true }).selectOption({ label: 'Square, 1080 × 1080' });
  const box = await boxOf(dialog().locator('.film-frame'));
  check(Math.abs(box.width - box.height) < 3, `not square: ${box.width} x ${box.height}`);
  await record(page, 'film', options.pictures);
  await dialog().getByRole('button', { name: 'Save' }).click();
  await dialog().waitFor({ state: 'detached' });
  for (const one of ['video_azimuth: 90', 'video_elevation: 30', 'video_background: green', 'video_width: 1080',
    'video_height: 1080', 'video_shadow: false'])
    check(pipeline().includes(one), `no ${one} in\n${pipeline()}`);
  check(!pipeline().includes('video_fov'), 'what was not touched is not written');
}

async function exported() {
  await page.getByRole('checkbox', { name: /^glTF/ }).first().uncheck();
  await page.getByRole('button', { name: 'Export', exact: true }).click();
  const film = join(folder, 'out/animation/character_turntable.mp4');
  await until('the film is made', () => existsSync(film), 300);
  const size = await page.evaluate(async (text) => {
    const bytes = Uint8Array.from(atob(text), (one) => one.charCodeAt(0));
    const shown = document.createElement('video');
    shown.src = URL.createObjectURL(new Blob([bytes], { type: 'video/mp4' }));
    await new Promise((done, failed) => {
      shown.onloadeddata = done;
      shown.onerror = () => failed(new Error('no film'));
    });
    shown.currentTime = 0.5;
    await new Promise((done) => (shown.onseeked = done));
    const canvas = document.createElement('canvas');
    [canvas.width, canvas.height] = [shown.videoWidth, shown.videoHeight];
    const context = canvas.getContext('2d');
    context.drawImage(shown, 0, 0);
    return [canvas.width, canvas.height, ...context.getImageData(20, 20, 1, 1).data];
  }, readFileSync(film).toString('base64'));
  check(size[0] === 1080 && size[1] === 1080, `${size}`);
  check([0, 177, 64].every((value, k) => Math.abs(size[2 + k] - value) < 6), `its corner is ${size}`);
}

await walkThrough([
  ['the figure in the dialogue', begin],
  ['side, height, background, size', setUp],
  ['the export renders that', exported],
]);
