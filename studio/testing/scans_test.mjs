// Two real scans, the Hellidropter of the paper's Figure 14: ten landmarks by clicks, three
// suggestions, a registration whose pairs come closer; five seconds played at 20,000 faces; a mesh
// of 300,000 faces loaded, turned and picked on. Figures are printed.
//
//   node scans_test.mjs BIN_DIR [--pictures DIR] [--keep] [--only play,load]
//
// `--only` names the parts to walk through: landmarks, play, load, pickMany.
//
// The scans are in KEYPOSE_DATA (default: ../shared/data beside the project); without them the test
// is skipped (exit code 77).
import { execFileSync } from 'node:child_process';
import {
  copyFileSync,
  existsSync,
  mkdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';
import { meshOf } from './walk_geometry.mjs';
import { Landmarks } from './walk_landmarks.mjs';

const { bin, options, folder, openPage, walkThrough } = withStudio('scans', 'hellidropter', {
  only: { type: 'string', default: 'landmarks,play,load,pickMany' },
});
const wanted = new Set(['prepare', ...options.only.split(',')]);
const source = resolve(dirname(fileURLToPath(import.meta.url)), '../..');
const scans = join(process.env.KEYPOSE_DATA ?? join(source, '../shared/data'), 'scans');
let page;

/** Few faces for the eye that finds what is visible; as many as the issue asks for elsewhere. */
const kPickFaces = 3000;
const kPlayFaces = 20000;
const kManyFaces = 300000;
const kPlaySeconds = 5;
const kFps = 24;
const kPicks = 10;
/**
 * Shares of the diagonal. Without landmarks the propeller lands a quarter turn off,
 * docs/results/registration.md.
 */
const kPairsAfter = 0.015;
const kLoad_ms = 3000;
const kTurn_fps = 30;
const kClicks = 49;
const kPick_ms = 5;

const scanNames = { rest: 'Hellidropter1.obj', bent: 'Hellidropter2.obj' };
const go = (place) => page.evaluate((to) => void (location.hash = to), place);
const keypose = (...words) =>
  execFileSync(join(bin, 'keypose'), words, {
    cwd: folder,
    stdio: ['ignore', 'ignore', 'inherit'],
  });

/** Scans instead of photographs: the steps before cleanup are switched off. */
function pipelineFor(faces) {
  const off = ['capture', 'sfm', 'masks', 'dense', 'mesh', 'refine', 'bake', 'complete', 'report'];
  return `name: hellidropter
poses: {rest: photos/rest, bent: photos/bent}
template: rest
timeline: [{pose: rest, at: 0}, {pose: bent, at: ${kPlaySeconds}}]
fps: ${kFps}
options: {cleanup: {faces: ${faces}, refine: true, ground: keep, support: keep, genus: -1}}
steps:
${off.map((step) => `  ${step}: {enabled: false}`).join('\n')}
  cleanup:
    inputs:
      surface: {template: ./scans/${scanNames.rest}, others: ./scans/${scanNames.bent}}
      images: null
      model: null
  export: {inputs: {textures: null}}
`;
}

/** The positions of an OBJ's vertices, in the file's order. */
const verticesOf = (file) =>
  readFileSync(file, 'utf8')
    .split('\n')
    .filter((line) => line.startsWith('v '))
    .map((line) => line.split(/\s+/).slice(1, 4).map(Number));

class Scans extends Landmarks {
  /** The docs' own picks are pairs of the scans' vertices; the meshes lie where the scans do. */
  async load() {
    const pairs = readFileSync(join(source, 'docs/results/hellidropter_landmarks.txt'), 'utf8')
      .trim()
      .split('\n')
      .map((line) => line.split(/\s+/).map(Number));
    check(pairs.length === kPicks, `${pairs.length} picks in the docs`);
    this.tilts = [0, 4, -6, 8, -10];
    this.meshes = {};
    this.places = {};
    for (const [column, pose] of Object.keys(scanNames).entries()) {
      const what = pose === 'rest' ? 'mesh' : 'clean';
      this.meshes[pose] = meshOf(
        await (await this.ask(`/api/mesh?pose=${pose}&what=${what}`)).body(),
      );
      const vertices = verticesOf(join(scans, scanNames[pose]));
      this.places[pose] = new Map(pairs.map((pair, i) => [`p${i + 1}`, vertices[pair[column]]]));
    }
  }

  async choose() {
    const names = [...this.places.rest.keys()];
    const seen = [];
    for (const name of names)
      if (
        (await this.turnsFor('rest', name)) !== null &&
        (await this.turnsFor('bent', name)) !== null
      )
        seen.push(name);
    return seen;
  }
}

async function prepare() {
  mkdirSync(join(folder, 'scans'), { recursive: true });
  for (const pose of Object.keys(scanNames)) {
    mkdirSync(join(folder, 'photos', pose), { recursive: true });
    copyFileSync(join(scans, scanNames[pose]), join(folder, 'scans', scanNames[pose]));
  }
  writeFileSync(join(folder, 'pipeline.yaml'), pipelineFor(kPickFaces));
  keypose('run', '--until', 'register');
  page = await openPage(async (tab) => {
    // How long the page's own work takes for each picture, apart from a graphics card or what stands
    // for one.
    await tab.addInitScript(() => {
      globalThis.frameTimes = [];
      const ask = globalThis.requestAnimationFrame.bind(globalThis);
      globalThis.requestAnimationFrame = (act) =>
        ask((time) => {
          const began = performance.now();
          act(time);
          globalThis.frameTimes.push({ time, ms: performance.now() - began });
        });
    });
  });
  await page.locator('main').waitFor();
}

const context = () => ({ page, folder, go, pictures: options.pictures });
const pairsFigure = (when) =>
  page
    .locator('.lm-fit dt', { hasText: 'Pairs' })
    .locator(`xpath=following-sibling::dd[1]//*[contains(@class, "${when}")]//span`)
    .textContent();

async function landmarks() {
  await go('#/landmarks');
  await until(
    'both meshes are shown',
    async () =>
      (await page.locator('.lm-wait').count()) === 0 &&
      (await page.locator('.lm-drop canvas').count()) === 2,
  );
  const walk = new Scans(context());
  await walk.load();
  await page.getByRole('button', { name: 'Turn together' }).click();
  await walk.whole();
  await walk.pickPairs();
  const picked = await walk.pairs();
  check(picked >= kPicks, `only ${picked} of ${kPicks} landmarks were picked`);
  await suggestions(walk, picked);
  await page.getByRole('button', { name: 'Lay the net on bent' }).click();
  await page.getByRole('button', { name: 'Lays the net …' }).waitFor();
  await until(
    'the fit before and after is shown',
    async () =>
      (await walk.figures('before')).length === 3 && (await walk.figures('after')).length === 3,
    400,
  );
  const [before, after] = [await pairsFigure('before'), await pairsFigure('after')];
  console.log(
    `    pairs apart: ${before} before, ${after} after; distance to the scan: ` +
    `${(await walk.figures('before')).slice(0, 2)} before, ` +
    `${(await walk.figures('after')).slice(0, 2)} after`,
  );
  const [was, is] = [before, after].map((text) => parseFloat(text) / 100);
  check(
    is < was && is < kPairsAfter,
    `the pairs are ${after} of the diagonal apart after the registration, ${before} before`,
  );
  await record(page, 'scans', options.pictures);
}

async function suggestions(walk, picked) {
  await page.getByRole('button', { name: 'Suggest' }).click();
  await until('suggestions are there', () => page.locator('.lm-suggested li').count(), 300);
  for (let i = 1; i <= 3; ++i) {
    await page.getByRole('button', { name: 'Accept suggestion 1', exact: true }).click();
    await until(`suggestion ${i} is accepted`, async () => (await walk.pairs()) === picked + i);
  }
  const refuse = page.getByRole('button', { name: 'Refuse all' });
  if (await refuse.count()) await refuse.click();
  await until('the file has them', async () => (await walk.picks('bent')).length === picked + 3);
}

const quantile = (values, share) =>
  [...values].sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(share * values.length))];

