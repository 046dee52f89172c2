import assert from 'node:assert/strict'
import { test } from 'node:test'

import { takeOfAddress, addressOfTake } from '../src/pages/armature/setup'
import { pulledLine } from '../src/pages/take/acts'
import { Edits } from '../src/pages/take/edits'
import { parseDraft } from '../src/pages/take/take_api'
import type { Draft } from '../src/pages/take/take_api'
import {
  byMotion,
  filmLength,
  framesOfTake,
  gridOf,
  heldFrames,
  limitWords,
  lineWords,
  moveLine,
  nextBetween,
  nextName,
  plotRange,
  recordedAt,
  roundedTo,
  setLine,
  spanOf,
  within,
  withinBy,
} from '../src/pages/take/take_model'
import type { Joint, Take } from '../src/pages/take/take_model'

const joint = (name: string, values: number[], more: Partial<Joint> = {}): Joint => ({
  name,
  unit: 'degrees',
  low: null,
  high: null,
  values,
  ...more,
})
const knee = joint('knee', [-10, -20, -20, -5], { low: -150, high: 0 })
const take: Take = {
  fps: 24,
  step: 2,
  film: 0,
  joints: [joint('rig', [1, 90, 2, 3], { unit: 'mm' }), joint('neck', [1, 1, 1, 2]), knee],
}

test('each recorded frame stands for its frames of the film', () => {
  assert.equal(filmLength(take), 8)
  assert.deepEqual(
    [0, 1, 2, 7, 99, -3].map((film) => recordedAt(take, film)),
    [0, 0, 1, 3, 3, 0],
  )
  assert.deepEqual(spanOf(3, -2, 4), { first: 0, last: 3 })
})

test('lines are those of the program, numbers as short as they can be', () => {
  assert.equal(setLine('knee', { first: 2, last: 2 }, -41.5), 'set knee 2 -41.5')
  assert.equal(setLine('knee', { first: 2, last: 5 }, 0.1 + 0.2), 'set knee 2-5 0.3')
  assert.equal(moveLine('all', { first: 1, last: 2 }, -1), 'move all 1-2 by -1')
  assert.equal(lineWords('move all 1-2 by -1'), 'all joints, frames 1-2: 1 earlier')
  assert.equal(lineWords('add knee 3 5'), 'knee, frame 3: +5')
  assert.equal(lineWords('step 2'), 'on twos')
})

test('a value stops where its joint does', () => {
  assert.equal(within(knee, 12), 0)
  assert.equal(within(knee, -151), -150)
  assert.equal(withinBy(knee, { first: 0, last: 3 }, 9), 5, 'the frame nearest to the stop decides')
  assert.equal(withinBy(knee, { first: 0, last: 2 }, 9), 9)
  assert.equal(withinBy(knee, { first: 0, last: 3 }, -900), -130)
  const beyond = joint('bent', [5, -3], { low: -10, high: 0 })
  assert.equal(withinBy(beyond, { first: 0, last: 1 }, 2), 0, 'what is beyond goes no further')
  assert.equal(withinBy(beyond, { first: 0, last: 1 }, -2), -2)
  assert.equal(limitWords(knee), 'stops at -150° and 0°')
  assert.equal(limitWords(take.joints[1]), '')
})

test('one frame is set, and several go along by the same amount', () => {
  const one = pulledLine(knee, { first: 1, last: 1 }, 1, -33)
  assert.deepEqual(one, { line: 'set knee 1 -33', by: -13, stopped: false })
  const more = pulledLine(knee, { first: 0, last: 2 }, 1, -33)
  assert.deepEqual(more, { line: 'add knee 0-2 -13', by: -13, stopped: false })
  const stopped = pulledLine(knee, { first: 0, last: 3 }, 3, 40)
  assert.deepEqual(stopped, { line: 'add knee 0-3 5', by: 5, stopped: true })
})

test('the joint that moves most comes first, and what slides last', () => {
  assert.deepEqual(byMotion(take), [2, 1, 0])
  assert.deepEqual(heldFrames({ ...take, joints: [knee] }), [false, false, true, false])
  assert.deepEqual(heldFrames(take), [false, false, false, false])
})

