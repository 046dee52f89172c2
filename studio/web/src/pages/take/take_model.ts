// A recorded take as its page shows it, and the lines that change it: those of `keypose armature
// edit` (docs/stages/armature.md), which does them.

export interface Joint {
  name: string
  /** 'degrees', or the unit of a joint that slides */
  unit: string
  /** where it stops; null: it is not known to stop */
  low: number | null
  high: number | null
  /** in each recorded frame */
  values: number[]
}

export interface Take {
  fps: number
  /** frames of the film for each recorded one */
  step: number
  /** frames of the film as it would be baked; 0: it is shown as recorded, each frame held */
  film: number
  joints: Joint[]
}

/** What stands between recorded frames, when they are played and when they are baked. */
export const kBetweens = ['hold', 'linear', 'smooth', 'keys'] as const
export type Between = (typeof kBetweens)[number]

/** The next of those that can be played. */
export const nextBetween = (between: Between): Between =>
  between === 'hold' ? 'linear' : between === 'linear' ? 'smooth' : 'hold'

/** Whether the program is asked for the pictures between; keys are for `interpolate`. */
export const isFilmed = (between: Between): boolean =>
  between === 'linear' || between === 'smooth'

export const framesOfTake = (take: Take): number => take.joints[0]?.values.length ?? 0
export const filmLength = (take: Take): number => take.film || framesOfTake(take) * take.step

/** The recorded frame that the film shows at one of its own. */
export const recordedAt = (take: Take, film: number): number =>
  Math.max(0, Math.min(framesOfTake(take) - 1, Math.floor(film / take.step)))

/** Recorded frames, both ends among them. */
export interface Span {
  first: number
  last: number
}

export const lengthOfSpan = (span: Span): number => span.last - span.first + 1

/** From one frame to another, whichever is earlier, as far as the take has them. */
export function spanOf(a: number, b: number, frames: number): Span {
  const inside = (frame: number) => Math.max(0, Math.min(frames - 1, Math.round(frame)))
  return { first: inside(Math.min(a, b)), last: inside(Math.max(a, b)) }
}

/** `12`, or `3-6` */
const spanText = ({ first, last }: Span): string =>
  first === last ? `${first}` : `${first}-${last}`

/** All joints, in a line of edits. */
export const kAll = 'all'

/** A number as short as it can be said. */
const amountText = (amount: number): string => String(Number(amount.toFixed(6)))

export const setLine = (joint: string, span: Span, value: number): string =>
  `set ${joint} ${spanText(span)} ${amountText(value)}`
export const addLine = (joint: string, span: Span, value: number): string =>
  `add ${joint} ${spanText(span)} ${amountText(value)}`
export const holdLine = (joint: string, span: Span): string => `hold ${joint} ${spanText(span)}`
export const moveLine = (joint: string, span: Span, by: number): string =>
  `move ${joint} ${spanText(span)} by ${by}`
export const deleteLine = (span: Span): string => `delete ${spanText(span)}`
export const repeatLine = (frame: number, by: number): string => `repeat ${frame} by ${by}`
export const stepLine = (step: number): string => `step ${step}`

/** A value that is within the joint's limits. */
export const within = (joint: Joint, value: number): number =>
  Math.min(joint.high ?? Infinity, Math.max(joint.low ?? -Infinity, value))

/** How far the values in these frames can all be raised or lowered; what is beyond stays. */
export function withinBy(joint: Joint, span: Span, by: number): number {
  let most = by
  for (let f = span.first; f <= span.last; ++f) {
    const value = joint.values[f]
    const room = within(joint, value + by) - value
    most = by > 0 ? Math.min(most, Math.max(0, room)) : Math.max(most, Math.min(0, room))
  }
  return most
}

export const unitSign = (unit: string): string => (unit === 'degrees' ? '°' : unit && ` ${unit}`)

/** "-41.5°", "12.0 mm" */
export const valueWords = (joint: Joint, value: number): string =>
  `${value.toFixed(1)}${unitSign(joint.unit)}`

