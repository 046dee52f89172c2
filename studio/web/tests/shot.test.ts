import assert from 'node:assert/strict'
import { test } from 'node:test'

import { ClickFile, nameOf, nextName, replaced, without } from '../src/pages/shot/click_file'
import { withShow } from '../src/pages/shot/film_strip'
import { withinFrame } from '../src/view/frame_view'
import { faultOf, kNoParts, lackOf, optionsOf, partsAfter, partWords } from '../src/pages/shot/parts'
import { firstShows } from '../src/pages/shot/setup_form'
import type { Click, Finished, Located, Measured, Offers } from '../src/pages/shot/shot_api'
import {
  cameraWords,
  countWords,
  focalWords,
  gradeOf,
  pictureWords,
  quickWords,
  seenWords,
} from '../src/pages/shot/words'

const click = (name: string): Click => ({
  name,
  frame: 0,
  pixel: [1, 2],
  face: 3,
  barycentric: [1, 0, 0],
})

/** A file that others may write; `told` are the words for the person. */
function fileOf() {
  const disk = { clicks: [] as readonly Click[], revision: '0', writes: 0, refuse: '' }
  const told: string[] = []
  const store = {
    save: async (clicks: readonly Click[], revision: string) => {
      await new Promise((go) => setTimeout(go, 2))
      if (disk.refuse) throw Object.assign(new Error(disk.refuse), { status: 400 })
      if (revision !== disk.revision) throw Object.assign(new Error('changed'), { status: 409 })
      disk.clicks = clicks
      disk.revision = String(++disk.writes)
      return disk.revision
    },
    read: async () => ({ clicks: disk.clicks, revision: disk.revision }),
  }
  const file = new ClickFile(store, () => undefined, (words) => told.push(words))
  file.take([], '0')
  return { file, disk, told }
}

test('clicks are saved in order, undone and redone, and the file has each state', async () => {
  const { file, disk } = fileOf()
  file.change('click 1', [click('1')])
  file.change('click 2', [click('1'), click('2')])
  await file.save()
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  assert.equal(disk.clicks.length, 2)
  assert.equal(file.undo(), 'click 2')
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  assert.deepEqual(disk.clicks, [click('1')])
  assert.equal(file.redo(), 'click 2')
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  assert.equal(disk.clicks.length, 2)
  assert.equal(file.redo(), '')
})

test('what somebody else has written is read and never overwritten', async () => {
  const { file, disk, told } = fileOf()
  disk.clicks = [click('theirs')]
  disk.revision = 'theirs'
  file.change('click 1', [click('1')])
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  assert.deepEqual(disk.clicks, [click('theirs')])
  assert.deepEqual(file.clicks, [click('theirs')])
  assert.equal(told.length, 1)
  assert.equal(file.canUndo, false)
})

test('a change that is refused stays on the page, and is tried again', async () => {
  const { file, disk } = fileOf()
  disk.refuse = 'no room'
  file.change('click 1', [click('1')])
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  assert.equal(file.failed, 'no room')
  // An older file that comes meanwhile does not take it away.
  file.take([], 'other')
  assert.equal(file.clicks.length, 1)
  disk.refuse = ''
  await file.save()
  assert.equal(file.failed, '')
  assert.equal(disk.clicks.length, 1)
})

test('names are the first free numbers; clicks of a hand-written file may have none', () => {
  assert.equal(nextName([click('1'), click('3')]), '2')
  assert.equal(nextName([]), '1')
  const bare: Click = { frame: 0, pixel: [0, 0], vertex: 7 }
  assert.equal(nameOf(bare, 4), '#5')
  assert.deepEqual(without([click('1'), bare], 0), [bare])
  assert.deepEqual(replaced([click('1'), bare], 1, click('2')), [click('1'), click('2')])
})

test('a frame shows one pose or none, and frames are in order', () => {
  const shows = [
    { frame: 0, pose: 'rest' },
    { frame: 8, pose: 'bow' },
  ]
  const three = withShow(shows, 4, 'wave')
  assert.deepEqual(
    three.map((show) => show.frame),
    [0, 4, 8],
  )
  assert.equal(withShow(three, 4, 'bow')[1].pose, 'bow')
  assert.deepEqual(withShow(three, 4, ''), shows)
})

