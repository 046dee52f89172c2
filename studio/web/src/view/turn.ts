// Where a view looks from, and how keys change it.

/**
 * The camera's place relative to the shown thing, in its sizes: the same for meshes of any size.
 */
export interface Turn {
  direction: [number, number, number]
  distance: number
  /** where the camera looks, from the middle of the thing; none: at the middle */
  offset?: [number, number, number]
}

/** Arrow keys turn, plus and minus zoom; null for any other key. */
export function turnedByKey(turn: Turn, key: string): Turn | null {
  const around = { ArrowLeft: -0.12, ArrowRight: 0.12 }[key] ?? 0
  const over = { ArrowUp: 0.12, ArrowDown: -0.12 }[key] ?? 0
  const closer = { '+': 0.9, '=': 0.9, '-': 1.1 }[key] ?? 1
  if (!around && !over && closer === 1) return null
  const [x, y, z] = turn.direction
  const level = Math.hypot(x, y) || 1e-6
  const tilt = Math.min(1.5, Math.max(-1.5, Math.atan2(z, level) + over))
  const yaw = Math.atan2(y, x) + around
  return {
    direction: [Math.cos(yaw) * Math.cos(tilt), Math.sin(yaw) * Math.cos(tilt), Math.sin(tilt)],
    distance: turn.distance * closer,
  }
}
