// Bundles the tests of the page's models, and runs them in one process: node run.mjs
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
  const all = join(folder, 'all.mjs')
  buildSync({
    stdin: { contents: tests.map((name) => `import './${name}'`).join('\n'), resolveDir: here },
    bundle: true,
    platform: 'node',
    format: 'esm',
    outfile: all,
  })
  const done = spawnSync(process.execPath, [all], { stdio: 'inherit' })
  process.exitCode = done.status ?? 1
} finally {
  rmSync(folder, { recursive: true })
}
