// What is drawn beside a surface: cameras, and see-through copies of it.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshBasicMaterial,
} from 'three'

import type { CameraView } from '../api'

/** Small frustums where photographs were taken. */
export function frustumsOf(cameras: CameraView[], chosen: string, depth: number): LineSegments {
  const places: number[] = []
  const colors: number[] = []
  for (const camera of cameras) {
    const m = camera.pose
    const at = (x: number, y: number, z: number) => [
      m[0] * x + m[1] * y + m[2] * z + m[3],
      m[4] * x + m[5] * y + m[6] * z + m[7],
      m[8] * x + m[9] * y + m[10] * z + m[11],
    ]
    const corner = (u: number, v: number) =>
      at(
        (depth * (u * camera.width - camera.cx)) / camera.focal_px,
        (depth * (v * camera.height - camera.cy)) / camera.focal_px,
        depth,
      )
    const corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)]
    const middle = at(0, 0, 0)
    const color = new Color(camera.name === chosen ? '#f08a5d' : '#7d776b')
    for (let i = 0; i < 4; ++i) {
      places.push(...middle, ...corners[i], ...corners[i], ...corners[(i + 1) % 4])
      for (let k = 0; k < 4; ++k) colors.push(color.r, color.g, color.b)
    }
  }
  const geometry = new BufferGeometry()
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(places), 3))
  geometry.setAttribute('color', new BufferAttribute(new Float32Array(colors), 3))
  const lines = new LineSegments(geometry, new LineBasicMaterial({ vertexColors: true }))
  lines.name = 'cameras'
  return lines
}

/** A see-through copy with other positions: onion skin. */
export function ghostOf(positions: Float32Array, indices: Uint32Array, color: string): Mesh {
  const geometry = new BufferGeometry()
  geometry.setAttribute('position', new BufferAttribute(positions, 3))
  geometry.setIndex(new BufferAttribute(indices, 1))
  const mesh = new Mesh(
    geometry,
    new MeshBasicMaterial({
      color,
      transparent: true,
      opacity: 0.3,
      depthWrite: false,
      // About a hundredth of the size behind the shown surface: where both nearly coincide they
      // would fight for the pixel.
      polygonOffset: true,
      polygonOffsetFactor: 4,
      polygonOffsetUnits: 300,
    }),
  )
  mesh.name = 'ghost'
  mesh.raycast = () => undefined
  return mesh
}
