// Two views that turn together: the second makes each movement of the first.
import type { Turn } from '../../view/viewer'

const kSteepest = 1.5

interface Angles {
  yaw: number
  tilt: number
}

function anglesOf([x, y, z]: Turn['direction']): Angles {
  return { yaw: Math.atan2(y, x), tilt: Math.atan2(z, Math.hypot(x, y)) }
}

function directionOf({ yaw, tilt }: Angles): Turn['direction'] {
  return [Math.cos(yaw) * Math.cos(tilt), Math.sin(yaw) * Math.cos(tilt), Math.sin(tilt)]
}

const clampTilt = (tilt: number) => Math.min(kSteepest, Math.max(-kSteepest, tilt))

/**
 * `other` moved as the first view moved from `before` to `after`. By differences, not by copy: each
 * view may look at its own landmark on limbs that point elsewhere.
 */
export function followed(before: Turn, after: Turn, other: Turn): Turn {
  const from = anglesOf(before.direction)
  const to = anglesOf(after.direction)
  const own = anglesOf(other.direction)
  const shift = (k: number) =>
    (other.offset?.[k] ?? 0) + (after.offset?.[k] ?? 0) - (before.offset?.[k] ?? 0)
  return {
    direction: directionOf({
      yaw: own.yaw + to.yaw - from.yaw,
      tilt: clampTilt(own.tilt + to.tilt - from.tilt),
    }),
    distance: (other.distance * after.distance) / before.distance,
    offset: [shift(0), shift(1), shift(2)],
  }
}

/** From where a place with this normal is seen well: not from above, nor from below the table. */
export function facing(normal: [number, number, number]): Turn['direction'] {
  const angles = anglesOf(normal)
  return directionOf({ ...angles, tilt: Math.min(1, Math.max(-0.2, angles.tilt)) })
}
