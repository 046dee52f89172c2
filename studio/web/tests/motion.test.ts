import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { FrameColours } from '../src/api'
import {
  kTextureRoom,
  nextColours,
  playedTextures,
  shownColours,
  videoWords,
} from '../src/pages/motion/colours'
import { FigureColours } from '../src/pages/motion/figure_colours'
import { TextureTrack } from '../src/pages/motion/texture_track'

const kAll: FrameColours = {
  own: 'texture',
  own_problem: '',
  video: { width: 2048, height: 2048, version: 'a' },
  video_problem: '',
}
const soon = (ms = 0) => new Promise((go) => setTimeout(go, ms))

/** A track whose loads end when the test says so. */
function trackOf(count: number, most: number, atOnce = 2) {
  const waiting = new Map<number, (fault?: Error) => void>()
  const log = { loads: [] as number[], freed: [] as number[], faults: [] as unknown[] }
  const load = (frame: number) => {
    log.loads.push(frame)
    return new Promise<number>((done, failed) =>
      waiting.set(frame, (fault) => (fault ? failed(fault) : done(frame))),
    )
  }
  const track = new TextureTrack<number>(
    count,
    load,
    (picture) => log.freed.push(picture),
    { most, atOnce },
    () => undefined,
    (fault) => log.faults.push(fault),
  )
  const come = async (frame: number, fault?: Error) => {
    waiting.get(frame)!(fault)
    waiting.delete(frame)
    await soon()
  }
  /** All that is asked for, in order. */
  const comeAll = async () => {
    while (waiting.size > 0) await come([...waiting.keys()][0])
  }
  return { track, log, waiting, come, comeAll }
}

test('textures are loaded from the playhead on, a few at a time, and the next when one came', async () => {
  const { track, log, come, comeAll } = trackOf(10, 4)
  assert.equal(track.want(3), null)
  assert.deepEqual(log.loads, [3, 4])
  await come(3)
  assert.deepEqual(log.loads, [3, 4, 5])
  assert.deepEqual(track.want(3), { frame: 3, picture: 3 })
  await comeAll()
  assert.deepEqual(log.loads, [3, 4, 5, 6])
})

test('no more textures are kept than may be, and those just passed go first', async () => {
  const { track, log, comeAll } = trackOf(100, 5)
  for (let frame = 0; frame < 60; ++frame) {
    track.want(frame, 4)
    await comeAll()
    assert.ok(track.size <= 5)
    assert.equal(track.want(frame, 4)!.frame, frame)
  }
  assert.deepEqual(log.freed.slice(0, 10), [0, 1, 2, 3, 4, 5, 6, 7, 8, 9])
  track.end()
  assert.equal(track.size, 0)
  assert.equal(new Set(log.freed).size, log.loads.length)
})

test('where all fit, a second round loads nothing', async () => {
  const { track, log, comeAll } = trackOf(6, 6)
  track.want(4)
  await comeAll()
  assert.deepEqual(log.loads, [4, 5, 0, 1, 2, 3])
  for (let i = 0; i < 12; ++i) assert.equal(track.want(i % 6, 3)!.frame, i % 6)
  assert.equal(log.loads.length, 6)
  assert.equal(log.freed.length, 0)
})

test('what is late is shown while it plays, and never where it rests', async () => {
  const { track, come } = trackOf(50, 20)
  track.want(10, 6)
  await come(10)
  assert.deepEqual(track.want(13, 6), { frame: 10, picture: 10 })
  assert.equal(track.want(13), null)
  assert.equal(track.want(18, 6), null)
})

test('after a texture that came too late, loading begins further ahead', async () => {
  const { track, log, come } = trackOf(100, 20, 1)
  track.want(0, 6)
  assert.deepEqual(log.loads, [0])
  track.want(3, 6) // the playhead has passed it
  await come(0)
  assert.deepEqual(log.loads, [0, 6])
  track.want(4, 6)
  await come(6) // in time
  assert.deepEqual(track.want(6, 6), { frame: 6, picture: 6 })
})

test('a texture that cannot be had is told once, and holds up nothing', async () => {
  const { track, log, come, comeAll } = trackOf(4, 4)
  const ready = track.ready(0, 3)
  await come(0, new Error('gone'))
  await comeAll()
  await ready
  assert.equal(log.faults.length, 1)
  assert.equal(track.want(0), null)
  assert.deepEqual(log.loads, [0, 1, 2, 3])
})

test('textures that come after the end are freed', async () => {
  const { track, log, comeAll } = trackOf(4, 4)
  track.want(0)
  track.end()
  await comeAll()
  assert.deepEqual(log.freed.sort(), [0, 1])
  assert.deepEqual(log.loads, [0, 1])
})

