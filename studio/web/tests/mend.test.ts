import assert from 'node:assert/strict'
import { test } from 'node:test'

import { draftFrom, kFirstBrush, MendPath, movedLevels, strokeName } from '../src/pages/poses/mend_model'

const hit = (x: number, face: number) => ({
  face,
  barycentric: [1, 0, 0] as [number, number, number],
  place: [x, 0, 0] as [number, number, number],
  ms: 0,
})

test('a path keeps places that are a third of the radius apart', () => {
  const path = new MendPath()
  const taken = [0, 0.01, 0.03, 0.05, 0.06, 0.2].map((x, i) => path.add(hit(x, i), 0.09))
  assert.deepEqual(taken, [true, false, true, false, true, true])
  const stroke = path.stroke({ ...kFirstBrush, tool: 'pull', radius: 0.03 }, 3)
  assert.deepEqual(
    stroke.places.map((one) => one.face),
    [0, 2, 4, 5],
  )
  assert.ok(Math.abs(stroke.radius - 0.09) < 1e-12)
  assert.equal(stroke.strength, kFirstBrush.strength.pull)
  assert.equal(strokeName(stroke), 'Pull out')
  assert.equal(strokeName({ ...stroke, strength: -0.1 }), 'Pull in')
})

test('a draft is read as positions, then two numbers a stroke', () => {
  const draft = draftFrom(new Float32Array([0, 0, 0, 1, 2, 3, 7, 0.5]).buffer, 2)
  assert.deepEqual([...draft.positions], [0, 0, 0, 1, 2, 3])
  assert.deepEqual(draft.moved, [{ vertices: 7, furthest: 0.5 }])
})

test('how far each place was moved is over the farthest; the rest has no colour', () => {
  const before = new Float32Array([0, 0, 0, 1, 0, 0, 2, 0, 0])
  const after = new Float32Array([0, 0, 0, 1, 0, 2, 2, 1, 0])
  assert.deepEqual([...movedLevels(before, after)], [NaN, 1, 0.5])
  assert.ok([...movedLevels(before, before)].every(Number.isNaN))
})
