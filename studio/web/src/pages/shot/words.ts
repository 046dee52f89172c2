// What was measured of a shot, in words.
import { count, percent, sentence } from '../../words'
import type { Finished, Located, LocatedFrame, Quick } from './shot_api'

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

/** How well the pictures alone show the lens; '' where that was not measured. */
export function seenWords({ measured }: Located): string {
  const seen = measured.focal_seen
  if (seen === null || !(seen > 0)) return ''
  return seen < 1
    ? `The pictures alone show it to ${percent(seen, 1)}.`
    : 'The pictures alone do not show it.'
}

/** Frames with two others on each side are needed to tell a tremble from a way. */
const kFramesToTremble = 5

/** Whether the camera moves, and how much it, or the character's place, jitters. */
export function cameraWords(located: Located): string {
  const { still, measured, frames } = located
  const px = (value: number | null) => `${(value ?? 0).toFixed(2)} px`
  if (!still) {
    const words = 'The camera moves: each frame has a camera of its own.'
    if (frames.length < kFramesToTremble || measured.camera_jitter_px === null)
      return `${words} With fewer than five frames its jitter cannot be told.`
    return `${words} It jitters by ${px(measured.camera_jitter_px)} about a smooth way.`
  }
  const words = 'The camera stands still'
  if (measured.one_place) return `${words}, and one place fits all frames: nothing jitters.`
  // 0 where no neighbours show one pose.
  if (!measured.jitter_px) return `${words}; each frame has a place of its own.`
  const jitter = `neighbours of one pose differ by at most ${px(measured.jitter_px)}`
  return `${words}; each frame has a place of its own, ${jitter}.`
}

/** What four clicks have given. */
export function quickWords(quick: Quick): string {
  if (quick.problem) return sentence(quick.problem)
  const source = quick.focal === 'kept' ? ' (50 mm, as four clicks do not show it)' : ''
  const lens = `focal length ${Math.round(quick.focal_px ?? 0)} px${source}`
  const matte =
    quick.contour_px != null && quick.iou != null
      ? `outlines ${quick.contour_px.toFixed(1)} px from the matte’s, overlap ${percent(quick.iou, 1)}; `
      : ''
  return `Rough: ${matte}${lens}.`
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
