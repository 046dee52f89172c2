// Shooting on the studio's page, with the simulated camera and turntable: a ring by itself, a
// photograph again, the next pose under onion skin, a page that is opened in mid-ring, a studio
// that is killed in mid-ring, a camera that comes late.
//
//   node shoot_test.mjs BIN_DIR [--pictures DIR] [--keep]
import { execFileSync } from 'node:child_process';
import {
  copyFileSync,
  existsSync,
  mkdirSync,
  readdirSync,
  readFileSync,
  statSync,
} from 'node:fs';
import { join } from 'node:path';

import { boxOf, check, record, until, withStudio } from './studio_driver.mjs';

const { bin, options, scratch, folder, browser, studio, openPage, walkThrough } =
  withStudio('shoot', 'fox');
const kAngles = 12;
const kRings = '12, 40';
const kAll = 2 * kAngles;
const drawn = join(scratch, 'drawn');
let page;

const landed = (pose) => {
  const place = join(folder, 'photos', pose);
  return existsSync(place) ? readdirSync(place).filter((name) => name.endsWith('.jpg')) : [];
};
/** Changes when a photograph is replaced, and only then. */
const stampOf = (pose, name) =>
  `${statSync(join(folder, 'photos', pose, name)).ino} ` +
  `${statSync(join(folder, 'photos', pose, name)).mtimeMs}`;
const stamps = (pose) => new Map(landed(pose).map((name) => [name, stampOf(pose, name)]));
const slots = (state) => page.locator(`.shoot-rings g[data-state="${state}"]`).count();
const rows = () => page.locator('.shoot-landed ol > li').count();
const button = (name) => page.getByRole('button', { name, exact: true });
const ask = () => page.locator('.shoot-say.ask');

function checkUnchanged(before, pose, but = []) {
  for (const [name, stamp] of before)
    if (!but.includes(name)) check(stampOf(pose, name) === stamp, `${name} was shot twice`);
}

async function enter() {
  page = await openPage();
  await page.getByRole('link', { name: 'Shoot' }).click();
  await page.getByLabel('Pose', { exact: true }).waitFor();
}

async function setUp() {
  await page.getByRole('button', { name: 'Begin' }).click();
  await page.getByText('Name the pose.').waitFor();
  await page.getByLabel('Pose', { exact: true }).fill('rest');
  await page.getByLabel('Camera', { exact: true }).selectOption('simulated');
  await page.getByLabel('Photographs to take').fill(drawn);
  await page.getByLabel('Turntable', { exact: true }).selectOption('simulated');
  await page.getByLabel('Rings, heights').fill(kRings);
  await page.getByLabel('Angles in a ring').fill(String(kAngles));
  await page.getByText(`2 rings × ${kAngles} angles: ${kAll} photographs`).waitFor();
  await record(page, 'shoot_setup', options.pictures);
}

/** Answers what is asked for until `over`. */
async function shootUntil(over, seconds = 120) {
  await until(
    'the ring is shot',
    async () => {
      if (await over()) return true;
      if (await ask().count()) await page.keyboard.press('Space');
      return false;
    },
    seconds,
  );
}

async function firstRing() {
  await page.getByRole('button', { name: 'Begin' }).click();
  await until('the session can begin', () => button('Shoot Space').isEnabled());
  check(existsSync(join(folder, 'pipeline.yaml')), 'no project was made');
  await page.keyboard.press('Space');
  await ask()
    .getByText(/Put the figure in its pose 'rest'.*12 degrees/)
    .waitFor();
  await until(
    'the live picture is drawn',
    async () => (await page.locator('.shoot-picture canvas').evaluate((one) => one.width)) > 150,
  );
  await record(page, 'shoot_ask', null);
  await aids();
  await page.keyboard.press('Space');
  await until('some have landed', async () => (await rows()) >= 5);
}

