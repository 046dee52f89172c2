// Versions, figures and verdicts in words.
import type { Figure, Said, Subject, Version } from './review_api'

export const nameOf = (pose: string): string => pose || 'The film'

/** "1 Mar, 14:05:09" here; '' where no run is on record. */
export function timeWords(when: string): string {
  const date = new Date(when.replace(' UTC', 'Z').replace(' ', 'T'))
  if (Number.isNaN(date.getTime())) return when
  const day = date.toLocaleDateString(undefined, { day: 'numeric', month: 'short' })
  return `${day}, ${date.toLocaleTimeString(undefined, { hour12: false })}`
}

/** Whether something of it is left to look at. */
export const isThere = (version: Version): boolean => version.mesh !== '' || version.files.length > 0

export function versionWords(version: Version): string {
  const time = timeWords(version.when) || 'an earlier run'
  if (!isThere(version) && version.gone.length > 0) return `${time}: cleaned away`
  return version.now ? `${time} (now)` : time
}

/** What of a result can be looked at: the figure in 3D, and each picture or film of its steps. */
export interface Sight {
  /** '3d', or the path of a file */
  key: string
  words: string
  film: boolean
}

/** What both have; films first. Of one alone, what that has. */
export function sightsOf(before: Version | null, after: Version): Sight[] {
  const sights: Sight[] = []
  if (after.mesh && (!before || before.mesh)) sights.push({ key: '3d', words: 'In 3D', film: false })
  const both = after.files.filter(
    (file) => !before || before.files.some((other) => other.path === file.path),
  )
  for (const film of [true, false])
    for (const file of both.filter((one) => one.film === film))
      sights.push({
        key: file.path,
        words: `${file.title}: ${file.path.split('/').at(-1)}`,
        film,
      })
  return sights
}

/** The address of a file of a version. */
export const fileAt = (version: Version, path: string): string | undefined =>
  version.files.find((file) => file.path === path)?.at

/** The newest result, and the newest before it that can be looked at. */
export function firstPair(versions: Version[]): { before: string; after: string } {
  const shown = versions.filter(isThere)
  return { before: shown[1]?.id ?? '', after: shown[0]?.id ?? '' }
}

export function numberWords(value: Figure['before'], unit: string): string {
  if (value === null) return '–'
  if (typeof value === 'boolean') return value ? 'yes' : 'no'
  const share = unit === 'share' || unit === 'diagonal'
  const shown = share ? 100 * value : value
  const text = Number.isInteger(shown) ? String(shown) : String(Number(shown.toPrecision(4)))
  return share ? `${text} %` : unit ? `${text} ${unit}` : text
}

/** How far a figure is outside of its good range. */
function outside(value: number, good: Figure['good']): number {
  return Math.max((good.min ?? -Infinity) - value, value - (good.max ?? Infinity), 0)
}

/** Only where the stage says what is good. */
export function trend(figure: Figure): 'better' | 'worse' | '' {
  if (typeof figure.before !== 'number' || typeof figure.after !== 'number') return ''
  const by = outside(figure.after, figure.good) - outside(figure.before, figure.good)
  return by > 0 ? 'worse' : by < 0 ? 'better' : ''
}

/** What the list says beside a name, from the newest word on it. */
export function standing(subject: Subject): { words: string; grade: 'good' | 'bad' | 'warn' | '' } {
  const last = subject.reviews[0]
  if (!last) return { words: '', grade: '' }
  if (!last.holds) return { words: 'changed since', grade: 'warn' }
  return last.verdict === 'approved'
    ? { words: 'approved', grade: 'good' }
    : { words: 'sent back', grade: 'bad' }
}

export function saidWords(said: Said): string {
  const verdict = said.verdict === 'approved' ? 'Approved' : 'Sent back'
  const of = said.holds ? 'this result' : 'an earlier result'
  return `${verdict}, of ${of}`
}

/** The end of the scale for distances: 99 % of them lie within; never nothing. */
export function scaleEnd(...all: Float32Array[]): number {
  const known = all.flatMap((values) => Array.from(values).filter(Number.isFinite)).sort((a, b) => a - b)
  const most = known[Math.min(known.length - 1, Math.floor(0.99 * known.length))] ?? 0
  return Math.max(most, 1e-4)
}
