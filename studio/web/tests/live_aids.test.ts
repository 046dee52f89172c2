import assert from 'node:assert/strict'
import { test } from 'node:test'

import { clippingOf, histogramOf, kBins, sharpnessOf } from '../src/pages/shoot/live_aids'

const pixels = (...colours: number[][]) =>
  Uint8ClampedArray.from(colours.flatMap(([r, g, b]) => [r, g, b, 255]))

test('a histogram is shares of the pixels, with those at both ends', () => {
  const seen = histogramOf(pixels([0, 0, 0], [255, 128, 0], [254, 254, 254], [100, 100, 100]))
  assert.equal(seen.channels[0][0], 0.25)
  assert.equal(seen.channels[0][kBins - 1], 0.5)
  assert.equal(seen.channels[1][32], 0.25)
  assert.equal(seen.channels[2][25], 0.25)
  assert.equal(seen.white, 0.5, 'one channel at its end is enough')
  assert.equal(seen.black, 0.25)
  for (const channel of seen.channels) assert.equal(channel.reduce((a, b) => a + b), 1)
})

test('stripes lie on what is clipped alone', () => {
  const veil = clippingOf(pixels([255, 10, 10], [128, 128, 128], [1, 2, 0], [0, 3, 0]), 4)
  const kind = (i: number) => (veil[4 * i + 3] === 0 ? '' : veil[4 * i] > veil[4 * i + 2] ? 'red' : 'blue')
  assert.deepEqual([0, 1, 2, 3].map(kind), ['red', '', 'blue', ''])
})

test('sharpness falls with blur, and not with light or contrast', () => {
  const side = 40
  const of = (value: (x: number, y: number) => number) => {
    const all: number[][] = []
    for (let y = 0; y < side; ++y)
      for (let x = 0; x < side; ++x) all.push(new Array(3).fill(value(x, y)))
    return sharpnessOf(pixels(...all), side, side)
  }
  const wave = (period: number, gain: number, base: number) => (x: number) =>
    Math.round(base + gain * Math.sin((2 * Math.PI * x) / period))
  const sharp = of(wave(5, 60, 100))
  assert.ok(sharp > 10 * of(wave(20, 60, 100)), 'a slow wave is blurred')
  assert.ok(Math.abs(of(wave(5, 30, 60)) / sharp - 1) < 0.02)
  assert.equal(of(() => 90), 0, 'nothing is to be seen')
  // For a wave along x the Laplacian is 2 - 2 cos(2 pi / period) times the wave.
  assert.ok(Math.abs(sharp - (2 - 2 * Math.cos((2 * Math.PI) / 5)) ** 2) < 0.05)
})
