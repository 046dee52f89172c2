import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Frames, Timeline } from '../src/api'
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

/** The engine's rules (core/io/timeline.cpp): rising times, holds that end before the next key. */
function assertUsable(timeline: Timeline): void {
  const frames = model.framesOf(timeline)
  timeline.keys.forEach((key, i) => {
    if (i > 0) assert.ok(frames[i] > frames[i - 1], 'keys keep their order')
    assert.ok((key.hold ?? 0) >= 0, 'no hold is negative')
    const next = timeline.keys[i + 1]
    if (next) assert.ok(key.at + (key.hold ?? 0) <= next.at, 'a hold ends before the next key')
  })
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
