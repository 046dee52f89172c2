import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Frames, Timeline } from '../src/api'
import { addPin, keyOfPin, pinsOf, setPin } from '../src/pages/timeline/region_model'
import * as model from '../src/pages/timeline/timeline_model'
import { numbers } from './random'

const timelineOf = (fps: number): Timeline => ({
  revision: '',
  timed: true,
  fps,
  loop: false,
  step: 1,
  other: {},
  keys: [
    { pose: 'a', at: 0 },
    { pose: 'b', at: 1 },
  ],
})

/**
 * The engine's rules (core/io/project/timeline.cpp): rising times, holds that end before the next key, loops
 * that close, pins from key to key.
 */
function assertUsable(timeline: Timeline): void {
  const frames = model.framesOf(timeline)
  timeline.keys.forEach((key, i) => {
    if (i > 0) assert.ok(frames[i] > frames[i - 1], 'keys keep their order')
    assert.ok((key.hold ?? 0) >= 0, 'no hold is negative')
    const next = timeline.keys[i + 1]
    if (next) assert.ok(key.at + (key.hold ?? 0) <= next.at, 'a hold ends before the next key')
  })
  const last = timeline.keys[timeline.keys.length - 1]
  if (timeline.loop) assert.equal(last.pose, timeline.keys[0].pose, 'a loop closes')
  for (const { from, to } of pinsOf(timeline)) {
    const [begin, end] = [from ?? timeline.keys[0].at, to ?? last.at]
    assert.ok(begin <= end, 'a pin does not end before it begins')
    for (const time of [begin, end]) assert.ok(keyOfPin(timeline, time) >= 0, 'a key is there')
  }
}

/** One edit, chosen by numbers. */
function edited(timeline: Timeline, pick: (below: number) => number): Timeline {
  const key = pick(timeline.keys.length)
  const frame = pick(200)
  const edits = [
    () => model.moveKey(timeline, key, frame),
    () => model.moveKeysFrom(timeline, key, frame),
    () => model.setHold(timeline, key, pick(40)),
    () => model.addKey(timeline, frame, 'c').timeline,
    () => model.copyKey(timeline, key, frame).timeline,
    () => model.deleteKey(timeline, key),
    () => model.setFps(timeline, [12, 24, 25, 30][pick(4)]),
    () => model.setHold(timeline, key, model.holdUntil(timeline, key, frame)),
    () => model.setLoop(timeline, pick(2) === 1).timeline,
    () => model.setPose(timeline, key, ['a', 'b', 'c'][pick(3)]),
    () => addPin(timeline, 'foot'),
    () => setPin(timeline, pick(pinsOf(timeline).length), { from: timeline.keys[key].at }),
    () => setPin(timeline, pick(pinsOf(timeline).length), { to: timeline.keys[key].at }),
  ]
  return edits[pick(edits.length)]()
}

test('whatever is edited, the engine can use the timeline', () => {
  const next = numbers(1)
  const pick = (below: number) => Math.floor(next() * below)
  let done = 0
  for (let round = 0; round < 200; ++round) {
    let timeline = timelineOf([12, 24, 25, 30, 23.976][pick(5)])
    for (let step = 0; step < 60; ++step) {
      try {
        timeline = edited(timeline, pick)
        ++done
      } catch (refusal) {
        if (!(refusal instanceof model.Refusal)) throw refusal
      }
      assertUsable(timeline)
    }
  }
  assert.ok(done > 6000, `only ${done} edits were possible`)
})

test('a loop stays closed, whatever is done to its first and last key', () => {
  const loop = model.setLoop(timelineOf(24), true).timeline
  const poses = (timeline: Timeline) => timeline.keys.map((key) => key.pose).join(' ')
  assert.equal(poses(loop), 'a b a')
  assert.equal(poses(model.setPose(loop, 0, 'c')), 'c b c')
  assert.equal(poses(model.setPose(loop, 2, 'c')), 'c b c')
  assert.equal(poses(model.setPose(loop, 1, 'c')), 'a c a')
  assert.equal(poses(model.deleteKey(loop, 0)), 'b b')
  assert.throws(() => model.deleteKey(loop, 2), /turn Loop off/)
  assert.throws(() => model.addKey(loop, 80, 'c'), /ends with its first pose/)
})

test('pins leave a key that is deleted for its neighbours', () => {
  let timeline = model.addKey(model.addKey(timelineOf(24), 48, 'c').timeline, 72, 'd').timeline
  timeline = setPin(addPin(timeline, 'foot'), 0, { from: 1, to: 2 })
  timeline = setPin(addPin(timeline, 'hand'), 1, { to: 2 })
  timeline = setPin(addPin(timeline, 'ear'), 2, { from: 2 })
  const spans = (after: Timeline) =>
    pinsOf(after).map(({ region, from, to }) => `${region} ${from ?? '-'} ${to ?? '-'}`)
  assert.deepEqual(spans(model.deleteKey(timeline, 2)), ['hand - 1'])
  assert.deepEqual(spans(model.deleteKey(timeline, 1)), ['hand - 2', 'ear 2 -'])
  assert.deepEqual(spans(model.deleteKey(timeline, 0)), ['foot 0 1', 'hand - 1', 'ear 1 -'])
})

test('keys that move together keep their distances, and earlier ones their places', () => {
  let timeline = model.addKey(timelineOf(24), 48, 'c').timeline
  const before = model.framesOf(timeline)
  timeline = model.moveKeysFrom(timeline, 1, before[1] + 7)
  assert.deepEqual(model.framesOf(timeline), [before[0], before[1] + 7, before[2] + 7])
})

test('an ease has its curve: CSS says in-out is half way at half time', () => {
  assert.ok(Math.abs(model.easeAt([0.42, 0, 0.58, 1], 0.5) - 0.5) < 1e-6)
  assert.ok(Math.abs(model.easeAt([0, 0, 1, 1], 0.3) - 0.3) < 1e-6)
})

test('a frame between keys wears the textures of both, as the film does', () => {
  const frames = { poses: ['a', 'b', 'a'], times: [0, 0.25, 1, 1.5, 2] } as Frames
  assert.deepEqual(model.texturesAt(frames, 0), ['a', 'b', 0])
  assert.deepEqual(model.texturesAt(frames, 1), ['a', 'b', 0.25])
  assert.deepEqual(model.texturesAt(frames, 2), ['b', 'a', 0])
  assert.deepEqual(model.texturesAt(frames, 3), ['b', 'a', 0.5])
  assert.deepEqual(model.texturesAt(frames, 4), ['a', 'a', 0])
  assert.deepEqual(model.texturesAt({ ...frames, times: [] }, 1), ['', '', 0])
})
