// The bytes in which the server sends meshes and clouds; studio/mesh/mesh_bytes.h writes them.

/** Flags of optional parts. */
const kUvs = 1
const kColors = 2

export interface MeshData {
  vertices: number
  faces: number
  /** vertices x 3 */
  positions: Float32Array
  /** faces x 3; empty for a cloud */
  indices: Uint32Array
  /** a corner each: faces x 3 x 2, v up; null without a layout */
  uvs: Float32Array | null
  /** vertices x 4, 0 to 255, the fourth unused; null without colours */
  colors: Uint8Array | null
}

/**
 * Reads 'KPM1', then as little-endian uint32 the number of vertices, of faces, and flags, then the
 * parts in the order of MeshData.
 */
export function parseMesh(buffer: ArrayBuffer): MeshData {
  const head = new DataView(buffer)
  const magic = String.fromCharCode(...new Uint8Array(buffer, 0, 4))
  if (magic !== 'KPM1') throw new Error('the studio sent a mesh of an unknown form')
  const vertices = head.getUint32(4, true)
  const faces = head.getUint32(8, true)
  const flags = head.getUint32(12, true)
  let at = 16
  const floats = (count: number) => {
    const part = new Float32Array(buffer, at, count)
    at += 4 * count
    return part
  }
  const positions = floats(3 * vertices)
  const indices = new Uint32Array(buffer, at, 3 * faces)
  at += 12 * faces
  const uvs = flags & kUvs ? floats(6 * faces) : null
  const colors = flags & kColors ? new Uint8Array(buffer, at, 4 * vertices) : null
  return { vertices, faces, positions, indices, uvs, colors }
}

/** Smallest box: [min x, min y, min z, max x, max y, max z]. */
export function boxOf(positions: Float32Array): number[] {
  const box = [Infinity, Infinity, Infinity, -Infinity, -Infinity, -Infinity]
  for (let i = 0; i < positions.length; i += 3)
    for (let k = 0; k < 3; ++k) {
      box[k] = Math.min(box[k], positions[i + k])
      box[k + 3] = Math.max(box[k + 3], positions[i + k])
    }
  return box
}
