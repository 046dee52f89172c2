import assert from 'node:assert/strict'
import { test } from 'node:test'

import { confidenceWords } from '../src/pages/poses/confidence_legend'
import { scaleColor } from '../src/view/colors'
import { anchorOf } from '../src/view/markers'
import type { MeshData } from '../src/view/mesh_data'
import { areaByLevel, inScaleColors } from '../src/view/scale_picture'
import { turnedByKey } from '../src/view/turn'

/** Two triangles: one of area 0.5 in the picture's lower left, one of 1.5 in its upper right. */
const kTwo: MeshData = {
  vertices: 6,
  faces: 2,
  positions: new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 5, 3, 0, 5, 0, 1, 5]),
  indices: new Uint32Array([0, 1, 2, 3, 4, 5]),
  uvs: new Float32Array([0, 0, 0.4, 0, 0, 0.4, 1, 1, 0.6, 1, 1, 0.6]),
  colors: null,
}

test('the share of the surface by confidence is its area, with the layout’s v upwards', () => {
  const grey = { width: 2, height: 2, values: new Uint8Array([10, 255, 0, 20]) }
  assert.deepEqual(areaByLevel(kTwo, grey, 4), [0.25, 0, 0, 0.75])
})

test('grey levels become the scale’s colours, and are kept', () => {
  const pixels = new Uint8ClampedArray([0, 0, 0, 255, 255, 255, 255, 255])
  assert.deepEqual([...inScaleColors(pixels)], [0, 255])
  assert.deepEqual(
    [...pixels.slice(0, 3)],
    scaleColor(0).map((part) => Math.round(255 * part)),
  )
  assert.deepEqual(
    [...pixels.slice(4)],
    [...scaleColor(1).map((part) => Math.round(255 * part)), 255],
  )
})

test('words say what was seen badly and what is made up', () => {
  const bins = new Array<number>(64).fill(0)
  assert.equal(
    confidenceWords([...bins.slice(0, 63), 1]),
    'Photographs show all of the surface well.',
  )
  const some = [0.02, 0.08, ...bins.slice(0, 61), 0.9]
  assert.equal(
    confidenceWords(some),
    'Photographs show 8.0 % of the surface badly, 2.0 % not at all: its colour is made up.',
  )
})

test('a name lies beside its marker, on the side where there is room', () => {
  const view = { width: 400, height: 300 }
  const label = { width: 100, height: 20 }
  assert.deepEqual(anchorOf({ x: 50, y: 100 }, label, view), { x: 0, y: 0.5 })
  assert.deepEqual(anchorOf({ x: 350, y: 100 }, label, view), { x: 1, y: 0.5 })
})

test('no name is cut at the view’s edge, wherever its marker is', () => {
  const view = { width: 400, height: 300 }
  for (const width of [40, 150, 390])
    for (let x = 0; x <= 400; x += 20)
      for (let y = 0; y <= 300; y += 10) {
        const label = { width, height: 20 }
        const anchor = anchorOf({ x, y }, label, view)
        const left = x - anchor.x * width
        const top = y - (1 - anchor.y) * 20
        const words = `${width} wide at ${x}, ${y}: ${left}, ${top}`
        assert.ok(left >= -1e-9 && left + width <= 400 + 1e-9, words)
        assert.ok(top >= -1e-9 && top + 20 <= 300 + 1e-9, words)
      }
  // One that is wider than the view begins at its left edge.
  assert.equal(anchorOf({ x: 100, y: 100 }, { width: 500, height: 20 }, view).x, 0.2)
})

test('arrow keys turn the view about the upright axis, and never over the top', () => {
  const front = { direction: [0, -1, 0] as [number, number, number], distance: 2 }
  const right = turnedByKey(front, 'ArrowRight')!
  assert.ok(right.direction[0] > 0.1 && Math.abs(right.direction[2]) < 1e-12)
  let above = front
  for (let i = 0; i < 50; ++i) above = turnedByKey(above, 'ArrowUp') as typeof front
  assert.ok(above.direction[2] < 1 && above.direction[2] > 0.99)
  assert.equal(turnedByKey(front, '+')!.distance, 1.8)
  assert.equal(turnedByKey(front, 'a'), null)
})
