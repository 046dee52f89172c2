// Which frames the lanes show, and where: one for ruler, keys, sound and curves.

export interface ViewWindow {
  /** the frame at the left edge; may be a fraction */
  start: number
  /** pixels of a frame */
  scale: number
  /** pixels of the lanes */
  width: number
  /** frames that there are to see */
  total: number
}

const kWidestFrame = 36

/** Room after the last frame, so that the last key can be dragged out. */
export function totalFor(frames: number): number {
  return frames + Math.max(4, Math.ceil(0.06 * frames))
}

/** zoom 1: all frames. Shows `start` at the left where that is possible. */
export function windowFor(
  width: number,
  total: number,
  zoom: number,
  start: number,
): ViewWindow {
  const fitting = Math.max(1, width) / Math.max(1, total)
  const scale = Math.min(kWidestFrame, fitting * zoom)
  // A short animation does not fill the ruler, which goes on after it.
  const seen = width / scale
  const most = Math.max(0, total - seen)
  const all = Math.max(total, Math.floor(seen))
  return { start: Math.min(most, Math.max(0, start)), scale, width, total: all }
}

/** The left edge of a frame [px]. */
export const xOf = (view: ViewWindow, frame: number): number => (frame - view.start) * view.scale

export const frameAt = (view: ViewWindow, x: number): number =>
  Math.floor(view.start + x / view.scale)

/** Frames between labels of the ruler: round numbers, or whole seconds where there is room. */
export function labelStep(view: ViewWindow, fps: number): number {
  const fine = [1, 2, 4, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 20000, 50000]
  const second = Math.round(fps)
  const steps = [...fine.filter((one) => second % one === 0 || one > second), second]
  for (const times of [2, 5, 10, 30, 60, 300]) steps.push(times * second)
  steps.sort((a, b) => a - b)
  return steps.find((one) => one * view.scale >= 44) ?? steps[steps.length - 1]
}
