import assert from 'node:assert/strict'
import { test } from 'node:test'

import { Player } from '../src/pages/timeline/player'
import type { Sound } from '../src/pages/timeline/sound'
import { joinedCorners, smoothNormals, spread } from '../src/view/corners'
import { Detail } from '../src/view/detail'
import type { MeshData } from '../src/view/mesh_data'
import { numbers } from './random'

const kBudget = 1000 / 24

/** Plays pictures whose cost follows from the pixels; the shares that were drawn. */
function played(detail: Detail, pictures: number, fixed_ms: number, pixels_ms: number): number[] {
  return Array.from({ length: pictures }, () => {
    const { share } = detail
    const cost = fixed_ms + pixels_ms * share * share
    detail.note(Math.max(1, Math.ceil(cost / (1000 / 60))) * (1000 / 60), kBudget)
    return share
  })
}

test('a quick machine draws all pixels, and goes on to', () => {
  assert.deepEqual([...new Set(played(new Detail(false), 500, 2, 10))], [1])
})

test('a slow one draws fewer, as few as it needs, within a few pictures', () => {
  const shares = played(new Detail(false), 120, 4, 40)
  assert.equal(shares[0], 1)
  assert.ok(shares.slice(12).every((share) => share === 0.5))
})

test('the share does not swing: what was too slow is not tried again before a rest', () => {
  const detail = new Detail(false)
  const shares = played(detail, 2000, 4, 40)
  const changes = shares.filter((share, i) => i > 0 && share !== shares[i - 1]).length
  assert.equal(changes, 2)
  detail.forget()
  const later = played(detail, 2000, 4, 40)
  const swings = later.filter((share, i) => i > 0 && share !== later[i - 1]).length
  assert.ok(swings <= 2, `${swings} changes`)
})

test('without a graphics card it begins with few pixels, and takes more where that goes well', () => {
  const shares = played(new Detail(true), 200, 2, 8)
  assert.equal(shares[0], 0.5)
  assert.equal(shares.at(-1), 0.75)
  assert.equal(played(new Detail(true), 200, 2, 3000).at(-1), 0.25)
})

test('one slow picture changes nothing', () => {
  const detail = new Detail(false)
  for (let i = 0; i < 300; ++i) detail.note(i % 10 === 5 ? 200 : 16, kBudget)
  assert.equal(detail.share, 1)
})

/** Some faces with a layout: corners of a vertex lie at one of two places of it. */
function mesh(faces: number): MeshData {
  const random = numbers(7)
  const vertices = 40
  const indices = Uint32Array.from({ length: 3 * faces }, () => Math.floor(random() * vertices))
  const uvs = new Float32Array(6 * faces)
  indices.forEach((vertex, corner) => {
    uvs[2 * corner] = vertex / vertices
    uvs[2 * corner + 1] = random() < 0.3 ? 0.25 : 0.75
  })
  const positions = Float32Array.from({ length: 3 * vertices }, () => random())
  return { vertices, faces, positions, indices, uvs, colors: null }
}

test('joined corners have the vertex and the layout of the face’s own, and none is there twice', () => {
  const data = mesh(300)
  const { index, vertexOf, uvs } = joinedCorners(data)
  data.indices.forEach((vertex, corner) => {
    assert.equal(vertexOf[index[corner]], vertex)
    assert.equal(uvs![2 * index[corner]], data.uvs![2 * corner])
    assert.equal(uvs![2 * index[corner] + 1], data.uvs![2 * corner + 1])
  })
  const places = [...vertexOf].map((vertex, i) => `${vertex} ${uvs![2 * i]} ${uvs![2 * i + 1]}`)
  assert.equal(new Set(places).size, places.length)
  const out = new Float32Array(3 * vertexOf.length)
  spread(vertexOf, data.positions, out)
  vertexOf.forEach((vertex, i) => assert.equal(out[3 * i + 2], data.positions[3 * vertex + 2]))
})

test('without a layout a corner is a vertex', () => {
  const { index, vertexOf, uvs } = joinedCorners({ ...mesh(30), uvs: null })
  assert.equal(vertexOf.length, 40)
  assert.deepEqual([...vertexOf.slice(0, 3)], [0, 1, 2])
  assert.equal(index.length, 90)
  assert.equal(uvs, null)
})

test('normals have unit length and stand on their faces; a vertex without faces has none', () => {
  const positions = new Float32Array([0, 0, 0, 2, 0, 0, 0, 3, 0, 9, 9, 9])
  const out = new Float32Array(12).fill(5)
  smoothNormals(new Uint32Array([0, 1, 2]), positions, out)
  assert.deepEqual([...out], [0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 0])
})

test('the clock begins when what shows the frames is ready', async () => {
  const asked: FrameRequestCallback[] = []
  Object.assign(globalThis, { requestAnimationFrame: (act: FrameRequestCallback) => asked.push(act) })
  const silent = { wake: async () => undefined, start: () => null, stop: () => undefined }
  const player = new Player(silent as unknown as Sound)
  player.length = 10
  let ready = () => undefined as void
  player.beforeStart = () => new Promise<void>((done) => (ready = done))
  const started = player.play()
  await new Promise((go) => setTimeout(go, 20))
  assert.equal(asked.length, 0)
  ready()
  await started
  assert.equal(asked.length, 1)
  assert.equal(player.dropped, 0)
})
