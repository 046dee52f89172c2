// Where the film's camera stands, as the export places it (export/film/film.cpp), for one mesh.
import type { CameraView } from '../../api'
import { boxOf } from '../../view/mesh_data'

type Vector = [number, number, number]

/** The share of the picture that figure and shadow fill. */
const kFilled = 0.9
/** Points round the figure where its shadow is still seen, over its reach. */
const kShadowWidth = 1.25

export interface FilmLook {
  /** degrees, counter-clockwise seen from above; 0: the side of the first photograph */
  azimuth: number
  elevation: number
  fov: number
  width: number
  height: number
  shadow: boolean
}

const dot = (a: Vector, b: ArrayLike<number>, i = 0) => a[0] * b[i] + a[1] * b[i + 1] + a[2] * b[i + 2]

/** The table's circle that has the shadow; z is up. */
function shadowCircle(positions: Float32Array): Float32Array {
  const [x0, y0, z0, x1, y1, z1] = boxOf(positions)
  const diagonal = Math.hypot(x1 - x0, y1 - y0, z1 - z0)
  const reach = kShadowWidth * Math.max(0.5 * Math.max(x1 - x0, y1 - y0), 0.2 * diagonal)
  const circle = new Float32Array(3 * 32)
  for (let i = 0; i < 32; ++i) {
    const angle = (2 * Math.PI * i) / 32
    circle.set([(x0 + x1) / 2 + reach * Math.cos(angle), (y0 + y1) / 2 + reach * Math.sin(angle), z0], 3 * i)
  }
  return circle
}

/** The camera of the film of this mesh alone; that of all frames is a little farther away. */
export function filmCamera(positions: Float32Array, look: FilmLook): CameraView {
  const a = (look.azimuth * Math.PI) / 180
  const e = (look.elevation * Math.PI) / 180
  const [cosA, sinA, cosE, sinE] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)]
  const forward: Vector = [-cosE * sinA, cosE * cosA, -sinE]
  const right: Vector = [cosA, sinA, 0]
  const down: Vector = [sinE * sinA, -sinE * cosA, -cosE]
  const focal_px = look.height / 2 / Math.tan((look.fov * Math.PI) / 360)
  const slopeX = (kFilled * look.width) / 2 / focal_px
  const slopeY = (kFilled * look.height) / 2 / focal_px
  const far = { left: -Infinity, right: -Infinity, above: -Infinity, below: -Infinity }
  const extend = (points: Float32Array) => {
    for (let i = 0; i < points.length; i += 3) {
      const [x, y, z] = [dot(right, points, i), dot(down, points, i), dot(forward, points, i)]
      far.right = Math.max(far.right, x - slopeX * z)
      far.left = Math.max(far.left, -x - slopeX * z)
      far.below = Math.max(far.below, y - slopeY * z)
      far.above = Math.max(far.above, -y - slopeY * z)
    }
  }
  extend(positions)
  if (look.shadow) extend(shadowCircle(positions))
  const eye: Vector = [
    (far.right - far.left) / 2,
    (far.below - far.above) / 2,
    -0.5 * Math.max((far.right + far.left) / slopeX, (far.below + far.above) / slopeY),
  ]
  const world = (k: number) => eye[0] * right[k] + eye[1] * down[k] + eye[2] * forward[k]
  return {
    name: 'film',
    pose: [0, 1, 2].flatMap((k) => [right[k], down[k], forward[k], world(k)]),
    focal_px,
    width: look.width,
    height: look.height,
    cx: look.width / 2,
    cy: look.height / 2,
  }
}

/** "48 mm": of a full-frame camera, whose picture is 24 mm high. */
export const lensOf = (fov: number): number => 12 / Math.tan((fov * Math.PI) / 360)
export const fovOf = (lens: number): number => (360 / Math.PI) * Math.atan(12 / lens)

export const kPaper = '#f6f7f9'
/** As export/film/film.cpp names them. */
export const kBackgrounds: [string, string, string][] = [
  ['paper', 'Paper', kPaper],
  ['white', 'White', '#ffffff'],
  ['grey', 'Grey', '#808080'],
  ['black', 'Black', '#000000'],
  ['green', 'Green, to cut out', '#00b140'],
]
export const colourOf = (background: string): string =>
  kBackgrounds.find(([name]) => name === background)?.[2] ?? background

export const kSizes: [string, number, number][] = [
  ['Small, 960 × 720', 960, 720],
  ['HD, 1280 × 720', 1280, 720],
  ['Full HD, 1920 × 1080', 1920, 1080],
  ['4K, 3840 × 2160', 3840, 2160],
  ['Square, 1080 × 1080', 1080, 1080],
  ['Telephone, 1080 × 1920', 1080, 1920],
]
