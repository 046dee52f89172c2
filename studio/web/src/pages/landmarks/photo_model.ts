// Picks in photographs: colours, how far the fitted model is from them, where more would help. Knows
// nothing of the page.
import type { PhotoFit, PhotoPick } from '../../api'
import type { PhotoPair } from './pick_history'

/** Told apart on clay and on a dark ground, neighbours also by people who see few colours. */
const kColors = [
  '#f08a5d',
  '#7bb7e8',
  '#e8c547',
  '#c79bf2',
  '#8fd17a',
  '#f27fb0',
  '#5ad6c8',
  '#d9b48f',
]

/** The colour of a pair by its place in the list: the same on the template and in photographs. */
export const colorOf = (index: number): string => kColors[index % kColors.length]

/** A residual above this share of the picture's longer side is to be looked at. */
const kFar = 0.012
/** An overlap of outlines farther apart than this share is worth a pick. */
const kWorth = 0.006
const kMostPlaces = 3

export interface Residual {
  pick: PhotoPick
  /** where the fitted model has it */
  shown: [number, number]
  off_px: number
  /** the last fit left the pick out, or it is far off */
  wrong: boolean
}

const apart = (a: readonly number[], b: readonly number[]) => Math.hypot(a[0] - b[0], a[1] - b[1])

/** Whether it was picked in an older photograph of that name: the fit leaves it out. */
export function isOlder(pick: PhotoPick, fit: PhotoFit | null): boolean {
  const now = fit?.photographs.find((one) => one.name === pick.image)
  return now !== undefined && !!pick.photograph && pick.photograph !== now.photograph
}

/** The picks, with older ones as made in the photographs of now. */
export function withOlderHeld(picks: readonly PhotoPick[], fit: PhotoFit): PhotoPick[] {
  return picks.map((pick) => {
    const now = fit.photographs.find((one) => one.name === pick.image)
    return now && isOlder(pick, fit) ? { ...pick, photograph: now.photograph } : pick
  })
}

/** Of the photographs in which the pair was picked, and whose cameras are known. */
export function residualsOf(pair: PhotoPair, fit: PhotoFit | null): Residual[] {
  const found: Residual[] = []
  for (const pick of pair.pixels) {
    const same = (one: { name: string; image: string }) =>
      one.name === pair.name && one.image === pick.image
    const shown = fit?.shown.find(same)
    const photograph = fit?.photographs.find((one) => one.name === pick.image)
    if (!fit || !shown || !photograph || isOlder(pick, fit)) continue
    const off_px = apart(pick.pixel, shown.pixel)
    const far = off_px > kFar * Math.max(photograph.width, photograph.height)
    found.push({ pick, shown: shown.pixel, off_px, wrong: far || fit.refused.some(same) })
  }
  return found
}

/** The largest of a pair; null: none is known. */
export function largestOf(residuals: readonly Residual[]): Residual | null {
  return residuals.reduce<Residual | null>(
    (most, one) => (!most || one.off_px > most.off_px ? one : most),
    null,
  )
}

/**
 * How far a pick is from where the picks of its name in other photographs have it; null: there are
 * none, or no cameras.
 */
export function contradictionOf(pair: PhotoPair, image: string, fit: PhotoFit | null) {
  const pick = pair.pixels.find((one) => one.image === image)
  const meets = fit?.meets.find((one) => one.name === pair.name && one.image === image)
  return pick && meets && pair.pixels.length > 1 ? apart(pick.pixel, meets.pixel) : null
}

export interface WorstPlace {
  image: string
  pixel: [number, number]
  /** "38 px: the photograph shows more than the fit" */
  words: string
}

/** Where outlines of the fitted model and of the masks are farthest apart: worst first. */
export function worstPlaces(fit: PhotoFit | null): WorstPlace[] {
  const all = (fit?.photographs ?? []).flatMap(({ name, width, height, worst }) =>
    worst && worst.distance_px > kWorth * Math.max(width, height)
      ? [{ image: name, worst, share: worst.distance_px / Math.max(width, height) }]
      : [],
  )
  all.sort((one, two) => two.share - one.share)
  return all.slice(0, kMostPlaces).map(({ image, worst }) => ({
    image,
    pixel: worst.pixel,
    words:
      `${Math.round(worst.distance_px)} px: ` +
      (worst.beyond === 'mask'
        ? 'the photograph shows more than the fit'
        : 'the fit reaches beyond the photograph'),
  }))
}

/** "1 photograph, 2.1 px off" */
export function stateWords(pair: PhotoPair, template: string, fit: PhotoFit | null): string {
  if (!pair.template) return `not on ${template}`
  const number = pair.pixels.length
  if (number === 0) return 'no photograph'
  const largest = largestOf(residualsOf(pair, fit))
  const off = largest ? ` · ${largest.off_px.toFixed(largest.off_px < 9.95 ? 1 : 0)} px` : ''
  return `${number} photo${number === 1 ? '' : 's'}${off}`
}
