// A mesh moved by its bones with dual quaternions, as armature/skinning/skin.h does it.

/** Numbers of a bone: its turn w x y z, then its shift. */
export const kBoneNumbers = 7
const kMost = 4

export interface Weights {
  /** four a vertex, the heaviest first */
  bones: Uint16Array
  weights: Float32Array
}

/** @throws Error  the bytes are not those of so many vertices */
export function parseWeights(bytes: ArrayBuffer, vertices: number): Weights {
  if (bytes.byteLength !== 24 * vertices)
    throw new Error('The mesh has changed since the session began: end it, and begin again.')
  return {
    bones: new Uint16Array(bytes, 0, kMost * vertices),
    weights: new Float32Array(bytes, 2 * kMost * vertices, kMost * vertices),
  }
}

/** Area-weighted normals of a mesh's vertices. */
export function normalsOf(positions: Float32Array, indices: Uint32Array): Float32Array {
  const normals = new Float32Array(positions.length)
  for (let f = 0; f < indices.length; f += 3) {
    const [a, b, c] = [3 * indices[f], 3 * indices[f + 1], 3 * indices[f + 2]]
    const [ux, uy, uz] = [0, 1, 2].map((k) => positions[b + k] - positions[a + k])
    const [vx, vy, vz] = [0, 1, 2].map((k) => positions[c + k] - positions[a + k])
    const cross = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx]
    for (const vertex of [a, b, c]) for (let k = 0; k < 3; ++k) normals[vertex + k] += cross[k]
  }
  for (let v = 0; v < normals.length; v += 3) {
    const length = Math.hypot(normals[v], normals[v + 1], normals[v + 2]) || 1
    for (let k = 0; k < 3; ++k) normals[v + k] /= length
  }
  return normals
}

/** x y z w of the turn, then of the dual part, for each bone. */
function dualsOf(bones: ArrayLike<number>): Float64Array {
  const count = bones.length / kBoneNumbers
  const duals = new Float64Array(8 * count)
  for (let b = 0; b < count; ++b) {
    const at = kBoneNumbers * b
    const [w, x, y, z] = [bones[at], bones[at + 1], bones[at + 2], bones[at + 3]]
    const [tx, ty, tz] = [bones[at + 4], bones[at + 5], bones[at + 6]]
    duals.set([x, y, z, w], 8 * b)
    duals[8 * b + 4] = 0.5 * (tx * w + ty * z - tz * y)
    duals[8 * b + 5] = 0.5 * (ty * w + tz * x - tx * z)
    duals[8 * b + 6] = 0.5 * (tz * w + tx * y - ty * x)
    duals[8 * b + 7] = -0.5 * (tx * x + ty * y + tz * z)
  }
  return duals
}

/** The blend of a vertex's bones into `sum`. */
function blend(duals: Float64Array, skin: Weights, vertex: number, sum: Float64Array): void {
  const at = kMost * vertex
  const first = 8 * skin.bones[at]
  for (let i = 0; i < 8; ++i) sum[i] = skin.weights[at] * duals[first + i]
  for (let k = 1; k < kMost && skin.weights[at + k] > 0; ++k) {
    const next = 8 * skin.bones[at + k]
    let dot = 0
    for (let i = 0; i < 4; ++i) dot += duals[next + i] * duals[first + i]
    // Of a motion's two dual quaternions the one nearer to the heaviest bone's.
    const weight = dot < 0 ? -skin.weights[at + k] : skin.weights[at + k]
    for (let i = 0; i < 8; ++i) sum[i] += weight * duals[next + i]
  }
}

/** Turns (and with `shifted` moves) three numbers at `at` by the blended motion. */
function apply(
  s: Float64Array,
  from: Float32Array,
  to: Float32Array,
  at: number,
  shifted: boolean,
): void {
  const twice = 2 / (s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + s[3] * s[3])
  const [x, y, z] = [from[at], from[at + 1], from[at + 2]]
  const ax = s[1] * z - s[2] * y + s[3] * x
  const ay = s[2] * x - s[0] * z + s[3] * y
  const az = s[0] * y - s[1] * x + s[3] * z
  let dx = s[1] * az - s[2] * ay
  let dy = s[2] * ax - s[0] * az
  let dz = s[0] * ay - s[1] * ax
  if (shifted) {
    dx += s[3] * s[4] - s[7] * s[0] + s[1] * s[6] - s[2] * s[5]
    dy += s[3] * s[5] - s[7] * s[1] + s[2] * s[4] - s[0] * s[6]
    dz += s[3] * s[6] - s[7] * s[2] + s[0] * s[5] - s[1] * s[4]
  }
  to[at] = x + twice * dx
  to[at + 1] = y + twice * dy
  to[at + 2] = z + twice * dz
}

export class Skin {
  readonly normals: Float32Array
  constructor(
    readonly rest: Float32Array,
    indices: Uint32Array,
    private readonly weights: Weights,
  ) {
    this.normals = normalsOf(rest, indices)
  }

  /** Writes places and normals of all vertices. @param bones  kBoneNumbers for each bone */
  pose(bones: ArrayLike<number>, positions: Float32Array, normals: Float32Array): void {
    const duals = dualsOf(bones)
    const sum = new Float64Array(8)
    for (let v = 0; v < this.rest.length / 3; ++v) {
      blend(duals, this.weights, v, sum)
      apply(sum, this.rest, positions, 3 * v, true)
      apply(sum, this.normals, normals, 3 * v, false)
    }
  }
}
