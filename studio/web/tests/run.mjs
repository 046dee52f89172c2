// Checks the page's types, bundles the tests of its models, and runs them in one process: node run.mjs
import { spawnSync } from 'node:child_process'
import { mkdtempSync, readdirSync, rmSync } from 'node:fs'
import { createRequire } from 'node:module'
import { tmpdir } from 'node:os'
import { dirname, join } from 'node:path'
import { fileURLToPath } from 'node:url'

import { buildSync } from 'esbuild'

const here = dirname(fileURLToPath(import.meta.url))
const tests = readdirSync(here).filter((name) => name.endsWith('.test.ts'))
const folder = mkdtempSync(join(tmpdir(), 'studio_tests_'))
try {
  const all = join(folder, 'all.mjs')
  buildSync({
    stdin: { contents: tests.map((name) => `import './${name}'`).join('\n'), resolveDir: here },
    bundle: true,
    platform: 'node',
    format: 'esm',
    outfile: all,
  })
  const compiler = createRequire(import.meta.url).resolve('typescript/bin/tsc')
  for (const words of [[all], [compiler, '--noEmit', '-p', join(here, '..')]]) {
    const done = spawnSync(process.execPath, words, { stdio: 'inherit' })
    process.exitCode ||= done.status ?? 1
  }
} finally {
  rmSync(folder, { recursive: true })
}
