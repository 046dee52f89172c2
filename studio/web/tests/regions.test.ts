import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Timeline } from '../src/api'
import * as model from '../src/pages/timeline/region_model'
import { moveKey, moveKeysFrom, Refusal } from '../src/pages/timeline/timeline_model'

const timeline = (other: Record<string, unknown> = {}): Timeline => ({
  revision: '',
  timed: true,
  fps: 24,
  loop: false,
  step: 1,
  other,
  keys: [
    { pose: 'a', at: 0 },
    { pose: 'b', at: 1 },
    { pose: 'a', at: 2 },
  ],
})

test('pins come, change and go, and leave the rest of the file as it was', () => {
  let now = model.addPin(timeline({ table: 0 }), 'foot')
  assert.deepEqual(now.other, { table: 0, pins: [{ region: 'foot' }] })
  now = model.setPin(now, 0, { from: 0, to: 1 })
  assert.deepEqual(model.pinsOf(now), [{ region: 'foot', from: 0, to: 1 }])
  assert.throws(() => model.setPin(now, 0, { from: 1 }), Refusal)
  now = model.setPin(now, 0, { from: undefined })
  assert.deepEqual(now.other.pins, [{ region: 'foot', to: 1 }])
  assert.deepEqual(model.deletePin(now, 0).other, { table: 0 })
})

test('a pin follows the keys that it hangs on, and no others', () => {
  const pinned = timeline({
    pins: [
      { region: 'foot', from: 1, to: 2 },
      { region: 'hand', from: 0.3 },
    ],
  })
  assert.deepEqual(moveKey(pinned, 1, 30).other.pins, [
    { region: 'foot', from: 1.25, to: 2 },
    { region: 'hand', from: 0.3 },
  ])
  assert.deepEqual(moveKeysFrom(pinned, 1, 36).other.pins, [
    { region: 'foot', from: 1.5, to: 2.5 },
    { region: 'hand', from: 0.3 },
  ])
  assert.equal(model.keyOfPin(pinned, 0.3), -1)
})

test('turns are fields of keys, with an axis where one is said', () => {
  let now = model.addTurn(timeline(), 'propeller', 1)
  assert.deepEqual(
    now.keys.map((key) => (key as { turns?: unknown }).turns),
    [undefined, { propeller: 1 }, undefined],
  )
  now = model.setTurn(now, 0, { turns: -2, axis: model.kAxes.z })
  assert.deepEqual((now.keys[1] as { turns?: unknown }).turns, {
    propeller: { turns: -2, axis: [0, 0, 1] },
  })
  assert.deepEqual(model.turnsOf(now), [
    { key: 1, region: 'propeller', turns: -2, axis: [0, 0, 1] },
  ])
  now = model.setTurn(now, 0, { axis: undefined })
  assert.deepEqual((now.keys[1] as { turns?: unknown }).turns, { propeller: -2 })
  assert.deepEqual(model.deleteTurn(now, 0), timeline())
})

test('a region turns once in each span: the next free one, then none', () => {
  let now = model.addTurn(timeline(), 'propeller', 1)
  now = model.addTurn(now, 'propeller', 1)
  assert.deepEqual(
    model.turnsOf(now).map((turn) => turn.key),
    [0, 1],
  )
  assert.throws(() => model.addTurn(now, 'propeller', 0), Refusal)
  assert.throws(() => model.setTurn(now, 0, { key: 1 }), Refusal)
  assert.throws(() => model.setTurn(now, 0, { turns: 0 }), Refusal)
  assert.equal(model.turnsOf(model.setTurn(now, 0, { turns: 1000 }))[0].turns, model.kMostTurns)
})

test('regions are those of the file and the painted ones, each once', () => {
  const written = timeline({ regions: [{ name: 'foot', center: [0, 0, 0], radius: 1 }] })
  assert.deepEqual(model.regionNames(written, ['belly', 'foot']), ['foot', 'belly'])
})
