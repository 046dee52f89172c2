// The walk's part on the timeline: keys by keyboard, an ease, twos, new frames, scrub, play, onion
// skin.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';

import { boxOf, check, record, until } from './studio_driver.mjs';

/** A PNG of one red pixel. */
const kRedPixel =
  'iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVR4nGP4z8AAAAMBAQDJ/pLvAAAAAElFTkSuQmCC';
const kPlay_ms = 3000;
const kFramesSeconds = 400;

/** "bent, frame 14 · 0.58 s": 14 */
const frameIn = (label) => Number(/frame (\d+)/.exec(label)?.[1]);

/** The button for ones, twos or threes of the whole timeline. */
export const picturesStand = (page, name) =>
  page
    .getByRole('group', { name: 'Frames that each picture stands' })
    .getByRole('button', { name });

class Timeline {
  constructor(context) {
    Object.assign(this, context);
  }

  block = (index) => this.page.locator(`.tl-block[data-key="${index}"]`);
  frameOf = async (index) => frameIn(await this.block(index).getAttribute('aria-label'));
  button = (name) => this.page.getByRole('button', { name, exact: true });
  counter = async () => Number(await this.page.locator('.tl-now').textContent());

  async written(words, pattern) {
    await until(
      `${words} is in pipeline.yaml; it is\n${this.pipeline()}`,
      () => pattern.test(this.pipeline()),
      15,
    );
  }

  async edit() {
    const { page } = this;
    const before = await this.frameOf(1);
    await this.block(1).focus();
    await page.keyboard.press('Shift+ArrowRight');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    await until(
      'the key has moved by twelve frames',
      async () => (await this.frameOf(1)) === before + 12,
    );
    this.seconds = (before + 12) / 24;
    await this.written(
      'the time of the key',
      new RegExp(
        `\\{pose: bent, at: ${String(Number(this.seconds.toFixed(4))).replace('.', '\\.')}`,
      ),
    );
    await page.keyboard.press('ArrowUp');
    await page.keyboard.press('Alt+ArrowRight');
    await this.button('In-out').click();
    await picturesStand(page, 'Twos').click();
    await this.written('the ease', /pose: rest, at: 0, .*ease: in-out/);
    await this.written('the hold', /pose: rest, at: 0, .*hold: 0\.04/);
    await this.written('the pictures on twos', /^ {2}step: 2$/m);
    await page.keyboard.press('Control+z');
    await until('undo takes the twos back', () => !/^ {2}step: 2$/m.test(this.pipeline()));
    await page.keyboard.press('Control+Shift+z');
    await this.written('the pictures on twos, done again', /^ {2}step: 2$/m);
    check(this.pipeline().startsWith('#'), 'pipeline.yaml has lost its comment');
  }

