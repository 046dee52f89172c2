// What a lasso encloses, and what hangs together with a place of a mask, as rows of pixels.
import type { Point } from './mask_model'

/** Of row `y`, the pixels from `left` to `right`, both included. */
export interface Row {
  y: number
  left: number
  right: number
}

/**
 * The pixels whose centres a closed line goes round, once or more often in either direction: loops of
 * it leave no holes.
 */
export function enclosedRows(line: Point[], width: number, height: number): Row[] {
  const rows: Row[] = []
  const ys = line.map((point) => point.y)
  const last = Math.min(height - 1, Math.ceil(Math.max(...ys)))
  for (let y = Math.max(0, Math.floor(Math.min(...ys))); y <= last; ++y) {
    const crossings: { x: number; turn: number }[] = []
    line.forEach((a, i) => {
      const b = line[(i + 1) % line.length]
      const middle = y + 0.5
      if (a.y <= middle === b.y <= middle) return
      const x = a.x + ((middle - a.y) / (b.y - a.y)) * (b.x - a.x)
      crossings.push({ x, turn: a.y < b.y ? 1 : -1 })
    })
    crossings.sort((one, other) => one.x - other.x)
    let round = 0
    crossings.forEach(({ x, turn }, i) => {
      round += turn
      if (round === 0) return
      const left = Math.max(0, Math.ceil(x - 0.5))
      const right = Math.min(width - 1, Math.ceil(crossings[i + 1].x - 0.5) - 1)
      if (left <= right) rows.push({ y, left, right })
    })
  }
  return rows
}

/** The pixels of the same side, figure or not, that are joined to one by their edges. */
export function joinedRows(values: Uint8Array, width: number, height: number, at: Point): Row[] {
  const x0 = Math.floor(at.x)
  const y0 = Math.floor(at.y)
  if (x0 < 0 || y0 < 0 || x0 >= width || y0 >= height) return []
  const figure = (i: number) => values[i] >= 128
  const side = figure(y0 * width + x0)
  const seen = new Uint8Array(values.length)
  const is = (i: number) => !seen[i] && figure(i) === side
  const rows: Row[] = []
  const seeds = [y0 * width + x0]
  while (seeds.length > 0) {
    const seed = seeds.pop()!
    if (!is(seed)) continue
    const y = Math.floor(seed / width)
    let left = seed
    let right = seed
    while (left > y * width && is(left - 1)) --left
    while (right < (y + 1) * width - 1 && is(right + 1)) ++right
    seen.fill(1, left, right + 1)
    rows.push({ y, left: left - y * width, right: right - y * width })
    // Of each piece of the rows above and below one pixel goes on.
    for (const shift of [-width, width]) {
      if (left + shift < 0 || left + shift >= values.length) continue
      for (let i = left + shift; i <= right + shift; ++i)
        if (is(i) && (i === left + shift || !is(i - 1))) seeds.push(i)
    }
  }
  return rows
}
