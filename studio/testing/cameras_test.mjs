// The cameras of a performance, calibrated on the studio's page: points are named and given places,
// clicked in two cameras under the loupe, moved, undone; one wrong click is found; lenses by hand.
// The clicks are where the generated world has its points, so the cameras must be the true ones.
//
//   node cameras_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('cameras', 'dance');
const world = join(scratch, 'world');
let page;

const kSize = 400;
/** Within what both cameras see; not all in a plane [m]. */
const kPlaces = [
  ['table left', [-0.5, -0.5, 0]],
  ['table right', [0.5, -0.5, 0.1]],
  ['door', [0.5, 0.5, 0.9]],
  ['shelf', [-0.5, 0.4, 1.3]],
  ['lamp', [0, 0, 1.6]],
  ['treadmill', [0.2, -0.1, 0]],
];

/** What calibration.yml says of each camera. */
function readRig(file) {
  const cameras = {};
  for (const part of readFileSync(file, 'utf8').split(/^"?(?=cam\d)/m).slice(1)) {
    const lists = [...part.matchAll(/data: *\[([^\]]*)\]/g)].map(([, text]) =>
      text.split(',').map(Number),
    );
    const [matrix, distortion, rotation, translation] = lists;
    cameras[/^\w+/.exec(part)[0]] = { matrix, distortion, rotation, translation };
  }
  return cameras;
}
const inCamera = ({ rotation: r, translation: t }, [x, y, z]) =>
  [0, 1, 2].map((i) => r[3 * i] * x + r[3 * i + 1] * y + r[3 * i + 2] * z + t[i]);
/** Where a camera sees a place, from the picture's corner [px]. */
function pixelOf(camera, place) {
  const [x, y, z] = inCamera(camera, place);
  const { matrix, distortion } = camera;
  const [u, v] = [x / z, y / z];
  const r2 = u * u + v * v;
  const bent = 1 + distortion[0] * r2 + distortion[1] * r2 * r2;
  // A calibration counts from the first pixel's centre, a click from the corner.
  return [matrix[0] * u * bent + matrix[2] + 0.5, matrix[4] * v * bent + matrix[5] + 0.5];
}
/** The camera's place: -R' t. */
const eyeOf = ({ rotation: r, translation: t }) =>
  [0, 1, 2].map((i) => -(r[i] * t[0] + r[3 + i] * t[1] + r[6 + i] * t[2]));

const truth = () => readRig(join(world, 'calibration.yml'));
const points = () => JSON.parse(readFileSync(join(folder, 'points.json'), 'utf8'));
const button = (name) => page.getByRole('button', { name, exact: true });
const camera = (name) => page.locator('.strip').getByRole('button', { name });
const row = (name) => page.locator('.cam-table tbody tr').filter({
  has: page.getByRole('button', { name: `Click ${name} next` }),
});
const clickOf = (cam, point) =>
  points().clicks.find((one) => one.camera === cam && one.point === point);

async function begin() {
  const words = ['performance', '--output', world, '--cameras', '2', '--seed', '3'];
  const size = ['--frames', '3', '--size', `${kSize}`, '--spacing', '0.03'];
  execFileSync(join(bin, 'keypose-synth'), [...words, ...size], { stdio: 'ignore' });
  mkdirSync(folder);
  copyFileSync(join(world, 'calibration.yml'), join(folder, 'lenses.yml'));
  const shot = join(world, 'shot');
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    `# a comment\nkind: performance\nshots:\n  walk: ${shot}\n`,
  );
  page = await openPage();
  // Without calibration there is no plan, and this page is what there is to do.
  await page.getByText("shot 'walk' has no calibration of its cameras").waitFor();
  await page.getByRole('link', { name: 'Calibrate them by points' }).click();
  await page.getByText('cam1: the empty set of walk').waitFor();
}

/** Where a pixel of the picture is on the screen, while all of it is shown. */
async function at([x, y]) {
  const box = await boxOf(page.locator('.frame-sheet'));
  return [box.x + (x / kSize) * box.width, box.y + (y / kSize) * box.height];
}

async function addPoints() {
  for (const [name, place] of kPlaces) {
    await button('Add a point').click();
    const given = 'point 1';
    const field = page.getByLabel(`Name of ${given}`, { exact: true });
    await field.fill(name);
    await field.press('Enter');
    for (const [axis, value] of place.entries()) {
      const number = page.getByLabel(`${'xyz'[axis]} of ${name}, metres`);
      await number.fill(String(value).replace('.', ','));
      await number.press('Enter');
    }
  }
  await until('all points are written', () => {
    const { points: all } = points();
    return all.length === kPlaces.length && all.at(-1).place[0] === 0.2;
  });
  const [name, place] = [points().points[3].name, points().points[3].place];
  check(name === 'shelf' && place.join() === '-0.5,0.4,1.3', `the shelf is ${name} ${place}`);
  // What is no number, and a name that another has, are put back.
  const x = page.getByLabel('x of lamp, metres');
  await x.fill('left');
  await x.press('Enter');
  check((await x.inputValue()) === '0', 'a word was taken for a number');
  const field = page.getByLabel('Name of lamp', { exact: true });
  await field.fill('door');
  await field.press('Enter');
  check((await field.inputValue()) === 'lamp', 'two points of one name');
}

