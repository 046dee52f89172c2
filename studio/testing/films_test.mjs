// The actor of a performance, said on the studio's page in frames of two cameras' films: clicks and
// lines, undone, taken back, said by another program; the masks made with them and shown over each
// frame.
//
//   node films_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  chmodSync,
  mkdirSync,
  readFileSync,
  renameSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { stageScript } from './projects.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('films', 'dance');
const films = join(scratch, 'world/shot');
let page;

const kSize = 240;
const kFrames = 3;

/** A stage that gives the true masks, once it is told what the actor is. */
const kSilhouettes = stageScript('silhouettes', 'masked', `if [ -z "$figure" ]; then
  echo "keypose silhouettes: error: two things move; say which with 'keypose figure --shot walk --at CAMERA/FRAME:X,Y'" >&2
  exit 3
fi
mkdir "$to"
cp -r "$here/masks" "$to"
echo '{"schema": 1}' > "$report"
`);
const port = (name, more) => ({ name, kind: 'folder', ...more });
const kStage = {
  schema: 1,
  stage: 'silhouettes',
  version: '1',
  summary: 'for this test',
  inputs: [port('video'), port('calibration', { optional: true })],
  outputs: [port('masked', { file: 'masked' })],
  options: [{ name: 'figure', type: 'string', default: '' }],
};
const kProject = `# a comment
kind: performance
shots:
  walk: ${films}
steps:
  silhouettes: {program: tools/silhouettes, inputs: {video: $unmasked, calibration: null}}
${['track', 'transfer', 'export', 'report'].map((one) => `  ${one}: {enabled: false}`).join('\n')}
`;

const yaml = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const said = () => /figure: "([^"]*)"/.exec(yaml())?.[1] ?? '';
const saidIs = (text) => until(`pipeline.yaml says ${text || 'nothing'}`, () => said() === text);
const button = (name) => page.getByRole('button', { name, exact: true });
const camera = (name) => page.locator('.strip').getByRole('button', { name });
const slider = () => page.getByRole('slider', { name: 'Frame' });
const listed = () => page.locator('.figure-list li');
const shown = () => page.locator('.frame-caption').textContent();

async function begin() {
  const words = ['performance', '--output', join(scratch, 'world'), '--cameras', '2', '--seed', '3'];
  const size = ['--frames', `${kFrames}`, '--size', `${kSize}`, '--spacing', '0.03'];
  execFileSync(join(bin, 'keypose-synth'), [...words, ...size], { stdio: 'ignore' });
  mkdirSync(join(folder, 'tools'), { recursive: true });
  renameSync(join(films, 'masks'), join(folder, 'tools/masks'));
  rmSync(join(films, 'background'), { recursive: true });
  writeFileSync(join(folder, 'tools/silhouettes'), kSilhouettes);
  chmodSync(join(folder, 'tools/silhouettes'), 0o755);
  writeFileSync(join(folder, 'tools/silhouettes.json'), JSON.stringify(kStage));
  writeFileSync(join(folder, 'pipeline.yaml'), kProject);
  page = await openPage();
  await page.getByRole('link', { name: 'Films', exact: true }).click();
  await page.getByRole('heading', { name: 'Show the actor' }).waitFor();
}

/** Where a pixel of the frame is on the screen, while all of it is shown. */
async function at(x, y) {
  const box = await boxOf(page.locator('.frame-sheet'));
  return [box.x + (x / kSize) * box.width, box.y + (y / kSize) * box.height];
}
const near = (text, numbers) =>
  text
    .replace(/^.*:/, '')
    .split(/[,-]/)
    .every((one, i) => Math.abs(Number(one) - numbers[i]) < 1.5);

async function isAskedFor() {
  await button('Run').click();
  await page.getByRole('heading', { name: 'What is the actor?' }).waitFor();
  await page.getByText(/^Two things move/).waitFor();
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await page.getByRole('link', { name: 'Show what it is' }).click();
  await page.getByText('Nothing yet.').waitFor();
}

async function clickAndLine() {
  await slider().fill('2');
  await until('frame 2 is shown', async () => (await shown()) === 'cam1/2');
  await page.mouse.click(...(await at(120, 100)));
  await until('the click is written', () => said().startsWith('cam1/2:'));
  check(near(said(), [120, 100]), `the click is at ${said()}`);
  await camera('cam2').click();
  await button('A frame back').click();
  await until('frame 1 is shown', async () => (await shown()) === 'cam2/1');
  await page.keyboard.press('n');
  await page.mouse.move(...(await at(20, 220)));
  await page.mouse.down();
  await page.mouse.move(...(await at(220, 220)));
  await page.mouse.up();
  await until('the line is written', () => said().includes('; !cam2/1:'));
  check(near(said().split('!')[1], [20, 220, 220, 220]), `the line is ${said()}`);
  check(yaml().includes('# a comment'), 'a comment is lost');
  const notes = await page.locator('.strip em').allTextContents();
  check(notes.join() === '−1', `the strip notes ${notes}`);
}

async function undoAndTakeBack() {
  const both = said();
  const one = both.split('; ')[0];
  await page.keyboard.press('Control+z');
  await saidIs(one);
  await page.keyboard.press('Control+Shift+z');
  await saidIs(both);
  await page.getByRole('button', { name: 'Take back a line in cam2/1' }).click();
  await saidIs(one);
}

async function anotherProgramSaysMore() {
  const more = ['figure', '-C', folder, '--shot', 'walk', '--not', 'cam2/0:5,6'];
  execFileSync(join(bin, 'keypose'), more, { stdio: 'ignore' });
  await until('the page lists it', async () => (await listed().count()) === 2);
  await listed().nth(1).getByRole('button').first().click();
  await until('its frame is shown', async () => (await shown()) === 'cam2/0');
  await page.locator('.figure-said.not').waitFor();
}

async function theMasksAreMade() {
  await listed().first().getByRole('button').first().click();
  await until('its frame is shown', async () => (await shown()) === 'cam1/2');
  await record(page, 'films', options.pictures);
  await page.getByText('The masks are made again at the next run.').waitFor();
  await button('Make the masks').click();
  await page.getByText('The masks are made with what you said.').waitFor();
  await page.locator('.figure-veil').waitFor();
  const mask = await page.locator('mask image').getAttribute('href');
  check(/camera=cam1&frame=2/.test(mask), `the mask is ${mask}`);
  await record(page, 'films_masked', options.pictures);
  await page.keyboard.press('m');
  await page.locator('.figure-veil').waitFor({ state: 'detached' });
}

await walkThrough([
  ['the films of two cameras', begin],
  ['a step asks what the actor is', isAskedFor],
  ['a click, and a line, in two frames', clickAndLine],
  ['undone, done again, taken back', undoAndTakeBack],
  ['another program says more', anotherProgramSaysMore],
  ['the masks are made', theMasksAreMade],
]);
