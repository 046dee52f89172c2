// What the figure is, said on the studio's page: a step asks for it, a click and a line in
// photographs, undone, taken back, changed by another program; the masks made with it.
//
//   node figure_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  chmodSync,
  cpSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { stageScript } from './projects.mjs';
import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, openPage, walkThrough } = withStudio('figure', 'table');
let page;

const [kWidth, kHeight] = [640, 480];
const kViews = 5;

/** A stage that finds two things on the table, and needs to be told which one is the figure. */
const kCapture = stageScript('capture', 'images', `if [ -z "$figure" ]; then
  cp "$here/made/contact_sheet.jpg" "$to.failed.jpg"
  echo "keypose capture: error: two things stand on the table; click on the one that you mean, or say 'keypose figure --pose rest --at PHOTO:X,Y'; what was taken for the figure: $to.failed.jpg" >&2
  exit 3
fi
cp -r "$here/made" "$to"
echo '{"schema": 1}' > "$report"
`);

const kOff = (
  'sfm masks dense mesh refine cleanup unwrap register fit bake complete interpolate export report'
).split(' ');
const kProject = `# a comment
poses:
  rest: photos/rest
steps:
${kOff.map((step) => `  ${step}: {enabled: false}`).join('\n')}
  capture: {program: tools/capture, inputs: {masks: null, background: null}}
  long: {program: tools/long, for: pose, inputs: {images: capture.images}}
`;

/** A stage that takes until it is let go. */
const kLong = stageScript('long', 'made', `until [ -e "$here/go" ]; do sleep 0.1; done
echo made > "$to"
echo '{"schema": 1}' > "$report"
`);

const port = (name, kind, more) => ({ name, kind, ...more });
const kOptional = { optional: true };
const kStages = {
  capture: {
    inputs: [
      port('photos', 'folder'),
      port('masks', 'folder', kOptional),
      port('background', 'file', kOptional),
    ],
    outputs: [port('images', 'folder', { file: 'images' })],
    options: [
      { name: 'min_images', type: 'int', default: 3 },
      { name: 'figure', type: 'string', default: '' },
    ],
  },
  long: {
    inputs: [port('images', 'folder')],
    outputs: [port('made', 'file', { file: 'made.txt' })],
    options: [],
  },
};

function addStage(name, program) {
  const about = { schema: 1, stage: name, version: '1', summary: 'for this test', ...kStages[name] };
  writeFileSync(join(folder, `tools/${name}`), program);
  chmodSync(join(folder, `tools/${name}`), 0o755);
  writeFileSync(join(folder, `tools/${name}.json`), JSON.stringify(about));
}

/** Photographs of a character, and its true masks for the stage; the third has a space in its name. */
function makeProject() {
  const world = join(scratch, 'world');
  const made = join(folder, 'tools/made');
  const words = ['photos', '--output', world, '--poses', 'rest', '--views', `${kViews}`];
  const size = ['--width', `${kWidth}`, '--seed', '5', '--spacing', '0.008'];
  execFileSync(join(bin, 'keypose-synth'), [...words, ...size], { stdio: 'ignore' });
  for (const one of [join(folder, 'photos/rest'), join(made, 'masks')])
    mkdirSync(one, { recursive: true });
  const images = readdirSync(join(world, 'photos/rest')).sort().map((photograph, i) => {
    const name = ['a.jpg', 'b.jpg', 'c d.jpg', 'e.jpg', 'f.jpg'][i];
    const from = join(world, 'photos/rest', photograph);
    cpSync(from, join(folder, 'photos/rest', name));
    cpSync(from, join(made, name));
    cpSync(join(world, `truth/rest/masks/${photograph}.png`), join(made, `masks/${name}.png`));
    return { name, mask: `masks/${name}.png`, width: kWidth, height: kHeight };
  });
  check(images.length === kViews, `${images.length} photographs`);
  writeFileSync(join(made, 'capture.json'), JSON.stringify({ schema: 1, images }));
  cpSync(join(made, 'a.jpg'), join(made, 'contact_sheet.jpg'));
  addStage('capture', kCapture);
  addStage('long', kLong);
  writeFileSync(join(folder, 'pipeline.yaml'), kProject);
}