async function clickAll() {
  await page.getByText('Click 6 points or more in each camera').waitFor();
  check(await button('Calibrate the cameras').isDisabled(), 'it calibrates without clicks');
  await button('Click table left next').click();
  for (const cam of ['cam1', 'cam2']) {
    await camera(cam).click();
    await page.getByText(`${cam}: the empty set of walk`).waitFor();
    await button('Click table left next').click();
    for (const [name, place] of kPlaces) {
      const [x, y] = await at(pixelOf(truth()[cam], place));
      await page.mouse.move(x, y);
      await page.locator('.cam-loupe').waitFor();
      await page.mouse.click(x, y);
      await until(`${name} is clicked in ${cam}`, () => clickOf(cam, name));
    }
  }
  const [x, y] = clickOf('cam2', 'lamp').pixel;
  const [u, v] = pixelOf(truth().cam2, [0, 0, 1.6]);
  check(Math.hypot(x - u, y - v) < 1, `the lamp is clicked at ${[x, y]}, not ${[u, v]}`);
  check(points().cameras.map((one) => one.size.join()).join(' ') === '400,400 400,400', 'sizes');
}

async function moveAndUndo() {
  const before = clickOf('cam2', 'door').pixel;
  const mark = page.locator('[data-mark="door"]');
  const box = await boxOf(mark);
  await page.mouse.move(box.x + 12, box.y + 12);
  await page.mouse.down();
  await page.mouse.move(box.x + 42, box.y + 12, { steps: 3 });
  await page.mouse.up();
  await until('the click has moved', () => clickOf('cam2', 'door').pixel[0] > before[0] + 10);
  await page.keyboard.press('Control+z');
  await until('it is back', () => clickOf('cam2', 'door').pixel[0] === before[0]);
  await button('Click door next').click();
  await button('Take the click back').click();
  await until('the click is gone', () => !clickOf('cam2', 'door'));
  await page.keyboard.press('Control+z');
  await until('it is there again', () => clickOf('cam2', 'door'));
}

/** One click far off is told by name, at its place and in the table. */
async function wrongClick() {
  await button('Click door next').click();
  const [x, y] = pixelOf(truth().cam2, [0.5, 0.5, 0.9]);
  await page.mouse.click(...(await at([x + 60, y + 10])));
  await until('it is clicked wrongly', () => clickOf('cam2', 'door').pixel[0] > x + 50);
  await page.getByLabel('Lenses').selectOption('lenses.yml');
  await button('Calibrate the cameras').click();
  await page.getByText(/Camera cam2: the click of 'door' is 6\d px/).waitFor({ timeout: 60000 });
  await page.locator('.cam-error.wrong').waitFor();
  check(/^6\d\.\d$/.test(await row('door').locator('td.bad').textContent()), 'no error in the row');
  await page.mouse.move(...(await at([x + 58, y + 8])));
  await record(page, 'cameras_wrong', options.pictures);
}

async function calibrated() {
  await button('Click door next').click();
  await page.mouse.click(...(await at(pixelOf(truth().cam2, [0.5, 0.5, 0.9]))));
  await page.getByText('The points have changed since the last calibration.').waitFor();
  check((await page.locator('.cam-error').count()) === 0, 'errors of other clicks are shown');
  await button('Calibrate the cameras').click();
  await page.getByText('calibration.yml is up to date.').waitFor({ timeout: 60000 });
  const found = readRig(join(folder, 'calibration.yml'));
  for (const cam of ['cam1', 'cam2']) {
    const [one, other] = [eyeOf(found[cam]), eyeOf(truth()[cam])];
    const off = Math.hypot(...one.map((value, i) => value - other[i]));
    console.log(`    ${cam} is ${(1000 * off).toFixed(1)} mm from its true place`);
    check(off < 0.05, `${cam} is ${off} m from its place`);
  }
  check((await page.locator('.cam-error').count()) === kPlaces.length, 'not each click has an error');
  await record(page, 'cameras', options.pictures);
  // The project has a plan now.
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await page.getByRole('grid', { name: 'Steps by pose' }).waitFor();
}

await walkThrough([
  ['two films without calibration', begin],
  ['points are named and placed', addPoints],
  ['clicked in both cameras', clickAll],
  ['moved, taken back, undone', moveAndUndo],
  ['a wrong click is told', wrongClick],
  ['the cameras are the true ones', calibrated],
]);
