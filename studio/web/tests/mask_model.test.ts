import assert from 'node:assert/strict'
import { test } from 'node:test'

import { kFigure, kOutside, MaskModel } from '../src/pages/poses/mask_model'
import type { Point } from '../src/pages/poses/mask_model'
import { numbers } from './random'

const kWidth = 150
const kHeight = 110

function distanceToSegment(x: number, y: number, a: Point, b: Point): number {
  const dx = b.x - a.x
  const dy = b.y - a.y
  const length = dx * dx + dy * dy
  const t = length === 0 ? 0 : ((x - a.x) * dx + (y - a.y) * dy) / length
  const at = Math.max(0, Math.min(1, t))
  return Math.hypot(x - a.x - at * dx, y - a.y - at * dy)
}

/** Pixels that differ from the definition: centres within the radius take the value. */
function wrongPixels(
  before: Uint8Array,
  after: Uint8Array,
  value: number,
  stroke: [Point, Point, number],
) {
  const [a, b, radius] = stroke
  let wrong = 0
  for (let y = 0; y < kHeight; ++y)
    for (let x = 0; x < kWidth; ++x) {
      const distance = distanceToSegment(x + 0.5, y + 0.5, a, b)
      if (Math.abs(distance - radius) < 1e-9) continue // either is right
      const wanted = distance <= radius ? value : before[y * kWidth + x]
      if (after[y * kWidth + x] !== wanted) ++wrong
    }
  return wrong
}

test('strokes cover the pixels within their radius, and undo and redo give every state again', () => {
  const next = numbers(1)
  const mask = new MaskModel(kWidth, kHeight)
  const states = [mask.values.slice()]
  for (let stroke = 0; stroke < 100; ++stroke) {
    const value = next() < 0.5 ? kOutside : kFigure
    const radius = next() < 0.2 ? 0.5 : 20 * next()
    let from = { x: kWidth * 1.2 * next() - 10, y: kHeight * 1.2 * next() - 10 }
    mask.begin(value)
    for (let part = 0; part < 4; ++part) {
      const to = {
        x: from.x + 40 * (next() - 0.5),
        y: from.y + (part === 2 ? 0 : 40 * (next() - 0.5)),
      }
      const before = mask.values.slice()
      mask.paint(from, to, radius)
      assert.equal(wrongPixels(before, mask.values, value, [from, to, radius]), 0)
      from = to
    }
    if (mask.end()) states.push(mask.values.slice())
  }
  for (let i = states.length - 2; i >= 0; --i) {
    mask.undo()
    assert.deepEqual(mask.values, states[i])
  }
  for (let i = 1; i < states.length; ++i) {
    mask.redo()
    assert.deepEqual(mask.values, states[i])
  }
})

test('a mask counts as changed until it is saved, and again after an undo', () => {
  const mask = new MaskModel(kWidth, kHeight)
  assert.equal(mask.changed, false)
  mask.begin(kFigure)
  mask.paint({ x: 20, y: 20 }, { x: 30, y: 20 }, 5)
  mask.end()
  assert.equal(mask.changed, true)
  mask.markSaved()
  assert.equal(mask.changed, false)
  mask.undo()
  assert.equal(mask.changed, true)
  mask.redo()
  assert.equal(mask.changed, false)
})
