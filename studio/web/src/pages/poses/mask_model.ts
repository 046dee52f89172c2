// A mask in photograph pixels: strokes, undo and redo. No drawing here, so it can be tested alone.
import type { Row } from './mask_shapes'

export interface Rect {
  x: number
  y: number
  width: number
  height: number
}
export interface Point {
  x: number
  y: number
}

/** What a stroke changed, as small squares with the values from before (after an undo: after). */
interface Tile {
  rect: Rect
  values: Uint8Array
}
type Stroke = Tile[]

const kTile = 64
/** Undo keeps at most this much; older strokes then stay for good. */
const kMostBytes = 96e6
export const kFigure = 255
export const kOutside = 0

/** The smallest rectangle round both. */
export function union(a: Rect | null, b: Rect | null): Rect | null {
  if (!a || !b) return a ?? b
  const x = Math.min(a.x, b.x)
  const y = Math.min(a.y, b.y)
  return {
    x,
    y,
    width: Math.max(a.x + a.width, b.x + b.width) - x,
    height: Math.max(a.y + a.height, b.y + b.height) - y,
  }
}

/**
 * Where a row at height `y` lies within `radius` of the segment from `a` to `b`, or null. A capsule
 * is convex, so it is one interval: the hull of those of the two discs and of the band between.
 */
export function capsuleRow(a: Point, b: Point, radius: number, y: number): [number, number] | null {
  let low = Infinity
  let high = -Infinity
  const add = (from: number, to: number) => {
    low = Math.min(low, from)
    high = Math.max(high, to)
  }
  for (const end of [a, b]) {
    const half = radius * radius - (y - end.y) * (y - end.y)
    if (half >= 0) add(end.x - Math.sqrt(half), end.x + Math.sqrt(half))
  }
  const band = bandRow(a, b, radius, y)
  if (band) add(...band)
  return low <= high ? [low, high] : null
}

/** The row's part in the rectangle that has the segment as its middle line. */
function bandRow(a: Point, b: Point, radius: number, y: number): [number, number] | null {
  const length = Math.hypot(b.x - a.x, b.y - a.y)
  if (length === 0) return null
  const ux = (b.x - a.x) / length
  const uy = (b.y - a.y) / length
  // With t = x - a.x, along the segment 0 <= ux t + along <= length, and across it
  // -radius <= -uy t + across <= radius.
  const along = uy * (y - a.y)
  const across = ux * (y - a.y)
  const first = within(ux, along, 0, length)
  const second = within(-uy, across, -radius, radius)
  if (!first || !second) return null
  const low = Math.max(first[0], second[0])
  const high = Math.min(first[1], second[1])
  return low <= high ? [a.x + low, a.x + high] : null
}

/** The t with low <= slope * t + shift <= high. */
function within(slope: number, shift: number, low: number, high: number): [number, number] | null {
  if (Math.abs(slope) < 1e-12)
    return shift >= low && shift <= high ? [-Infinity, Infinity] : null
  const one = (low - shift) / slope
  const two = (high - shift) / slope
  return [Math.min(one, two), Math.max(one, two)]
}

export class MaskModel {
  /** width x height, 255 where the figure is */
  readonly values: Uint8Array
  private done: Stroke[] = []
  private undone: Stroke[] = []
  private doneBytes = 0
  /** the stroke under the oldest one that undo still has; null: none was dropped */
  private base: Stroke | null = null
  private saved: Stroke | null = null
  /** tiles of the stroke under way, by their number */
  private touched: Map<number, Tile> | null = null
  private value = kFigure

  constructor(
    readonly width: number,
    readonly height: number,
    values?: Uint8Array,
  ) {
    this.values = values ?? new Uint8Array(width * height)
    if (this.values.length !== width * height) throw new Error('a mask of another size')
  }

  get canUndo(): boolean {
    return this.done.length > 0
  }
  get canRedo(): boolean {
    return this.undone.length > 0
  }
  /** true: there are strokes, or undone ones, since the last save */
  get changed(): boolean {
    return this.touched !== null || this.top() !== this.saved
  }
  markSaved(): void {
    this.saved = this.top()
  }
  /** A mark of what is shown now, to hand to markSavedAt after a slow save. */
  mark(): unknown {
    return this.top()
  }
  markSavedAt(mark: unknown): void {
    this.saved = mark as Stroke | null
  }

  /** Starts a stroke that sets pixels to `value`. */
  begin(value: number): void {
    if (this.touched) this.end()
    this.value = value
    this.touched = new Map()
  }

