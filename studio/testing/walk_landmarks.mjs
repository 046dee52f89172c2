// The walk's part on landmarks: pairs picked by clicks on places that the truth names, suggestions,
// registration, paint.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';

import { boxOf, check, record, until } from './studio_driver.mjs';
import {
  firstHit,
  length,
  meshOf,
  placeOn,
  similarity,
  sub,
  trueCentres,
  View,
} from './walk_geometry.mjs';

const kPairs = 6;
const kMost_ms = 5;
const kSides = { rest: 'mesh', bent: 'clean' };
/** Of the figure's size: how far the scan may be from the truth. */
const kSlack = 0.03;
/** So that no click meets another marker. */
const kApart = 0.1;

const pairsIn = (title) => Number(/Pairs · (\d+)/.exec(title)?.[1]);

export class Landmarks {
  constructor(context) {
    Object.assign(this, context);
    this.turns = { rest: [0, 0], bent: [0, 0] };
    /** presses of the arrow key upwards that are tried */
    this.tilts = [0];
    this.times = [];
  }

  canvas(pose) {
    return this.page.getByRole('region', { name: `${pose}: 3D view` }).locator('canvas');
  }

  file(pose) {
    return JSON.parse(readFileSync(join(this.folder, 'landmarks', `${pose}.json`), 'utf8'));
  }

  async ask(path) {
    const answer = await this.page.request.get(new URL(path, this.page.url()).href);
    check(answer.ok(), `${answer.status()} for ${path}`);
    return answer;
  }

  picks = async (pose) => (await (await this.ask(`/api/landmarks?pose=${pose}`)).json()).picks;

  /** The meshes as the page shows them, and the truth's landmarks on them. */
  async load() {
    this.meshes = {};
    this.places = {};
    for (const [pose, what] of Object.entries(kSides)) {
      this.meshes[pose] = meshOf(
        await (await this.ask(`/api/mesh?pose=${pose}&what=${what}`)).body(),
      );
      const cameras = await (await this.ask(`/api/cameras?pose=${pose}`)).json();
      const truth = trueCentres(this.data, pose);
      const known = cameras.filter((camera) => truth.has(camera.name));
      const map = similarity(
        known.map((camera) => truth.get(camera.name)),
        known.map(({ pose: m }) => [m[3], m[7], m[11]]),
      );
      const { landmarks } = JSON.parse(
        readFileSync(join(this.data, 'truth', pose, 'landmarks.json'), 'utf8'),
      );
      this.places[pose] = new Map(landmarks.map(({ name, position }) => [name, map(position)]));
    }
  }

  async view(pose, turns) {
    return new View(this.meshes[pose], await boxOf(this.canvas(pose)), turns);
  }

  /** The fewest turns after which a place is seen, or null. */
  async turnsToSee(pose, place) {
    for (const tilts of this.tilts)
      for (let by = 0; by <= 26; ++by)
        for (const turns of [by, -by])
          if ((await this.view(pose, [turns, tilts])).sees(place, kSlack * this.meshes[pose].size))
            return [turns, tilts];
    return null;
  }

  turnsFor = (pose, name) => this.turnsToSee(pose, this.places[pose].get(name));

  async turnTo(pose, wanted) {
    await this.canvas(pose).focus();
    for (const [axis, [more, less]] of [
      ['ArrowRight', 'ArrowLeft'],
      ['ArrowUp', 'ArrowDown'],
    ].entries()) {
      const by = wanted[axis] - this.turns[pose][axis];
      for (let i = 0; i < Math.abs(by); ++i) await this.page.keyboard.press(by > 0 ? more : less);
    }
    this.turns[pose] = wanted;
  }

  async pointOf(pose, place) {
    const { x, y } = (await this.view(pose, this.turns[pose])).pointOf(place);
    return [Math.round(x), Math.round(y)];
  }

  async click(pose, name) {
    await this.turnTo(pose, await this.turnsFor(pose, name));
    const point = await this.pointOf(pose, this.places[pose].get(name));
    await this.page.mouse.click(...point);
    this.times.push(Number(await this.page.locator('main').getAttribute('data-pick-ms')));
    return point;
  }