test('the best colours that are there are shown, and the choice goes round among them', () => {
  assert.equal(shownColours(kAll, null), 'video')
  assert.equal(shownColours({ ...kAll, video: null }, null), 'own')
  assert.equal(shownColours({ ...kAll, video: null }, 'video'), 'own')
  assert.equal(shownColours({ ...kAll, video: null, own: '' }, 'own'), 'grey')
  assert.equal(shownColours(kAll, 'grey'), 'grey')
  assert.equal(nextColours(kAll, 'grey'), 'video')
  assert.equal(nextColours({ ...kAll, own: '' }, 'video'), 'grey')
})

test('textures play as large as all of them fit, and never take more room than there is', () => {
  const painted = { width: 2048, height: 2048 }
  assert.equal(playedTextures(painted, 40, false).width, 1024)
  assert.equal(playedTextures(painted, 40, true).width, 512)
  assert.deepEqual(playedTextures({ width: 256, height: 128 }, 40, false), {
    width: 256,
    height: 128,
    most: 40,
  })
  for (const frames of [1, 2, 48, 49, 156, 5000]) {
    const { width, height, most } = playedTextures(painted, frames, false)
    assert.ok(most * 4 * width * height <= kTextureRoom && most >= 2)
    assert.ok(most <= Math.max(2, frames))
  }
})

/** A figure on a canvas that remembers; textures are texts such as "7 at 512". */
function figureOf(colours: FrameColours, delay = 0) {
  const seen = { look: 'plain', texture: '', words: '', freed: new Set<string>() }
  const canvas = {
    setLook: (look: string) => (seen.look = look),
    loadTexture: async (url: string) => {
      await soon(delay)
      seen.texture = url
    },
    showTexture: (picture: string) => {
      assert.ok(!seen.freed.has(picture), `${picture} was freed before it was shown`)
      seen.texture = picture
    },
  }
  const figure = new FigureColours<string>(canvas, {
    colours,
    frames: 30,
    byProcessor: true,
    ownUrl: 'own',
    load: async (frame, { width }) => {
      await soon(delay)
      return `${frame} at ${width}`
    },
    free: (picture) => seen.freed.add(picture),
    complain: (error) => assert.fail(String(error)),
    tell: (words) => (seen.words = words),
  })
  return { figure, seen }
}

test('a frame wears its own texture: small while it plays, whole once it rests', async () => {
  const { figure, seen } = figureOf(kAll)
  await figure.choose('video')
  assert.equal(seen.look, 'plain')
  await soon(20)
  assert.deepEqual([seen.look, seen.texture], ['texture', '0 at 512'])
  await soon(400)
  assert.equal(seen.texture, '0 at 2048')
  assert.equal(seen.words, 'From the video: the texture of frame 0, 2048 × 2048')
  await figure.beforeStart()
  for (let frame = 0; frame < 8; ++frame) {
    figure.show(frame, true)
    assert.equal(seen.texture, `${frame} at 512`)
    assert.ok(seen.words.includes('512 × 512 while it plays'))
  }
  assert.ok(seen.freed.has('0 at 2048'))
  figure.show(7, false)
  await soon(400)
  assert.equal(seen.texture, '7 at 2048')
  figure.end()
  assert.ok(seen.freed.has('7 at 2048') && seen.freed.has('7 at 512'))
})

test('colours that are late say so', async () => {
  const { figure, seen } = figureOf(kAll, 30)
  await figure.choose('video')
  assert.equal(seen.words, 'From the video: loading…')
  await figure.beforeStart()
  figure.show(0, true)
  figure.show(11, true)
  assert.notEqual(seen.texture, '11 at 512')
  const late = Number(seen.texture.split(' ')[0])
  assert.ok(seen.words.includes(`the texture of frame ${late}, that of 11 is loading`))
  figure.end()
})

test('the scan’s own texture and grey do not follow the frames', async () => {
  const { figure, seen } = figureOf(kAll)
  await figure.choose('own')
  assert.deepEqual([seen.look, seen.texture], ['texture', 'own'])
  figure.show(5, false)
  await soon(20)
  assert.equal(seen.texture, 'own')
  await figure.choose('grey')
  assert.equal(seen.look, 'plain')
  figure.end()
  const vertices = figureOf({ ...kAll, own: 'vertices' })
  await vertices.figure.choose('own')
  assert.deepEqual([vertices.seen.look, vertices.seen.texture], ['colors', ''])
})

test('of two choices, one after the other, the last is shown', async () => {
  const { figure, seen } = figureOf(kAll, 20)
  const own = figure.choose('own')
  await figure.choose('video')
  await own
  await soon(100)
  assert.equal(seen.texture, '0 at 512')
  assert.ok(seen.words.startsWith('From the video'))
  figure.end()
})

test('words name the frame whose texture is shown', () => {
  const size = { width: 512, height: 512 }
  assert.equal(
    videoWords({ texture: 3, playing: false, ...size }, 3),
    'From the video: the texture of frame 3, 512 × 512',
  )
  assert.ok(videoWords({ texture: 3, playing: true, ...size }, 5).includes('that of 5 is loading'))
})
