// Clicks and lines that say what the figure is: from pixels to shares of a photograph, and words.
import type { FigureStroke, Photograph } from '../../api'

type Pixel = [number, number]

/** Points of a drawn line beside which the others say nothing, in shares of the longer side. */
const kStraight = 0.002
const kMostPoints = 200

/** How far a point is from the segment between two others. */
function distance([x, y]: Pixel, [ax, ay]: Pixel, [bx, by]: Pixel): number {
  const [dx, dy] = [bx - ax, by - ay]
  const length = dx * dx + dy * dy
  const along = length === 0 ? 0 : ((x - ax) * dx + (y - ay) * dy) / length
  const t = Math.min(1, Math.max(0, along))
  return Math.hypot(x - ax - t * dx, y - ay - t * dy)
}

/**
 * The line with fewer points, none of the dropped ones farther from it than `tolerance` [pixels].
 * Source: Douglas & Peucker 1973.
 */
export function simplified(line: readonly Pixel[], tolerance: number): Pixel[] {
  if (line.length < 3) return [...line]
  const keeps = new Uint8Array(line.length)
  keeps[0] = keeps[line.length - 1] = 1
  const open: [number, number][] = [[0, line.length - 1]]
  while (open.length > 0) {
    const [from, to] = open.pop()!
    let farthest = -1
    let most = tolerance
    for (let i = from + 1; i < to; ++i) {
      const far = distance(line[i], line[from], line[to])
      if (far > most) [farthest, most] = [i, far]
    }
    if (farthest < 0) continue
    keeps[farthest] = 1
    open.push([from, farthest], [farthest, to])
  }
  return line.filter((_, i) => keeps[i])
}

/** What a pointer drew, as a stroke of the photograph; a click is a line of one point. */
export function strokeOf(
  picture: string,
  line: readonly Pixel[],
  width: number,
  height: number,
  figure: boolean,
): FigureStroke {
  let tolerance = kStraight * Math.max(width, height)
  let points = simplified(line, tolerance)
  // A scribble that fills the whole photograph.
  while (points.length > kMostPoints) points = simplified(line, (tolerance *= 2))
  const share = ([x, y]: Pixel): Pixel => [
    Math.min(1, Math.max(0, x / width)),
    Math.min(1, Math.max(0, y / height)),
  ]
  return { text: '', picture, figure, points: points.map(share), gone: false }
}

export const pixelsOf = (stroke: FigureStroke, width: number, height: number): Pixel[] =>
  stroke.points.map(([x, y]) => [x * width, y * height])

/** The photograph that is shown first: one with a stroke, else the first. */
export function firstShown(strokes: readonly FigureStroke[], photographs: Photograph[]): string {
  const names = new Set(photographs.map((one) => one.name))
  const said = strokes.find((one) => names.has(one.picture))
  return said?.picture ?? photographs[0]?.name ?? ''
}

/** What to do where a step asks what the figure is. */
export const askingFor = (strokes: readonly FigureStroke[], noun = 'photograph'): string =>
  strokes.length === 0
    ? `The ${noun}s alone do not tell. Click on it in one of them; the others follow.`
    : `What was said does not settle it yet. Click once more, in another ${noun}.`

/** "a click", "a line" */
export const shapeOf = (stroke: FigureStroke): string =>
  stroke.points.length === 1 ? 'a click' : 'a line'

/** Strokes in a photograph, as a short mark: "+1", "+2 −1". */
export function noteOf(strokes: readonly FigureStroke[], picture: string): string {
  const here = strokes.filter((one) => one.picture === picture && !one.gone)
  const count = (figure: boolean) => here.filter((one) => one.figure === figure).length
  const parts = [count(true) && `+${count(true)}`, count(false) && `−${count(false)}`]
  return parts.filter(Boolean).join(' ')
}
