// Runs the Khronos glTF validator on files; fails if one has an error. node tests/validate_gltf.mjs FILE.glb ...
import { readFile } from 'node:fs/promises';
import { basename } from 'node:path';
import { createRequire } from 'node:module';

const validator = createRequire(import.meta.url)('gltf-validator');
const severities = ['error', 'warning', 'information', 'hint'];
const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node tests/validate_gltf.mjs FILE.glb ...');
  process.exit(2);
}
let errors = 0;
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), { uri: basename(file), maxIssues: 1000 });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  for (const m of messages) console.log(`${severities[m.severity]}: ${m.code} at ${m.pointer ?? ''}: ${m.message}`);
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} informations, ${numHints} hints`);
  errors += numErrors;
}
process.exit(errors > 0 ? 1 : 0);