const yaml = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const said = () => /figure: "([^"]*)"/.exec(yaml())?.[1] ?? '';
const saidIs = (text) => until(`pipeline.yaml says ${text || 'nothing'}`, () => said() === text);
const button = (name) => page.getByRole('button', { name, exact: true });
const tab = (name) => page.getByRole('tab', { name });
const sheet = () => page.locator('.frame-sheet');
const listed = () => page.locator('.figure-list li');

/** Where a pixel of the photograph is on the screen, while all of it is shown. */
async function at(x, y) {
  const box = await boxOf(sheet());
  return [box.x + (x / kWidth) * box.width, box.y + (y / kHeight) * box.height];
}
async function drag(from, to, how = {}) {
  await page.mouse.move(...(await at(...from)));
  await page.mouse.down(how);
  await page.mouse.move(...(await at((from[0] + to[0]) / 2, (from[1] + to[1]) / 2)));
  await page.mouse.move(...(await at(...to)));
  await page.mouse.up(how);
}
/** The numbers of the last thing that was said. */
const lastPoints = () =>
  said()
    .split('; ')
    .at(-1)
    .replace(/^.*:/, '')
    .split('-')
    .map((pair) => pair.split(',').map(Number));
const near = ([x, y], [u, v]) => Math.hypot(x - u, y - v) < 1.5;

async function begin() {
  makeProject();
  page = await openPage();
  await page.getByRole('link', { name: 'Poses', exact: true }).click();
}

/** What was taken for the figure: small beside the error, large by a click. */
async function opensTheRefused(place) {
  const small = place.getByRole('button', { name: 'What was taken for the figure' });
  const loaded = (one) => one.evaluate((img) => img.complete && img.naturalWidth > 0);
  await until('it is shown small', () => loaded(small.locator('img')));
  await small.click();
  const large = page.getByRole('dialog', { name: 'What was taken for the figure' });
  await until('it is shown large', () => loaded(large.locator('img')));
  await large.getByRole('button', { name: 'Close' }).click();
}

async function isAskedFor() {
  await tab('Figure').click();
  await page.getByText('Nothing yet.').waitFor();
  await button('Make the masks').click();
  const asked = page.getByRole('complementary', { name: 'What is the figure' });
  await asked.getByText(/^Two things stand on the table/).waitFor();
  await page.getByRole('link', { name: 'Show it' }).waitFor();
  check(await button('Make the masks').isDisabled(), 'the masks could be made without a click');
  check(!(await asked.textContent()).includes('failed.jpg'), 'the page names a file');
  await opensTheRefused(asked);
  await record(page, 'figure_asked', options.pictures);
  await tab(/Photographs/).click();
  const notice = page.getByRole('region', { name: 'What is the figure?' });
  await notice.getByText('Two things stand on the table').waitFor();
  await opensTheRefused(notice);
  await record(page, 'figure_notice', options.pictures);
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await opensTheRefused(page.locator('.run-failure'));
  await record(page, 'figure_refused_run', options.pictures);
  await page.getByRole('link', { name: 'Show what it is' }).click();
  await page.getByText('Nothing yet.').waitFor();
  await tab(/Photographs/).click();
  await notice.getByRole('button', { name: 'Show it' }).click();
  await sheet().waitFor();
  // What was asked for by hand and failed is told at the bottom as well.
  // Each notice that goes moves those after it up, so always the first.
  const dismiss = page.getByRole('button', { name: 'Dismiss' });
  await until('no notice is left', async () => {
    if (await dismiss.count()) await dismiss.first().click();
    return (await dismiss.count()) === 0;
  });
}

async function clickAndLine() {
  await page.mouse.click(...(await at(330, 250)));
  await until('the click is written', () => said().startsWith('a.jpg:'));
  check(near(lastPoints()[0], [330, 250]), `the click is at ${said()}`);
  await page.keyboard.press('n');
  await page.locator('.strip button').nth(2).click();
  await drag([60, 440], [580, 440]);
  await until('the line is written', () => said().includes('; !c d.jpg:'));
  const line = lastPoints();
  check(line.length === 2, `a straight line has ${line.length} points`);
  check(near(line[0], [60, 440]) && near(line[1], [580, 440]), `the line is ${said()}`);
  check(yaml().includes('# a comment'), 'a comment is lost');
  check((await listed().count()) === 2, 'not two things are listed');
  const notes = await page.locator('.strip em').allTextContents();
  check(notes.join() === '+1,−1', `the strip notes ${notes}`);
}