  /** A pick lies where it was clicked, on the surface that is in front. */
  async checkPlace(pose, pick, point) {
    const view = await this.view(pose, this.turns[pose]);
    const place = placeOn(this.meshes[pose], pick);
    const seen = view.pointOf(place);
    const off = Math.hypot(seen.x - point[0], seen.y - point[1]);
    check(
      off < 1,
      `${pick.name} on ${pose} lies ${off.toFixed(1)} pixels from where it was clicked`,
    );
    const towards = sub(place, view.eye);
    const gap = Math.abs(firstHit(this.meshes[pose], view.eye, towards) - 1) * length(towards);
    check(gap < 1e-3 * this.meshes[pose].size, `${pick.name} on ${pose} lies behind the surface`);
  }

  pairs = async () => pairsIn(await this.page.locator('.lm-pairs h2').textContent());

  /**
   * Landmarks that are seen on both, far from each other and from the places that the page marks as
   * advice.
   */
  async choose() {
    const taken = (await (await this.ask('/api/landmarks/advice?pose=bent')).json()).map(
      (advice) => advice.place,
    );
    const names = [];
    for (const [name, place] of this.places.rest) {
      const far = taken.every(
        (other) => length(sub(other, place)) > kApart * this.meshes.rest.size,
      );
      const seen =
        far &&
        (await this.turnsFor('rest', name)) !== null &&
        (await this.turnsFor('bent', name)) !== null;
      if (!seen || names.length === kPairs) continue;
      names.push(name);
      taken.push(place);
    }
    check(names.length >= 4, `only ${names} are seen on both`);
    return names;
  }

  async pickPairs() {
    const chosen = await this.choose();
    for (const [i, name] of chosen.entries()) {
      const first = await this.click('rest', name);
      await this.page.getByText(`now click the same place on bent`).waitFor();
      const second = await this.click('bent', name);
      await until(`pair ${i + 1} is made`, async () => (await this.pairs()) === i + 1);
      const at = async (pose, point) =>
        this.checkPlace(
          pose,
          await until('it is saved', async () => (await this.picks(pose))[i]),
          point,
        );
      await at('rest', first);
      await at('bent', second);
    }
    const sorted = [...this.times].sort((a, b) => a - b);
    const median = sorted[sorted.length >> 1];
    console.log(
      `    ${chosen.length} pairs; a pick takes ${median.toFixed(2)} ms, at most ` +
      `${sorted.at(-1).toFixed(2)} ms`,
    );
    check(sorted.length > 0 && sorted.at(-1) > 0 && median < kMost_ms, `a pick takes ${median} ms`);
  }

  /** Back to the whole figures, as lists may have turned the views. */
  async whole() {
    await this.page.keyboard.press('Escape');
    await this.page.keyboard.press('h');
    this.turns = { rest: [0, 0], bent: [0, 0] };
  }

  async edit() {
    const { page } = this;
    await page.locator('.lm-pairs [data-row]').first().click();
    await page.keyboard.press('F2');
    await page.keyboard.type('big toe');
    await page.keyboard.press('Enter');
    await until(
      'the new name is in both files',
      async () =>
        (await this.picks('rest'))[0].name === 'big toe' &&
        (await this.picks('bent')).some((pick) => pick.name === 'big toe'),
    );
    await this.drag();
    await page.keyboard.press('Control+z');
    await until(
      'the drag is undone',
      async () => JSON.stringify((await this.picks('rest'))[0]) === JSON.stringify(this.before),
    );
    await page.getByText('Undone: move big toe.').waitFor();
  }

