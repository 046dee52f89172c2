import assert from 'node:assert/strict'
import { test } from 'node:test'

import { ApiError } from '../src/api'
import type { PhotoFit, PhotoPick, Pick } from '../src/api'
import { figuresOf, pairsApart } from '../src/pages/landmarks/fit_figures'
import { outlinePath } from '../src/pages/landmarks/mask_outline'
import { connected, neighboursOf, Painting } from '../src/pages/landmarks/painting'
import {
  contradictionOf,
  isOlder,
  residualsOf,
  stateWords,
  withOlderHeld,
  worstPlaces,
} from '../src/pages/landmarks/photo_model'
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

const photoPick = (name: string, image: string, x = 0, y = 0): PhotoPick => ({
  name,
  image,
  pixel: [x, y],
})

test('picks in photographs are joined by name, renamed with the template, and deleted', () => {
  let sheet = history.withPick(history.kEmptyHistory.now, 'rest', pick('nose'))
  sheet = history.withPhotoPick(sheet, 'wave', photoPick('nose', 'a.jpg', 1))
  sheet = history.withPhotoPick(sheet, 'wave', photoPick('nose', 'b.jpg', 2))
  sheet = history.withPhotoPick(sheet, 'wave', photoPick('nose', 'b.jpg', 3))
  sheet = history.withPhotoPick(sheet, 'wave', photoPick('tail', 'b.jpg'))
  const [nose, tail] = history.photoPairsOf(sheet, 'rest', 'wave')
  assert.deepEqual(
    nose.pixels.map((one) => one.pixel[0]),
    [1, 3],
  )
  assert.equal(tail.template, null)
  assert.ok(history.namesOf(sheet).has('tail'))
  const renamed = history.withName(sheet, 'nose', 'snout')
  assert.equal(history.photoPairsOf(renamed, 'rest', 'wave')[0].pixels.length, 2)
  assert.equal(history.photoPairsOf(renamed, 'rest', 'wave')[0].template?.name, 'snout')
  const less = history.withoutPhotoPick(sheet, 'wave', 'nose', 'a.jpg')
  assert.equal(history.photoPicksOf(less, 'wave').length, 2)
  const none = history.withoutPhotoPair(sheet, 'rest', 'wave', 'nose')
  assert.deepEqual(history.photoPairsOf(none, 'rest', 'wave'), [tail])
  const used = history.withPick(sheet, 'bow', pick('nose'))
  const kept = history.withoutPhotoPair(used, 'rest', 'wave', 'nose')
  assert.equal(history.picksOf(kept, 'rest').length, 1)
})

test('picks in photographs are saved beside those on meshes, and undone together', async () => {
  const disk = new Disk()
  let saved: PhotoPick[] = []
  let revision = 0
  const answer = () => ({
    pose: 'wave',
    revision: String(revision),
    picks: [],
    pixels: structuredClone(saved),
    problems: [],
  })
  const files = new PickFiles(
    {
      picks: async (pose) => (pose === 'wave' ? answer() : disk.api.picks(pose)),
      savePicks: (pose, picks, old) => disk.api.savePicks(pose, picks, old),
      savePixels: async (_, pixels, old) => {
        if (old !== String(revision)) throw new ApiError(409, 'changed elsewhere')
        saved = structuredClone(pixels)
        revision++
        return answer()
      },
    },
    () => undefined,
    () => undefined,
  )
  await files.load(['rest', 'wave'])
  const half = history.withPick(files.history.now, 'rest', pick('nose'))
  files.change('pair nose', history.withPhotoPick(half, 'wave', photoPick('nose', 'a.jpg')))
  await files.save()
  assert.deepEqual(disk.names('rest'), ['nose'])
  assert.equal(saved.length, 1)
  files.undo()
  await files.save()
  assert.deepEqual(disk.names('rest'), [])
  assert.equal(saved.length, 0)
  saved = [photoPick('ear', 'b.jpg')]
  revision++
  await files.load(['rest', 'wave'])
  assert.equal(history.photoPicksOf(files.history.now, 'wave')[0].name, 'ear')
  assert.equal(files.history.future.length, 0)
})

