// What was measured of a shot, in words.
import { count, percent } from '../../words'
import type { Finished, Located, LocatedFrame } from './shot_api'

const kFocal: Record<string, string> = {
  exif: 'from the photograph’s EXIF',
  solved: 'found in the pictures',
  given: 'as given',
  kept: 'could not be seen in the pictures: 50 mm is taken',
}

/** "1353 px, found in the pictures, ± 2.1 %" */
export function focalWords(located: Located): string {
  const parts = [`${Math.round(located.focal_px)} px`, kFocal[located.focal] ?? located.focal]
  if (located.focal_uncertainty > 0) parts.push(`± ${percent(located.focal_uncertainty, 1)}`)
  return parts.join(', ')
}

const kMethods: Record<string, string> = {
  features: 'by its texture',
  outlines: 'by its outline',
  clicks: 'by clicks',
  given: 'as given',
}
export const methodWords = (frame: LocatedFrame): string => kMethods[frame.method] ?? frame.method

/** How well outlines agree: goals of the engine are 0.5 px and an overlap of 0.99. */
export function gradeOf(frame: LocatedFrame): 'good' | 'look' | 'wrong' {
  const { contour_px: contour, iou } = frame
  if (contour === null || iou === null) return 'look'
  if (contour <= 1 && iou >= 0.97) return 'good'
  return contour <= 3 && iou >= 0.9 ? 'look' : 'wrong'
}

/** "9 filmed, 8 in-betweens" */
export function countWords(finished: Finished): string {
  const of = (kind: string) => finished.pictures.filter((one) => one.kind === kind).length
  const held = of('held')
  const words = [`${of('filmed')} filmed`, count(of('between'), 'in-between')]
  return [...words, ...(held > 0 ? [`${held} held`] : [])].join(', ')
}

/** What the picture at a place of the sequence is. */
export function pictureWords(finished: Finished, index: number): string {
  const one = finished.pictures[index]
  if (!one) return ''
  if (one.kind === 'filmed') return `filmed: ${one.film ?? ''}`
  if (one.kind === 'held') return 'held: the film’s last picture again'
  const film = (list: typeof finished.pictures) =>
    list.find((other) => other.kind === 'filmed')?.film ?? ''
  const before = film(finished.pictures.slice(0, index).reverse())
  const after = film(finished.pictures.slice(index + 1))
  return `in-between, made: from ${before} to ${after}`
}
