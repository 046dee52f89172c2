import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Stage, Step } from '../src/api'
import {
  askedBy,
  errorWords,
  formatsOf,
  noteWords,
  otherOptions,
} from '../src/pages/export/formats'
import { notesOf } from '../src/pages/export/notes'

const kStage = {
  stage: 'export',
  summary: '',
  options: [
    {
      name: 'formats',
      type: 'string',
      default: 'glb,video',
      unit: '',
      help: 'formats to write: glb, glb-few, video, sculpture',
    },
    { name: 'fps', type: 'double', default: '24', unit: '1/s', help: '' },
  ],
} as Stage
const step = (formats?: string) =>
  ({ options: formats === undefined ? {} : { formats } }) as unknown as Step

test('formats are those that the stage offers, in its order, also ones that are new to the page', () => {
  const formats = formatsOf(kStage, step('glb-few,glb'))
  assert.deepEqual(
    formats.map((one) => one.id),
    ['glb', 'glb-few', 'video', 'sculpture'],
  )
  assert.deepEqual(
    formats.map((one) => one.on),
    [true, true, false, false],
  )
  assert.equal(formats[3].title, 'sculpture')
  assert.deepEqual(
    formatsOf(kStage, step())
      .filter((one) => one.on)
      .map((one) => one.id),
    ['glb', 'video'],
  )
  assert.deepEqual(
    otherOptions(kStage).map((one) => one.name),
    ['fps'],
  )
})

test('only a change asks for something', () => {
  const formats = formatsOf(kStage, step('glb,video'))
  assert.equal(askedBy(formats, new Set(['video', 'glb'])), null)
  assert.equal(askedBy(formats, new Set(['sculpture', 'glb'])), 'glb,sculpture')
})

test('an error is said on a figure that one can hold in the hand', () => {
  assert.equal(errorWords(5e-5), 'Off by at most 0.01 mm on a figure of 20 cm (0.005 %)')
  assert.equal(errorWords(0.0213), 'Off by at most 4.3 mm on a figure of 20 cm (2.1 %)')
  assert.equal(errorWords(0.75), 'Off by at most 150 mm on a figure of 20 cm (75 %)')
  assert.match(errorWords(0), /^Exact: off by less than 0.001 mm/)
  assert.match(errorWords(1e-8), /^Exact: off by less than 0.001 mm/)
})

test('a note says what was measured, and nothing else', () => {
  assert.equal(noteWords({ format: 'video', files: [], bytes: 3 }), '')
  assert.equal(
    noteWords({
      format: 'glb-few',
      files: [],
      bytes: 3,
      error_over_diagonal: 0.001,
      morph_targets: 8,
    }),
    'Off by at most 0.2 mm on a figure of 20 cm (0.1 %), 8 shapes',
  )
})

test('a file that is no animation.json has no notes', () => {
  for (const other of [null, [], {}, { formats: 'glb' }, { formats: [null, 3, { format: 'glb' }] }])
    assert.deepEqual(notesOf(other), [])
  assert.equal(notesOf({ formats: [{ format: 'glb', files: [], bytes: 1 }] }).length, 1)
})
