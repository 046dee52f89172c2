// Starts a studio and a browser for the tests of the page; what all of these share.
// A walk takes 20 s or more: Chromium starts, draws without a graphics card, and axe-core looks at each page twice.
import { spawn } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';

import { chromium } from 'playwright-core';

const kBrowser = '/usr/bin/chromium';
const kArguments = [
  '--headless',
  '--no-sandbox',
  '--disable-gpu',
  '--use-gl=angle',
  '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];
const kUnsaved = 'The last change could not be saved';
const kAxe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/**
 * What a test was started with: the folder of the programs, and the options, of which every test
 * has --pictures and --keep. Ends the program with 2 where the words make no sense.
 * @param more  further options, as parseArgs takes them
 */
function readWords(test, more = {}) {
  const known = { pictures: { type: 'string' }, keep: { type: 'boolean' }, ...more };
  try {
    const { values, positionals } = parseArgs({ allowPositionals: true, options: known });
    if (positionals.length === 1) return { bin: resolve(positionals[0]), options: values };
  } catch (error) {
    console.error(error.message);
  }
  const words = Object.entries(known).map(([name, { type }]) =>
    type === 'string' ? `[--${name} ${name.toUpperCase()}]` : `[--${name}]`,
  );
  console.error(`usage: node ${test} BIN_DIR ${words.join(' ')}`);
  process.exit(2);
}

/** @throws Error with these words */
export function check(condition, words) {
  if (!condition) throw new Error(words);
}

/** Asks again and again; the first answer that is not false, null or ''. */
export async function until(words, probe, seconds = 30) {
  const end = Date.now() + 1000 * seconds;
  let last = '';
  while (Date.now() < end) {
    try {
      const answer = await probe();
      if (answer) return answer;
    } catch (error) {
      last = ` (${error.message})`;
    }
    await new Promise((go) => setTimeout(go, 150));
  }
  throw new Error(`not within ${seconds} s: ${words}${last}`);
}

/**
 * Where an element is on the screen, once it is shown and has come to rest: a picture that is still
 * being loaded has no place, and one that slides in has another a moment later.
 */
export async function boxOf(element) {
  const sides = ['x', 'y', 'width', 'height'];
  let last = null;
  return until(`${element} is shown and at rest`, async () => {
    const before = last ?? (await element.boundingBox());
    await element.evaluate(() => new Promise((drawn) => requestAnimationFrame(drawn)));
    last = await element.boundingBox();
    return before && last && sides.every((side) => before[side] === last[side]) ? last : null;
  });
}

/** The program `keypose studio` of one folder. */
class StudioProgram {
  constructor(bin, folder) {
    this.bin = bin;
    /** what it is started with, until it has a port */
    this.words = ['-C', folder];
    /** of spawn: its folder and variables */
    this.place = {};
    this.port = 0;
  }

  /** The address to enter at. Started again, it listens on the same port. */
  async start() {
    const words = [
      'studio',
      ...this.words,
      '--no-browser',
      ...(this.port ? ['--port', String(this.port)] : []),
    ];
    this.program = spawn(join(this.bin, 'keypose'), words, {
      ...this.place,
      stdio: ['ignore', 'pipe', 'inherit'],
    });
    this.ended = new Promise((resolve) =>
      this.program.once('exit', (code, signal) => resolve(signal ?? code)),
    );
    const line = await new Promise((resolve, reject) => {
      let text = '';
      this.program.stdout.on('data', (piece) => {
        text += piece;
        if (text.includes('\n')) resolve(text.split('\n')[0]);
      });
      this.program.once('exit', (code) =>
        reject(new Error(`keypose studio ended with ${code} before it gave an address`)),
      );
    });
    check(
      /^http:\/\/127\.0\.0\.1:\d+\/enter\?token=[0-9a-f]{32}$/.test(line),
      `the first line is no address: ${line}`,
    );
    this.port = Number(new URL(line).port);
    return line;
  }

  /** The exit code, or the name of the signal. */
  async end(signal) {
    this.program.kill(signal);
    return Promise.race([
      this.ended,
      new Promise((resolve) => setTimeout(resolve, 20000, 'it goes on after 20 s')),
    ]);
  }
}

/** A browser that keeps what goes wrong in its pages. */
class Browser {
  /** what must be empty at the end */
  faults = [];
  /** the tab that was opened last */
  page = null;
  /** while true, a server that does not answer is no fault */
  away = false;
  /** kinds of the page's own questions before it is left, and how they are answered */
  questions = [];
  stays = false;

  async start() {
    this.browser = await chromium.launch({ executablePath: kBrowser, args: kArguments });
    this.context = await this.browser.newContext({
      viewport: { width: 1280, height: 800 },
      colorScheme: 'light',
    });
  }

  async tab() {
    const page = await this.context.newPage();
    this.page = page;
    page.on('pageerror', (error) =>
      this.faults.push(`${page.url()}: ${error.stack ?? error.message}`),
    );
    page.on('console', (message) => {
      const text = message.text();
      if (
        message.type() === 'error' &&
        !this.away &&
        !/the server responded with a status of/.test(text)
      )
        this.faults.push(`${page.url()}: ${text}`);
    });
    page.on('response', (response) => {
      if (response.status() >= 400 && !this.expected?.test(response.url()))
        this.faults.push(
          `${page.url()}: ${response.status()} for ${response.request().method()} ` +
          `${response.url()}`,
        );
    });
    page.on('request', (request) => {
      const url = new URL(request.url());
      if (/^https?:$/.test(url.protocol) && url.hostname !== '127.0.0.1')
        this.faults.push(`${page.url()} asks another machine: ${request.url()}`);
    });
    page.on('dialog', (dialog) => {
      const ours = dialog.type() === 'beforeunload' || dialog.message().startsWith(kUnsaved);
      if (ours) this.questions.push(dialog.type());
      else this.faults.push(`a script ran: ${dialog.message()}`);
      (this.stays ? dialog.dismiss() : dialog.accept()).catch(() => undefined);
    });
    return page;
  }

  async end() {
    await this.browser?.close();
  }
}

/** Waits until the page is drawn as it is now, and what fades or slides has come to its end. */
async function atRest(page) {
  await page.evaluate(async () => {
    const drawn = () => new Promise((next) => requestAnimationFrame(next));
    const ends = (one) =>
      one.playState === 'running' && Number.isFinite(one.effect?.getComputedTiming().endTime);
    await drawn();
    await drawn();
    const moving = document.getAnimations().filter(ends);
    await Promise.all(moving.map((one) => one.finished.catch(() => undefined)));
    await drawn();
  });
}

/** @throws Error with each thing that axe-core finds on the page */
export async function checkAccess(page, name) {
  if (!(await page.evaluate(() => 'axe' in globalThis))) await page.evaluate(kAxe);
  const found = await page.evaluate(() =>
    globalThis.axe.run(document, { resultTypes: ['violations'] }),
  );
  const lines = found.violations.flatMap((rule) =>
    rule.nodes.map(
      (node) =>
        `  ${rule.id}: ${rule.help}\n    ${node.html.slice(0, 200)}\n    ` +
        `${node.failureSummary?.split('\n').slice(1, 3).join(' ')}`,
    ),
  );
  check(lines.length === 0, `axe-core on ${name}:\n${lines.join('\n')}`);
}

const kSizes = [
  { width: 1280, height: 800, colours: 'light' },
  { width: 1920, height: 1080, colours: 'dark' },
];

/** Pictures of a page in both sizes, if somebody wants them; axe-core looks at both colours. */
export async function record(page, name, pictures) {
  if (pictures) mkdirSync(pictures, { recursive: true });
  for (const { width, height, colours } of kSizes) {
    await page.setViewportSize({ width, height });
    await page.emulateMedia({ colorScheme: colours });
    await atRest(page);
    if (pictures) await page.waitForTimeout(900);
    await checkAccess(page, `${name}, ${colours}`);
    if (pictures) await page.screenshot({ path: join(pictures, `${name}_${colours}.png`) });
  }
  await page.setViewportSize({ width: 1280, height: 800 });
  await page.emulateMedia({ colorScheme: 'light' });
  await atRest(page);
}

/** @param parts  pairs of a name and what to do, in order, or an object of them */
async function runParts(parts) {
  for (const [name, act] of Array.isArray(parts) ? parts : Object.entries(parts)) {
    const began = Date.now();
    await act();
    console.log(`ok  ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  }
}

/** @throws Error with all that went wrong in the browser's pages */
function checkFaults(browser) {
  const faults = new Set(browser.faults);
  check(faults.size === 0, `faults in the page:\n${[...faults].join('\n')}`);
}

async function tellFailure(error, test, browser) {
  const lines = error.stack?.split('\n').filter((line) => line.includes('testing/'));
  console.error(`FAILED: ${error.message}\n${lines?.join('\n')}`);
  for (const fault of new Set(browser.faults)) console.error(`fault in the page: ${fault}`);
  const shown = join(tmpdir(), `keypose_${test}_failed.png`);
  await browser.page?.screenshot({ path: shown }).then(
    () => console.error(`what the page showed: ${shown}`),
    () => undefined,
  );
}

/** Starts studio and browser. @param prepare  called with the tab before it loads the page */
async function openPage({ browser, studio }, prepare) {
  await browser.start();
  const address = await studio.start();
  const page = await browser.tab();
  await prepare?.(page);
  await page.goto(address);
  return page;
}

/**
 * Runs a test to its end, whatever happens: the exit code, what went wrong and a picture of it, and
 * nothing left over; with --keep the project stays.
 */
async function walkThrough(opened, parts, done = 'all of it went well') {
  const { test, options, scratch, folder, browser, studio } = opened;
  try {
    await runParts(parts);
    checkFaults(browser);
    console.log(done);
  } catch (error) {
    await tellFailure(error, test, browser);
    process.exitCode = 1;
  } finally {
    await browser.end();
    studio.program?.kill('SIGKILL');
    if (options.keep) console.log(`kept: ${folder}`);
    else rmSync(scratch, { recursive: true, force: true });
  }
}

/**
 * What every walk begins with: its words, a folder that is gone afterwards, a studio and a browser.
 * `openPage` starts them and gives a tab; `walkThrough(parts, done)` is the whole walk.
 * @param test     of TEST_test.mjs
 * @param project  name of the project's folder, which is not made yet
 * @param more     further options, as parseArgs takes them
 */
export function withStudio(test, project, more) {
  const words = readWords(`${test}_test.mjs`, more);
  const scratch = mkdtempSync(join(tmpdir(), `keypose_studio_${test}_`));
  const folder = join(scratch, project);
  const browser = new Browser();
  const studio = new StudioProgram(words.bin, folder);
  const opened = { ...words, test, scratch, folder, browser, studio };
  return {
    ...opened,
    openPage: (prepare) => openPage(opened, prepare),
    walkThrough: (parts, done) => walkThrough(opened, parts, done),
  };
}
