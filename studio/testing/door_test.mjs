// The page before all projects: a new one, one by its folder, one that is gone, an example, another
// browser, two tabs, the end; and how to photograph.
//
//   node door_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { existsSync, mkdirSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { plainPng } from './png.mjs';
import { check, record, until, withStudio } from './studio_driver.mjs';

const { options, scratch, browser, studio, openPage, walkThrough } = withStudio('door', 'unused');
const home = join(scratch, 'home');
const newOne = join(home, 'Keypose/clay fox');
const hare = join(scratch, 'elsewhere/hare');
/** The first look at a project asks all programs what they are. */
const patience = { timeout: 120_000 };
let page;

const button = (name) => page.getByRole('button', { name, exact: true });
const card = (name) => page.getByRole('listitem').filter({ has: page.getByRole('heading', { name, exact: true }) });
const heading = (name) => page.getByRole('heading', { name, exact: true });
const toProjects = () => page.getByRole('link', { name: 'Keypose', exact: true }).click();

/** A project of one pose and one photograph. */
function makeProject(folder, colour) {
  mkdirSync(join(folder, 'photos/rest'), { recursive: true });
  writeFileSync(join(folder, 'photos/rest/a.png'), plainPng(64, colour));
  writeFileSync(join(folder, 'pipeline.yaml'), 'poses: {rest: photos/rest}\n');
}

async function firstTime() {
  mkdirSync(home);
  studio.words = ['--port', '0'];
  // What programs say of themselves is kept, as asking all of them takes long.
  const cache = process.env.XDG_CACHE_HOME ?? join(process.env.HOME ?? home, '.cache');
  const own = { HOME: home, KEYPOSE_HOME: join(scratch, 'state'), XDG_CACHE_HOME: cache };
  studio.place = { cwd: home, env: { ...process.env, ...own } };
  browser.expected = /\/api\/(door\/(open|picture)|timeline$)|\/enter/;
  page = await openPage();
  studio.words = [];
  await heading('Welcome').waitFor();
  await record(page, 'door_first', options.pictures);
}

async function guide() {
  await page.getByRole('link', { name: 'How to photograph', exact: true }).click();
  await heading('What goes wrong').waitFor();
  check((await page.getByRole('img').count()) === 6, 'not six drawings');
  await record(page, 'door_guide', options.pictures);
  await page.getByRole('link', { name: 'Projects', exact: true }).click();
}

async function aNewOne() {
  await page.getByLabel('Its name').fill('../fox');
  check(await button('Make it').first().isDisabled(), 'a name that leads elsewhere');
  await page.getByLabel('Its name').fill('clay fox');
  await button('Make it').first().click();
  await button('Make project').waitFor();
  check(existsSync(newOne), `${newOne} is not there`);
  makeProject(newOne, [200, 120, 80]);
  await page.getByRole('link', { name: 'Poses', exact: true }).waitFor(patience);
  await toProjects();
  await card('clay fox').getByText('not run yet').waitFor(patience);
  await card('clay fox').getByText(newOne).waitFor();
}

async function byItsFolder() {
  makeProject(hare, [80, 120, 200]);
  await page.getByLabel('Where it is').fill(join(scratch, 'elsewhere'));
  await button('Open it').click();
  await page.getByText('its folder \'hare\' is one').waitFor();
  await page.getByLabel('Where it is').fill(hare);
  await button('Open it').click();
  await page.locator('.brand').getByText('hare').waitFor(patience);
  await toProjects();
  await until('its picture', () =>
    card('hare').locator('img').evaluate((picture) => picture.naturalWidth === 64),
  );
}

/** What a tab of another project still wants to change is not changed in this one. */
async function twoTabs() {
  await card('hare').getByRole('button', { name: 'Open hare' }).click();
  await page.locator('.brand').getByText('hare').waitFor(patience);
  const first = page;
  page = await browser.tab();
  await page.goto(new URL('/#/projects', first.url()).href);
  await card('clay fox').getByRole('button', { name: 'Open clay fox' }).click();
  await page.locator('.brand').getByText('clay fox').waitFor(patience);
  await first.locator('.brand').getByText('clay fox').waitFor(patience);
  await first.getByText('Another tab has opened another project').waitFor(patience);
  const refused = await page.evaluate(async () => {
    const headers = { 'X-Keypose': '1', 'X-Keypose-Project': '0123456789abcdef' };
    const answer = await fetch('/api/timeline', { method: 'PUT', headers, body: '{}' });
    return answer.status;
  });
  check(refused === 409, `a change meant for another project: ${refused}`);
  await first.close();
  await toProjects();
}

async function oneThatIsGone() {
  renameSync(hare, `${hare} moved`);
  await page.reload();
  await card('hare').getByText('moved, or gone').waitFor();
  await record(page, 'door', options.pictures);
  await button('Take off the list: hare').click();
  await until('it is off the list', async () => (await card('hare').count()) === 0);
  check(existsSync(`${hare} moved/pipeline.yaml`), 'its files are gone');
}

async function anExample() {
  const examples = join(scratch, 'examples');
  await page.getByLabel('made in').fill(examples);
  await button('Make it: A puppet of wire').click();
  const open = button('Open: A puppet of wire');
  await until('the example is made', () => open.isVisible(), 120);
  check(existsSync(join(examples, 'puppet/armature/example/set.ply')), 'nothing was made');
  await record(page, 'door_example', options.pictures);
  await open.click();
  await button('Use the example').waitFor(patience);
  await page.locator('.brand').getByText('puppet').waitFor(patience);
  await toProjects();
  await card('puppet').getByText('puppet of wire · open now').waitFor(patience);
}

async function anotherBrowser() {
  await button('Another browser').click();
  const address = await page.getByLabel('Address for another browser').inputValue();
  const other = await browser.browser.newContext();
  const second = await other.newPage();
  await second.goto(address);
  await second.locator('.brand').getByText('puppet').waitFor(patience);
  const late = await (await browser.browser.newContext()).newPage();
  await late.goto(address);
  await late.getByRole('heading', { name: 'This browser is not let in yet' }).waitFor();
  // Its own goes on, also by an address that was used.
  await page.goto(address);
  await page.locator('.brand').getByText('puppet').waitFor(patience);
  await other.close();
}

async function theEnd() {
  await page.goto(new URL('/#/projects', page.url()).href);
  await button('End the studio').click();
  await heading('The studio has ended').waitFor();
  check((await studio.end('SIGCONT')) === 0, 'the studio did not end');
}

await walkThrough({
  'the first time': firstTime,
  'how to photograph': guide,
  'a new one': aNewOne,
  'by its folder': byItsFolder,
  'two tabs': twoTabs,
  'one that is gone': oneThatIsGone,
  'an example': anExample,
  'another browser': anotherBrowser,
  'the end': theEnd,
});
