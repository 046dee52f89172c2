import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Figure, Said, Version } from '../src/pages/review/review_api'
import {
  firstPair,
  numberWords,
  scaleEnd,
  sightsOf,
  standing,
  trend,
} from '../src/pages/review/review_model'

const version = (id: string, more: Partial<Version> = {}): Version => ({
  id,
  when: '2026-03-01 14:05:09 UTC',
  now: false,
  gone: [],
  mesh: 'b5/unwrapped.obj',
  texture: '',
  files: [],
  ...more,
})
const figure = (more: Partial<Figure>): Figure => ({
  step: 'mesh/rest',
  title: 'Surface',
  key: 'size',
  label: 'how large',
  unit: '',
  before: 1,
  after: 2,
  good: {},
  main: true,
  ...more,
})
const said = (more: Partial<Said>): Said => ({
  index: 0,
  verdict: 'approved',
  note: '',
  when: '',
  holds: true,
  version: 'a',
  ...more,
})

test('the newest stands beside the newest before it that is still there', () => {
  const gone = version('b', { mesh: '', gone: ['unwrap/rest'] })
  assert.deepEqual(firstPair([version('c'), gone, version('a')]), { before: 'a', after: 'c' })
  assert.deepEqual(firstPair([version('c')]), { before: '', after: 'c' })
})

test('what both have is looked at, films before pictures', () => {
  const file = (path: string, film: boolean) => ({ path, title: 'Film', film, at: `c0/${path}` })
  const now = version('b', { files: [file('rest/a.png', false), file('rest/a.mp4', true)] })
  const old = version('a', { mesh: '', files: [file('rest/a.mp4', true)] })
  assert.deepEqual(sightsOf(old, now).map((one) => one.key), ['rest/a.mp4'])
  assert.deepEqual(sightsOf(null, now).map((one) => one.key), ['3d', 'rest/a.mp4', 'rest/a.png'])
})

test('a figure is better or worse only by the range that its stage calls good', () => {
  assert.equal(trend(figure({})), '')
  assert.equal(trend(figure({ good: { max: 1.5 } })), 'worse')
  assert.equal(trend(figure({ good: { min: 1.5 } })), 'better')
  assert.equal(trend(figure({ good: { max: 3 } })), '')
  assert.equal(trend(figure({ before: null, good: { max: 1 } })), '')
})

test('numbers have four digits and shares are percent', () => {
  assert.equal(numberWords(0.012345, 'share'), '1.234 %')
  assert.equal(numberWords(20000, ''), '20000')
  assert.equal(numberWords(1.75, 'm'), '1.75 m')
  assert.equal(numberWords(null, 'm'), '–')
  assert.equal(numberWords(true, ''), 'yes')
})

test('an approval stands until the result is another', () => {
  const of = (reviews: Said[]) => standing({ pose: 'rest', versions: [], reviews }).words
  assert.equal(of([]), '')
  assert.equal(of([said({}), said({ verdict: 'sent back' })]), 'approved')
  assert.equal(of([said({ verdict: 'sent back' })]), 'sent back')
  assert.equal(of([said({ holds: false })]), 'changed since')
})

test('the scale of distances ends where 99 of 100 lie, and never at nothing', () => {
  const values = Float32Array.from({ length: 101 }, (_, i) => i / 100)
  assert.ok(Math.abs(scaleEnd(values) - 0.99) < 1e-6)
  assert.equal(scaleEnd(new Float32Array([0, NaN])), 1e-4)
})
