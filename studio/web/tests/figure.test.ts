import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { FigureStroke, Photograph } from '../src/api'
import {
  firstShown,
  noteOf,
  pixelsOf,
  shapeOf,
  simplified,
  strokeOf,
} from '../src/pages/poses/figure_model'
import { numbers } from './random'

type Pixel = [number, number]

const stroke = (picture: string, figure = true, gone = false): FigureStroke => ({
  text: '',
  picture,
  figure,
  points: [[0.5, 0.5]],
  gone,
})

test('a straight line becomes its two ends, and a corner stays', () => {
  const line: Pixel[] = []
  for (let x = 0; x <= 50; ++x) line.push([x, 10])
  for (let y = 10; y <= 40; ++y) line.push([50, y])
  assert.deepEqual(simplified(line, 0.5), [
    [0, 10],
    [50, 10],
    [50, 40],
  ])
})

test('no dropped point is farther from the line than allowed', () => {
  const random = numbers(3)
  const line: Pixel[] = []
  for (let i = 0; i < 300; ++i)
    line.push([i + 4 * random(), 60 * Math.sin(i / 20) + 3 * random()])
  const kept = simplified(line, 2)
  assert.ok(kept.length < 100, `${kept.length} points`)
  for (const [x, y] of line) {
    const nearest = Math.min(
      ...kept.slice(1).map(([bx, by], i) => {
        const [ax, ay] = kept[i]
        const length = (bx - ax) ** 2 + (by - ay) ** 2
        const t = Math.min(1, Math.max(0, ((x - ax) * (bx - ax) + (y - ay) * (by - ay)) / length))
        return Math.hypot(x - ax - t * (bx - ax), y - ay - t * (by - ay))
      }),
    )
    assert.ok(nearest <= 2 + 1e-9)
  }
})

test('a stroke keeps to its photograph, and comes back in pixels', () => {
  const one = strokeOf('a.jpg', [[-3, 30], [120, 90], [410, 20]], 400, 300, false)
  assert.equal(one.figure, false)
  assert.deepEqual(pixelsOf(one, 400, 300), [[0, 30], [120, 90], [400, 20]])
  assert.equal(shapeOf(one), 'a line')
  assert.equal(shapeOf(strokeOf('a.jpg', [[4, 5]], 400, 300, true)), 'a click')
})

test('a scribble over the whole photograph stays small', () => {
  const random = numbers(8)
  const line = Array.from({ length: 20000 }, (): Pixel => [4000 * random(), 3000 * random()])
  assert.ok(strokeOf('a.jpg', line, 4000, 3000, true).points.length <= 200)
})

test('the first photograph is one with a stroke that is there', () => {
  const photographs = ['a.jpg', 'b.jpg'].map((name) => ({ name }) as Photograph)
  assert.equal(firstShown([], photographs), 'a.jpg')
  assert.equal(firstShown([stroke('c.jpg'), stroke('b.jpg')], photographs), 'b.jpg')
  assert.equal(firstShown([], []), '')
})

test('a photograph is marked with what was said in it', () => {
  const strokes = [stroke('a.jpg'), stroke('a.jpg', false), stroke('a.jpg'), stroke('b.jpg')]
  assert.equal(noteOf(strokes, 'a.jpg'), '+2 −1')
  assert.equal(noteOf(strokes, 'b.jpg'), '+1')
  assert.equal(noteOf([stroke('a.jpg', true, true)], 'a.jpg'), '')
})
