import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Photograph } from '../src/api'
import { judge } from '../src/pages/poses/quality'

const photograph = (more: Partial<Photograph>): Photograph => ({
  name: 'a.jpg',
  width: 600,
  height: 400,
  sharpness: 200,
  exposure: 100,
  mask_fraction: 0.2,
  mask_given: false,
  mask_of_another: false,
  photograph: '',
  trusted: true,
  why: '',
  left_out: false,
  another_thing: false,
  captured: true,
  ...more,
})

const flags = (more: Partial<Photograph>) =>
  judge([photograph({}), photograph({}), photograph({}), photograph(more)])[3].flags.map(
    (flag) => flag.text,
  )

test('a photograph is blurred against the others, and only where it shows the figure', () => {
  assert.deepEqual(flags({}), [])
  assert.deepEqual(flags({ sharpness: 90 }), ['blurred'])
  assert.deepEqual(flags({ sharpness: 90, mask_fraction: 0 }), ['no figure'])
})

test('what capture has left out says why, though capture has not made it', () => {
  const out = { captured: false, another_thing: true, why: 'it shows another thing' }
  assert.deepEqual(flags(out), ['another thing'])
  assert.deepEqual(flags({ captured: false }), [])
})

test('a photograph without a figure does not count for the middle of the set', () => {
  const soft = { sharpness: 120 }
  const none = { sharpness: 2000, mask_fraction: 0 }
  const judged = judge([soft, soft, none, none, none].map(photograph))
  assert.equal(judged[0].sharpness, 1)
})
