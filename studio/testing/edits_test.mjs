// Edits that must not get lost: a page that is closed at once after one, a studio that is away, a
// mask whose photograph is shot again.
//
//   node edits_test.mjs BIN_DIR [--keep]
import {
  mkdirSync,
  readdirSync,
  readFileSync,
  renameSync,
  writeFileSync,
} from 'node:fs';
import { join } from 'node:path';

import { plainPng } from './png.mjs';
import { check, until, withStudio } from './studio_driver.mjs';

const { scratch, folder, browser, studio, openPage, walkThrough } = withStudio('edits', 'dance');
let page;

const pipeline = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const key = () => page.locator('.tl-block[data-key="1"]');
const where = () => key().getAttribute('aria-label');
const toTimeline = () => page.getByRole('link', { name: 'Timeline', exact: true }).click();

async function begin() {
  for (const pose of ['rest', 'bent']) mkdirSync(join(folder, 'photos', pose), { recursive: true });
  writeFileSync(
    join(folder, 'pipeline.yaml'),
    'name: dance\nposes: {rest: photos/rest, bent: photos/bent}\ntemplate: rest\n',
  );
  page = await openPage();
  await toTimeline();
}

async function closedAtOnce() {
  await key().press('Shift+ArrowRight');
  await until('the key is written', () => pipeline().includes('pose: bent, at: '));
  const before = pipeline();
  await key().press('Shift+ArrowRight');
  await page.close({ runBeforeUnload: true });
  await until('where the key was moved last is written', () => pipeline() !== before, 10);
  page = await browser.tab();
  await page.goto(`http://127.0.0.1:${studio.port}/`);
  await toTimeline();
}

async function whileAway() {
  await key().waitFor();
  browser.away = true;
  await studio.end('SIGKILL');
  const [before, written] = [await where(), pipeline()];
  await key().press('Shift+ArrowRight');
  await page.getByText('Not saved').waitFor();
  check((await where()) !== before, 'the key has not moved');
  check(pipeline() === written, 'nobody was there to write it');
  browser.stays = true;
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await key().waitFor();
  check(browser.questions.join() === 'confirm', `asked before leaving: ${browser.questions}`);
  browser.stays = false;
  await studio.start();
  await until('the move is written once the studio is back', () => pipeline() !== written, 30);
  browser.away = false;
  await page.getByRole('link', { name: 'Run', exact: true }).click();
  await key().waitFor({ state: 'detached' });
  check(browser.questions.length === 1, 'what is saved is asked about');
}

/** A mask that was painted, and then its photograph is shot again, twice. */
async function shotAgain() {
  const shoot = (grey) => {
    const file = join(scratch, 'a.png');
    writeFileSync(file, plainPng(48, [grey, grey, grey]));
    renameSync(file, join(folder, 'photos/rest/a.png')); // the studio must not see half of it
  };
  const masks = () => readdirSync(join(folder, 'masks/rest')).sort().join();
  const noted = () => readFileSync(join(folder, 'masks/rest/painted.json'), 'utf8');
  shoot(90);
  await page.getByRole('link', { name: 'Poses', exact: true }).click();
  await page.locator('.sheet button').first().click();
  const surface = page.getByRole('application', { name: /^a.png with its mask/ });
  await surface.focus();
  await page.keyboard.press('Enter');
  await page.getByRole('button', { name: 'Save', exact: true }).click();
  await page.getByText('own mask').waitFor();
  const before = noted();
  shoot(91);
  const older = page.getByRole('region', { name: 'Masks of older photographs' });
  await older.getByText('a.png was shot again after you painted its mask').waitFor();
  await older.getByRole('button', { name: 'It still holds' }).click();
  await older.waitFor({ state: 'detached' });
  await page.getByText('own mask').waitFor();
  check(noted() !== before, 'nothing is noted of the new photograph');
  await page.getByRole('button', { name: /Photographs of rest/ }).click();
  shoot(92);
  await page.getByText('older mask').waitFor();
  await older.getByRole('button', { name: 'Set aside' }).click();
  await older.waitFor({ state: 'detached' });
  check(masks() === 'a.png.png.old', `the mask is not set aside alone: ${masks()}`);
  // No run has made a mask, so that the brush finds none.
  browser.faults = browser.faults.filter((fault) => !/404 for GET \S+api\/mask/.test(fault));
}

await walkThrough([
  ['a project of two poses', begin],
  ['a page that is closed at once', closedAtOnce],
  ['a studio that is away', whileAway],
  ['a photograph that is shot again', shotAgain],
]);