/** "stops at -150° and 0°", or '' */
export function limitWords(joint: Joint): string {
  if (joint.low === null || joint.high === null) return ''
  const sign = unitSign(joint.unit)
  const words = (limit: number) => `${Number(limit.toFixed(3))}${sign}`
  return `stops at ${words(joint.low)} and ${words(joint.high)}`
}

/** How far a joint goes in the take. */
export function rangeOf(joint: Joint): { low: number; high: number } {
  let low = Infinity
  let high = -Infinity
  for (const value of joint.values) {
    low = Math.min(low, value)
    high = Math.max(high, value)
  }
  return { low, high }
}

/** Joints that turn, the one that moves most first. */
export function byMotion(take: Take): number[] {
  const moved = take.joints.map((joint) => {
    const { low, high } = rangeOf(joint)
    return joint.unit === 'degrees' ? high - low : -1
  })
  return moved.map((_, j) => j).sort((a, b) => moved[b] - moved[a] || a - b)
}

/** The values that the plot shows: those of the curves, and a little room. */
export function plotRange(joints: Joint[]): { low: number; high: number } {
  let low = Infinity
  let high = -Infinity
  for (const joint of joints) {
    const one = rangeOf(joint)
    low = Math.min(low, one.low)
    high = Math.max(high, one.high)
  }
  if (!(low <= high)) return { low: -1, high: 1 }
  // A joint that trembles does not look as if it leapt.
  const room = Math.max(0.12 * (high - low), 2)
  return { low: low - room, high: high + room }
}

/** Lines of the grid at round numbers, about `most` of them. */
export function gridOf(low: number, high: number, most: number): number[] {
  const raw = (high - low) / Math.max(1, most)
  const power = 10 ** Math.floor(Math.log10(raw))
  const step = [1, 2, 5, 10].map((times) => times * power).find((one) => one >= raw) ?? raw
  const lines: number[] = []
  const first = Math.ceil(low / step)
  for (let i = first; i * step <= high; ++i) lines.push(Number((i * step).toFixed(9)))
  return lines
}

/** A pulled value with no more digits than a pixel is worth. */
export function roundedTo(value: number, perPixel: number): number {
  const digits = Math.max(0, Math.min(3, Math.ceil(-Math.log10(perPixel))))
  return Number(value.toFixed(digits))
}

/** Frames that show what the frame before them shows: a held pose is one block. */
export function heldFrames(take: Take): boolean[] {
  return Array.from(
    { length: framesOfTake(take) },
    (_, f) => f > 0 && take.joints.every((joint) => joint.values[f] === joint.values[f - 1]),
  )
}

/** "walk_2", "walk_3": the first that no take has. */
export function nextName(take: string, names: string[]): string {
  const stem = take.replace(/_\d+$/, '')
  let number = 2
  while (names.includes(`${stem}_${number}`)) ++number
  return `${stem}_${number}`
}

const kStepWords = ['ones', 'twos', 'threes', 'fours']
export const stepWords = (step: number): string => kStepWords[step - 1] ?? `every ${step}`

/** A line of edits in words, for the list of changes. */
export function lineWords(line: string): string {
  const [verb, ...rest] = line.split(' ')
  const joint = (name: string) => (name === kAll ? 'all joints' : name)
  const frames = (text: string) => (text.includes('-') ? `frames ${text}` : `frame ${text}`)
  switch (verb) {
    case 'set':
      return `${rest[0]}, ${frames(rest[1])}: ${rest[2]}`
    case 'add':
      return `${rest[0]}, ${frames(rest[1])}: ${rest[2].startsWith('-') ? '' : '+'}${rest[2]}`
    case 'hold':
      return `${joint(rest[0])}, ${frames(rest[1])}: held`
    case 'move': {
      const by = Number(rest[3])
      const words = `${Math.abs(by)} ${by < 0 ? 'earlier' : 'later'}`
      return `${joint(rest[0])}, ${frames(rest[1])}: ${words}`
    }
    case 'delete':
      return `${frames(rest[0])}: taken out`
    case 'repeat':
      return `${frames(rest[0])}: shown ${rest[2]} longer`
    case 'step':
      return `on ${stepWords(Number(rest[0]))}`
    default:
      return line
  }
}
