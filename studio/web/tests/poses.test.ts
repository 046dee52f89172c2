import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Photograph, Pose, Step } from '../src/api'
import { freeName, groupsOf, sentOf } from '../src/pages/poses/add_model'
import { againWords } from '../src/pages/poses/again_words'
import { namedIn, saysLeaveOut } from '../src/pages/poses/named'
import { judge, ordered } from '../src/pages/poses/quality'
import { isFromMesh, tabsOf } from '../src/pages/poses/tabs'

const pose = (more: Partial<Pose>): Pose => ({
  name: 'rest',
  template: false,
  method: 'scan',
  photos: 'photos/rest',
  photographs: 24,
  left_out: 0,
  masks: '',
  mesh: '',
  has_landmarks: false,
  meshes: [],
  has_texture: false,
  has_confidence: false,
  has_cameras: false,
  has_frames: false,
  ...more,
})

test('a pose of photographs has all there is to see; the template is fitted to nothing', () => {
  assert.deepEqual(tabsOf(pose({})), ['photographs', 'figure', '3d', 'mend', 'fit', 'wipe'])
  assert.deepEqual(tabsOf(pose({ template: true })), ['photographs', 'figure', '3d', 'mend', 'wipe'])
})

test('a pose whose mesh was made elsewhere has no photographs to show', () => {
  const given = pose({ mesh: 'meshes/rest.obj', photographs: 0 })
  assert.deepEqual(tabsOf(given), ['3d', 'mend', 'fit'])
  assert.deepEqual(tabsOf({ ...given, template: true }), ['3d', 'mend'])
  assert.equal(isFromMesh({ ...given, photographs: 3 }), false)
})

const found = (path: string, text = path) => ({
  file: new File([text], path.split('/').pop()!),
  path,
})

test('folders go to the pose of their name, loose files to the one that is open', () => {
  const poses = ['rest', 'wave']
  const both = groupsOf(['wave/a.jpg', 'bow (2)/b.jpg', 'c.jpg'].map((one) => found(one)), poses, 'rest')
  assert.deepEqual(
    both.map((one) => [one.folder, one.target, one.name]),
    [
      ['wave', 'wave', 'wave'],
      ['bow (2)', '', 'bow-2'],
      ['', 'rest', ''],
    ],
  )
  const [alone] = groupsOf([found('DCIM/a.jpg'), found('DCIM/notes.txt')], poses, 'rest')
  assert.equal(alone.target, 'rest')
  assert.equal(alone.leftOut[0].path, 'DCIM/notes.txt')
})

test('a name that is there already is replaced, kept beside it, or not sent', () => {
  const [group] = groupsOf([found('a.jpg'), found('b.jpg')], ['rest'], 'rest')
  const sent = (same: 'replace' | 'both' | 'skip') =>
    sentOf(group, ['a.jpg', 'a-2.jpg'], same).map((one) => `${one.name} ${one.replaces}`)
  assert.deepEqual(sent('replace'), ['a.jpg a.jpg', 'b.jpg '])
  assert.deepEqual(sent('both'), ['a-3.jpg ', 'b.jpg '])
  assert.deepEqual(sent('skip'), ['b.jpg '])
  assert.equal(freeName('x.jpg', new Set()), 'x.jpg')
})

test('a warning names photographs by whole names, and says what to do with them', () => {
  const names = ['a.jpg', 'aa.jpg', 'lying_a.jpg', 'IMG 1.jpg']
  const text = 'contradict the others: a.jpg, IMG 1.jpg. Leave them out, or shoot them again'
  assert.deepEqual(namedIn(text, names), ['a.jpg', 'IMG 1.jpg'])
  assert.deepEqual(namedIn('masks of none: a.jpg.png, lying_a.jpgx', names), [])
  assert.deepEqual(namedIn('/photos/rest/aa.jpg: it is cut off', names), ['aa.jpg'])
  assert.ok(saysLeaveOut(text))
  assert.ok(saysLeaveOut('these were left out: a.jpg'))
  assert.ok(!saysLeaveOut('the mask of a.jpg touches the border; move the figure'))
})

test('what runs again is said with the time that it took', () => {
  const again = { step: 'capture/rest', follow: ['sfm/rest', 'report'], seconds: 125, made: true }
  assert.equal(
    againWords(again, 'rest', [
      { id: 'capture/rest', title: 'Photographs', pose: 'rest' } as Step,
    ]),
    'The next run makes “Photographs of rest” again, and after it up to 2 steps; all of it took 2 min 05 s last time.',
  )
  assert.match(againWords({ ...again, made: false }, 'rest', []), /^Nothing is made of rest yet/)
  assert.match(againWords({ ...again, step: '' }, 'rest', []), /^No step reads/)
  assert.equal(againWords(null, 'rest', []), '')
})

test('what is left out is not judged, and changes nothing of how others are', () => {
  const one = (name: string, sharpness: number, more: Partial<Photograph> = {}) =>
    ({ name, sharpness, exposure: 100, mask_fraction: 0.3, trusted: true, captured: true, left_out: false, ...more }) as Photograph
  const set = [one('a', 10), one('b', 10), one('c', 1), one('d', 0.1, { left_out: true, trusted: false })]
  const judged = judge(set)
  assert.deepEqual(
    judged.map((each) => each.flags.map((flag) => flag.text).join()),
    ['', '', 'blurred', ''],
  )
  assert.equal(judged[0].sharpness, 1)
  assert.equal(ordered(judged, 'worst').at(-1)!.photograph.name, 'd')
})
