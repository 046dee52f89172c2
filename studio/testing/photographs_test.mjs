// Photographs and poses, corrected: added by a real drop, replaced, left out by the button of a
// warning, deleted and taken back; poses made from files, renamed, sorted, deleted.
//
//   node photographs_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { rowsPng } from './png.mjs';
import { check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, browser, openPage, walkThrough } = withStudio('photographs', 'dance');
let page;

const pipeline = () => readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
const files = (below) => readdirSync(join(folder, below)).sort().join(' ');
const picture = (shade) => rowsPng(64, 48, (y) => [shade, (y * 5) % 255, 255 - shade]);
const tile = (name) => page.locator('.sheet .tile').filter({ hasText: name });
const dialog = () => page.locator('dialog[open]');
const says = (words) => page.locator('.notices').getByText(words).waitFor();
const key = async (name, what) => {
  await tile(name).focus();
  await page.keyboard.press(what);
};
const menu = async (name, item) => {
  await page.getByRole('button', { name: `What to do with ${name}`, exact: true }).click();
  await page.getByRole('menuitem', { name: item }).click();
};

/** As a person drags files or folders from the desktop; where nothing takes them, nothing is done. */
async function drop(paths, x = 800, y = 500) {
  const session = await page.context().newCDPSession(page);
  const data = { items: [], files: paths, dragOperationsMask: 1 };
  for (const type of ['dragEnter', 'dragOver', 'drop'])
    await session.send('Input.dispatchDragEvent', { type, x, y, data });
  await session.detach();
}

async function begin() {
  for (let i = 1; i <= 8; ++i) {
    mkdirSync(join(folder, 'photos/rest'), { recursive: true });
    writeFileSync(join(folder, `photos/rest/p${i}.png`), picture(20 * i));
  }
  writeFileSync(join(folder, 'pipeline.yaml'), '# ours\nposes:\n  rest: photos/rest  # a ring\n');
  for (const [name, shade] of [['new/q1.png', 7], ['new/p2.png', 200], ['wave/w1.png', 9], ['wave/w2.png', 11]]) {
    mkdirSync(join(scratch, name, '..'), { recursive: true });
    writeFileSync(join(scratch, name), picture(shade));
  }
  writeFileSync(join(scratch, 'new/notes.txt'), 'no photograph');
  page = await openPage();
  await page.getByRole('link', { name: 'Poses', exact: true }).click();
  await tile('p8.png').waitFor();
}

async function addedByADrop() {
  await drop(['q1.png', 'p2.png', 'notes.txt'].map((name) => join(scratch, 'new', name)));
  await dialog().getByText('1 name there already').waitFor();
  await dialog().getByText('1 file not taken').waitFor();
  await dialog().getByText('Nothing is made of rest yet').waitFor();
  await record(page, 'photographs_add', options.pictures);
  await dialog().getByRole('button', { name: 'Add 2 photographs' }).click();
  await tile('q1.png').waitFor();
  check(readFileSync(join(folder, 'photos/rest/p2.png')).equals(picture(200)), 'not replaced');
  check(
    readFileSync(join(folder, 'bin/0001/photos/rest/p2.png')).equals(picture(40)),
    'the replaced one is lost',
  );
}

async function leftOutByKeyAndMenu() {
  await key('q1.png', 'o');
  await until('it stands in pipeline.yaml', () => pipeline().includes('leave_out: q1.png'));
  await tile('q1.png').getByText('left out: no step reads it').waitFor();
  await page.getByText('9 photographs · 1 left out').waitFor();
  await tile('q1.png').hover();
  await menu('q1.png', 'Take it back');
  await until('it is taken back', () => !pipeline().includes('leave_out'));
  check(pipeline().startsWith('# ours\n') && pipeline().includes('# a ring'), pipeline());
}

/** What a step refuses: the button beside its words leaves it out. */
async function warningWithAButton() {
  writeFileSync(join(folder, 'photos/rest/broken.png'), picture(3).subarray(0, 90));
  spawnSync(join(bin, 'keypose'), ['run', '-C', folder, '--until', 'capture'], { stdio: 'ignore' });
  const button = page.getByRole('button', { name: 'Leave out broken.png' });
  await button.waitFor();
  await tile('broken.png').scrollIntoViewIfNeeded();
  await tile('broken.png').getByText('cannot be read').waitFor();
  await record(page, 'photographs_warning', options.pictures);
  await button.click();
  await until('it is left out', () => pipeline().includes('leave_out: broken.png'));
  await button.waitFor({ state: 'detached' });
  const { stderr } = spawnSync(join(bin, 'keypose'), ['run', '-C', folder, '--until', 'capture'], {
    encoding: 'utf8',
  });
  check(!/error: .*broken/.test(stderr), `the step reads what is left out: ${stderr}`);
  // Half a picture has no small one.
  browser.faults = browser.faults.filter((fault) => !/api\/photo\?\S*broken/.test(fault));
}

