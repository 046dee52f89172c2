import assert from 'node:assert/strict'
import { test } from 'node:test'

import { afterLine } from '../src/run_lines'
import { boxOf, parseMesh } from '../src/view/mesh_data'
import { bytes, count, cssShare, duration, durationRange } from '../src/words'

test('a mesh is read as the server writes it', () => {
  const buffer = new ArrayBuffer(16 + 36 + 12 + 24 + 12)
  const view = new DataView(buffer)
  ;[...'KPM1'].forEach((letter, i) => view.setUint8(i, letter.charCodeAt(0)))
  ;[3, 1, 3].forEach((value, i) => view.setUint32(4 + 4 * i, value, true))
  ;[0, 0, 0, 2, 0, 0, 0, 3, 0].forEach((value, i) => view.setFloat32(16 + 4 * i, value, true))
  ;[0, 1, 2].forEach((value, i) => view.setUint32(52 + 4 * i, value, true))
  view.setFloat32(64 + 4, 0.5, true)
  view.setUint8(88, 255)
  const mesh = parseMesh(buffer)
  assert.deepEqual([mesh.vertices, mesh.faces], [3, 1])
  assert.deepEqual([...mesh.indices], [0, 1, 2])
  assert.equal(mesh.uvs?.[1], 0.5)
  assert.equal(mesh.colors?.[0], 255)
  assert.deepEqual(boxOf(mesh.positions), [0, 0, 0, 2, 3, 0])
  assert.throws(() => parseMesh(new ArrayBuffer(16)), /unknown form/)
})

test('a run is followed line by line', () => {
  let run = { overall: 0, left: null, steps: {}, finished: {}, notes: [] } as Parameters<
    typeof afterLine
  >[0]
  run = afterLine(run, { event: 'start', step: 'sfm/rest', overall: 0.1, seconds_left: 9 })
  assert.equal(run.left, '9.0 s')
  const range: [number, number] = [100, 320]
  run = afterLine(run, { event: 'time', overall: 0.1, seconds_left: 180, seconds_left_range: range })
  assert.equal(run.left, '2 to 5 min')
  assert.deepEqual(Object.keys(run.steps), ['sfm/rest'])
  run = afterLine(run, {
    event: 'progress',
    step: 'sfm/rest',
    fraction: 0.5,
    what: 'matching',
    overall: 0.2,
  })
  assert.deepEqual(run.steps['sfm/rest'], { fraction: 0.5, what: 'matching' })
  run = afterLine(run, { event: 'finish', step: 'sfm/rest', status: 'made', overall: 0.3 })
  assert.deepEqual(run.steps, {})
  assert.deepEqual(run.finished, { 'sfm/rest': 'made' })
  assert.equal(run.overall, 0.3)
})

test('numbers are words that a person reads', () => {
  assert.equal(duration(3.21), '3.2 s')
  assert.equal(duration(125), '2 min 05 s')
  assert.equal(duration(4320), '1 h 12 min')
  assert.equal(durationRange(125, [115, 135]), '2 min 05 s')
  assert.equal(durationRange(70, [41, 118]), '40 s to 2 min')
  assert.equal(durationRange(2, [0, 7]), 'about 5 s')
  assert.equal(durationRange(4000, [1800, 9000]), '30 min to 2 h 30 min')
  assert.equal(durationRange(5800, [4100, 8300]), '1 h 10 min to 2 h 20 min')
  assert.equal(bytes(1234567), '1.2 MB')
  assert.equal(count(1, 'photograph'), '1 photograph')
  assert.equal(cssShare(0.456), '45.6%')
})
