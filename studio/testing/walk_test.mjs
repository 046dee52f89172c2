// One walk through the studio as an artist takes it, on photographs that `keypose synth` makes: a
// new project, a run, a mended mask, landmarks, a timeline, the report; then a second tab, edits by
// hand and a killed studio.
//
//   node walk_test.mjs BIN_DIR [--pictures DIR] [--data DATA] [--project DIR] [--from PART]
// [--keep]
//
// DATA holds what `keypose synth photos` has made, so that it is not made anew. DIR is a project
// that is made and run already: the walk then goes on with a copy of it, from PART on. --keep
// leaves the walk's project. Needs Chromium.
import { execFileSync } from 'node:child_process';
import {
  cpSync,
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { join, resolve } from 'node:path';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';
import { walkLandmarks, walkPaint } from './walk_landmarks.mjs';
import { picturesStand, walkTimeline } from './walk_timeline.mjs';

const { bin, options, scratch, folder, browser, studio, openPage, walkThrough } =
  withStudio('walk', 'creature', {
  data: { type: 'string' },
  project: { type: 'string' },
  from: { type: 'string' },
});
const kRunSeconds = 900;
const pictures = options.pictures;
let page;

const file = (path) => readFileSync(join(folder, path), 'utf8');
const pipeline = () => file('pipeline.yaml');
const go = (place) => page.evaluate((to) => void (location.hash = to), place);
const notice = (words) => page.locator('.notices').getByText(words);

function photographs() {
  if (options.data) return resolve(options.data);
  const made = join(scratch, 'data');
  execFileSync(
    join(bin, 'keypose'),
    [
      'synth',
      'photos',
      '--output',
      made,
      '--poses',
      'rest',
      'bent',
      '--views',
      '16',
      '--width',
      '480',
    ],
    { stdio: 'ignore' },
  );
  return made;
}

async function enter() {
  const answers = [];
  page = await openPage((tab) => tab.on('response', (response) => answers.push(response)));
  await page.locator('main').waitFor();
  const paint_ms = await until('the first paint', () =>
    page.evaluate(() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime),
  );
  let bytes = 0;
  for (const answer of answers)
    if (/\/$|\.js$|\.css$/.test(new URL(answer.url()).pathname))
      bytes += (await answer.body()).length;
  console.log(`page: ${(bytes / 1e6).toFixed(2)} MB, first paint after ${Math.round(paint_ms)} ms`);
  check(bytes > 1e5 && bytes < 1.5e6, `the page weighs ${bytes} bytes; 1.5 MB is the most`);
  check(paint_ms < 5000, `the first paint took ${Math.round(paint_ms)} ms`);
}

/** An empty folder: two poses, their photographs through both kinds of dialog. */
async function makeProject(data) {
  await page.getByRole('heading', { name: 'New project' }).waitFor();
  await page.getByLabel('Pose 1', { exact: true }).fill('rest');
  const choose = async (button, what) => {
    const [dialog] = await Promise.all([
      page.waitForEvent('filechooser'),
      page.getByRole('button', { name: button }).click(),
    ]);
    await dialog.setFiles(what);
  };
  const of = (pose) =>
    readdirSync(join(data, 'photos', pose))
      .filter((name) => name.endsWith('.jpg'))
      .map((name) => join(data, 'photos', pose, name));
  await choose('Choose files for rest', of('rest'));
  await choose('Choose a folder for pose 2', join(data, 'photos/bent'));
  check(
    (await page.getByLabel('Pose 2', { exact: true }).inputValue()) === 'bent',
    'a folder does not name its pose',
  );
  const both = of('rest').length + of('bent').length;
  await page.getByText(`2 poses, ${both} photographs`).waitFor();
  if (pictures)
    await page.locator('main code').evaluate((one) => void (one.textContent = '~/creature'));
  await record(page, 'new_project', pictures);
  await page.getByRole('button', { name: 'Make project' }).click();
  await notice('The project is made.').waitFor({ timeout: 60000 });
  for (const pose of ['rest', 'bent'])
    check(
      readdirSync(join(folder, 'photos', pose)).length === of(pose).length,
      `photographs of ${pose} are missing on disk`,
    );
  check(
    /^template: rest$/m.test(pipeline()),
    `pipeline.yaml names another template:\n${pipeline()}`,
  );
  await page.getByText('Nothing has run yet').waitFor();
}

/** An option through its form: fewer faces, which makes the walk shorter. */
async function setFaces() {
  await page.locator('[data-id="cleanup/rest"]').click();
  const field = page.getByRole('textbox', { name: 'faces', exact: true });
  await field.fill('7');
  await page.getByText('7 is out of range').waitFor();
  await field.fill('4000');
  await field.press('Enter');
  await page.locator('.run-effect').waitFor();
  check(
    /^options:\s*\{?\s*cleanup:\s*\{?\s*faces: 4000\b/m.test(pipeline()),
    `the option did not come into pipeline.yaml:\n${pipeline()}`,
  );
  await page.getByText(/pipeline.yaml, line \d+/).waitFor();
  await page.getByRole('button', { name: 'Keep', exact: true }).click();
}

const upToDate = () => page.locator('.run-summary').getByText('All is up to date.');

/** Follows a run on the page until all is up to date. */
async function followRun() {
  const seen = new Set();
  await page.locator('.run-now').waitFor();
  await until(
    'the log of a step at work is shown',
    async () => {
      // Short steps may be over before the click.
      await page.locator('.cell.running').first().click({ timeout: 500 });
      await page.waitForTimeout(1200);
      return page.locator('.run-log').count();
    },
    120,
  );
  if (pictures) await record(page, 'run_under_way', pictures);
  await until(
    'the run is done',
    async () => {
      const bar = page.locator('.run-now b');
      if (await bar.count()) seen.add(await bar.textContent({ timeout: 500 }).catch(() => ''));
      const failed = page.locator('.run-summary li.failed');
      if (await failed.count())
        throw new Error(
          `a step has failed: ${await page.locator('.cell.failed').first().textContent()}`,
        );
      return (await upToDate().count()) > 0;
    },
    kRunSeconds,
  );
  check(seen.size > 5, `the Run page showed no progress, only ${[...seen]}`);
}

async function firstRun() {
  await setFaces();
  const began = Date.now();
  await page.locator('header').getByRole('button', { name: 'Run', exact: true }).click();
  await followRun();
  console.log(`the run took ${Math.round((Date.now() - began) / 1000)} s`);
  check(existsSync(join(folder, 'out/report/index.html')), 'the run made no report');
}

async function walkPoses() {
  await go('#/poses');
  await page.getByRole('list', { name: 'Photographs of rest' }).waitFor();
  await until('the masks are drawn over the photographs', () =>
    page.evaluate(
      () =>
        [...document.querySelectorAll('.sheet canvas')].filter((one) => one.width > 1).length >= 8,
    ),
  );
  await record(page, 'poses', pictures);
  await mendMask();
  await threeViews();
}

async function mendMask() {
  const comment = pipeline()
    .split('\n')
    .find((line) => line.startsWith('#'));
  const button = page.locator('.sheet button').first();
  const name = (await button.locator('.caption .name').textContent()).trim();
  await button.click();
  const surface = page.getByRole('application', { name: new RegExp(`^${name} with its mask`) });
  await surface.waitFor();
  const box = await boxOf(surface);
  await page.getByRole('button', { name: /^Add/ }).click();
  for (let i = 0; i < 6; ++i) await page.keyboard.press('[');
  // Where the tail meets the body: other photographs outvote what is wrong here.
  await page.mouse.move(box.x + 0.6 * box.width, box.y + 0.7 * box.height);
  await page.mouse.down();
  for (let i = 0; i <= 8; ++i)
    await page.mouse.move(
      box.x + (0.6 + 0.003 * i) * box.width,
      box.y + (0.7 + 0.005 * i) * box.height,
    );
  await page.mouse.up();
  const words = page.getByText('Strokes not saved yet.');
  await words.waitFor();
  await page.getByRole('button', { name: /Undo/ }).click();
  await words.waitFor({ state: 'detached' });
  await page.keyboard.press('Control+Shift+Z');
  await words.waitFor();
  await record(page, 'brush', pictures);
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  await notice(`Saved: ${name}.`).waitFor();
  const mask = `masks/rest/${name}.png`;
  check(existsSync(join(folder, mask)), `${mask} is not on disk`);
  check(
    /masks: masks\/rest/.test(pipeline()),
    `pipeline.yaml does not name masks/rest:\n${pipeline()}`,
  );
  check(
    comment && pipeline().split('\n').includes(comment),
    `pipeline.yaml has lost its comment:\n${pipeline()}`,
  );
  await page.getByText('own mask').first().waitFor();
  await tellsWhy();
}

/** What hangs on the mended mask is made anew. */
async function runAgain() {
  await go('#/run');
  await page.locator('header').getByRole('button', { name: 'Run', exact: true }).click();
  await page.locator('.run-now').waitFor();
  await upToDate().waitFor({ timeout: 1000 * kRunSeconds });
}

/** The Run page says which steps a mended mask sets off, and why. */
async function tellsWhy() {
  await go('#/run/capture%2Frest');
  const cell = page.locator('[data-id="capture/rest"]');
  await until('capture/rest would run', async () =>
    (await cell.textContent()).includes('would run'),
  );
  const why = page.locator('.run-why');
  await until('the reason names the mask', async () =>
    (await why.textContent()).includes('masks/rest'),
  );
  await until('later steps wait', async () => (await page.locator('.cell.waits').count()) > 3);
  check(
    (await page.locator('[data-id="capture/bent"]').textContent()).includes('done'),
    'the other pose would run as well',
  );
  await record(page, 'run', pictures);
}

async function threeViews() {
  const shows = async (pose, tab, words) => {
    await go(`#/poses/${pose}/${tab}`);
    await page.getByText(words).first().waitFor();
    await page.waitForTimeout(800);
    await record(page, tab, pictures);
  };
  await shows('rest', '3d', /faces · .* vertices/);
  for (const kind of ['Cloud', 'Surface', 'Refined', 'Clean']) {
    await page.getByRole('button', { name: kind, exact: true }).click();
    await until(`${kind} is shown`, async () =>
      /points|faces/.test(await page.locator('.caption-chip').textContent()),
    );
  }
  await page.getByRole('button', { name: 'Mesh', exact: true }).click();
  await page.getByRole('button', { name: 'Confidence', exact: true }).click();
  await page.getByText(/Photographs show .* of the surface/).waitFor();
  await record(page, 'confidence', pictures);
  await page.locator('.cameras').getByText('IMG_0005.jpg').click();
  await shows('bent', 'fit', /Half of the vertices lie within/);
  await shows('bent', 'wipe', /left of the edge/);
  const edge = page.getByRole('slider', { name: 'Share of the photograph' });
  await edge.focus();
  await page.keyboard.press('Shift+ArrowLeft');
  check(
    (await edge.getAttribute('aria-valuenow')) === '40',
    'the edge of the wipe does not move by keyboard',
  );
}

/** Asks for one more format, exports what the timeline has changed, and looks at the report. */
async function walkExport() {
  await go('#/export');
  await page.getByRole('checkbox', { name: /OBJ sequence/ }).check();
  await page
    .locator('.export-formats')
    .getByRole('button', { name: 'Export', exact: true })
    .click();
  await page.getByText('The files are up to date.').waitFor({ timeout: 1000 * kRunSeconds });
  check(
    /formats: "?glb,video,obj"?$/m.test(pipeline()),
    `pipeline.yaml does not ask for OBJ:\n${pipeline()}`,
  );
  await page.getByRole('button', { name: 'Make it again' }).click();
  await page
    .getByText('The project has changed since this report')
    .waitFor({ state: 'detached', timeout: 1000 * kRunSeconds });
  const report = page.frameLocator('iframe[title="Report on this project"]');
  await report.getByRole('heading', { name: 'creature' }).waitFor({ timeout: 30000 });
  const link = page.locator('.export-results').getByRole('link', { name: /character\.glb/ });
  const [download] = await Promise.all([page.waitForEvent('download'), link.click()]);
  const bytes = readFileSync(await download.path());
  check(
    bytes.equals(readFileSync(join(folder, 'out/animation/character.glb'))),
    'the download is not the file of out/',
  );
  await page.waitForTimeout(1500);
  await page.locator('.export-page .side').evaluate((one) => void (one.scrollTop = 0));
  await record(page, 'export', pictures);
}

/** A second tab, a hand at the file, a killed studio: nothing is lost, all of it is told. */
async function walkTogether() {
  await go('#/timeline');
  await page.getByRole('group', { name: 'Keys' }).waitFor();
  const other = await browser.tab();
  await other.goto(`http://127.0.0.1:${studio.port}/#/timeline`);
  await page.getByText('open in 2 tabs').waitFor();
  await other.getByText('open in 2 tabs').waitFor();
  await picturesStand(other, 'Threes').click();
  await until(
    'the first tab shows what the second has changed',
    async () => (await picturesStand(page, 'Threes').getAttribute('aria-pressed')) === 'true',
  );
  await other.close();
  await page.getByText('open in 2 tabs').waitFor({ state: 'detached', timeout: 20000 });

  writeFileSync(
    join(folder, 'pipeline.yaml'),
    `${pipeline()}# by hand\n`.replace(/^ {2}step: 3$/m, '  step: 2'),
  );
  await until(
    'an edit by hand is noticed',
    async () => (await picturesStand(page, 'Twos').getAttribute('aria-pressed')) === 'true',
  );
  await killAndGoOn();
}

async function killAndGoOn() {
  browser.away = true;
  await page.getByRole('button', { name: 'Loop', exact: true }).click();
  check((await studio.end('SIGKILL')) === 'SIGKILL', 'the studio did not end by SIGKILL');
  await page.getByText('The studio does not answer').first().waitFor();
  await studio.start();
  await page
    .getByText('The studio does not answer')
    .first()
    .waitFor({ state: 'detached', timeout: 30000 });
  browser.away = false;
  await until('the edit from before the end is in pipeline.yaml', () =>
    /^ {2}loop: true$/m.test(pipeline()),
  );
  await page.getByText('Saved', { exact: true }).waitFor();
  check(pipeline().includes('# by hand'), 'the comment that was written by hand is lost');
  await page.reload();
  await page.getByRole('group', { name: 'Keys' }).waitFor();
  check(
    (await page.getByRole('button', { name: 'Loop', exact: true }).getAttribute('aria-pressed')) ===
      'true',
    'the edit is lost after the studio was killed',
  );
}

/** Names of the project's files are text, whatever they say. */
async function walkMarkup() {
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    pipeline().replace(/^name: .*$/m, 'name: "<img src=x onerror=alert(1)><b>x</b>"'),
  );
  const photo = join(folder, 'photos/rest', '<img src=x onerror=alert(1)>.jpg');
  cpSync(join(folder, 'photos/rest', readdirSync(join(folder, 'photos/rest'))[0]), photo);
  const brand = page.locator('.brand');
  await until('the new name is shown as text', async () =>
    (await brand.textContent()).includes('<b>x</b>'),
  );
  check((await brand.locator('b, img').count()) === 0, 'the name of the project became markup');
  await go('#/poses/rest');
  await page.locator('.sheet').getByText('onerror=alert(1)').waitFor();
  check(
    (await page.locator('.sheet img[src="x"]').count()) === 0,
    'the name of a photograph became markup',
  );
  // Of a project with a mistake the page has no pictures, whatever it had asked for before.
  browser.expected = /\/api\/(photo|mask)\?/;
  rmSync(photo);
  writeFileSync(join(folder, 'pipeline.yaml'), 'poses: [<b>x</b>\n');
  await page.getByRole('heading', { name: 'The project’s file, pipeline.yaml, has a mistake' }).waitFor();
  await record(page, 'mistake', null);
}

let data;
const context = () => ({ page, folder, data, pictures, go, notice, pipeline });
const parts = [
  ['new project', () => makeProject(data)],
  ['run', firstRun],
  ['poses', walkPoses],
  ['run again', runAgain],
  ['landmarks', () => walkLandmarks(context())],
  ['paint', () => walkPaint(context())],
  ['timeline', () => walkTimeline(context())],
  ['export', walkExport],
  ['two tabs', walkTogether],
  ['markup', walkMarkup],
];
const first = options.project
  ? parts.findIndex(([name]) => name === (options.from ?? 'poses'))
  : 0;

function prepare() {
  check(first >= 0, `--from is one of ${parts.map(([name]) => name).join(', ')}`);
  data = photographs();
  mkdirSync(folder);
  if (options.project)
    cpSync(resolve(options.project), folder, { recursive: true, preserveTimestamps: true });
}

async function end() {
  browser.away = true;
  const code = await studio.end('SIGTERM');
  check(code === 0, `SIGTERM ends the studio with ${code}`);
}

await walkThrough(
  [['photographs', prepare], ['enter', enter], ...parts.slice(first), ['end', end]],
  'the whole walk went well',
);
