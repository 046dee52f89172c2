import assert from 'node:assert/strict'
import { test } from 'node:test'

import type { Pose } from '../src/api'
import { isFromMesh, tabsOf } from '../src/pages/poses/tabs'

const pose = (more: Partial<Pose>): Pose => ({
  name: 'rest',
  template: false,
  method: 'scan',
  photos: 'photos/rest',
  photographs: 24,
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
  assert.deepEqual(tabsOf(pose({})), ['photographs', 'figure', '3d', 'fit', 'wipe'])
  assert.deepEqual(tabsOf(pose({ template: true })), ['photographs', 'figure', '3d', 'wipe'])
})

test('a pose whose mesh was made elsewhere has no photographs to show', () => {
  const given = pose({ mesh: 'meshes/rest.obj', photographs: 0 })
  assert.deepEqual(tabsOf(given), ['3d', 'fit'])
  assert.deepEqual(tabsOf({ ...given, template: true }), ['3d'])
  assert.equal(isFromMesh({ ...given, photographs: 3 }), false)
})