  /** Sets each pixel whose centre is within `radius` of the segment; the part that changed. */
  paint(from: Point, to: Point, radius: number): Rect | null {
    if (!this.touched) return null
    const top = Math.max(0, Math.ceil(Math.min(from.y, to.y) - radius - 0.5))
    const bottom = Math.min(this.height - 1, Math.floor(Math.max(from.y, to.y) + radius - 0.5))
    let changed: Rect | null = null
    for (let y = top; y <= bottom; ++y) {
      const row = capsuleRow(from, to, radius, y + 0.5)
      if (!row) continue
      const left = Math.max(0, Math.ceil(row[0] - 0.5))
      const right = Math.min(this.width - 1, Math.floor(row[1] - 0.5))
      if (left <= right) changed = union(changed, this.paintRow(y, left, right))
    }
    return changed
  }

  /** Sets rows of pixels; the part that changed. A stroke must have begun. */
  fill(rows: Row[]): Rect | null {
    let changed: Rect | null = null
    for (const { y, left, right } of rows) changed = union(changed, this.paintRow(y, left, right))
    return changed
  }

  /** Becomes another mask of its size, as a stroke of its own; the part that changed. */
  become(values: (i: number) => number): Rect | null {
    this.begin(kFigure)
    let changed: Rect | null = null
    for (let y = 0; y < this.height; ++y) {
      const row = y * this.width
      for (let x = 0; x < this.width; ++x) {
        const value = values(row + x)
        if (value === this.values[row + x]) continue
        this.keep(y, x, x)
        this.values[row + x] = value
        changed = union(changed, { x, y, width: 1, height: 1 })
      }
    }
    this.end()
    return changed
  }

  /** Ends the stroke; false if it changed nothing, so that undo has nothing new. */
  end(): boolean {
    const tiles = this.touched ? [...this.touched.values()] : []
    this.touched = null
    if (tiles.length === 0) return false
    this.done.push(tiles)
    this.doneBytes += bytesOf(tiles)
    this.undone = []
    while (this.doneBytes > kMostBytes && this.done.length > 1) {
      this.base = this.done.shift()!
      this.doneBytes -= bytesOf(this.base)
    }
    return true
  }

  /** Takes the last stroke back; the part that changed. */
  undo(): Rect | null {
    if (this.touched) this.end()
    const stroke = this.done.pop()
    if (!stroke) return null
    this.doneBytes -= bytesOf(stroke)
    this.undone.push(stroke)
    return this.swap(stroke)
  }

  redo(): Rect | null {
    const stroke = this.undone.pop()
    if (!stroke) return null
    this.doneBytes += bytesOf(stroke)
    this.done.push(stroke)
    return this.swap(stroke)
  }

  /** The share of the photograph that the figure covers. */
  share(): number {
    let figure = 0
    for (const value of this.values) if (value >= 128) ++figure
    return figure / this.values.length
  }

  private top(): Stroke | null {
    return this.done[this.done.length - 1] ?? this.base
  }

  private paintRow(y: number, left: number, right: number): Rect | null {
    const row = y * this.width
    let first = -1
    let last = -1
    for (let x = left; x <= right; ++x) {
      if (this.values[row + x] === this.value) continue
      if (first < 0) first = x
      last = x
    }
    if (first < 0) return null
    this.keep(y, first, last)
    this.values.fill(this.value, row + first, row + last + 1)
    return { x: first, y, width: last - first + 1, height: 1 }
  }

  /** Copies the tiles under a part of a row, if this stroke has not yet. */
  private keep(y: number, left: number, right: number): void {
    const row = Math.floor(y / kTile)
    const first = row * Math.ceil(this.width / kTile)
    for (let column = Math.floor(left / kTile); column <= Math.floor(right / kTile); ++column)
      if (!this.touched!.has(first + column))
        this.touched!.set(first + column, this.copyTile(column * kTile, row * kTile))
  }

  private copyTile(x: number, y: number): Tile {
    const width = Math.min(kTile, this.width - x)
    const height = Math.min(kTile, this.height - y)
    const values = new Uint8Array(width * height)
    for (let row = 0; row < height; ++row) {
      const from = (y + row) * this.width + x
      values.set(this.values.subarray(from, from + width), row * width)
    }
    return { rect: { x, y, width, height }, values }
  }

  /** Exchanges the tiles' values with the mask's, so that the same tiles do undo and redo. */
  private swap(stroke: Stroke): Rect | null {
    let changed: Rect | null = null
    for (const tile of stroke) {
      const { x, y, width, height } = tile.rect
      const now = this.copyTile(x, y).values
      for (let row = 0; row < height; ++row)
        this.values.set(
          tile.values.subarray(row * width, (row + 1) * width),
          (y + row) * this.width + x,
        )
      tile.values = now
      changed = union(changed, tile.rect)
    }
    return changed
  }
}

function bytesOf(stroke: Stroke): number {
  return stroke.reduce((sum, tile) => sum + tile.values.length, 0)
}