/** Guides, safe frame, clipping, histogram and loupe, by their keys; the browser remembers them. */
async function aids() {
  for (const one of ['g', 'f', 'c', 'h', 'z']) await page.keyboard.press(one);
  const pressed = () => page.locator('.shoot-aids button[aria-pressed=true]').count();
  await until('five aids are on', async () => (await pressed()) === 5);
  check((await page.locator('.aid.lines').count()) === 2, 'not guides and a safe frame');
  await page.locator('.aid.histogram').getByText(/% white/).waitFor();
  const box = await boxOf(page.locator('.shoot-picture .frame'));
  await page.mouse.move(box.x + 0.45 * box.width, box.y + 0.6 * box.height);
  await page.locator('.aid.loupe').getByText(/of the sharpest here/).waitFor();
  await record(page, 'shoot_aids', options.pictures);
  const clear = await page.locator('canvas.clipping').evaluate((one) => {
    const { data } = one.getContext('2d').getImageData(0, 0, one.width, one.height);
    return data.filter((_, i) => i % 4 === 3 && data[i] === 0).length / (data.length / 4);
  });
  check(clear > 0.5, `${1 - clear} of the picture is striped`);
  for (const one of ['g', 'f', 'c', 'h', 'z']) await page.keyboard.press(one);
  await until('they are off', async () => (await pressed()) === 0);
}

/** A page that is opened in the middle of it shows all that has landed. */
async function openLate() {
  await page.keyboard.press('p');
  await page.getByText('Paused').waitFor();
  const there = landed('rest').length;
  await until('the page shows what is on the disk', async () => (await rows()) === there);
  const seen = [await rows(), await slots('done'), await slots('warned')];
  check(
    seen[1] + seen[2] === there,
    `${there} photographs, the diagram shows ${seen[1]} + ${seen[2]}`,
  );
  await page.reload();
  await until(
    'it is the same after it is loaded again',
    async () => [await rows(), await slots('done'), await slots('warned')].join() === seen.join(),
  );
  await page.getByText('Paused').waitFor();
  await record(page, 'shoot', options.pictures);
}

/** The studio is killed, and started again: the session goes on, and nothing is shot twice. */
async function kill() {
  await page.keyboard.press('Space');
  await until('it goes on', async () => landed('rest').length > 6);
  browser.away = true;
  await studio.end('SIGKILL');
  await page.getByText('The studio does not answer').first().waitFor();
  // The program that shoots ends by itself when its studio is gone.
  await until('the camera is free again', () => {
    const before = landed('rest').length;
    return new Promise((done) => setTimeout(() => done(landed('rest').length === before), 700));
  });
  const before = stamps('rest');
  await studio.start();
  await button('Go on with rest').waitFor({ timeout: 30000 });
  browser.away = false;
  check(
    (await page.getByLabel('Angles in a ring').inputValue()) === String(kAngles),
    'the set-up is forgotten',
  );
  check(
    await page.getByLabel('Rings, heights').isDisabled(),
    'the plan of a pose that was begun could be changed',
  );
  await button('Go on with rest').click();
  await until('what was shot is there', async () => (await rows()) === before.size);
  await page.keyboard.press('Space');
  await shootUntil(() => page.getByText('All angles are there').count());
  check(landed('rest').length === kAll, `${landed('rest').length} photographs, not ${kAll}`);
  checkUnchanged(before, 'rest');
}

async function again() {
  const before = stamps('rest');
  await page.locator('.shoot-landed ol button').nth(2).click();
  const name = (await page.locator('.shoot-picture img').getAttribute('alt')) ?? '';
  check(/^r\d_a\d{3}$/.test(name), `the photograph is called '${name}'`);
  await record(page, 'shoot_photograph', null);
  await page.keyboard.press('a');
  await shootUntil(async () => stampOf('rest', `${name}.jpg`) !== before.get(`${name}.jpg`));
  await shootUntil(() => page.getByText('All angles are there').count());
  checkUnchanged(before, 'rest', [`${name}.jpg`]);
  check(landed('rest').length === kAll, 'a photograph that was shot again is there twice');
}

async function nextPose() {
  await page.keyboard.press('n');
  await until('the name can be typed', () =>
    page.getByLabel('Next pose').evaluate((one) => one === document.activeElement),
  );
  await page.keyboard.type('bent');
  await page.getByText('A full ring is better where').waitFor();
  await record(page, 'shoot_next', options.pictures);
  await page.keyboard.press('Enter');
  await ask()
    .getByText(/pose 'bent'/)
    .waitFor();
  const onion = page.locator('.shoot-picture img.onion');
  await until('the last pose lies over the live picture', () =>
    onion.evaluate((one) => one.naturalWidth > 0),
  );
  const slider = page.getByRole('slider', { name: /Over it: rest/ });
  await slider.focus();
  await page.keyboard.press('Home');
  await onion.waitFor({ state: 'detached' });
  for (let i = 0; i < 45; ++i) await page.keyboard.press('ArrowRight');
  check(
    (await onion.evaluate((one) => getComputedStyle(one).opacity)) === '0.45',
    'the slider does not fade the onion skin',
  );
  await slider.evaluate((one) => one.blur());
  await page.keyboard.press('Space');
  await until('the next pose lands', async () => (await rows()) >= 2);
  check(
    (await page.locator('.shoot-page h2').first().textContent()) === 'bent',
    'the page shows another pose',
  );
  await page.keyboard.press('p');
  await page.getByText('Paused').waitFor();
  await record(page, 'shoot_onion', options.pictures);
  await page.keyboard.press('s');
  await until('one is left out', async () => (await slots('skipped')) === 1);
}

