// The corners of a mesh's faces, joined where vertex and layout are the same.
import type { MeshData } from './mesh_data'

/** What the graphics card takes: `index` counts in joined corners, of which each has a vertex. */
export interface Corners {
  /** faces x 3 */
  index: Uint32Array
  /** vertex of each joined corner */
  vertexOf: Uint32Array
  /** u and v of each joined corner; null without a layout */
  uvs: Float32Array | null
}

/**
 * A vertex becomes as many corners as it has places in the layout: about one, where one a face and
 * corner would be six. What is drawn again for each picture is that much less.
 */
export function joinedCorners(data: MeshData): Corners {
  const { indices, uvs, vertices } = data
  if (!uvs) {
    const all = new Uint32Array(vertices)
    for (let vertex = 0; vertex < vertices; ++vertex) all[vertex] = vertex
    return { index: indices, vertexOf: all, uvs: null }
  }
  const index = new Uint32Array(indices.length)
  // Corners of one vertex are a list: `first` of the vertex, then `next`; -1 ends it.
  const first = new Int32Array(vertices).fill(-1)
  const next = new Int32Array(indices.length)
  const from = new Uint32Array(indices.length)
  let count = 0
  for (let corner = 0; corner < indices.length; ++corner) {
    const vertex = indices[corner]
    let at = first[vertex]
    while (at >= 0 && !sameUv(uvs, from[at], corner)) at = next[at]
    if (at < 0) {
      at = count++
      from[at] = corner
      next[at] = first[vertex]
      first[vertex] = at
    }
    index[corner] = at
  }
  const vertexOf = new Uint32Array(count)
  const joined = new Float32Array(2 * count)
  for (let at = 0; at < count; ++at) {
    vertexOf[at] = indices[from[at]]
    joined[2 * at] = uvs[2 * from[at]]
    joined[2 * at + 1] = uvs[2 * from[at] + 1]
  }
  return { index, vertexOf, uvs: joined }
}

function sameUv(uvs: Float32Array, one: number, two: number): boolean {
  return uvs[2 * one] === uvs[2 * two] && uvs[2 * one + 1] === uvs[2 * two + 1]
}

/** Three numbers a vertex become three a corner. */
export function spread(vertexOf: Uint32Array, values: Float32Array, out: Float32Array): void {
  for (let corner = 0, to = 0; corner < vertexOf.length; ++corner, to += 3) {
    const from = 3 * vertexOf[corner]
    out[to] = values[from]
    out[to + 1] = values[from + 1]
    out[to + 2] = values[from + 2]
  }
}

/**
 * Unit normals of the vertices, each face counting by its area.
 * @param out vertices x 3, written over
 */
export function smoothNormals(indices: Uint32Array, p: Float32Array, out: Float32Array): void {
  out.fill(0)
  for (let f = 0; f < indices.length; f += 3) {
    const a = 3 * indices[f]
    const b = 3 * indices[f + 1]
    const c = 3 * indices[f + 2]
    const ux = p[b] - p[a]
    const uy = p[b + 1] - p[a + 1]
    const uz = p[b + 2] - p[a + 2]
    const vx = p[c] - p[a]
    const vy = p[c + 1] - p[a + 1]
    const vz = p[c + 2] - p[a + 2]
    const nx = uy * vz - uz * vy
    const ny = uz * vx - ux * vz
    const nz = ux * vy - uy * vx
    out[a] += nx
    out[a + 1] += ny
    out[a + 2] += nz
    out[b] += nx
    out[b + 1] += ny
    out[b + 2] += nz
    out[c] += nx
    out[c + 1] += ny
    out[c + 2] += nz
  }
  for (let i = 0; i < out.length; i += 3) {
    const x = out[i]
    const y = out[i + 1]
    const z = out[i + 2]
    const length = Math.sqrt(x * x + y * y + z * z) || 1
    out[i] = x / length
    out[i + 1] = y / length
    out[i + 2] = z / length
  }
}
