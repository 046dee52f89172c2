// What is wrong with a photograph, judged against the others of its pose.
import type { Photograph } from '../../api'
import { percent } from '../../words'

export interface Flag {
  text: string
  why: string
  grade: 'warn' | 'bad'
}

export interface Judged {
  photograph: Photograph
  /** sharpness over the median; NaN before capture */
  sharpness: number
  /** exposure over the median, minus 1; NaN before capture */
  exposure: number
  flags: Flag[]
  /** for 'worst first' */
  badness: number
}

const kBlurred = 0.75 // as capture warns
const kNoFigure = 0.002 // as min_mask of capture
const kExposureOff = 0.15

function median(values: number[]): number {
  const sorted = values.filter(Number.isFinite).sort((a, b) => a - b)
  const middle = sorted.length >> 1
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2
}

/** "+3 %" */
export function signedPercent(share: number): string {
  const text = percent(Math.abs(share))
  return text === '0 %' ? '±0 %' : `${share < 0 ? '−' : '+'}${text}`
}

function flagsOf(photograph: Photograph, sharpness: number, exposure: number): Flag[] {
  const flags: Flag[] = []
  if (photograph.left_out) return flags
  if (photograph.another_thing)
    flags.push({ text: 'another thing', why: photograph.why, grade: 'bad' })
  if (!photograph.captured) return flags
  if (!photograph.trusted)
    flags.push({ text: 'mask', why: photograph.why || 'the mask is not trusted', grade: 'bad' })
  // without a figure there is nothing that could be sharp
  if (photograph.mask_fraction < kNoFigure)
    flags.push({ text: 'no figure', why: 'no figure was found in it', grade: 'bad' })
  else if (sharpness < kBlurred)
    flags.push({
      text: 'blurred',
      why: `${percent(sharpness)} of the sharpness that this set has in the middle`,
      grade: 'bad',
    })
  if (Math.abs(exposure) > kExposureOff)
    flags.push({
      text: exposure < 0 ? 'dark' : 'bright',
      why: `${percent(Math.abs(exposure))} ${exposure < 0 ? 'darker' : 'brighter'} than the set`,
      grade: 'warn',
    })
  return flags
}

export function judge(photographs: Photograph[]): Judged[] {
  const captured = photographs.filter(
    (one) => one.captured && !one.left_out && one.mask_fraction >= kNoFigure,
  )
  const middleSharpness = median(captured.map((one) => one.sharpness))
  const middleExposure = median(captured.map((one) => one.exposure))
  return photographs.map((photograph) => {
    const sharpness = photograph.captured ? photograph.sharpness / middleSharpness : NaN
    const exposure = photograph.captured ? photograph.exposure / middleExposure - 1 : NaN
    const flags = flagsOf(photograph, sharpness, exposure)
    const small = photograph.captured ? Math.max(0, 1 - sharpness) + Math.abs(exposure) : 0
    const grades = flags.reduce((sum, flag) => sum + (flag.grade === 'bad' ? 20 : 10), 0)
    return { photograph, sharpness, exposure, flags, badness: grades + small }
  })
}

export type Order = 'name' | 'worst'

export function ordered(judged: Judged[], order: Order): Judged[] {
  const byName = (a: Judged, b: Judged) =>
    a.photograph.name.localeCompare(b.photograph.name, undefined, { numeric: true })
  const out = (one: Judged) => Number(one.photograph.left_out)
  return [...judged].sort((a, b) => {
    const apart = order === 'worst' ? out(a) - out(b) || b.badness - a.badness : 0
    return apart || byName(a, b)
  })
}
