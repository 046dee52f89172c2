// Pins and turns of regions, and what may be done to them. Knows nothing of the page.
import type { Timeline } from '../../api'
import { keysOf, Refusal } from './timeline_model'
import type { Key } from './timeline_model'

type Fields = Record<string, unknown>

export const listOf = (value: unknown): Fields[] =>
  Array.isArray(value) ? value.filter((one) => typeof one === 'object' && one !== null) : []

/** A region that stays where two neighbouring keys have it. */
export interface Pin {
  region: string
  /** times of keys [s]; none: the start, the end */
  from?: number
  to?: number
}

/** A region that makes whole turns more on the way from a key to the next. */
export interface Turn {
  key: number
  region: string
  turns: number
  /** between equal poses the axis must be said */
  axis?: [number, number, number]
}

export type Axis = 'x' | 'y' | 'z'
export const kAxes: Record<Axis, [number, number, number]> = {
  x: [1, 0, 0],
  y: [0, 1, 0],
  z: [0, 0, 1],
}
export const kMostTurns = 100

/** Regions that pins and turns can be about: those of the file, and the painted ones. */
export function regionNames(timeline: Timeline, painted: string[]): string[] {
  const written = listOf(timeline.other.regions).map((region) => String(region.name))
  return [...new Set([...written, ...painted])]
}

export const pinsOf = (timeline: Timeline): Pin[] =>
  listOf(timeline.other.pins).map((pin) => ({ ...pin, region: String(pin.region) }))

function withPins(timeline: Timeline, pins: Pin[]): Timeline {
  const { pins: _, ...other } = timeline.other
  return { ...timeline, other: pins.length > 0 ? { ...other, pins } : other }
}

export function addPin(timeline: Timeline, region: string): Timeline {
  return withPins(timeline, [...pinsOf(timeline), { region }])
}

export function setPin(timeline: Timeline, index: number, change: Partial<Pin>): Timeline {
  const pins = pinsOf(timeline)
  const pin: Pin = { ...pins[index], ...change }
  if (pin.from === undefined) delete pin.from
  if (pin.to === undefined) delete pin.to
  if (pin.from !== undefined && pin.to !== undefined && pin.to <= pin.from)
    throw new Refusal('A pin ends at a later key than it begins with.')
  return withPins(timeline, pins.map((old, i) => (i === index ? pin : old)))
}

export function deletePin(timeline: Timeline, index: number): Timeline {
  return withPins(timeline, pinsOf(timeline).filter((_, i) => i !== index))
}

/** The key at a pin's time; -1: it has moved on. */
export function keyOfPin(timeline: Timeline, seconds: number): number {
  return timeline.keys.findIndex((key) => Math.abs(key.at - seconds) * timeline.fps < 0.5)
}

/**
 * Pins without a key that was taken out: one that began with it begins with the next, one that
 * ended with it ends with the one before. Without a span to hold, it goes as well.
 * @param after  the keys without that of `index`, which may have moved
 */
export function withPinsOff(timeline: Timeline, after: Timeline, index: number): Timeline {
  const pins = pinsOf(timeline)
  if (pins.length === 0) return after
  const last = after.keys.length - 1
  const at = (seconds: number | undefined, otherwise: number, ifGone: number) => {
    if (seconds === undefined) return otherwise
    const key = keyOfPin(timeline, seconds)
    // A time within a hold is no key's own; it stays.
    if (key < 0) return null
    return key === index ? ifGone : key > index ? key - 1 : key
  }
  const kept: Pin[] = []
  for (const pin of pins) {
    const from = at(pin.from, 0, Math.min(index, last))
    const to = at(pin.to, last, Math.max(index - 1, 0))
    if (from !== null && to !== null && from >= to) continue
    const next: Pin = { ...pin }
    if (pin.from !== undefined && from !== null) next.from = after.keys[from].at
    if (pin.to !== undefined && to !== null) next.to = after.keys[to].at
    kept.push(next)
  }
  return withPins(after, kept)
}

/** Pins follow the keys that they hang on; `moved` has the same keys in the same order. */
export function withPinsOn(timeline: Timeline, moved: Timeline): Timeline {
  const pins = pinsOf(timeline)
  if (pins.length === 0) return moved
  const follow = (seconds: number | undefined) => {
    const key = seconds === undefined ? -1 : keyOfPin(timeline, seconds)
    return key < 0 ? seconds : moved.keys[key].at
  }
  const followed = pins.map((pin) => {
    const next: Pin = { ...pin }
    if (pin.from !== undefined) next.from = follow(pin.from)
    if (pin.to !== undefined) next.to = follow(pin.to)
    return next
  })
  return withPins(moved, followed)
}

export function turnsOf(timeline: Timeline): Turn[] {
  return keysOf(timeline).flatMap((key, index) =>
    Object.entries(key.turns ?? {}).map(([region, value]) => {
      const fields = (typeof value === 'object' && value !== null ? value : {}) as Fields
      const turn: Turn = { key: index, region, turns: Number(fields.turns ?? value) }
      if (Array.isArray(fields.axis)) turn.axis = fields.axis as [number, number, number]
      return turn
    }),
  )
}

const written = ({ turns, axis }: Turn): unknown => (axis ? { turns, axis } : turns)

function withTurns(timeline: Timeline, turns: Turn[]): Timeline {
  const keys = keysOf(timeline).map((key, index): Key => {
    const { turns: _, ...others } = key
    const own = turns.filter((turn) => turn.key === index)
    if (own.length === 0) return others as Key
    const fields = Object.fromEntries(own.map((turn) => [turn.region, written(turn)]))
    return { ...others, turns: fields } as Key
  })
  return { ...timeline, keys }
}

/** In the first span, at or after `key`, where the region does not turn yet. */
export function addTurn(timeline: Timeline, region: string, key: number): Timeline {
  const turns = turnsOf(timeline)
  const spans = timeline.keys.length - 1
  const taken = (at: number) => turns.some((turn) => turn.key === at && turn.region === region)
  const free = Array.from({ length: spans }, (_, i) => (key + i) % spans).find((at) => !taken(at))
  if (free === undefined) throw new Refusal(`${region} turns between all keys already.`)
  return withTurns(timeline, [...turns, { key: free, region, turns: 1 }])
}

export function setTurn(timeline: Timeline, index: number, change: Partial<Turn>): Timeline {
  const turns = turnsOf(timeline)
  const turn: Turn = { ...turns[index], ...change }
  const again = turns.some(
    (old, i) => i !== index && old.key === turn.key && old.region === turn.region,
  )
  if (again) throw new Refusal(`${turn.region} turns from this key already.`)
  turn.turns = Math.max(-kMostTurns, Math.min(kMostTurns, Math.round(turn.turns)))
  if (turn.turns === 0) throw new Refusal('No turn: delete it instead.')
  if (!turn.axis) delete turn.axis
  return withTurns(timeline, turns.map((old, i) => (i === index ? turn : old)))
}

export function deleteTurn(timeline: Timeline, index: number): Timeline {
  return withTurns(timeline, turnsOf(timeline).filter((_, i) => i !== index))
}
