// Edits that must not get lost: a page that is closed at once after one, and a studio that is away.
//
//   node edits_test.mjs BIN_DIR [--keep]
import { mkdirSync, mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

import {
  Browser,
  check,
  checkFaults,
  readWords,
  runParts,
  runTest,
  StudioProgram,
  until,
} from './studio_driver.mjs';

const { bin, options } = readWords('edits_test.mjs');
const scratch = mkdtempSync(join(tmpdir(), 'keypose_studio_edits_'));
const folder = join(scratch, 'dance');
const browser = new Browser();
const studio = new StudioProgram(bin, folder);
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
  await browser.start();
  const address = await studio.start();
  page = await browser.tab();
  await page.goto(address);
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

await runTest({
  name: 'edits',
  walk: async () => {
    await runParts([
      ['a project of two poses', begin],
      ['a page that is closed at once', closedAtOnce],
      ['a studio that is away', whileAway],
    ]);
    checkFaults(browser);
  },
  browser,
  studio,
  page: () => page,
  scratch,
  keep: options.keep ? folder : undefined,
});
