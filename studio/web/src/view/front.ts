// Where the figure looks: kept as the option `front` of the step that exports, for all that shows it.
import type { Steps } from '../api'
import type { Turn } from './turn'

/** Whose option it is; '' before there is such a step. */
export const frontStep = (steps: Steps): string =>
  steps.steps.find((step) => step.stage === 'export' && step.options.front !== undefined)?.step ?? ''

/** [deg], counter-clockwise seen from above; 0: the side of the first photograph (-y). */
export function frontOf(steps: Steps): number {
  const found = steps.steps.find((step) => step.stage === 'export' && step.options.front !== undefined)
  return Number(found?.options.front ?? 0) || 0
}

/** The azimuth of a direction that looks away from the figure, as frontOf has it. */
export function azimuthOf([x, y]: readonly number[]): number {
  return Math.round((Math.atan2(x, -y) * 180) / Math.PI + 360) % 360
}

/** What views begin with; the page sets it as it reads the project. */
export const shownFront = { degrees: 0 }

/** A view of a figure that looks to -y, for one that looks elsewhere. */
export function turnedToFront(turn: Turn, front: number): Turn {
  const a = (front * Math.PI) / 180
  const [x, y, z] = turn.direction
  const direction: [number, number, number] = [
    x * Math.cos(a) - y * Math.sin(a),
    x * Math.sin(a) + y * Math.cos(a),
    z,
  ]
  return { ...turn, direction }
}