test('a new shot begins with frames of its own for each pose', () => {
  assert.deepEqual(firstShows(['rest'], 9), [
    { frame: 0, pose: 'rest' },
    { frame: 8, pose: 'rest' },
  ])
  for (const pictures of [2, 3, 5, 100]) {
    const shows = firstShows(['a', 'b', 'c', 'd', 'e'], pictures)
    assert.equal(new Set(shows.map((show) => show.frame)).size, shows.length)
    assert.equal(shows[0].frame, 0)
    assert.equal(shows.at(-1)!.frame, pictures - 1)
  }
})

test('however far one zooms and drags, the frame fills the view', () => {
  for (const scale of [0.2, 1, 3, 100])
    for (const x of [-500, 0, 240, 900]) {
      const zoom = withinFrame({ scale, x, y: x }, 480, 270)
      assert.ok(zoom.scale >= 1 && zoom.scale <= 12)
      assert.ok(zoom.x - 240 / zoom.scale >= -1e-9 && zoom.x + 240 / zoom.scale <= 480 + 1e-9)
      assert.ok(zoom.y - 135 / zoom.scale >= -1e-9 && zoom.y + 135 / zoom.scale <= 270 + 1e-9)
    }
})

test('words say how the lens was found, and how well a frame fits', () => {
  const located = { focal_px: 1353.3, focal: 'solved', focal_uncertainty: 0.0215 } as Located
  assert.equal(focalWords(located), '1353 px, found in the pictures, ± 2.1 %')
  const kept = focalWords({ ...located, focal: 'kept', focal_uncertainty: 0 })
  assert.equal(kept, '1353 px, could not be seen in the pictures: 50 mm is taken')
  const frame = { frame: 0, pose: 'rest', method: 'clicks', inliers: null }
  assert.equal(gradeOf({ ...frame, contour_px: 0.3, iou: 0.99 }), 'good')
  assert.equal(gradeOf({ ...frame, contour_px: 2, iou: 0.99 }), 'look')
  assert.equal(gradeOf({ ...frame, contour_px: 0.3, iou: 0.5 }), 'wrong')
  assert.equal(gradeOf({ ...frame, contour_px: null, iou: null }), 'look')
})

test('a picture says whether it was filmed or made, and between which', () => {
  const finished = {
    pictures: [
      { picture: 0, kind: 'filmed', film: '0000.png', frame: 0 },
      { picture: 1, kind: 'between', frame: 1 },
      { picture: 2, kind: 'filmed', film: '0001.png', frame: 2 },
      { picture: 3, kind: 'held', film: '0001.png', frame: 2 },
    ],
  } as Finished
  assert.equal(countWords(finished), '2 filmed, 1 in-between, 1 held')
  assert.equal(pictureWords(finished, 1), 'in-between, made: from 0000.png to 0001.png')
  assert.equal(pictureWords(finished, 2), 'filmed: 0001.png')
  assert.equal(pictureWords(finished, 9), '')
})

const kOffers: Offers = {
  folders: [
    { path: 'films/plates', pictures: 9 },
    { path: 'films/take1', pictures: 9 },
  ],
  videos: ['films/mattes.mov'],
  pictures: ['films/empty.png'],
  meshes: ['films/set.obj'],
}

test('each part is chosen from what it can be, and never the film itself', () => {
  const of = (part: 'plate' | 'mattes' | 'holdout' | 'set', camera: 'still' | 'moving', now = '') =>
    optionsOf(part, kOffers, camera, now, 'films/take1').map(({ path }) => path)
  assert.deepEqual(of('plate', 'still'), ['films/empty.png', 'films/plates', 'films/mattes.mov'])
  assert.deepEqual(of('plate', 'moving'), ['films/plates', 'films/mattes.mov'])
  assert.deepEqual(of('mattes', 'still'), ['films/plates', 'films/mattes.mov'])
  assert.deepEqual(of('holdout', 'still'), ['films/empty.png'])
  assert.deepEqual(of('set', 'moving'), ['films/set.obj'])
  // What an editor has named stays to be seen.
  assert.deepEqual(of('set', 'still', '../rig/set.ply'), ['../rig/set.ply', 'films/set.obj'])
})

