import assert from 'node:assert/strict'
import { test } from 'node:test'

import { ApiError } from '../src/api'
import type { Pick } from '../src/api'
import { figuresOf, pairsApart } from '../src/pages/landmarks/fit_figures'
import { connected, neighboursOf, Painting } from '../src/pages/landmarks/painting'
import { PickFiles } from '../src/pages/landmarks/pick_files'
import type { PicksApi } from '../src/pages/landmarks/pick_files'
import * as history from '../src/pages/landmarks/pick_history'

const pick = (name: string, face = 0): Pick => ({ name, face, barycentric: [1, 0, 0] })

/** Files in memory, with revisions as the server has them. */
class Disk {
  readonly files = new Map<string, { revision: number; picks: Pick[] }>()
  readonly api: PicksApi = {
    picks: async (pose: string) => this.answer(pose),
    savePicks: async (pose: string, picks: Pick[], revision: string) => {
      const file = this.file(pose)
      if (revision !== String(file.revision)) throw new ApiError(409, 'changed elsewhere')
      this.files.set(pose, { revision: file.revision + 1, picks: structuredClone(picks) })
      return this.answer(pose)
    },
  } as PicksApi
  file(pose: string) {
    return this.files.get(pose) ?? { revision: 0, picks: [] }
  }
  names(pose: string) {
    return this.file(pose).picks.map((one) => one.name)
  }
  private answer(pose: string) {
    const file = this.file(pose)
    return {
      pose,
      revision: String(file.revision),
      picks: structuredClone(file.picks),
      problems: [],
    }
  }
}

test('deleting a pair keeps the template pick that another pose uses', () => {
  let sheet = history.kEmptyHistory.now
  for (const pose of ['template', 'wave', 'bow'])
    sheet = history.withPick(sheet, pose, pick('nose'))
  assert.deepEqual(history.otherUsers(sheet, 'template', 'wave', 'nose'), ['bow'])
  const without = history.withoutPair(sheet, 'template', 'wave', 'nose')
  assert.equal(history.picksOf(without, 'template').length, 1)
  assert.equal(history.picksOf(without, 'wave').length, 0)
})

test('names of the language are names like any other', () => {
  const sheet = history.withPick(history.kEmptyHistory.now, 'template', pick('a'))
  const renamed = history.withName(sheet, 'a', '__proto__')
  assert.equal(history.picksOf(renamed, 'template')[0].name, '__proto__')
})

test('changes are saved in order, undone and redone', async () => {
  const disk = new Disk()
  const files = new PickFiles(
    disk.api,
    () => undefined,
    () => undefined,
  )
  await files.load(['template', 'wave'])
  files.change('pick a', history.withPick(files.history.now, 'wave', pick('a')))
  files.change('pick b', history.withPick(files.history.now, 'template', pick('b')))
  await files.save()
  assert.deepEqual(disk.names('wave'), ['a'])
  assert.deepEqual(disk.names('template'), ['b'])
  files.undo()
  await files.save()
  assert.deepEqual(disk.names('template'), [])
  files.redo()
  await files.save()
  assert.deepEqual(disk.names('template'), ['b'])
})

test('what somebody else has written meanwhile is told and never overwritten', async () => {
  const disk = new Disk()
  const told: string[] = []
  const files = new PickFiles(
    disk.api,
    () => undefined,
    (text: string) => told.push(text),
  )
  await files.load(['template', 'wave'])
  disk.files.set('wave', { revision: 99, picks: [pick('theirs')] })
  files.change('pick', history.withPick(files.history.now, 'wave', pick('ours')))
  await files.save()
  assert.equal(told.length, 1)
  assert.deepEqual(disk.names('wave'), ['theirs'])
  assert.deepEqual(
    history.picksOf(files.history.now, 'wave').map((one) => one.name),
    ['theirs'],
  )
})

test('paint is undone stroke by stroke, and stays on the part that was touched', () => {
  const painting = new Painting(4)
  painting.layer('stiffness', 1)
  painting.begin('stiffness')
  painting.paint([0, 1], 8)
  painting.paint([1, 2], 4)
  assert.ok(painting.end())
  assert.deepEqual([...painting.layer('stiffness')], [8, 4, 4, 1])
  painting.undo()
  assert.deepEqual([...painting.layer('stiffness')], [1, 1, 1, 1])
  const neighbours = neighboursOf(new Uint32Array([0, 1, 2, 3, 4, 5]), 6)
  assert.deepEqual(connected([0, 1, 2, 3, 4, 5], [0], neighbours).sort(), [0, 1, 2])
})

test('the median of a fit leaves out vertices without a distance', () => {
  assert.equal(figuresOf(new Float32Array([3, 1, NaN, 2]))?.median, 2)
})

test('pairs apart are a mean, and nothing without pairs', () => {
  assert.equal(pairsApart([]), null)
  assert.equal(pairsApart([{ distance: 0.25 }, { distance: 0.75 }]), 0.5)
})
