import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { ArmatureEvent, ArmatureStory, ArmatureView } from '../src/pages/armature/armature_api'
import { rowsOf } from '../src/pages/armature/readings'
import { kFirstSetup, problemsOf } from '../src/pages/armature/setup'
import { afterEnd, afterEvent, fromStory, kNoSitting, plateOf } from '../src/pages/armature/sitting'
import type { Sitting } from '../src/pages/armature/sitting'
import { kBoneNumbers, normalsOf, parseWeights, Skin } from '../src/pages/armature/skin'
import { numbers } from './random'

const told = (...events: ArmatureEvent[]): Sitting => events.reduce(afterEvent, kNoSitting)
const story = (events: ArmatureEvent[], more: Partial<ArmatureStory> = {}): ArmatureStory => ({
  running: true,
  baking: false,
  number: events.length,
  events,
  exit_code: 0,
  message: '',
  ports: [],
  setup: null,
  files: [],
  takes: [],
  edited: [],
  ...more,
})
const session = { event: 'session', at: 3, frames: 3, fps: 25, step: 2 }

test('frames that are recorded, gone back to and forgotten', () => {
  const begun = told(session)
  assert.deepEqual([begun.at, begun.frames, begun.fps, begun.ready], [3, 3, 25, true])
  const more = afterEvent(begun, { event: 'recorded', frame: 3, frames: 4 })
  assert.deepEqual([more.at, more.frames], [4, 4])
  assert.ok(more.changes > begun.changes)
  const back = afterEvent(more, { event: 'at', at: 1, frames: 4 })
  const again = afterEvent(back, { event: 'recorded', frame: 1, frames: 4 })
  assert.deepEqual([again.at, again.frames], [2, 4])
})

test('what is wrong is told until it is mended', () => {
  const out = told(session, { event: 'cable-out', words: 'the cable is out', what_to_do: 'plug' })
  assert.deepEqual(out.box, { words: 'the cable is out', do: 'plug' })
  assert.equal(afterEvent(out, { event: 'cable-back' }).box, null)
  const stuck = told(session, { event: 'still-joint', joint: 'knee', words: 'is it stuck?' })
  assert.equal(stuck.sensors.knee.kind, 'stuck?')
  assert.deepEqual(afterEvent(stuck, { event: 'set', joint: 'knee' }).sensors, {})
  const waits = told(session, { event: 'waiting', words: 'the controller does not answer' })
  assert.equal(afterEvent(waits, { event: 'recorded', frame: 3, frames: 4 }).waiting, '')
  const refused = told(session, { event: 'refused', words: 'no joint' })
  assert.equal(refused.refused, 'no joint')
  assert.equal(afterEvent(refused, { event: 'at', at: 0, frames: 3 }).refused, '')
  const odd = told(session, { event: 'warning', words: 'the mesh is too large' })
  assert.equal(afterEvent(odd, { event: 'at', at: 0, frames: 3 }).warning, 'the mesh is too large')
})

test('a story is told as its events were, and a failure only when it is over', () => {
  assert.deepEqual(fromStory(story([session])), told(session))
  const failed = fromStory(story([], { running: false, message: 'no such port' }))
  assert.equal(failed.failure, 'no such port')
  assert.equal(failed.running, false)
  assert.equal(afterEnd(told(session), '').running, false)
})

test('frames have plates as far as there are any', () => {
  assert.deepEqual(
    [0, 1, 9].map((frame) => plateOf(frame, 2, 5)),
    [0, 2, 4],
  )
  assert.equal(plateOf(3, 2, 0), 0)
})

test('sensors that are wrong come first', () => {
  const sensors = ['a', 'b', 'c'].map((name) => ({ name, unit: '°' }))
  const view = { sensors } as unknown as ArmatureView
  const sitting = { ...kNoSitting, sensors: { c: { kind: 'stuck?', words: 'is it stuck?' } } }
  const rows = rowsOf(view, sitting, [1], [2, 0, 0])
  assert.deepEqual(
    rows.map((row) => [row.name, row.state, row.fault]),
    [
      ['b', 'jumped', true],
      ['c', 'stuck?', true],
      ['a', 'wrapped × 2', false],
    ],
  )
})

