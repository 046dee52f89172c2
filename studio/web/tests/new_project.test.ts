import assert from 'node:assert/strict'
import { test } from 'node:test'

import { kAccept, sorted } from '../src/pages/new_project/files'
import { emptyRow, fewOf, withFiles } from '../src/pages/new_project/rows'
import { headOf } from '../src/pages/new_project/upload'
import type { Upload } from '../src/pages/new_project/upload'

const found = (path: string, bytes = 1) => ({ file: new File([new Uint8Array(bytes)], path), path })

test('only what the server takes is offered and sent', () => {
  assert.equal(kAccept, '.jpg,.jpeg,.jfif,.png,.tif,.tiff,.heic,.heif,.hif')
  const { photos } = sorted(
    ['b10.JPG', 'b9.heic', 'a.tiff', 'c.webp', 'd.CR2'].map((path) => found(path)),
  )
  assert.deepEqual(
    photos.map((one) => one.path),
    ['a.tiff', 'b9.heic', 'b10.JPG'],
  )
})

test('what is left out is told with what to do', () => {
  const { leftOut } = sorted([
    found('d.CR2'),
    found('c.webp'),
    found('notes.txt'),
    found('README'),
    found('a.jpg', 0),
    found('rest/masks/a.png'),
    found('.DS_Store'),
    found('Thumbs.db'),
  ])
  assert.deepEqual(
    leftOut.map((one) => one.path),
    ['d.CR2', 'c.webp', 'notes.txt', 'README', 'a.jpg', 'rest/masks/a.png'],
  )
  assert.match(leftOut[0].why, /RAW files go into the pose’s folder by hand/)
  assert.equal(leftOut[1].why, 'save it as JPEG or PNG')
  assert.equal(leftOut[2].why, '.txt is no photograph')
})

test('a pose of few photographs is one that the template is bent into, never the template', () => {
  const row = (name: string, photographs: number) => {
    const files = Array.from({ length: photographs }, (_, i) => found(`${name}/${i}.jpg`))
    return withFiles({ ...emptyRow(), name }, files, [])
  }
  const rows = [row('rest', 6), row('wave', 6), row('bent', 16)]
  assert.deepEqual(fewOf(rows, 'rest'), ['wave'])
  assert.deepEqual(fewOf(rows, 'bent'), ['rest', 'wave'])
})

test('a project whose photographs did not all arrive is not said to be made', () => {
  const photo = sorted([found('a.jpg')]).photos[0]
  const one = { pose: 'rest', photo, why: 'there is no space left on the disk' }
  const ended = (sent: number, failed: number): Upload => ({
    ...{ state: 'ended', sent, total: sent, bytesSent: 0, bytesTotal: 0, now: '', left: [] },
    failed: Array.from({ length: failed }, () => one),
  })
  assert.equal(headOf(ended(3, 0)), 'The project is made')
  assert.equal(headOf(ended(3, 1)), 'Not all photographs were taken')
  assert.equal(headOf(ended(3, 3)), 'No photograph was taken')
  assert.equal(headOf({ ...ended(3, 0), state: 'cancelled' }), 'Stopped')
})
