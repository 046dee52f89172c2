// Runs the code of docs/vertex-animation-textures.md in a browser without a graphics card, and
// compares what it gives with the true frames.   node run_in_browser.mjs FOLDER NAME PAGE
// [PICTURE.png] FOLDER has vat/NAME.json and truth/, which WriteTruth made. PAGE: draw_page.mjs
// draws by the three.js code; engines_page.mjs runs the shaders of Godot and Unity. Prints figures
// as name=number.
import { createReadStream, existsSync, readFileSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { join, normalize } from 'node:path';

import { chromium } from 'playwright-core';

import { readPng } from './read_png.mjs';

const root = join(import.meta.dirname, '../../..');
const [folder, name, module, picture] = process.argv.slice(2);
const kinds = {
  js: 'text/javascript',
  mjs: 'text/javascript',
  json: 'application/json',
  png: 'image/png',
  html: 'text/html',
};

/** The code blocks of a language in a Markdown page. */
function codeBlocks(page, language) {
  return [
    ...readFileSync(page, 'utf8').matchAll(new RegExp('^```' + language + '\\n(.*?)^```', 'gms')),
  ].map((match) => match[1]);
}

const manual = join(root, 'docs/vertex-animation-textures.md');
const blocks = {
  '/keypose-vat.js': codeBlocks(manual, 'js')[0],
  '/keypose_vat.gdshader': codeBlocks(manual, 'glsl')[0],
  '/KeyposeVat.hlsl': codeBlocks(manual, 'hlsl')[0],
};

/** The 16-bit positions as numbers from 0 to 1, as an engine that keeps all bits has them. */
function positions() {
  const { values } = readPng(join(folder, 'vat', `${name}_positions.png`));
  return Buffer.from(Float32Array.from(values, (code) => code / 65535).buffer);
}

const page = `<!doctype html><title>vat</title><link rel="icon" href="data:,"><body style="margin:0">
<canvas width="480" height="480"></canvas>
<script type="importmap">{"imports": {"three": "/node_modules/three/build/three.module.js",
  "three/addons/": "/node_modules/three/examples/jsm/"}}</script>
<script type="module" src="/page.mjs"></script>`;

function answer(request, response) {
  const path = normalize(decodeURIComponent(new URL(request.url, 'http://x').pathname));
  const send = (kind, text) =>
    response
      .writeHead(200, { 'Content-Type': kinds[kind] ?? 'application/octet-stream' })
      .end(text);
  if (path === '/') return send('html', page);
  if (path in blocks) return send('js', blocks[path]);
  if (path === '/positions.f32') return send('', positions());
  if (path === '/page.mjs') return send('mjs', readFileSync(join(import.meta.dirname, module)));
  const file = path.startsWith('/node_modules/') ? join(root, path) : join(folder, path);
  if (!existsSync(file)) return response.writeHead(404).end();
  response.writeHead(200, {
    'Content-Type': kinds[file.split('.').pop()] ?? 'application/octet-stream',
  });
  return createReadStream(file).pipe(response);
}

const server = createServer(answer).listen(0, '127.0.0.1');
await new Promise((listening) => server.once('listening', listening));
const browser = await chromium.launch({
  executablePath: '/usr/bin/chromium',
  args: [
    '--headless',
    '--no-sandbox',
    '--disable-gpu',
    '--use-gl=angle',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    '--no-first-run',
    '--disable-background-networking',
    '--disable-component-update',
    '--disable-sync',
  ],
});
let code = 0;
try {
  const tab = await browser.newPage({ viewport: { width: 480, height: 480 } });
  const faults = [];
  tab.on('pageerror', (error) => faults.push(error.stack ?? error.message));
  tab.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
  await tab.goto(`http://127.0.0.1:${server.address().port}/?name=${encodeURIComponent(name)}`);
  await tab
    .waitForFunction(() => globalThis.figures || globalThis.fault, null, { timeout: 120000 })
    .catch((error) => faults.push(error.message));
  const fault = await tab.evaluate(() => globalThis.fault);
  if (fault) faults.push(fault);
  const figures = await tab.evaluate(() => globalThis.figures);
  for (const [key, value] of Object.entries(figures ?? {})) console.log(`${key}=${value}`);
  if (picture) writeFileSync(picture, await tab.screenshot());
  for (const text of faults) console.error(text);
  code = faults.length > 0 ? 1 : 0;
} finally {
  await browser.close();
  server.close();
}
process.exit(code);
