// The angles of a plan, and how far each of them is.
import type { Landed, Plan, Session } from './session'

export type SlotState = 'done' | 'warned' | 'missing' | 'skipped'

export interface Slot {
  ring: number
  flip: number
  index: number
  angle_deg: number
  state: SlotState
  /** the one at work */
  current: boolean
  photograph: Landed | null
}

/** The angle's number in its ring. */
function indexOf(angle_deg: number, angles: number): number {
  const index = Math.round((angle_deg / 360) * angles) % angles
  return index < 0 ? index + angles : index
}

interface Place {
  flip: number
  ring: number
  angle_deg: number
}

/** "r2_a045", "lying_r1_a000", "lying3_r1_a000"; null: it is no name of a photograph. */
export function placeOf(name: string): Place | null {
  const parts = /^(?:lying(\d*)_)?r(\d+)_a(\d+)$/.exec(name)
  if (!parts) return null
  const flip = parts[1] === undefined ? 0 : Number(parts[1] || 1)
  return { flip, ring: Number(parts[2]), angle_deg: Number(parts[3]) }
}

/** As `keypose shoot` calls the photograph of an angle. */
export function nameOf({ flip, ring, angle_deg }: Place): string {
  const lay = flip === 0 ? '' : flip === 1 ? 'lying_' : `lying${flip}_`
  return `${lay}r${ring}_a${String(Math.round(angle_deg)).padStart(3, '0')}`
}

/** The next photograph: what the program says, else the first that is missing; null: none is. */
export function aheadOf(session: Session): Place | null {
  if (session.next) return placeOf(session.next)
  for (let flip = 0; flip <= session.plan.flips; ++flip) {
    const slot = slotsOf({ ...session, next: '' }, flip)
      .flat()
      .find((one) => one.state === 'missing')
    if (slot) return slot
  }
  return null
}

/** All angles of one lay of the figure: ring by ring, each from 0 degrees on. */
export function slotsOf(session: Session, flip: number): Slot[][] {
  const { plan } = session
  const rings = plan.rings_deg.map((_, r) =>
    Array.from({ length: plan.angles }, (_, index): Slot => {
      const angle_deg = (360 * index) / plan.angles
      const place = { ring: r + 1, flip, index, angle_deg }
      return { ...place, state: 'missing', current: false, photograph: null }
    }),
  )
  const at = ({ flip: lay, ring, angle_deg }: Place): Slot | undefined =>
    lay === flip ? rings[ring - 1]?.[indexOf(angle_deg, plan.angles)] : undefined
  for (const one of Object.values(session.photographs)) {
    const slot = at(one)
    if (!slot) continue
    slot.photograph = one
    slot.state = one.findings.length > 0 ? 'warned' : 'done'
  }
  for (const name of session.skipped) {
    const place = placeOf(name)
    const slot = place && at(place)
    if (slot && !slot.photograph) slot.state = 'skipped'
  }
  const next = session.next ? placeOf(session.next) : null
  const slot = next && at(next)
  if (slot) slot.current = true
  return rings
}

export interface Counts {
  done: number
  warned: number
  missing: number
  skipped: number
}

export function countsOf(slots: Slot[]): Counts {
  const counts: Counts = { done: 0, warned: 0, missing: 0, skipped: 0 }
  for (const slot of slots) ++counts[slot.state]
  return counts
}

/** Where an angle is in the diagram: 0 degrees at the bottom, then to the right. */
export function spotOf(angle_deg: number, radius: number): { x: number; y: number } {
  const turn = (angle_deg * Math.PI) / 180
  return { x: radius * Math.sin(turn), y: radius * Math.cos(turn) }
}

/** The higher the camera, the nearer to the middle. */
export function radiusOf(ring: number, plan: Plan, most: number): number {
  const heights = [...plan.rings_deg].sort((a, b) => a - b)
  const place = heights.indexOf(plan.rings_deg[ring - 1])
  // Rings of the same height lie beside each other.
  const same = plan.rings_deg.slice(0, ring - 1).filter((one) => one === plan.rings_deg[ring - 1])
  const step = (0.56 * most) / Math.max(2, plan.rings_deg.length)
  return most - step * (place + same.length)
}

export function ringWords(plan: Plan, ring: number): string {
  const height = plan.rings_deg[ring - 1]
  return height === undefined ? `ring ${ring}` : `ring ${ring}, camera at ${height}°`
}

/** "45°", "7.5°" */
export function degrees(angle: number): string {
  return `${Math.round(angle * 10) / 10}°`
}