test('a set-up that cannot begin says why', () => {
  assert.deepEqual(Object.keys(problemsOf(kFirstSetup)), ['description', 'chains'])
  const files = { ...kFirstSetup, description: 'a.txt', chains: 'b.txt' }
  assert.deepEqual(problemsOf(files), {})
  const board = { ...files, port: 'COM3', calibration: '' }
  assert.deepEqual(Object.keys(problemsOf(board)), ['port', 'calibration'])
  assert.deepEqual(Object.keys(problemsOf({ ...files, take: 'a/b', fps: 0 })), ['take', 'fps'])
})

/** Four vertices, each moved by the bones and weights given. */
function weightsOf(bones: number[], weights: number[]) {
  const bytes = new ArrayBuffer(24 * (bones.length / 4))
  new Uint16Array(bytes, 0, bones.length).set(bones)
  new Float32Array(bytes, 2 * bones.length, weights.length).set(weights)
  return bytes
}

function near(got: ArrayLike<number>, wanted: number[], tolerance = 1e-6) {
  wanted.forEach((value, i) => assert.ok(Math.abs(got[i] - value) < tolerance, `${i}: ${got[i]}`))
}

test('rigid bones move rigidly, whichever sign their turns have', () => {
  const rest = new Float32Array([1, 0, 0, 0, 1, 0, 0, 0, 1])
  const indices = new Uint32Array([0, 1, 2])
  const both = weightsOf(Array(3).fill([0, 1, 0, 0]).flat(), Array(3).fill([0.6, 0.4, 0, 0]).flat())
  const skin = new Skin(rest, indices, parseWeights(both, 3))
  // A quarter about z, then a shift; the other bone has the same motion with the other sign.
  const h = Math.SQRT1_2
  const bones = [h, 0, 0, h, 1, 2, 3, -h, 0, 0, -h, 1, 2, 3]
  assert.equal(bones.length, 2 * kBoneNumbers)
  const [places, normals] = [new Float32Array(9), new Float32Array(9)]
  skin.pose(bones, places, normals)
  near(places, [1, 3, 3, 0, 2, 3, 1, 2, 4])
  const third = 1 / Math.sqrt(3)
  near(normals, [-third, third, third])
})

test('between two turns lies the turn between them: nothing shrinks', () => {
  const rest = new Float32Array([1, 0, 0, 2, 0, 0, 3, 0, 0])
  const half = weightsOf(Array(3).fill([0, 1, 0, 0]).flat(), Array(3).fill([0.5, 0.5, 0, 0]).flat())
  const skin = new Skin(rest, new Uint32Array([0, 1, 2]), parseWeights(half, 3))
  const h = Math.SQRT1_2
  const [places, normals] = [new Float32Array(9), new Float32Array(9)]
  skin.pose([1, 0, 0, 0, 0, 0, 0, h, 0, 0, h, 0, 0, 0], places, normals)
  near(places, [h, h, 0, 2 * h, 2 * h, 0])
})

test('motions of one bone are those of quaternions', () => {
  const random = numbers(7)
  const rest = Float32Array.from({ length: 9 }, () => random() - 0.5)
  const one = weightsOf(Array(3).fill([0, 0, 0, 0]).flat(), Array(3).fill([1, 0, 0, 0]).flat())
  const skin = new Skin(rest, new Uint32Array([0, 1, 2]), parseWeights(one, 3))
  const raw = Array.from({ length: 4 }, () => random() - 0.5)
  const size = Math.hypot(...raw)
  const [w, x, y, z] = raw.map((value) => value / size)
  const shift = [random(), random(), random()]
  const rows = [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ]
  const wanted = [0, 1, 2].flatMap((v) =>
    rows.map((row, k) => shift[k] + row.reduce((sum, r, c) => sum + r * rest[3 * v + c], 0)),
  )
  const places = new Float32Array(9)
  skin.pose([w, x, y, z, ...shift], places, new Float32Array(9))
  near(places, wanted)
})

test('weights of another mesh are refused', () => {
  assert.throws(() => parseWeights(new ArrayBuffer(24), 2), /has changed/)
  near(normalsOf(new Float32Array(9), new Uint32Array([0, 1, 2])), Array(9).fill(0))
})
