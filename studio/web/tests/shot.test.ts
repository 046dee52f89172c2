import assert from 'node:assert/strict'
import { test } from 'node:test'

import { ClickFile, nameOf, nextName, replaced, without } from '../src/pages/shot/click_file'
import { withShow } from '../src/pages/shot/film_strip'
import { withinFrame } from '../src/view/frame_view'
import { firstShows } from '../src/pages/shot/setup_form'
import type { Click, Finished, Located } from '../src/pages/shot/shot_api'
import { countWords, focalWords, gradeOf, pictureWords } from '../src/pages/shot/words'

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