  async drag() {
    const { page } = this;
    await this.whole();
    this.before = (await this.picks('rest'))[0];
    const place = placeOn(this.meshes.rest, this.before);
    const turns = await this.nearestSeen('rest', place);
    await this.turnTo('rest', turns);
    const [x, y] = await this.pointOf('rest', place);
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 6; ++i) await page.mouse.move(x, y - 2 * i);
    await page.mouse.up();
    const moved = await until('the drag is saved', async () => {
      const now = (await this.picks('rest'))[0];
      return JSON.stringify(now) !== JSON.stringify(this.before) && now;
    });
    await this.checkPlace('rest', moved, [x, y - 12]);
  }

  async nearestSeen(pose, place) {
    const turns = await this.turnsToSee(pose, place);
    check(turns !== null, 'a pick is seen from nowhere');
    return turns;
  }

  async suggest() {
    const { page } = this;
    const before = await this.pairs();
    await page.getByRole('button', { name: 'Suggest' }).click();
    await until('suggestions are there', () => page.locator('.lm-suggested li').count(), 300);
    const offered = await page.locator('.lm-suggested li').count();
    check(offered >= 3, `only ${offered} suggestions`);
    await page.waitForTimeout(300);
    await record(page, 'landmarks', this.pictures);
    await page.getByRole('button', { name: 'Accept suggestion 1', exact: true }).click();
    await until('the first is accepted', async () => (await this.pairs()) === before + 1);
    for (let i = 2; i <= 3; ++i) {
      await page.locator('.lm-suggested [data-row]').first().focus();
      await page.locator('.lm-suggested [data-row]').first().click();
      await page.keyboard.press('Enter');
      await until(`suggestion ${i} is accepted`, async () => (await this.pairs()) === before + i);
    }
    const refuse = page.getByRole('button', { name: 'Refuse all' });
    if (await refuse.count()) await refuse.click();
    await until(
      'the file has the accepted ones',
      async () => (await this.picks('bent')).length === before + 3,
    );
    for (const pose of Object.keys(kSides))
      check(
        JSON.stringify(this.file(pose)).includes('big toe'),
        `landmarks/${pose}.json lacks a pick`,
      );
  }

  /** Median and 95 % of the distance to the scan, and how far the pairs are apart. */
  figures = (when) => this.page.locator(`.lm-bar.${when} .number`).allTextContents();

  async register() {
    const { page } = this;
    const now = await this.figures('after');
    check(now.length === 3, `the page shows no fit of the first registration: ${now}`);
    await page.getByRole('button', { name: 'Lay the net on bent' }).click();
    await page.getByRole('button', { name: 'Lays the net …' }).waitFor();
    await until(
      'the fit before and after is shown',
      async () =>
        (await this.figures('before')).length === 3 && (await this.figures('after')).length === 3,
      400,
    );
    const [before, after] = [await this.figures('before'), await this.figures('after')];
    console.log(
      `    distance to the scan, median and 95 %, and of pairs: ${before.join(', ')} before, ` +
      `${after.join(', ')} after`,
    );
    check(
      before.slice(0, 2).join() === now.slice(0, 2).join(),
      `the fit before was ${now}, the page says ${before}`,
    );
    const [was, is] = [before, after].map((one) => parseFloat(one[1]));
    check(
      is < 1.5 * was + 0.2,
      `landmarks on true places make the fit worse: ${before} to ${after}`,
    );
    await record(page, 'register', null);
  }
}

export async function walkLandmarks(context) {
  const { page, go } = context;
  await go('#/landmarks');
  await until(
    'both meshes are shown',
    async () =>
      (await page.locator('.lm-wait').count()) === 0 &&
      (await page.locator('.lm-drop canvas').count()) === 2,
  );
  const landmarks = new Landmarks(context);
  await landmarks.load();
  await page.getByRole('button', { name: 'Turn together' }).click();
  await landmarks.whole();
  await landmarks.pickPairs();
  await landmarks.edit();
  await landmarks.whole();
  await landmarks.suggest();
  await landmarks.register();
}

/** A region and some stiffness, painted on the template. */
export async function walkPaint(context) {
  const { page, pictures, folder } = context;
  await page.getByRole('button', { name: 'Paint', exact: true }).first().click();
  const canvas = page.locator('.lm-work canvas');
  await until(
    'the template is shown',
    async () => (await page.locator('.lm-wait').count()) === 0 && (await canvas.count()) === 1,
  );
  await page.waitForTimeout(500);
  const stroke = async (name) => {
    const box = await boxOf(canvas);
    const [x, y] = [box.x + box.width / 2, box.y + 0.45 * box.height];
    await page.mouse.move(x, y);
    await page.mouse.down();
    for (let i = 1; i <= 8; ++i) await page.mouse.move(x + 3 * i, y + 2 * i);
    await page.mouse.up();
    return until(`${name} is on disk`, () => readFileSync(join(folder, name), 'utf8'));
  };
  await page.getByRole('button', { name: 'Stiff', exact: true }).click();
  await stroke('stiffness.json');
  await page.getByLabel('Name of a new region').fill('belly');
  await page.getByRole('button', { name: 'Add', exact: true }).first().click();
  const regions = await stroke('regions.json');
  check(regions.includes('belly'), `regions.json has no belly: ${regions.slice(0, 200)}`);
  await page.locator('.lm-pairs [data-layer], .lm-pairs .lm-row').first().click();
  await record(page, 'paint', pictures);
}
