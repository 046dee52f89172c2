// Picks in photographs on the studio's page: a pose of six photographs beside the textured template.
// Pairs begun on either side, the same place in further photographs along the line that the first
// gives, a wrong click seen, undo, names, an editor's change, a fit that takes the picks up.
//
//   node landmarks_test.mjs BIN_DIR [--pictures DIR] [--keep] [--prepared PROJECT]
//
// `--prepared`: a project that --keep has left, instead of the minutes that it takes to make one.
import { execFileSync } from 'node:child_process';
import {
  cpSync,
  existsSync,
  mkdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('landmarks', 'limbs', {
  prepared: { type: 'string' },
});
let page;

const kMarkup = '<img src=x onerror=alert(1)>';
/** How near the page's hints must be to where the fitted model has a place [px]. */
const kNear = 2;

const restFile = join(folder, 'landmarks/rest.json');
const limbsFile = join(folder, 'landmarks/limbs.json');
const pixels = () =>
  existsSync(limbsFile) ? JSON.parse(readFileSync(limbsFile, 'utf8')).pixels : [];
const places = () => JSON.parse(readFileSync(restFile, 'utf8')).landmarks;
const button = (name) => page.getByRole('button', { name, exact: true });
const ask = async (path) => (await page.request.get(new URL(path, page.url()).href)).json();
const photoFit = () => ask('/api/landmarks/photographs?pose=limbs');
const sheet = () => page.locator('.frame-sheet');
const canvas = () => page.locator('.lm-drop canvas');
const shownIn = async (name, image) =>
  (await photoFit()).shown.find((one) => one.name === name && one.image === image);
const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

/** The true surface and cameras stand for a scan, which other tests make. */
function projectText() {
  const off = 'sfm masks dense mesh refine register complete export report'.split(' ');
  return `name: limbs
poses:
  rest: photos/rest
  limbs: {photos: photos/limbs, method: fit}
template: rest
options:
  cleanup: {faces: 5000}
  bake: {texture_size: 1024, hold_out: 0}
  fit: {max_size: 320}
steps:
${off.map((step) => `  ${step}: {enabled: false}`).join('\n')}
  cleanup: {inputs: {surface: ./rest.ply, images: null, model: null}}
  bake:
    inputs:
      mesh: {template: unwrap.unwrapped, fit: fit.fitted}
      images: capture.images
      model: {template: ./cameras, fit: fit.model}
  fit: {inputs: {rig: ./cameras}}
  interpolate: {inputs: {keys: {template: unwrap.unwrapped, fit: fit.fitted}}}
`;
}

const quietly = { stdio: ['ignore', 'ignore', 'inherit'] };

function makeProject() {
  const world = join(scratch, 'world');
  const words = ['photos', '--output', world, '--poses', 'rest,limbs', '--views', '20'];
  const more = ['--few', 'limbs=6', '--width', '640', '--spacing', '0.005'];
  const seeds = ['--seed', '5', '--pose-seed', '5'];
  execFileSync(join(bin, 'keypose-synth'), [...words, ...more, ...seeds], quietly);
  mkdirSync(folder);
  const copy = (from, to) => cpSync(join(world, from), join(folder, to), { recursive: true });
  copy('photos', 'photos');
  copy('truth/rest/cameras', 'cameras');
  copy('truth/rest/surface.ply', 'rest.ply');
  writeFileSync(join(folder, 'pipeline.yaml'), projectText());
  execFileSync(join(bin, 'keypose'), ['run', '-C', folder, '--until', 'fit'], quietly);
}

async function prepare() {
  if (options.prepared) {
    cpSync(options.prepared, folder, { recursive: true });
    rmSync(join(folder, 'landmarks'), { recursive: true, force: true });
  } else makeProject();
  page = await openPage();
  await page.getByRole('link', { name: 'Landmarks', exact: true }).click();
  await until('the template is shown', async () => (await page.locator('.lm-wait').count()) === 0);
  await until('the photograph is shown', () =>
    page.locator('.frame-sheet img').evaluate((one) => one.naturalWidth > 0),
  );
  await page.waitForTimeout(1000);
  check((await page.locator('.ph-side .strip li').count()) === 6, 'the strip has not six pictures');
}

const imageShown = () =>
  page.locator('.ph-side .strip button[aria-current="true"]').getAttribute('title');
const goTo = async (image) => {
  await page.locator(`.ph-side .strip button[title="${image}"]`).click();
  await until(`${image} is shown`, async () =>
    decodeURIComponent(await page.locator('.frame-sheet img').getAttribute('src')).includes(image),
  );
};

/** The place in the window of a pixel of the photograph. */
async function windowOf([x, y]) {
  const box = await boxOf(sheet());
  const image = await imageShown();
  const { width, height } = (await photoFit()).photographs.find((one) => one.name === image);
  return [box.x + (x / width) * box.width, box.y + (y / height) * box.height];
}
const clickPhotograph = async (pixel) => page.mouse.click(...(await windowOf(pixel)));

async function clickTemplate(x, y) {
  const box = await boxOf(canvas());
  await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
}

async function drag(from, to) {
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move((from[0] + to[0]) / 2, (from[1] + to[1]) / 2);
  await page.mouse.move(...to);
  await page.mouse.up();
}

/** Photographs that show the place, by what the last fit says. */
async function seenIn(name) {
  const { shown } = await photoFit();
  return shown.filter((one) => one.name === name && !one.hidden);
}

/** The first pair: the template, then anywhere in a photograph; dragged to where it belongs. */
async function firstPair() {
  await clickTemplate(0.5, 0.3);
  await page.getByText('a: now click the same place in a photograph').waitFor();
  check(!existsSync(limbsFile), 'half a pair was written');
  await clickPhotograph([40, 40]);
  await until('the pair is in both files', () => pixels().length === 1 && places().length === 1);
  const at = await until('the fit has its place', () => shownIn('a', pixels()[0].image));
  await until('its distance is shown', async () =>
    (await page.locator('.lm-state').first().textContent()).includes(
      `${apart(pixels()[0].pixel, at.pixel).toFixed(0)} px`,
    ),
  );
  check((await page.locator('.ph-pixels .bad').count()) === 1, 'a far click is not shown as bad');
  const [one] = await seenIn('a');
  if (one.image !== pixels()[0].image) {
    await goTo(one.image);
    await clickPhotograph(one.pixel);
    await until('it is in this photograph', () => pixels().length === 2);
    await button('Take a out of ' + pixels()[0].image).click();
  } else await drag(await windowOf(pixels()[0].pixel), await windowOf(one.pixel));
  await until('it is where it belongs', () => {
    const now = pixels();
    return now.length === 1 && apart(now[0].pixel, one.pixel) < kNear;
  });
}

/** Distance of a pixel from a line of points. */
const fromLine = (points, [x, y]) =>
  Math.min(
    ...points.slice(1).map(([u, v], i) => {
      const [p, q] = points[i];
      const [dx, dy] = [u - p, v - q];
      const t = ((x - p) * dx + (y - q) * dy) / (dx * dx + dy * dy || 1);
      const s = Math.min(1, Math.max(0, t));
      return Math.hypot(x - p - s * dx, y - q - s * dy);
    }),
  );

/** In the second photograph a line says where, in the third a ring. */
async function furtherPhotographs() {
  const seen = await seenIn('a');
  check(seen.length > 2, `only ${seen.length} photographs show the place`);
  const [first, second, third] = seen;
  check(pixels()[0].image === first.image, `the pick is in ${pixels()[0].image}`);
  await goTo(second.image);
  await until('the line is drawn', () => page.locator('.ph-line polyline').count());
  const line = (await photoFit()).lines.find((one) => one.image === second.image);
  const off = fromLine(line.points, second.pixel);
  check(off < kNear, `the line passes ${off.toFixed(1)} px beside the place`);
  await record(page, 'photo_picks_line', options.pictures);
  await clickPhotograph(second.pixel);
  await until('it is in two photographs', () => pixels().length === 2);
  await goTo(third.image);
  await until('the ring is drawn', () => page.locator('.ph-meets').count());
  const { meets } = await photoFit();
  const ring = meets.find((one) => one.image === third.image).pixel;
  check(apart(ring, third.pixel) < kNear, `the ring is ${apart(ring, third.pixel)} px beside`);
  await page.getByText('a must lie in the ring').waitFor();
  // A click far beside it: said in words, and shown as wrong.
  const wrong = [third.pixel[0] + 50, third.pixel[1]];
  await clickPhotograph(wrong);
  await until('it is in three photographs', () => pixels().length === 3);
  await page.getByText(/a: \d+\.\d px from where its other photographs have it/).waitFor();
  const bad = page.locator('.ph-pixels .bad');
  await until('it is shown as wrong', async () => (await bad.count()) === 1);
  check((await bad.textContent()).startsWith('50'), `it is ${await bad.textContent()}`);
  await record(page, 'photo_picks_wrong', options.pictures);
  await page.keyboard.press('Control+z');
  await until('it is gone', () => pixels().length === 2);
  await page.keyboard.press('Control+Shift+z');
  await until('it is back', () => pixels().length === 3);
  await page.keyboard.press('Control+z');
  await until('it is gone again', () => pixels().length === 2);
}

/** The other way round: the photograph first; by keyboard; names; markup. */
async function namesAndKeys() {
  await page.keyboard.press('Escape');
  await page.getByLabel('Name of the next pair').fill('left-hand');
  await page.keyboard.press('Enter');
  await sheet().focus();
  await page.keyboard.press('Space');
  check((await page.locator('.frame-mark.pending').count()) === 1, 'Space set no mark');
  await page.keyboard.press('Escape');
  check((await page.locator('.frame-mark.pending').count()) === 0, 'Escape left the mark');
  await clickPhotograph([200, 200]);
  await page.getByText('left-hand: now click the same place on rest').waitFor();
  await clickTemplate(0.52, 0.5);
  await until('both have it', () => pixels().length === 3 && places().length === 2);
  check(places()[1].name === 'left-hand', `it is called ${places()[1].name}`);
  await page.keyboard.press('F2');
  await page.getByLabel('New name of left-hand').fill(kMarkup);
  await page.keyboard.press('Enter');
  await until('both files have the new name', () =>
    places().some((one) => one.name === kMarkup) && pixels().some((one) => one.name === kMarkup),
  );
  await page.keyboard.press('Control+z');
  await until('the old name is back', () => pixels().some((one) => one.name === 'left-hand'));
  await until('and in the other file', () => places().some((one) => one.name === 'left-hand'));
  const row = page.locator('.lm-row', { hasText: 'left-hand' });
  if (!(await row.getAttribute('aria-current'))) await row.click();
  await row.evaluate((one) => one.blur());
  await page.keyboard.press('Delete');
  await until('it is gone', () => pixels().length === 2 && places().length === 1);
}

/** What an editor writes is taken up; what the page does not show stays in the file. */
async function editor() {
  const file = JSON.parse(readFileSync(limbsFile, 'utf8'));
  const spot = { name: 'nose', position: [0.01, 0.02, 0.03] };
  file.landmarks = [spot];
  file.pixels[0].remark = 'sharp';
  file.pixels.push({ name: kMarkup, image: 'IMG_0099.jpg', pixel: [3, 4] });
  writeFileSync(limbsFile, JSON.stringify(file));
  const row = page.locator('.lm-row', { hasText: kMarkup });
  await row.waitFor();
  await page.getByText("in photograph 'IMG_0099.jpg', which the pose does not have").waitFor();
  check(await button('Undo').isDisabled(), "undo would write over the editor's change");
  await row.click();
  await page.getByRole('button', { name: `Delete ${kMarkup}` }).click();
  await until('it is gone', () => pixels().length === 2);
  const now = JSON.parse(readFileSync(limbsFile, 'utf8'));
  check(JSON.stringify(now.landmarks) === JSON.stringify([spot]), 'the place in space is gone');
  check(pixels()[0].remark === 'sharp', "the editor's remark is gone");
  delete now.landmarks;
  writeFileSync(limbsFile, JSON.stringify(now));
  await page.waitForTimeout(1500);
}

async function advice() {
  const worst = (await photoFit()).photographs.filter((one) => one.worst);
  check(worst.length > 0, 'no photograph says where the fit is worst');
  const first = page.locator('.ph-worst button').first();
  await first.click();
  const image = await first.locator('b').textContent();
  await until('its photograph is shown', async () => (await imageShown()) === image);
  await until('it is looked at closely', () => page.locator('.frame-zoom').count());
  await until('a ring is there', () => page.locator('.ph-worst-ring').count());
  await record(page, 'photo_picks_worst', options.pictures);
  await page.locator('.frame-zoom').click();
}

async function fit() {
  await page.locator('.lm-row', { hasText: 'a' }).first().click();
  await page.getByRole('button', { name: 'Fit limbs again' }).click();
  const step = await until(
    'fit has ended',
    async () => {
      const { steps, running } = await ask('/api/steps');
      const one = steps.find((other) => other.step === 'fit');
      return !running && ['done', 'failed'].includes(one.state) && one;
    },
    300,
  );
  check(step.state === 'done', `fit has failed: ${step.error}`);
  await page.getByText('The run is done.').waitFor({ state: 'detached' });
  const { refused, shown } = await photoFit();
  check(refused.length === 0, 'a right pick was refused');
  for (const pick of pixels()) {
    const at = shown.find((one) => one.name === pick.name && one.image === pick.image);
    const off = apart(at.pixel, pick.pixel);
    check(off < 6, `after the fit ${pick.name} is ${off.toFixed(1)} px off in ${pick.image}`);
  }
  await goTo(pixels()[0].image);
  await record(page, 'photo_picks', options.pictures);
}

await walkThrough({ prepare, firstPair, furtherPhotographs, namesAndKeys, editor, advice, fit });