  /**
   * A pin and a turn of the painted region come into the file with its vertices, and go with them.
   */
  async regions() {
    const { page } = this;
    await page.getByRole('tab', { name: 'Regions' }).click();
    await this.button('Pin it').click();
    await this.button('Turn it').click();
    await page.getByLabel('Axis of turn 1').selectOption('z');
    await this.written('the pin', /^ {2}pins: \[\{region: belly\}\]$/m);
    await this.written('the turn', /turns: \{belly: \{axis: \[0, 0, 1\], turns: 1\}\}/);
    await this.written('the region', /^ {2}regions: \[\{name: belly, vertices: \[\d/m);
    await record(page, 'regions', this.pictures);
    await page.getByLabel('Delete pin 1').click();
    await page.getByLabel('Delete turn 1').click();
    await until('they are gone again', () => !/belly/.test(this.pipeline()));
    await page.getByRole('tab', { name: 'Key', exact: true }).click();
  }

  async makeFrames() {
    const { page } = this;
    await page.getByText('the timeline has changed since').waitFor();
    await this.button('Make frames').click();
    await page
      .getByText('the timeline has changed since')
      .waitFor({ state: 'detached', timeout: 1000 * kFramesSeconds });
    const frames = await (await page.request.get(new URL('/api/frames', page.url()).href)).json();
    const last = Number((await page.locator('.tl-counter .soft').textContent()).replace('/', ''));
    check(frames.count === last + 1, `${frames.count} frames were made, the ruler has ${last + 1}`);
  }

  async scrub() {
    const { page } = this;
    const box = await boxOf(page.getByRole('slider', { name: 'Playhead' }));
    const y = box.y + box.height / 2;
    await page.mouse.move(box.x + 30, y);
    await page.mouse.down();
    const seen = new Set();
    for (let i = 1; i <= 12; ++i) {
      await page.mouse.move(box.x + 30 + i * (box.width / 30), y);
      seen.add(await this.counter());
    }
    await page.mouse.up();
    check(seen.size > 5, `scrubbing showed only the frames ${[...seen]}`);
    const at = await this.counter();
    await page.keyboard.press(',');
    await until('the comma goes a frame back', async () => (await this.counter()) === at - 1);
  }

  async play() {
    const { page } = this;
    await page.keyboard.press('Home');
    await this.button('Play').click();
    const seen = new Set();
    for (const end = Date.now() + kPlay_ms; Date.now() < end; await page.waitForTimeout(40))
      seen.add(await this.counter());
    await this.button('Pause').click();
    const dropped = await page.locator('main').getAttribute('data-dropped');
    console.log(
      `    ${kPlay_ms / 1000} s played, ${seen.size} frames seen here, ${dropped} dropped`,
    );
    check(seen.size > 3, `playing showed only the frames ${[...seen]}`);
    check(/^\d+$/.test(dropped), `data-dropped is '${dropped}'`);
  }

  /** The share of the view's pixels that are pure red. */
  async redness() {
    const picture = await this.page.locator('.view canvas').first().screenshot();
    return this.page.evaluate(async (base64) => {
      const image = new Image();
      image.src = `data:image/png;base64,${base64}`;
      await image.decode();
      const canvas = new OffscreenCanvas(image.width, image.height);
      const context = canvas.getContext('2d');
      context.drawImage(image, 0, 0);
      const { data } = context.getImageData(0, 0, image.width, image.height);
      let red = 0;
      for (let i = 0; i < data.length; i += 4)
        red += data[i] > 250 && data[i + 1] < 5 && data[i + 2] < 5;
      return red / (data.length / 4);
    }, picture.toString('base64'));
  }

  /** Between keys the figure wears the textures of both; at a key that of its pose. */
  async blend() {
    const { page } = this;
    const red = Buffer.from(kRedPixel, 'base64');
    await page.route(/api\/texture\?pose=bent/, (route) =>
      route.fulfill({ contentType: 'image/png', body: red }),
    );
    await page.reload();
    await this.button('Play').waitFor();
    await page.keyboard.press('End');
    await until('the last key wears its own texture', async () => (await this.redness()) > 0.02);
    await page.keyboard.press('Home');
    await until('the first key wears its own', async () => (await this.redness()) === 0);
    for (let i = 0; i < 11; ++i) await page.keyboard.press('.');
    await page.waitForTimeout(400);
    check((await this.redness()) === 0, 'half-way the figure wears the next texture only');
    await page.unroute(/api\/texture\?pose=bent/);
    await page.reload();
    await this.button('Play').waitFor();
  }

  async onion() {
    const { page } = this;
    await page.keyboard.press('Home');
    for (let i = 0; i < 8; ++i) await page.keyboard.press('.');
    await page.keyboard.press('o');
    check(
      (await this.button('Onion skin').getAttribute('aria-pressed')) === 'true',
      'the key O does not switch the onion skin on',
    );
    await page.getByRole('button', { name: 'Frames after: one more' }).waitFor();
    await page.waitForTimeout(600);
    await this.block(0).focus();
    await record(page, 'timeline', this.pictures);
  }
}

export async function walkTimeline(context) {
  const { page, go } = context;
  await go('#/timeline');
  await page.getByRole('group', { name: 'Keys', exact: true }).waitFor();
  const blocks = page.locator('.tl-block');
  await until('a project without a timeline plays a loop', async () => (await blocks.count()) === 3);
  writeFileSync(
    join(context.folder, 'pipeline.yaml'),
    `${context.pipeline()}timeline: [rest, bent]\n`,
  );
  await until('a list by hand takes its place', async () => (await blocks.count()) === 2);
  const timeline = new Timeline(context);
  await timeline.edit();
  await timeline.regions();
  await timeline.makeFrames();
  await timeline.scrub();
  await timeline.play();
  await timeline.blend();
  await timeline.onion();
}
