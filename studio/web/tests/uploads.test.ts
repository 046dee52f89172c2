// Which files go where, and under which names; marks as two lists of picks.
import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Found } from '../src/pages/new_project/files'
import { kBody, kScan, MarkSides } from '../src/pages/marks/marks_api'
import type { Marks } from '../src/pages/marks/marks_api'
import { camerasOf } from '../src/pages/new_project/cameras_of'
import { itemsFor } from '../src/uploads/upload_model'

const found = (...paths: string[]): Found[] =>
  paths.map((path) => ({ file: { name: path.split('/').pop()! } as File, path }))
const names = (place: 'shot' | 'scan', ...paths: string[]) =>
  itemsFor(place, found(...paths)).items.map((one) => one.name)

test('films keep the folders that say what they are', () => {
  assert.deepEqual(
    names('shot', 'walk/cam1/0.png', 'walk/masks/cam1/0.png', 'walk/background/cam1.jpg'),
    ['cam1/0.png', 'masks/cam1/0.png', 'background/cam1.jpg'],
  )
  // As cameras write them: each in a folder, all of one name.
  assert.deepEqual(names('shot', 'a/GX01.MP4', 'b/GX01.MP4', 'c.mov'), ['a.mp4', 'b.mp4', 'c.mov'])
  assert.deepEqual(itemsFor('shot', found('notes.txt', 'x/.DS_Store')).leftOut, ['notes.txt'])
  assert.deepEqual(names('scan', 'x/hero.obj', 'x/hero.png'), ['hero.obj', 'hero.png'])
})

test('cameras come before what lies beside them', () => {
  const items = itemsFor('shot', found('w/masks/cam1/0.png', 'w/cam1/0.png', 'w/cam1/1.png', 'c.mp4'))
  assert.deepEqual(
    camerasOf(items.items).map((one) => one.words),
    ['cam1: 2 pictures', 'c.mp4', 'masks/cam1: 1 picture'],
  )
})

test('a mark is saved once both its sides are there, and halves stay', async () => {
  const pick = (name: string, face: number) =>
    ({ name, face, barycentric: [1, 0, 0] as [number, number, number] })
  const sent: string[][] = []
  const side = { there: true, version: '', missing: '' }
  let file: Marks = { revision: '0', problem: '', pairs: [], body: side, scan: side }
  const marks = new MarkSides(
    {
      read: async () => file,
      save: async (pairs, revision) => {
        assert.equal(revision, file.revision)
        sent.push(pairs.map((one) => one.source.name))
        const whole = pairs.map((one) => ({
          ...one, name: one.source.name, confirmed: true, confidence: 1,
        }))
        return (file = { ...file, pairs: whole, revision: String(sent.length) })
      },
    },
    () => undefined,
  )
  assert.deepEqual((await marks.picks(kBody)).picks, [])
  await marks.savePicks(kBody, [pick('a', 1), pick('b', 2)], '')
  assert.deepEqual(sent, [])
  const saved = await marks.savePicks(kScan, [pick('a', 7)], '')
  assert.deepEqual(sent, [['a']])
  // Read again: the same content has the same revision, and the half is still there.
  assert.equal((await marks.picks(kScan)).revision, saved.revision)
  assert.deepEqual((await marks.picks(kBody)).picks.map((one) => one.name), ['a', 'b'])
  await marks.savePicks(kBody, [pick('b', 2)], '')
  assert.deepEqual(sent, [['a'], []])
})
