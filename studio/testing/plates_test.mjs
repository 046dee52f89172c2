// What stands beside a film, chosen on the page Shot, on its way to finished pictures: a camera
// that moves, plates of the empty set, mattes; then a mesh of the set, or a holdout. `keypose run`
// makes the pictures, and they are compared with the truth. The shot is generated.
//
//   node plates_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import { cpSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { plainPng, readPng, rowsPng } from './png.mjs';
import { filmedProject } from './projects.mjs';
import { check, record, until as untilWithin, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('plates', 'dance');
const until = (words, probe) => untilWithin(words, probe, 120);
const world = join(scratch, 'world');
let page;

/** As composite_program_test holds for cameras that `locate` found. */
const kWorst_db = 26;
const kFilmed = 3;
const [kWidth, kHeight] = [384, 216];
const pipelineFile = join(folder, 'pipeline.yaml');
const pipelineText = () => readFileSync(pipelineFile, 'utf8');
const pictureFile = (number) =>
  join(folder, 'out/shot/pictures', `${String(number).padStart(4, '0')}.png`);
const button = (name) => page.getByRole('button', { name, exact: true });
const part = (name) => page.locator(`select[aria-describedby="part-${name}"]`);

const program = (name, ...words) =>
  execFileSync(join(bin, name), words, { stdio: ['ignore', 'pipe', 'inherit'] }).toString();

async function prepare() {
  const film = ['--shows', '0=rest,2=wave', '--width', `${kWidth}`];
  const camera = ['--swing', '5', '--dolly', '0.03'];
  const more = ['--no-photographs', '--meshes', '--clean-plate', '--spacing', '0.006'];
  const plain = ['--texture', 'none'];
  program('keypose-synth', 'shot', '--output', world, ...film, ...camera, ...more, ...plain);
  for (const name of ['meshes', 'photos/rest', 'photos/wave', 'films'])
    mkdirSync(join(folder, name), { recursive: true });
  const copy = (from, to) => cpSync(join(world, from), join(folder, to), { recursive: true });
  copy('truth/shot/meshes/frame_0000.ply', 'meshes/rest.ply');
  copy('truth/shot/meshes/frame_0004.ply', 'meshes/wave.ply');
  copy('film', 'films/take1');
  copy('plates', 'films/plates');
  copy('truth/shot/mattes', 'films/mattes');
  writeFileSync(join(folder, 'texture.png'), plainPng(64, [176, 120, 84]));
  writeFileSync(pipelineFile, filmedProject('# A camera on rails.'));
  page = await openPage((tab) => tab.setDefaultTimeout(120000));
  await page.getByRole('link', { name: 'Shot', exact: true }).click();
}

/** All of it in the form of a new shot. */
async function choose() {
  await page.getByLabel('Folder of the film').selectOption('films/take1');
  await page.getByText('Moving camera, empty set, mattes, props').click();
  await button('moves').click();
  await page.getByText('no pictures can be made').waitFor();
  await part('plate').selectOption('films/plates');
  await part('mattes').selectOption('films/mattes');
  await record(page, 'plates_setup', options.pictures);
  await button('Add the film').click();
  await page.locator('.shot-strip').waitFor();
  const text = pipelineText();
  for (const line of ['  plate: films/plates', '  mattes: films/mattes', 'camera: moving'])
    check(text.includes(line), `${line} is not written:\n${text}`);
  check(/\{0: rest, 2: wave\}/.test(text), `the poses are others:\n${text}`);
  check(text.startsWith('# A camera on rails.'), 'the comment is gone');
}

const compositeReport = () =>
  JSON.parse(readFileSync(join(folder, 'out/shot/pictures/composite.json'), 'utf8'));

/** `keypose run`, as it is typed: in-betweens are near the truth, filmed frames untouched. */
async function run() {
  program('keypose', 'run', '-C', folder);
  const words = ['score-shot', '--shot', world, '--pictures', join(folder, 'out/shot/pictures')];
  const sheet = options.pictures ? ['--sheet', join(options.pictures, 'plates_truth.png')] : [];
  const score = JSON.parse(program('keypose-synth', ...words, ...sheet));
  const { worst_psnr_db } = score;
  console.log(`    in-betweens ${worst_psnr_db.toFixed(1)} dB at worst, in the character's box`);
  check(worst_psnr_db > kWorst_db, `an in-between has ${worst_psnr_db} dB`);
  check(score.filmed_unchanged === kFilmed, `${score.filmed_unchanged} filmed frames unchanged`);
  const { pictures } = compositeReport();
  check(pictures.length === 2 * kFilmed - 1, `${pictures.length} pictures`);
}

async function look() {
  await button('Result').click();
  await page.locator('.shot-cells button').first().waitFor();
  check((await page.locator('.shot-cells button').count()) === 2 * kFilmed - 1, 'other cells');
  await until('all are loaded', async () => (await page.getByText(/^loading/).count()) === 0);
  await page.keyboard.press('Home');
  await page.keyboard.press('.');
  await page.locator('.shot-kind.between').waitFor();
  await record(page, 'plates_result', options.pictures);
  await button('Camera').click();
  await page.locator('.shot-camera').getByText('moving').waitFor();
}

/** How many pixels of two pictures differ by much, in rows from one to before another. */
function differing(before, after, from = 0, to = kHeight) {
  const [one, two] = [readPng(before), readPng(after)];
  const apart = (a, b) => Math.max(...a.map((value, k) => Math.abs(value - b[k])));
  let count = 0;
  for (let i = from * kWidth; i < to * kWidth; ++i)
    if (apart(one.rgb[i], two.rgb[i]) > 25) ++count;
  return count;
}

/** Chooses files for parts in the set-up ('' for none), saves it, and makes the pictures. */
async function setUp(chosen) {
  await page.getByRole('button', { name: 'Set-up', exact: true }).click();
  for (const [name, path] of Object.entries(chosen)) {
    await until(`${path} is offered`, async () => (await part(name).innerHTML()).includes(path));
    await part(name).selectOption(path);
  }
  await button('Save the set-up').click();
  const line = (name) => new RegExp(`^  ${name}: (.*)$`, 'm').exec(pipelineText())?.[1] ?? '';
  await until('it is written', () =>
    Object.entries(chosen).every(([name, path]) => line(name) === path),
  );
  program('keypose', 'run', '-C', folder);
}

/** A wall before the character's feet, as a mesh of the set: it hides them in what is made. */
async function set() {
  const [made, filmed] = [readFileSync(pictureFile(1)), readFileSync(pictureFile(2))];
  const [wide, far, high] = [0.4, -0.12, 0.05];
  const wall = [
    [-wide, 0],
    [wide, 0],
    [wide, high],
    [-wide, high],
  ].map(([x, z]) => `v ${x} ${far} ${z}\n`);
  writeFileSync(join(folder, 'films/wall.obj'), `${wall.join('')}f 1 2 3\nf 1 3 4\n`);
  await setUp({ set: 'films/wall.obj' });
  const hidden = differing(made, readFileSync(pictureFile(1)));
  console.log(`    the wall hides ${hidden} pixels`);
  check(hidden > 300, `the wall hides ${hidden} pixels only`);
  check(readFileSync(pictureFile(2)).equals(filmed), 'a filmed frame has changed');
  await button('Result').click();
  await until('all are loaded', async () => (await page.getByText(/^loading/).count()) === 0);
  await page.keyboard.press('Home');
  await page.keyboard.press('.');
  await page.locator('.shot-kind.between').waitFor();
  await record(page, 'plates_set', options.pictures);
  return made;
}

/** A holdout in its place: white below a row, so that only the character above it is seen. */
async function holdout(made) {
  const from = Math.round(0.6 * kHeight);
  const props = rowsPng(kWidth, kHeight, (y) => Array(3).fill(y < from ? 0 : 255));
  writeFileSync(join(folder, 'films/props.png'), props);
  await setUp({ set: '', holdout: 'films/props.png' });
  const now = readFileSync(pictureFile(1));
  const [above, below] = [differing(made, now, 0, from), differing(made, now, from)];
  console.log(`    the holdout hides ${below} pixels, and changes ${above} above it`);
  check(below > 300 && above < 30, 'it hides what is above it, or nothing');
}

let made = null;
const props = { set: async () => void (made = await set()), holdout: () => holdout(made) };
await walkThrough(Object.entries({ prepare, choose, run, look, ...props }));
