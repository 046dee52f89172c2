// Strokes of the brush that mends a mesh, as the page keeps them, and their words.
import type { MendStroke } from '../../api'
import type { Hit } from '../../view/viewer'

export type MendTool = MendStroke['tool']

/** The brush in the hand. `radius`: of the figure's size. */
export interface MendBrush {
  tool: MendTool
  radius: number
  /** of each tool; of pull with the direction's sign */
  strength: Record<MendTool, number>
}

export const kMendTools: [MendTool, string, string, string][] = [
  ['smooth', 'Smooth', '1', 'Bumps narrower than the brush fade'],
  ['pull', 'Pull', '2', 'The surface moves out, or in'],
  ['fill', 'Fill', '3', 'Paint over a bitten place and a little beyond: a smooth patch closes it'],
]
export const kFirstBrush: MendBrush = {
  tool: 'smooth',
  radius: 0.03,
  strength: { smooth: 1, pull: 0.2, fill: 1 },
}
export const kSmallestMend = 0.005
export const kLargestMend = 0.2

/** Of a brush's radius: places of a path are so far apart. */
const kApart = 1 / 3
const kMostPlaces = 500

/** A path while it is painted: the places of the pointer, as far apart as is needed. */
export class MendPath {
  readonly hits: Hit[] = []

  /** @param radius  in the mesh's unit. Returns whether the place was taken. */
  add(hit: Hit, radius: number): boolean {
    const last = this.hits[this.hits.length - 1]
    const step = last ? Math.hypot(...[0, 1, 2].map((k) => hit.place[k] - last.place[k])) : Infinity
    if (step < kApart * radius || this.hits.length >= kMostPlaces) return false
    this.hits.push(hit)
    return true
  }

  /** @param size  of the figure, in the mesh's unit */
  stroke(brush: MendBrush, size: number): MendStroke {
    return {
      tool: brush.tool,
      radius: brush.radius * size,
      strength: brush.strength[brush.tool],
      places: this.hits.map(({ face, barycentric }) => ({ face, barycentric })),
      fault: '',
    }
  }
}

/** What the server drafted. */
export interface MendDraft {
  positions: Float32Array
  /** of each stroke */
  moved: { vertices: number; furthest: number }[]
}

export function draftFrom(bytes: ArrayBuffer, vertices: number): MendDraft {
  const numbers = new Float32Array(bytes)
  const moved = []
  for (let i = 3 * vertices; i + 1 < numbers.length; i += 2)
    moved.push({ vertices: numbers[i], furthest: numbers[i + 1] })
  return { positions: numbers.slice(0, 3 * vertices), moved }
}

/** How far each vertex was moved, over the farthest; NaN where it was not. */
export function movedLevels(before: Float32Array, after: Float32Array): Float32Array {
  const levels = new Float32Array(before.length / 3)
  let most = 0
  for (let v = 0; v < levels.length; ++v) {
    levels[v] = Math.hypot(...[0, 1, 2].map((k) => after[3 * v + k] - before[3 * v + k]))
    most = Math.max(most, levels[v])
  }
  return levels.map((far) => (far > 1e-4 * most && most > 0 ? far / most : NaN))
}

/** "Pull in", "Fill" */
export function strokeName(stroke: MendStroke): string {
  const name = kMendTools.find(([tool]) => tool === stroke.tool)![1]
  return stroke.tool === 'pull' ? `${name} ${stroke.strength < 0 ? 'in' : 'out'}` : name
}