async function undoAndTakeBack() {
  const both = said();
  const one = both.split('; ')[0];
  await page.keyboard.press('Control+z');
  await saidIs(one);
  await page.keyboard.press('Control+Shift+z');
  await saidIs(both);
  await page.getByRole('button', { name: 'Take back a line in c d.jpg' }).click();
  await saidIs(one);
}

async function looksCloser() {
  await page.locator('.strip button').nth(1).click();
  await page.keyboard.press('f');
  await page.mouse.move(...(await at(120, 80)));
  for (let i = 0; i < 6; ++i) await page.mouse.wheel(0, -120);
  await page.locator('.frame-zoom').waitFor();
  await page.mouse.click(...(await at(120, 80)));
  await until('the click in b is written', () => said().includes('; b.jpg:'));
  check(near(lastPoints()[0], [120, 80]), `looked at closely the click is at ${said()}`);
  // The middle button moves the picture, and says nothing.
  const before = said();
  await drag([120, 80], [150, 90], { button: 'middle' });
  await page.waitForTimeout(300);
  check(said() === before, 'moving the picture said something');
  await page.locator('.frame-zoom').click();
  await sheet().focus();
  await page.keyboard.press('Space');
  await until('the click by the keyboard is written', () => said() !== before);
  check(near(lastPoints()[0], [kWidth / 2, kHeight / 2]), `the keyboard's click is at ${said()}`);
  await page.keyboard.press('Control+z');
  await saidIs(before);
}

async function anotherProgramSaysMore() {
  const more = ['figure', '-C', folder, '--pose', 'rest', '--not', 'c d.jpg:5,6'];
  execFileSync(join(bin, 'keypose'), more, { stdio: 'ignore' });
  await until('the page lists what was said elsewhere', async () => (await listed().count()) === 3);
  await page.reload();
  await until('all of it is there after a reload', async () => (await listed().count()) === 3);
}

async function theMasksAreMade() {
  await page.locator('.strip button').first().click();
  await page.keyboard.press('n');
  await drag([90, 430], [560, 445]);
  await until('the line is written', () => said().includes('; !a.jpg:'));
  await page.getByText('The masks are made again at the next run.').waitFor();
  await button('Make the masks').click();
  await page.getByText('The masks are made with what you said.').waitFor();
  await page.locator('.figure-veil').waitFor();
  await button('All masks in one picture').click();
  await until('the picture of all masks is shown', () =>
    page.locator('.sheet-dialog[open] img').evaluate((one) => one.naturalWidth > 0),
  );
  await button('Close').click();
  await record(page, 'figure', options.pictures);
  await page.keyboard.press('m');
  await page.locator('.figure-veil').waitFor({ state: 'detached' });
}

/** In a run of everything, the masks are there while what takes long is at work. */
async function shownBeforeTheLongSteps() {
  await page.getByRole('button', { name: 'Take back a click in b.jpg' }).click();
  await page.getByText('The masks are made again at the next run.').waitFor();
  await button('Run').click();
  await page.getByText('The masks are made with what you said.').waitFor();
  await button('A run is at work …').waitFor();
  await tab(/Photographs/).click();
  const veils = page.locator('.sheet canvas');
  await until('the sheet shows the masks', () =>
    veils.evaluateAll((all) => all.length === 5 && all.every((one) => one.width > 1)),
  );
  await page.getByRole('region', { name: 'What is the figure?' }).waitFor({ state: 'detached' });
  writeFileSync(join(folder, 'tools/go'), '');
  await page.getByText('The run is done.').waitFor();
}

await walkThrough([
  ['a project with two things on a table', begin],
  ['a step asks what the figure is', isAskedFor],
  ['a click, and a line', clickAndLine],
  ['undone, done again, taken back', undoAndTakeBack],
  ['looked at closely', looksCloser],
  ['another program says more', anotherProgramSaysMore],
  ['the masks are made', theMasksAreMade],
  ['the masks are shown before the long steps', shownBeforeTheLongSteps],
]);
