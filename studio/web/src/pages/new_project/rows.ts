// The poses of the new project, as the page keeps them until the project is made.
import { byPose, joined, sorted } from './files'
import type { Found, LeftOut, Photo } from './files'

export interface Row {
  key: number
  name: string
  photos: Photo[]
  leftOut: LeftOut[]
}

let nextKey = 1
export const emptyRow = (name = ''): Row => ({ key: nextKey++, name, photos: [], leftOut: [] })
export const isBlank = (row: Row): boolean => row.name === '' && row.photos.length === 0

/** The rule of pipeline/text/text.h: letters and digits of any script, - and _; no - at the start. */
const kName = /^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_-]*$/u

/** A folder's name as a pose's: "Pose 2 (bent)" is Pose-2-bent. */
export function asName(folder: string): string {
  return folder
    .normalize('NFC')
    .replace(/[^\p{L}\p{M}\p{N}_-]+/gu, '-')
    .replace(/^-+|-+$/g, '')
}

export function nameProblem(row: Row, rows: Row[]): string {
  const name = row.name
  if (name === '') return row.photos.length > 0 ? 'Name this pose.' : ''
  if (!kName.test(name)) return 'Letters, digits, - and _ only; no - at the start.'
  const same = (other: Row) => other.name.toLowerCase() === name.toLowerCase()
  return rows.some((other) => other !== row && same(other)) ? 'Two poses have this name.' : ''
}

/** What is missing before the project can be made, or ''. */
export function missing(rows: Row[]): string {
  const used = rows.filter((row) => !isBlank(row))
  if (used.length === 0) return 'Name a pose and drop its photographs.'
  if (used.some((row) => nameProblem(row, rows))) return 'Mend the names that are marked.'
  const bare = used.find((row) => row.photos.length === 0)
  return bare ? `${bare.name} has no photographs yet.` : ''
}

/** The row with more photographs; a row without a name takes that of their folder. */
export function withFiles(row: Row, found: Found[], rows: Row[]): Row {
  const { photos, leftOut } = sorted(found)
  const folder = asName(photos[0]?.path.split('/').slice(-2, -1)[0] ?? '')
  const free = !rows.some((other) => other.name === folder)
  return {
    ...row,
    name: row.name || (free ? folder : ''),
    photos: joined(row.photos, photos),
    leftOut: [...row.leftOut, ...leftOut],
  }
}

/**
 * With fewer photographs a pose other than the template is not scanned, as `keypose init` decides.
 */
export const kScan = 16

/** Poses of few photographs, which the template will be bent into. */
export function fewOf(rows: Row[], template: string): string[] {
  const few = rows.filter((row) => row.name !== template && row.photos.length < kScan)
  return few.map((row) => row.name)
}

/** Files dropped beside the rows: each folder goes to the row of its name, or to one of its own. */
export function spreadOver(rows: Row[], found: Found[]): Row[] {
  let next = rows
  for (const [folder, files] of byPose(found)) {
    if (sorted(files).photos.length === 0) continue
    const name = asName(folder)
    const row = next.find((one) => name && one.name === name) ?? next.find(isBlank)
    if (!row) next = [...next, withFiles(emptyRow(), files, next)]
    else next = next.map((one) => (one === row ? withFiles(row, files, next) : one))
  }
  return next
}