/** Makes the frames of another number of faces, and waits until the page has noticed. */
async function remake(faces, until_step) {
  rmSync(join(folder, 'landmarks'), { recursive: true, force: true });
  writeFileSync(join(folder, 'pipeline.yaml'), pipelineFor(faces));
  keypose('run', '--until', until_step);
}

async function play() {
  await remake(kPlayFaces, 'interpolate');
  await go('#/timeline');
  await page.reload();
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  const frames = await (await page.request.get(new URL('/api/frames', page.url()).href)).json();
  const mesh = meshOf(
    await (
      await page.request.get(new URL('/api/mesh?pose=rest&what=mesh', page.url()).href)
    ).body(),
  );
  check(Math.abs(mesh.faces - kPlayFaces) < 0.02 * kPlayFaces, `the mesh has ${mesh.faces} faces`);
  check(frames.count === kFps * kPlaySeconds + 1, `${frames.count} frames`);
  await until('the picture is drawn', () => page.evaluate(() => globalThis.frameTimes.length > 3));
  await page.waitForTimeout(1500);
  await page.keyboard.press('Home');
  await page.evaluate(() => void (globalThis.frameTimes.length = 0));
  await page.getByRole('button', { name: 'Play', exact: true }).click();
  await page.waitForTimeout(1000 * kPlaySeconds);
  const drawn = await page.evaluate(() => {
    const { width, clientWidth } = document.querySelector('.view canvas');
    return width / clientWidth;
  });
  await page.getByRole('button', { name: 'Pause', exact: true }).click();
  const dropped = Number(await page.locator('main').getAttribute('data-dropped'));
  const times = (await page.evaluate(() => globalThis.frameTimes)).map((one) => one.ms);
  const most = Math.max(...times);
  console.log(
    `    ${kPlaySeconds} s at ${kFps} fps, ${mesh.faces} faces: ${times.length} animation ` +
    `frames, script time median ${quantile(times, 0.5).toFixed(2)} ms, 99 % ` +
    `${quantile(times, 0.99).toFixed(2)} ms, most ${most.toFixed(1)} ms; ` +
      `${dropped} of ${kFps * kPlaySeconds} frames dropped with a software renderer, which drew ` +
      `${drawn.toFixed(2)} of the pixels along each side at the end`,
  );
  check(
    quantile(times, 0.99) < 1000 / kFps,
    `a frame takes ${quantile(times, 0.99)} ms of script time`,
  );
}