test('a part that was chosen while the set-up was saved stays chosen', () => {
  const before = { ...kNoParts, set: 'films/set.obj' }
  const sent = { ...before, plate: 'films/empty.png' }
  const chosen = { ...sent, mattes: 'films/mattes.mov' }
  // The file has what was sent; what was chosen since is not in it.
  assert.deepEqual(partsAfter(chosen, before, sent), chosen)
  // Somebody else has taken the set out: nobody has chosen it here.
  assert.deepEqual(partsAfter(chosen, sent, { ...sent, set: '' }), { ...chosen, set: '' })
  assert.deepEqual(partsAfter(before, before, sent), sent)
})

test('a moving camera asks for plates, and is not saved with one picture of the set', () => {
  const moving = { ...kNoParts, camera: 'moving' as const }
  assert.equal(faultOf(kNoParts, kOffers), '')
  assert.equal(faultOf({ ...kNoParts, plate: 'films/empty.png' }, kOffers), '')
  assert.notEqual(faultOf({ ...moving, plate: 'films/empty.png' }, kOffers), '')
  assert.equal(faultOf({ ...moving, plate: 'films/plates' }, kOffers), '')
  assert.ok(lackOf(moving).includes('no pictures can be made'))
  assert.equal(lackOf({ ...moving, plate: 'films/plates' }), '')
  assert.ok(lackOf({ ...moving, plate: 'films/plates', holdout: 'x.png' }).includes('holdout'))
  assert.equal(partWords('moving')[0].label, 'Plates of the empty set')
  for (const { when } of [...partWords('still'), ...partWords('moving')]) assert.ok(when.length > 40)
})

test('the card says whether the camera moves, and how much it jitters', () => {
  const measured: Measured = {
    focal_seen: 0.043,
    one_place: true,
    jitter_px: 0,
    camera_jitter_px: null,
  }
  const frames = Array.from({ length: 5 }, (_, frame) => ({ frame }))
  const still = { still: true, measured, frames } as Located
  assert.ok(cameraWords(still).endsWith('nothing jitters.'))
  const apart = { ...still, measured: { ...measured, one_place: false, jitter_px: 0.714 } }
  assert.ok(cameraWords(apart).includes('at most 0.71 px'))
  const moving = { ...still, still: false, measured: { ...measured, camera_jitter_px: 0.304 } }
  assert.ok(cameraWords(moving).includes('jitters by 0.30 px'))
  const short = { ...moving, frames: moving.frames.slice(1) }
  assert.ok(cameraWords(short).includes('cannot be told'))
  assert.equal(seenWords(still), 'The pictures alone show it to 4.3 %.')
  assert.equal(seenWords({ ...still, measured: { ...measured, focal_seen: null } }), '')
})

test('what four clicks give is called rough; clicks that do not agree are told', () => {
  const quick = { frame: 0, number: 1, seconds: 0.3, problem: '', focal_px: 853.4, focal: 'kept' }
  assert.ok(quickWords({ ...quick, contour_px: null, iou: null }).startsWith('Rough'))
  assert.ok(quickWords({ ...quick, contour_px: 1.52, iou: 0.951 }).includes('overlap 95.1 %'))
  const wrong = 'click 3 does not agree with the others'
  assert.equal(quickWords({ ...quick, problem: wrong }), 'Click 3 does not agree with the others.')
})

test('an answer to a question of before a change does not undo the change', async () => {
  const { file } = fileOf()
  const asked = file.moment
  file.change('click 1', [click('1')])
  await file.save()
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  file.take([], 'of before', asked)
  assert.deepEqual(file.clicks, [click('1')])
  file.take([], 'of another', file.moment)
  assert.deepEqual(file.clicks, [])
})

test('an answer that the saving has overtaken takes nothing back, and undo goes on', async () => {
  const { file, told } = fileOf()
  file.change('click 1', [click('1')])
  assert.ok(file.saving)
  const asked = file.moment // the server reads the file before it has the change
  while (file.saving) await new Promise((go) => setTimeout(go, 2))
  file.take([], '0 of before', asked)
  assert.deepEqual(file.clicks, [click('1')])
  assert.deepEqual(told, [])
  assert.equal(file.undo(), 'click 1')
})