const photograph = (name: string, distance_px: number): PhotoFit['photographs'][number] => ({
  name,
  width: 1000,
  height: 800,
  photograph: `${name} now`,
  shot_again: false,
  placed: true,
  iou: 0.9,
  worst: { pixel: [5, 6], distance_px, beyond: 'mask' },
})
const photoFit = (over: Partial<PhotoFit>): PhotoFit => ({
  photographs: [photograph('a.jpg', 3), photograph('b.jpg', 30), photograph('c.jpg', 10)],
  shown: [],
  lines: [],
  meets: [],
  refused: [],
  ...over,
})

test('a residual is the distance to the fitted model, and wrong if far or refused', () => {
  const pair = {
    name: 'nose',
    template: pick('nose'),
    pixels: [photoPick('nose', 'a.jpg', 100, 100), photoPick('nose', 'b.jpg', 3, 4)],
  }
  const shown = [
    { ...photoPick('nose', 'a.jpg', 130, 140), hidden: false },
    { ...photoPick('nose', 'b.jpg'), hidden: false },
  ]
  const fit = photoFit({ shown })
  assert.deepEqual(
    residualsOf(pair, fit).map(({ off_px, wrong }) => [off_px, wrong]),
    [
      [50, true],
      [5, false],
    ],
  )
  assert.equal(stateWords(pair, 'rest', fit), '2 photos · 50 px')
  const refused = photoFit({ shown, refused: [{ name: 'nose', image: 'b.jpg' }] })
  assert.ok(residualsOf(pair, refused)[1].wrong)
  assert.deepEqual(residualsOf(pair, null), [])
  const meets = [photoPick('nose', 'a.jpg', 100, 106)]
  assert.equal(contradictionOf(pair, 'a.jpg', photoFit({ meets })), 6)
  assert.equal(contradictionOf(pair, 'c.jpg', photoFit({ meets })), null)
})

test('a pick in an older photograph is told apart, has no residual, and can be held', () => {
  const old = { ...photoPick('nose', 'a.jpg', 100, 100), photograph: 'a.jpg then' }
  const fresh = { ...photoPick('nose', 'b.jpg', 3, 4), photograph: 'b.jpg now' }
  const unknown = photoPick('nose', 'c.jpg', 5, 6)
  const gone = { ...photoPick('nose', 'd.jpg'), photograph: 'd.jpg then' }
  const picks = [old, fresh, unknown, gone]
  const fit = photoFit({ shown: picks.map((one) => ({ ...one, hidden: false })) })
  assert.deepEqual(
    picks.map((one) => isOlder(one, fit)),
    [true, false, false, false],
  )
  const pair = { name: 'nose', template: pick('nose'), pixels: picks }
  assert.deepEqual(
    residualsOf(pair, fit).map((one) => one.pick.image),
    ['b.jpg', 'c.jpg'],
  )
  const held = withOlderHeld(picks, fit)
  assert.deepEqual(held, [{ ...old, photograph: 'a.jpg now' }, fresh, unknown, gone])
})

test('the worst places come first, and small gaps not at all', () => {
  assert.deepEqual(
    worstPlaces(photoFit({})).map((one) => one.image),
    ['b.jpg', 'c.jpg'],
  )
  assert.deepEqual(worstPlaces(null), [])
})

test('the outline of a mask is the sides of its pixels, joined along rows and columns', () => {
  const mask = new Uint8Array([0, 0, 0, 0, 0, 255, 255, 0, 0, 0, 0, 0])
  assert.equal(outlinePath(mask, 4, 3, 2), 'M2.0 2.0H6.0M2.0 4.0H6.0M2.0 2.0V4.0M6.0 2.0V4.0')
})
