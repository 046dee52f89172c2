import assert from 'node:assert/strict'
import { test } from 'node:test'

import { kFigure, kOutside, MaskModel } from '../src/pages/poses/mask_model'
import type { Point } from '../src/pages/poses/mask_model'
import { enclosedRows, joinedRows } from '../src/pages/poses/mask_shapes'
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

/** A mask of '#' and '.', and back. */
const drawn = (...rows: string[]) =>
  new MaskModel(
    rows[0].length,
    rows.length,
    Uint8Array.from(rows.join(''), (one) => (one === '#' ? kFigure : kOutside)),
  )
const shown = ({ values, width, height }: MaskModel) =>
  Array.from({ length: height }, (_, y) =>
    Array.from(values.subarray(y * width, (y + 1) * width), (one) => (one ? '#' : '.')).join(''),
  )

test('a lasso takes the pixels whose centres it goes round, also where it crosses itself', () => {
  const mask = drawn('......', '......', '......', '......')
  const fill = (line: number[][]) => {
    mask.begin(kFigure)
    mask.fill(enclosedRows(line.map(([x, y]) => ({ x, y })), mask.width, mask.height))
    mask.end()
  }
  fill([[0.6, -3], [3.4, -3], [3.4, 2.2]])
  assert.deepEqual(shown(mask), ['..#...', '......', '......', '......'], 'a triangle from outside')
  mask.undo()
  // Twice round the same square, and a triangle: what is gone round twice is no hole.
  const square = [[1, 1], [5, 1], [5, 3], [1, 3]]
  fill([...square, ...square])
  assert.deepEqual(shown(mask), ['......', '.####.', '.####.', '......'])
  mask.undo()
  fill([[0, 0], [6, 4], [6, 0], [0, 4]])
  assert.deepEqual(shown(mask), ['#....#', '##..##', '##..##', '#....#'], 'a bow')
})

test('a lasso agrees with the winding number of each pixel', () => {
  const next = numbers(3)
  for (let k = 0; k < 30; ++k) {
    const line = Array.from({ length: 3 + Math.floor(8 * next()) }, () => ({
      x: 60 * next() - 10,
      y: 50 * next() - 5,
    }))
    const inside = new Uint8Array(40 * 40)
    for (const { y, left, right } of enclosedRows(line, 40, 40)) inside.fill(1, 40 * y + left, 40 * y + right + 1)
    for (let y = 0; y < 40; ++y)
      for (let x = 0; x < 40; ++x) {
        let turned = 0
        line.forEach((a, i) => {
          const b = line[(i + 1) % line.length]
          const [ax, ay, bx, by] = [a.x - x - 0.5, a.y - y - 0.5, b.x - x - 0.5, b.y - y - 0.5]
          turned += Math.atan2(ax * by - ay * bx, ax * bx + ay * by)
        })
        assert.equal(inside[40 * y + x] === 1, Math.abs(turned) > 1, `${k}: ${x}, ${y}`)
      }
  }
})

test('fill takes what is joined by edges: a hole is closed, a speck goes', () => {
  const mask = drawn('######..', '#..#.#.#', '#.##.#..', '####.#..')
  const fill = (x: number, y: number, value: number) => {
    mask.begin(value)
    mask.fill(joinedRows(mask.values, mask.width, mask.height, { x, y }))
    mask.end()
  }
  fill(2.2, 1.9, kFigure)
  assert.deepEqual(shown(mask), ['######..', '####.#.#', '####.#..', '####.#..'], 'one hole')
  fill(7.5, 1.5, kOutside)
  assert.deepEqual(shown(mask), ['######..', '####.#..', '####.#..', '####.#..'], 'the speck')
  fill(-1, 2, kFigure)
  fill(6, 0, kFigure)
  assert.deepEqual(shown(mask), ['########', '####.###', '####.###', '####.###'])
})

test('a mask that becomes another one is one stroke', () => {
  const mask = drawn('##..', '#...')
  mask.become((i) => 255 - mask.values[i])
  assert.deepEqual(shown(mask), ['..##', '.###'])
  assert.equal(mask.changed, true)
  mask.undo()
  assert.deepEqual(shown(mask), ['##..', '#...'])
  assert.equal(mask.canUndo, false)
  mask.become((i) => mask.values[i])
  assert.equal(mask.canUndo, false, 'the same again is no stroke')
})
