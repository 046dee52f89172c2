import assert from 'node:assert/strict'
import { test } from 'node:test'

import { colourOf, filmCamera, fovOf, lensOf } from '../src/pages/export/film_camera'

const box = Float32Array.from(
  [0, 1].flatMap((x) => [0, 1].flatMap((y) => [0, 1].flatMap((z) => [x - 0.5, 3 * y, 2 * z + 5]))),
)
const kSize = { width: 640, height: 480, shadow: false }

/** The part of the picture that the points fill. */
function seen(points: Float32Array, camera: ReturnType<typeof filmCamera>) {
  const m = camera.pose
  const extent = { left: 1, right: 0, top: 1, bottom: 0 }
  for (let i = 0; i < points.length; i += 3) {
    const d = [points[i] - m[3], points[i + 1] - m[7], points[i + 2] - m[11]]
    const [x, y, z] = [0, 1, 2].map((k) => d[0] * m[k] + d[1] * m[4 + k] + d[2] * m[8 + k])
    assert.ok(z > 0, 'before the camera')
    const u = (camera.focal_px * x) / z / camera.width + 0.5
    const v = (camera.focal_px * y) / z / camera.height + 0.5
    extent.left = Math.min(extent.left, u)
    extent.right = Math.max(extent.right, u)
    extent.top = Math.min(extent.top, v)
    extent.bottom = Math.max(extent.bottom, v)
  }
  return extent
}

test('the film’s camera stands where it is asked, and the figure fills nine tenths', () => {
  for (const azimuth of [0, 40, 200])
    for (const elevation of [0, 14, 70])
      for (const fov of [8, 28, 80]) {
        const camera = filmCamera(box, { azimuth, elevation, fov, ...kSize })
        const { left, right, top, bottom } = seen(box, camera)
        assert.ok(left > 0.0499 && right < 0.9501 && top > 0.0499 && bottom < 0.9501)
        assert.ok(Math.abs(Math.max(right - left, bottom - top) - 0.9) < 1e-6)
        const [, , fx, , , , fy, , , , fz] = camera.pose
        assert.ok(Math.abs(Math.asin(-fz) - (elevation * Math.PI) / 180) < 1e-9)
        // 0 looks along +y; counter-clockwise seen from above, 90 sees the +x side.
        const side = (Math.atan2(-fx, fy) * 180) / Math.PI
        assert.ok(Math.abs(((side - azimuth + 540) % 360) - 180) < 1e-6 || elevation === 90)
        const [right0, down0] = [[0, 4, 8], [1, 5, 9]].map((row) => row.map((k) => camera.pose[k]))
        assert.ok(Math.abs(right0[0] * down0[0] + right0[1] * down0[1] + right0[2] * down0[2]) < 1e-12)
        assert.ok(down0[2] <= 0, 'upright')
      }
})

test('with its shadow it is seen from farther away', () => {
  const look = { azimuth: 0, elevation: 30, fov: 28, ...kSize }
  const far = (shadow: boolean) => filmCamera(box, { ...look, shadow }).pose[7]
  assert.ok(far(true) < far(false), 'farther along -y')
})

test('lenses are those of a picture of 24 mm height', () => {
  assert.equal(Math.round(lensOf(28)), 48)
  assert.ok(Math.abs(fovOf(lensOf(53)) - 53) < 1e-9)
  assert.equal(colourOf('green'), '#00b140')
  assert.equal(colourOf('#123456'), '#123456')
})
