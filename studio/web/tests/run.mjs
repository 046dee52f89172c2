// Bundles the tests of the page's models, and runs them: node run.mjs
import { spawnSync } from 'node:child_process'
import { mkdtempSync, readdirSync, rmSync } from 'node:fs'
import { tmpdir } from 'node:os'
import { dirname, join } from 'node:path'
import { fileURLToPath } from 'node:url'

import { buildSync } from 'esbuild'

const here = dirname(fileURLToPath(import.meta.url))
const tests = readdirSync(here).filter((name) => name.endsWith('.test.ts'))
const folder = mkdtempSync(join(tmpdir(), 'studio_tests_'))
try {
  buildSync({
    entryPoints: tests.map((name) => join(here, name)),
    bundle: true,
    platform: 'node',
    format: 'esm',
    outdir: folder,
    outExtension: { '.js': '.mjs' },
  })
  const files = tests.map((name) => join(folder, name.replace('.ts', '.mjs')))
  const done = spawnSync(process.execPath, ['--test', ...files], { stdio: 'inherit' })
  process.exitCode = done.status ?? 1
} finally {
  rmSync(folder, { recursive: true })
}
