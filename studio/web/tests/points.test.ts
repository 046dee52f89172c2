import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { PointCamera, Points } from '../src/pages/cameras/points_api'
import {
  clickOf,
  lacking,
  metresOf,
  nextToClick,
  renamed,
  withClick,
  withoutPoint,
  withPoint,
} from '../src/pages/cameras/points_model'

const none: Points = { points: [], clicks: [] }
const named = (...names: string[]): Points => ({
  points: names.map((name) => ({ name, place: [0, 0, 0] })),
  clicks: [],
})
const camera = (name: string): PointCamera => ({
  name,
  width: 10,
  height: 10,
  frames: 0,
  still: '',
  problem: '',
})

test('a new point gets a name that none has', () => {
  const two = withPoint(withPoint(none))
  assert.deepEqual(two.points.map((one) => one.name), ['point 1', 'point 2'])
  assert.equal(withPoint(withoutPoint(two, 'point 1')).points[1].name, 'point 1')
})

test('a second click of a point takes the place of the first', () => {
  const one = withClick(named('a', 'b'), 'cam1', 'a', [1, 2])
  const two = withClick(withClick(one, 'cam2', 'a', [3, 4]), 'cam1', 'a', [5, 6])
  assert.equal(two.clicks.length, 2)
  assert.deepEqual(clickOf(two, 'cam1', 'a')?.pixel, [5, 6])
})

test('clicks follow their point: renamed, or removed with it', () => {
  const one = withClick(named('a', 'b'), 'cam1', 'a', [1, 2])
  assert.equal(renamed(one, 'a', 'b'), null)
  assert.equal(renamed(one, 'a', '  '), null)
  assert.deepEqual(clickOf(renamed(one, 'a', ' c ')!, 'cam1', 'c')?.pixel, [1, 2])
  assert.deepEqual(withoutPoint(one, 'a').clicks, [])
})

test('metres are read with a point or a comma, and nothing else', () => {
  assert.equal(metresOf('1.5'), 1.5)
  assert.equal(metresOf(' -0,25 '), -0.25)
  for (const wrong of ['', ' ', 'x', '1,2,3', '1e9', 'Infinity', 'NaN'])
    assert.equal(metresOf(wrong), null, wrong)
})

test('the next point to click is the first after this one that is not clicked', () => {
  const one = withClick(named('a', 'b', 'c'), 'cam1', 'b', [1, 2])
  assert.equal(nextToClick(one, 'cam1', 'a'), 'c')
  assert.equal(nextToClick(one, 'cam1', 'c'), 'a')
  assert.equal(nextToClick(withClick(none, 'cam1', 'a', [1, 2]), 'cam1', 'a'), '')
})

test('a camera with too few clicks is named', () => {
  let points = named('a', 'b', 'c', 'd')
  assert.match(lacking(points, [camera('cam1')], true), /^Click 4 points/)
  for (const { name } of points.points) points = withClick(points, 'cam1', name, [1, 2])
  assert.equal(lacking(points, [camera('cam1'), camera('cam2')], true), '')
  assert.match(lacking(points, [camera('cam1')], false), /^cam1: at least 6/)
})
