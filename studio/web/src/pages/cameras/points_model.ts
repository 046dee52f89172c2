// What may be done to points and their clicks. Knows nothing of the page.
import type { CalibrationResult, KnownPoint, PointCamera, PointClick, Points } from './points_api'

type Pixel = [number, number]

/** Clicks of a camera that place it: with its lens known, and without. */
export const kLeastClicks = 4
export const kLeastWithoutLens = 6

export const clickOf = (
  points: Points,
  camera: string,
  point: string,
): PointClick | undefined =>
  points.clicks.find((one) => one.camera === camera && one.point === point)

export const clicksOf = (points: Points, camera: string): PointClick[] =>
  points.clicks.filter((one) => one.camera === camera)

/** With a point clicked in a camera, in place of an earlier click of it. */
export function withClick(points: Points, camera: string, point: string, pixel: Pixel): Points {
  const others = points.clicks.filter((one) => one.camera !== camera || one.point !== point)
  return { ...points, clicks: [...others, { camera, point, pixel }] }
}

export function withoutClick(points: Points, camera: string, point: string): Points {
  const clicks = points.clicks.filter((one) => one.camera !== camera || one.point !== point)
  return { ...points, clicks }
}

export function withoutCamera(points: Points, camera: string): Points {
  return { ...points, clicks: points.clicks.filter((one) => one.camera !== camera) }
}

/** "point 3": the first such name that none has. */
export function freeName(points: Points): string {
  const taken = new Set(points.points.map((one) => one.name))
  for (let i = 1; ; ++i) if (!taken.has(`point ${i}`)) return `point ${i}`
}

export function withPoint(points: Points): Points {
  const point: KnownPoint = { name: freeName(points), place: [0, 0, 0] }
  return { ...points, points: [...points.points, point] }
}

/** Its clicks go with it. */
export function withoutPoint(points: Points, name: string): Points {
  return {
    points: points.points.filter((one) => one.name !== name),
    clicks: points.clicks.filter((one) => one.point !== name),
  }
}

/** Another name, which its clicks take, too; null: it is empty, or another point has it. */
export function renamed(points: Points, from: string, typed: string): Points | null {
  const to = typed.trim()
  if (!to || points.points.some((one) => one.name === to && to !== from)) return null
  const named = <One extends { name: string }>(one: One) =>
    one.name === from ? { ...one, name: to } : one
  return {
    points: points.points.map(named),
    clicks: points.clicks.map((one) => (one.point === from ? { ...one, point: to } : one)),
  }
}

/** A coordinate as a person types it, in metres, also with a comma; null: no such number. */
export function metresOf(typed: string): number | null {
  const value = Number(typed.trim().replace(',', '.'))
  return typed.trim() !== '' && Number.isFinite(value) && Math.abs(value) <= 1e6 ? value : null
}

export function moved(points: Points, name: string, axis: number, metres: number): Points {
  const place = (old: KnownPoint['place']) =>
    old.map((value, i) => (i === axis ? metres : value)) as KnownPoint['place']
  return {
    ...points,
    points: points.points.map((one) =>
      one.name === name ? { ...one, place: place(one.place) } : one,
    ),
  }
}

/** The point to click next in a camera: the first after `from` that is not yet; '' if none. */
export function nextToClick(points: Points, camera: string, from: string): string {
  const names = points.points.map((one) => one.name)
  const start = names.indexOf(from) + 1
  const round = [...names.slice(start), ...names.slice(0, start)]
  return round.find((name) => !clickOf(points, camera, name)) ?? ''
}

/** Why cameras cannot be calibrated yet; '' if they can. */
export function lacking(points: Points, cameras: PointCamera[], lenses: boolean): string {
  const least = lenses ? kLeastClicks : kLeastWithoutLens
  const clicked = cameras.filter((one) => clicksOf(points, one.name).length > 0)
  if (clicked.length === 0)
    return `Click ${least} points or more in each camera; eight are good, not all in a plane.`
  const few = clicked.filter((one) => clicksOf(points, one.name).length < least)
  if (few.length === 0) return ''
  const names = few.map((one) => one.name).join(', ')
  const why = lenses ? '' : ', as no picture of a board tells its lens'
  return `${names}: at least ${least} clicks are needed${why}.`
}

/** What the last calibration told of a click, unless the points have changed since. */
export function errorOf(result: CalibrationResult | null, camera: string, point: string) {
  if (!result || result.stale) return undefined
  const found = result.cameras.find((one) => one.camera === camera)
  return found?.clicks.find((one) => one.point === point)
}