test('the plot has room, and its grid round numbers', () => {
  const { low, high } = plotRange([knee])
  assert.ok(low < -20 && high > -5)
  assert.deepEqual(gridOf(-22, -3, 4), [-20, -15, -10, -5])
  assert.deepEqual(gridOf(-1, 1, 4), [-1, -0.5, 0, 0.5, 1])
  assert.equal(roundedTo(1.23456, 0.4), 1.2)
  assert.equal(roundedTo(1.23456, 3), 1)
})

test('names of takes and addresses', () => {
  assert.equal(nextName('walk', ['walk', 'walk_2']), 'walk_3')
  assert.equal(nextName('walk_2', ['walk', 'walk_2']), 'walk_3')
  assert.equal(takeOfAddress(addressOfTake('Gänge_2')), 'Gänge_2')
  assert.equal(takeOfAddress('#/armature'), '')
  assert.equal(takeOfAddress('#/armature/%zz'), '')
})

/** Numbers that count on from 0, behind the take's line, as the program writes them. */
function draftBytes(told: Take, bones: number): ArrayBuffer {
  const line = new TextEncoder().encode(JSON.stringify(told).padEnd(607) + '\n')
  const frames = framesOfTake(told) + told.film
  const numbers = Float32Array.from(
    { length: frames * 7 * bones + told.film * told.joints.length },
    (_, i) => i,
  )
  const bytes = new Uint8Array(line.length + numbers.byteLength)
  bytes.set(line)
  bytes.set(new Uint8Array(numbers.buffer), line.length)
  return bytes.buffer
}

test('a draft is a line and the bones after it', () => {
  const bytes = draftBytes(take, 2)
  const draft = parseDraft(bytes, 2)
  assert.deepEqual(draft.take, take)
  assert.deepEqual(
    draft.poses.map((pose) => pose[0]),
    [0, 14, 28, 42],
  )
  assert.equal(draft.film.length, 0)
  assert.throws(() => parseDraft(bytes.slice(1), 2), /not read whole/)
  assert.throws(() => parseDraft(bytes.slice(0, -4), 2), /not read whole/)
})

test('a draft of a film has the bones and values of each of its frames', () => {
  const filmed = { ...take, film: 7 }
  const draft = parseDraft(draftBytes(filmed, 2), 2)
  assert.equal(draft.poses.length, 4)
  assert.deepEqual(
    draft.film.map((pose) => pose[0]),
    [56, 70, 84, 98, 112, 126, 140],
  )
  assert.deepEqual([draft.filmValues[0], draft.filmValues.length], [154, 21])
  assert.equal(filmLength(filmed), 7, 'the last recorded frame ends the film')
  assert.equal(recordedAt(filmed, 5), 2)
})

/** A program whose answers say what it was asked, and that refuses some lines. */
function desk(refuses: (lines: string[]) => boolean = () => false) {
  const asked: string[] = []
  const refused: unknown[] = []
  let time = 0
  const edits = new Edits({
    draft: async (lines, between) => {
      asked.push((between === 'hold' ? '' : `${between}: `) + lines.join(', '))
      await Promise.resolve()
      if (refuses(lines)) throw new Error(`line ${lines.length}: no`)
      return { take: { ...take, fps: asked.length }, poses: [], said: lines } as unknown as Draft
    },
    changed: () => undefined,
    refused: (error) => refused.push(error),
    now: () => time,
  })
  const rest = async () => {
    for (let i = 0; i < 50; ++i) await Promise.resolve()
  }
  const shown = () => (edits.draft as unknown as { said: string[] }).said.join(', ')
  return { edits, asked, refused, rest, shown, wait: (by: number) => (time += by) }
}