async function load() {
  await remake(kManyFaces, 'unwrap');
  await go('#/run');
  await page.reload();
  await page.locator('main').waitFor();
  await page.waitForTimeout(1500);
  const began = Date.now();
  await go('#/poses/rest/3d');
  await page
    .getByText(/\d faces · .* vertices/)
    .first()
    .waitFor();
  await page.evaluate(
    () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
  );
  const ms = Date.now() - began;
  const words = await page.locator('.caption-chip').first().textContent();
  const faces = Number(/([\d,]+) faces/.exec(words)[1].replaceAll(',', ''));
  check(faces > 0.97 * kManyFaces, `the mesh has ${faces} faces`);
  const turn_ms = await turn();
  console.log(
    `    ${faces} faces: shown after ${ms} ms; turning takes ${turn_ms.toFixed(2)} ms of script ` +
    `time a picture`,
  );
  check(ms < kLoad_ms, `${faces} faces took ${ms} ms`);
  check(turn_ms < 1000 / kTurn_fps, `turning takes ${turn_ms} ms a picture`);
}

/** Clicks all over the template of as many faces; those that meet it are picks. */
async function pickMany() {
  await go('#/landmarks');
  await until(
    'both meshes are shown',
    async () =>
      (await page.locator('.lm-wait').count()) === 0 &&
      (await page.locator('.lm-drop canvas').count()) === 2,
    60,
  );
  const canvas = page.getByRole('region', { name: 'rest: 3D view' }).locator('canvas');
  await page.waitForTimeout(1500);
  const box = await boxOf(canvas);
  const times = [];
  for (let i = 0; i < kClicks; ++i) {
    await page.locator('main').evaluate((one) => void (one.dataset.pickMs = ''));
    const [x, y] = [(i % 7) + 1, Math.floor(i / 7) + 1].map((k) => k / 8);
    await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
    const told = await page.locator('main').getAttribute('data-pick-ms');
    if (told) times.push(Number(told));
  }
  const most = Math.max(...times);
  console.log(
    `    ${times.length} picks on the template: median ${quantile(times, 0.5).toFixed(2)} ms, ` +
    `most ${most.toFixed(2)} ms`,
  );
  check(times.length >= 5, `only ${times.length} of ${kClicks} clicks met the figure`);
  check(quantile(times, 0.5) < kPick_ms, `a pick takes ${quantile(times, 0.5)} ms`);
}

async function turn() {
  const box = await boxOf(page.locator('.view canvas'));
  await page.evaluate(() => void (globalThis.frameTimes.length = 0));
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  for (let i = 1; i <= 40; ++i)
    await page.mouse.move(box.x + box.width / 2 + 4 * i, box.y + box.height / 2);
  await page.mouse.up();
  const times = (await page.evaluate(() => globalThis.frameTimes)).map((one) => one.ms);
  check(times.length > 5, `only ${times.length} pictures were drawn while turning`);
  return quantile(times, 0.95);
}

if (!existsSync(join(scans, scanNames.rest))) {
  console.log(`skipped: ${scans} has no Hellidropter`);
  process.exit(77);
}
const parts = { prepare, landmarks, play, load, pickMany };
await walkThrough(Object.entries(parts).filter(([part]) => wanted.has(part)));