/** Six photographs suffice for what is not the first pose. */
function bentFromSix() {
  const text = readFileSync(join(folder, 'pipeline.yaml'), 'utf8');
  check(text.includes('bent: {photos: photos/bent, method: fit}'), `pipeline.yaml: ${text}`);
  const { plan } = JSON.parse(readFileSync(join(folder, 'photos/bent/shoot.json'), 'utf8'));
  check(plan.angles === 6 && plan.rings_deg.join() === '12', `the plan: ${JSON.stringify(plan)}`);
}

async function end() {
  bentFromSix();
  await button('End').click();
  await page.getByText(/\d+ of 6 photographs of bent are there/).waitFor();
  await record(page, 'shoot_ended', null);
  await page.getByRole('link', { name: 'Look at them' }).click();
  const there = landed('bent').length;
  await until(
    'the page of poses has them',
    async () => (await page.locator('.sheet li').count()) === there,
  );
}

/** A camera that is not there yet: said in words, and gone on with when it comes. */
async function comesLate() {
  const watched = join(scratch, 'tethered');
  await page.getByRole('link', { name: 'Shoot' }).click();
  await page.getByLabel('Pose', { exact: true }).fill('late');
  await page.getByLabel('Camera', { exact: true }).selectOption('folder');
  await page.getByLabel('Folder', { exact: true }).fill(watched);
  await page.getByLabel('Turntable', { exact: true }).selectOption('none');
  await page.getByLabel('Rings, heights').fill('12');
  await button('Begin').click();
  const fault = page.locator('.shoot-say.fault');
  await fault.getByText(/is not there/).waitFor();
  await fault.getByText('It tries again by itself.').waitFor();
  await record(page, 'shoot_fault', null);
  mkdirSync(watched);
  await fault.waitFor({ state: 'detached' });
  await until('the session can begin', () => button('Shoot Space').isEnabled());
  await page.keyboard.press('Space');
  // Not the question that follows the photograph.
  const first = ask().filter({ hasNotText: /60 degrees/ });
  await until('a photograph lands', async () => {
    if (await first.count()) await page.keyboard.press('Space');
    if (!existsSync(join(watched, 'a.jpg')))
      copyFileSync(join(drawn, 'photos/rest/IMG_0001.jpg'), join(watched, 'a.jpg'));
    return rows();
  });
  await ask()
    .getByText(/Turn the table to 60 degrees/)
    .waitFor();
}

/** With a session at work, an idle connection and a tab that listens. */
async function stop() {
  browser.away = true;
  const began = Date.now();
  const code = await studio.end('SIGTERM');
  const ms = Date.now() - began;
  check(code === 0, `SIGTERM ends the studio with ${code}`);
  console.log(`    SIGTERM in a session: ${ms} ms`);
  check(ms < 1000, `the studio ended ${ms} ms after SIGTERM`);
}

/** What the simulated camera takes. */
function draw() {
  mkdirSync(folder);
  execFileSync(
    join(bin, 'keypose-synth'),
    [
      'photos',
      '--output',
      drawn,
      '--poses',
      'rest,bent',
      '--views',
      String(kAll),
      '--elevations',
      '12,40',
      ...(options.pictures ? ['--width', '800'] : ['--width', '240', '--spacing', '0.008']),
    ],
    { stdio: 'ignore' },
  );
}

function sideFile() {
  const side = JSON.parse(readFileSync(join(folder, 'photos/rest/shoot.json'), 'utf8'));
  check(
    Object.keys(side.photographs).length === kAll,
    'the side file does not have all photographs',
  );
}

await walkThrough({
  draw,
  enter,
  'set up': setUp,
  'first ring': firstRing,
  'open late': openLate,
  kill,
  again,
  'next pose': nextPose,
  end,
  'comes late': comesLate,
  stop,
  'side file': sideFile,
});