async function deletedAndTakenBack() {
  await key('p3.png', 'Delete');
  await says('p3.png is in the bin');
  await until('it is gone', () => !existsSync(join(folder, 'photos/rest/p3.png')));
  await tile('p4.png').focus();
  await tile('p4.png').click({ button: 'right' });
  await page.getByRole('menu').waitFor();
  await record(page, 'photographs_menu', options.pictures);
  await page.keyboard.press('Escape');
  await page.getByRole('button', { name: 'Bin 2' }).click();
  await record(page, 'photographs_bin', options.pictures);
  await dialog().getByRole('listitem').filter({ hasText: 'p3.png' }).getByText('Take back').click();
  await until('it is back', () => existsSync(join(folder, 'photos/rest/p3.png')));
  await dialog().getByRole('button', { name: 'Close' }).click();
  await tile('p3.png').waitFor();
}

async function aPoseFromAFolder() {
  await drop([join(scratch, 'wave')]);
  await dialog().getByLabel('To', { exact: true }).selectOption('a new pose');
  await dialog().getByText('rest is bent into 2 photographs').waitFor();
  await record(page, 'photographs_pose', options.pictures);
  await dialog().getByRole('button', { name: 'Add 2 photographs' }).click();
  await tile('w2.png').waitFor();
  check(pipeline().includes('wave: {photos: photos/wave, method: fit}'), pipeline());
  check(files('photos/wave') === 'w1.png w2.png', files('photos/wave'));
}

const poseButton = (name) => page.locator('.pose-names').getByRole('button', { name: new RegExp(`^${name}`) });

async function posesChanged() {
  await poseButton('wave').focus();
  await page.keyboard.press('F2');
  const field = page.getByLabel('New name of wave');
  await field.fill('rest');
  await page.getByText('Two poses have this name.').waitFor();
  await field.fill('hello');
  await page.keyboard.press('Enter');
  await poseButton('hello').waitFor();
  check(files('photos') === 'hello rest', files('photos'));
  check(pipeline().includes('timeline: [rest, hello]'), pipeline());
  await poseButton('hello').focus();
  await page.keyboard.press('Alt+ArrowUp');
  await until('it comes first', () => pipeline().includes('timeline: [hello, rest]'));
  check(/template: rest/.test(pipeline()), `the template stays: ${pipeline()}`);
  // It is the last: nothing can be chosen.
  await page.getByRole('button', { name: 'What to do with rest', exact: true }).click();
  const down = page.getByRole('menuitem', { name: 'Down' });
  await down.waitFor();
  check(await down.isDisabled(), 'the last pose could be moved down');
  await page.keyboard.press('Escape');
  await poseButton('hello').focus();
  await page.keyboard.press('Delete');
  await says('hello is in the bin');
  check(files('photos') === 'rest', files('photos'));
  await page.getByRole('button', { name: /^Bin/ }).click();
  await dialog().getByRole('listitem').filter({ hasText: 'The pose hello' }).getByText('Take back').click();
  await until('it is back', () => existsSync(join(folder, 'photos/hello/w1.png')));
  await page.keyboard.press('Escape');
  await poseButton('hello').waitFor();
}

/** Asked for before the page knew that the pose was gone; and what no browser can show. */
const kExpected = /400 for GET \S+api\/((photos|figure)\?pose=hello|photo\?pose=rest&name=broken)/;

async function droppedElsewhere() {
  for (const name of ['Run', 'Timeline', 'Shoot']) {
    await page.getByRole('link', { name, exact: true }).click();
    const before = page.url();
    await drop([join(scratch, 'new/q1.png')]);
    await page.waitForTimeout(300);
    check(page.url() === before, `a drop on ${name} leads to ${page.url()}`);
    await page.getByRole('link', { name: 'Poses', exact: true }).waitFor();
  }
  browser.faults = browser.faults.filter((fault) => !kExpected.test(fault));
}

await walkThrough({
  'a project of eight photographs': begin,
  'photographs are dropped': addedByADrop,
  'left out, and taken back': leftOutByKeyAndMenu,
  'a warning has the button that does what it says': warningWithAButton,
  'deleted, and taken back': deletedAndTakenBack,
  'a pose from a folder': aPoseFromAFolder,
  'poses renamed, sorted, deleted': posesChanged,
  'dropped where nothing takes it': droppedElsewhere,
});
