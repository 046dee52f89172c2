import assert from 'node:assert/strict'
import { test } from 'node:test'

import { azimuthOf, turnedToFront } from '../src/view/front'

test('the front is counted from -y, counter-clockwise seen from above', () => {
  assert.equal(azimuthOf([0, -1, 0.3]), 0)
  assert.equal(azimuthOf([1, 0, 0]), 90)
  assert.equal(azimuthOf([0, 1, 0]), 180)
  assert.equal(azimuthOf([-1, -1, 0]), 315)
})

test('a view of the front goes with it', () => {
  for (const front of [0, 40, 90, 200]) {
    const turn = turnedToFront({ direction: [0, -1, 0.3], distance: 2 }, front)
    assert.equal(azimuthOf(turn.direction), front)
    assert.equal(turn.direction[2], 0.3)
    assert.equal(turn.distance, 2)
  }
})