test('changes are done in order, undone and done again without asking anew', async () => {
  const { edits, asked, rest, shown } = desk()
  edits.begin([])
  await rest()
  edits.change(['a'])
  await rest()
  edits.change(['b', 'c'])
  await rest()
  assert.equal(shown(), 'a, b, c')
  edits.undo()
  await rest()
  assert.equal(shown(), 'a')
  edits.redo()
  await rest()
  assert.equal(shown(), 'a, b, c')
  assert.deepEqual(asked, ['', 'a', 'a, b, c'])
  edits.undo()
  edits.undo()
  edits.undo()
  await rest()
  assert.equal(shown(), '')
  edits.change(['d'])
  assert.deepEqual(edits.undone, [])
})

test('another way between frames is asked for, and is no change', async () => {
  const { edits, asked, rest, shown } = desk()
  edits.begin([['a']])
  await rest()
  edits.play('smooth')
  await rest()
  edits.change(['b'])
  await rest()
  edits.play('hold')
  await rest()
  edits.play('smooth')
  await rest()
  assert.deepEqual(asked, ['a', 'smooth: a', 'smooth: a, b', 'a, b'])
  assert.equal(shown(), 'a, b')
  assert.deepEqual(edits.lines, ['a', 'b'])
  edits.undo()
  await rest()
  assert.deepEqual(edits.lines, ['a'])
  assert.equal(nextBetween(nextBetween(nextBetween('hold'))), 'hold')
  assert.equal(nextBetween('keys'), 'hold')
})

test('a pull is shown and leaves nothing behind; only its newest place is asked for', async () => {
  const { edits, asked, rest, shown } = desk()
  edits.begin([['a']])
  await rest()
  edits.show(['p1'])
  edits.show(['p2'])
  edits.show(['p3'])
  await rest()
  assert.equal(shown(), 'a, p3')
  assert.deepEqual(asked, ['a', 'a, p1', 'a, p3'])
  edits.show([])
  await rest()
  assert.equal(shown(), 'a')
  assert.deepEqual(edits.lines, ['a'])
})

test('changes of one kind in quick succession are one', async () => {
  const { edits, rest, wait } = desk()
  edits.begin([])
  edits.change(['x 1'], 'nudge x')
  wait(300)
  assert.ok(edits.continues('nudge x'))
  edits.change(['x 2'], 'nudge x')
  edits.change(['y 1'], 'nudge y')
  wait(2000)
  edits.change(['y 2'], 'nudge y')
  await rest()
  assert.deepEqual(edits.done, [['x 2'], ['y 1'], ['y 2']])
})

test('what was changed while the take was saved is still to be saved', async () => {
  const { edits, rest, shown } = desk()
  edits.begin([['a']])
  await rest()
  const saved = edits.done
  edits.change(['b'])
  assert.equal(edits.saved(saved), false)
  edits.undo()
  edits.show(['p'])
  assert.equal(edits.saved(edits.done), false, 'a pull is about to become a change')
  edits.show([])
  assert.deepEqual(edits.done, [['a']])
  assert.equal(edits.saved(edits.done), true)
  await rest()
  assert.deepEqual([edits.done, edits.undone], [[], []])
  assert.equal(shown(), '')
})

test('what cannot be done is told, and what could be done stays', async () => {
  const { edits, refused, rest, shown } = desk((lines) => lines.includes('bad'))
  edits.begin([])
  edits.change(['a'])
  await rest()
  edits.change(['bad'])
  await rest()
  assert.equal(refused.length, 1)
  assert.deepEqual(edits.done, [['a']])
  assert.equal(shown(), 'a')
  edits.show(['bad'])
  await rest()
  assert.equal(refused.length, 1, 'a pull is only looked at')
  assert.equal(shown(), 'a')
})

test('changes of before that do not fit any more are told and let go', async () => {
  const { edits, refused, rest, shown } = desk((lines) => lines.includes('bad'))
  edits.begin([['bad'], ['c']])
  await rest()
  assert.equal(refused.length, 1)
  assert.deepEqual(edits.done, [])
  assert.equal(shown(), '')
})

test('a take that cannot be read at all is told once', async () => {
  const { edits, refused, rest } = desk(() => true)
  edits.begin([])
  await rest()
  assert.equal(refused.length, 1)
  assert.equal(edits.draft, null)
  assert.equal(edits.busy, false)
})
