import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { ProjectCard } from '../src/pages/door/door_api'
import { kExamples, nameFault, stateWords, whenWords } from '../src/pages/door/door_words'

test('how far a project is', () => {
  const card: ProjectCard = { state: 'begun', done: 3, steps: 22, poses: 2, kind: 'poses', problem: '' }
  assert.equal(stateWords(card), '3 of 22 steps done')
  assert.equal(stateWords({ ...card, state: 'running' }), 'running: 3 of 22 steps done')
  assert.equal(stateWords({ ...card, state: 'failed' }), 'a step failed; 3 of 22 steps done')
  assert.equal(stateWords({ ...card, state: 'done' }), 'finished')
  assert.equal(stateWords({ ...card, state: 'new' }), 'not run yet')
})

test('when it was opened', () => {
  const at = (day: number, hour: number) => new Date(2026, 10, day, hour, 5).getTime() / 1000
  assert.equal(whenWords(at(30, 8), at(30, 23)), 'today, 08:05')
  assert.equal(whenWords(at(29, 8), at(30, 23)), 'yesterday, 08:05')
  assert.equal(whenWords(at(2, 8), at(30, 23)), '2 November 2026')
})

test('a name that no folder of a project can have is said', () => {
  assert.equal(nameFault('clay fox'), '')
  assert.notEqual(nameFault(''), '')
  assert.notEqual(nameFault('.fox'), '')
  assert.notEqual(nameFault('a/b'), '')
})

test('each example has a name, what it is and how long it takes', () => {
  assert.deepEqual(Object.keys(kExamples), ['finished', 'two', 'six', 'film', 'dance', 'puppet'])
  for (const { name, about, time } of Object.values(kExamples)) assert.ok(name && about && time)
})
