// The timeline's keys and what may be done to them, in frames. Knows nothing of the page.
//
// Times are rounded to frames as interpolate does (interpolate/timing/timeline.cpp): frame 0 is
// the first key, and a key with a hold of h frames is seen in h + 1 frames.
import type { Frames, Timeline, TimelineKey } from '../../api'
import { withPinsOff, withPinsOn } from './region_model'

/** A key with the fields of the file that TimelineKey does not list; the server passes them on. */
export interface Key extends TimelineKey {
  interpolation?: 'smooth' | 'linear' | 'stepped'
  /** of the span that begins here; none: the timeline's */
  step?: number
  turns?: Record<string, unknown>
}

/** CSS's cubic-bezier: x1, y1, x2, y2. */
export type Curve = [number, number, number, number]
export type EaseName = 'linear' | 'ease' | 'in' | 'out' | 'in-out' | 'stepped' | 'custom'

export const kCurves: Record<string, Curve> = {
  linear: [0, 0, 1, 1],
  ease: [0.25, 0.1, 0.25, 1],
  in: [0.42, 0, 1, 1],
  out: [0, 0, 0.58, 1],
  'in-out': [0.42, 0, 0.58, 1],
}
/** Bounds of a custom curve's y; core/io/project/timeline.cpp refuses others. */
export const kLowestY = -2
export const kHighestY = 3
/** The page's own bound; the engine takes a million. */
export const kMostFrames = 100000

/** An edit that cannot be done, with the reason in words. */
export class Refusal extends Error {}

const clamp = (value: number, low: number, high: number) => Math.min(high, Math.max(low, value))
/** Short numbers for the file; far below half a frame at any rate up to 1000. */
const kLastDigit = 1e-4
const round = (value: number, digits = 4) => Number(value.toFixed(digits))

export const keysOf = (timeline: Timeline): Key[] => timeline.keys

/** The frame of each key. */
export function framesOf(timeline: Timeline): number[] {
  const start = timeline.keys[0]?.at ?? 0
  return timeline.keys.map((key) => Math.round((key.at - start) * timeline.fps))
}

/** Frames that a key stands beyond its own. */
export function holdOf(timeline: Timeline, index: number): number {
  const hold = Math.round((timeline.keys[index].hold ?? 0) * timeline.fps)
  const frames = framesOf(timeline)
  return index + 1 < frames.length ? Math.min(hold, frames[index + 1] - frames[index]) : hold
}

/** The first frame that does not show the key any more. */
export function blockEnd(timeline: Timeline, index: number): number {
  const frames = framesOf(timeline)
  const end = frames[index] + holdOf(timeline, index) + 1
  return index + 1 < frames.length ? Math.min(end, frames[index + 1]) : end
}

/** Number of frames of the whole timeline. */
export function lengthOf(timeline: Timeline): number {
  return timeline.keys.length === 0 ? 0 : blockEnd(timeline, timeline.keys.length - 1)
}

/** The key that is seen, or left, at a frame. */
export function keyAt(timeline: Timeline, frame: number): number {
  const frames = framesOf(timeline)
  let index = 0
  while (index + 1 < frames.length && frames[index + 1] <= frame) ++index
  return index
}

export function secondsOf(timeline: Timeline, frame: number): number {
  return (timeline.keys[0]?.at ?? 0) + frame / timeline.fps
}

/** The frame of a time of the file. */
export function frameOfSeconds(timeline: Timeline, seconds: number): number {
  return Math.round((seconds - (timeline.keys[0]?.at ?? 0)) * timeline.fps)
}

/**
 * Keys as the file may have them: the engine compares seconds, and refuses a hold that passes the
 * next key by the last digit of a rounded number. Less than a frame is taken off.
 */
function withKeys(timeline: Timeline, keys: Key[]): Timeline {
  const settled = keys.map((key, i) => {
    const next = keys[i + 1]
    if (key.hold === undefined || !next || key.at + key.hold <= next.at) return key
    let hold = round(next.at - key.at)
    while (key.at + hold > next.at) hold = round(hold - kLastDigit)
    return { ...key, hold }
  })
  return { ...timeline, keys: settled }
}

function withKey(timeline: Timeline, index: number, key: Key): Timeline {
  const keys = keysOf(timeline).map((old, i) => (i === index ? key : old))
  return withKeys(timeline, keys)
}

function withoutField<K extends keyof Key>(key: Key, field: K): Key {
  const { [field]: _, ...others } = key
  return others as Key
}

function placed(timeline: Timeline, key: Key, frame: number): Key {
  return { ...key, at: round(secondsOf(timeline, frame)) }
}

function held(timeline: Timeline, key: Key, frames: number): Key {
  if (frames <= 0) return withoutField(key, 'hold')
  return { ...key, hold: round(frames / timeline.fps) }
}

/** Frames between which a key may move: after its predecessor's hold, its own before the next. */
export function roomOf(timeline: Timeline, index: number): { min: number; max: number } {
  const frames = framesOf(timeline)
  // Frame 0 is the first key by definition: it has no earlier place to go to.
  if (index === 0) return { min: 0, max: 0 }
  const min = frames[index - 1] + Math.max(1, holdOf(timeline, index - 1))
  if (index + 1 === frames.length) return { min, max: kMostFrames }
  return { min, max: frames[index + 1] - Math.max(1, holdOf(timeline, index)) }
}

/** The key at this frame, or at the nearest that its neighbours leave free. */
export function moveKey(timeline: Timeline, index: number, frame: number): Timeline {
  const { min, max } = roomOf(timeline, index)
  const target = clamp(Math.round(frame), min, max)
  if (target === framesOf(timeline)[index]) return timeline
  const moved = withKey(timeline, index, placed(timeline, timeline.keys[index], target))
  return withPinsOn(timeline, moved)
}

/** The same with all later keys, whose distances stay. */
export function moveKeysFrom(timeline: Timeline, index: number, frame: number): Timeline {
  if (index === 0) return timeline
  const frames = framesOf(timeline)
  const { min } = roomOf(timeline, index)
  const most = kMostFrames - frames[frames.length - 1] + frames[index]
  const by = clamp(Math.round(frame), min, most) - frames[index]
  if (by === 0) return timeline
  const keys = keysOf(timeline).map((key, i) =>
    i < index ? key : placed(timeline, key, frames[i] + by),
  )
  return withPinsOn(timeline, withKeys(timeline, keys))
}

/** The longest hold; reaching the next key means that the span does not move at all. */
export function mostHold(timeline: Timeline, index: number): number {
  const frames = framesOf(timeline)
  return index + 1 < frames.length ? frames[index + 1] - frames[index] : kMostFrames
}

export function setHold(timeline: Timeline, index: number, frames: number): Timeline {
  const hold = clamp(Math.round(frames), 0, mostHold(timeline, index))
  if (hold === holdOf(timeline, index)) return timeline
  return withKey(timeline, index, held(timeline, timeline.keys[index], hold))
}

/** The hold with which a key's block ends before `end`. */
export function holdUntil(timeline: Timeline, index: number, end: number): number {
  const hold = end - framesOf(timeline)[index] - 1
  return hold + 1 >= mostHold(timeline, index) ? mostHold(timeline, index) : Math.max(0, hold)
}

/** In a loop the last key is the first one again: both change. */
export function setPose(timeline: Timeline, index: number, pose: string): Timeline {
  const last = timeline.keys.length - 1
  const ends = timeline.loop && (index === 0 || index === last)
  const keys = keysOf(timeline).map((key, i) =>
    i === index || (ends && (i === 0 || i === last)) ? { ...key, pose } : key,
  )
  return withKeys(timeline, keys)
}

/** The nearest frame without a key, later ones first. */
export function freeFrame(timeline: Timeline, frame: number): number {
  const taken = new Set(framesOf(timeline))
  const from = Math.max(1, Math.round(frame))
  for (let by = 0; ; ++by) {
    if (!taken.has(from + by)) return from + by
    if (from - by > 0 && !taken.has(from - by)) return from - by
  }
}

function insert(
  timeline: Timeline,
  frame: number,
  key: Key,
): { timeline: Timeline; index: number } {
  const frames = framesOf(timeline)
  if (frame < 0 || frame > kMostFrames) throw new Refusal('A key must lie on the ruler.')
  if (frames.includes(frame)) throw new Refusal(`Frame ${frame} has a key already.`)
  const index = keyAt(timeline, frame) + 1
  if (timeline.loop && index === frames.length && key.pose !== timeline.keys[0].pose)
    throw new Refusal('A loop ends with its first pose: move its last key out first.')
  let before = keysOf(timeline)[index - 1]
  // A key inside of a hold ends it.
  const gap = frame - frames[index - 1]
  if (holdOf(timeline, index - 1) > gap) before = held(timeline, before, gap)
  let added = placed(timeline, key, frame)
  const room = index < frames.length ? frames[index] - frame : kMostFrames
  if (Math.round((key.hold ?? 0) * timeline.fps) > room) added = held(timeline, added, room)
  const keys = keysOf(timeline).slice()
  keys.splice(index - 1, 1, before, added)
  return { timeline: withKeys(timeline, keys), index }
}

/** A new key; a span without in-betweens stays without. */
export function addKey(
  timeline: Timeline,
  frame: number,
  pose: string,
): { timeline: Timeline; index: number } {
  const key: Key = { pose, at: 0 }
  if (timeline.keys.length === 0) return { timeline: { ...timeline, keys: [key] }, index: 0 }
  const before = keyAt(timeline, frame)
  if (easeOf(timeline, before).name === 'stepped') key.interpolation = 'stepped'
  return insert(timeline, frame, key)
}

/** A second key with all that the first says, at the nearest free frame. */
export function copyKey(
  timeline: Timeline,
  index: number,
  frame: number,
): { timeline: Timeline; index: number } {
  return insert(timeline, freeFrame(timeline, frame), { ...timeline.keys[index] })
}

export function deleteKey(timeline: Timeline, index: number): Timeline {
  if (timeline.keys.length <= 2) throw new Refusal('An animation needs two keys.')
  const keys = keysOf(timeline).filter((_, i) => i !== index)
  const last = keys[keys.length - 1]
  if (timeline.loop && index === keys.length && last.pose !== keys[0].pose)
    throw new Refusal('A loop ends with its first pose: turn Loop off first.')
  if (index > 0) return withPinsOff(timeline, withKeys(timeline, keys), index)
  if (timeline.loop) keys[keys.length - 1] = { ...last, pose: keys[0].pose }
  // Without its first key the animation begins with the second: all move to the same start, by
  // frames, as seconds would be rounded anew.
  const frames = framesOf(timeline)
  const moved = keys.map((key, i) => placed(timeline, key, frames[i + 1] - frames[1]))
  return withPinsOff(timeline, withKeys(timeline, moved), index)
}

/** Another rate; times in seconds stay. */
export function setFps(timeline: Timeline, fps: number): Timeline {
  if (!(fps >= 1 && fps <= 120)) throw new Refusal('Frames per second go from 1 to 120.')
  const next = { ...timeline, fps }
  const frames = framesOf(next)
  const clash = frames.findIndex((frame, i) => i > 0 && frame <= frames[i - 1])
  if (clash > 0)
    throw new Refusal(`At ${fps} frames per second keys ${clash} and ${clash + 1} would meet.`)
  return next
}

/** A loop ends with its first pose; the key for it is added where it is missing. */
export function setLoop(timeline: Timeline, loop: boolean): { timeline: Timeline; added: boolean } {
  const next = { ...timeline, loop }
  const [first, last] = [timeline.keys[0], timeline.keys[timeline.keys.length - 1]]
  if (!loop || !first || first.pose === last.pose) return { timeline: next, added: false }
  const frames = framesOf(timeline)
  const gap = Math.max(1, frames[frames.length - 1] - frames[frames.length - 2])
  return { timeline: addKey(next, lengthOf(timeline) - 1 + gap, first.pose).timeline, added: true }
}

function curveOf(ease: unknown): { name: EaseName; curve: Curve } | null {
  if (typeof ease === 'string' && kCurves[ease])
    return { name: ease as EaseName, curve: kCurves[ease] }
  if (Array.isArray(ease) && ease.length === 4 && ease.every((one) => Number.isFinite(one)))
    return { name: 'custom', curve: ease as Curve }
  return null
}

/** How the span after a key runs: what the key says, else the timeline, else evenly. */
export function easeOf(timeline: Timeline, index: number): { name: EaseName; curve: Curve } {
  const key = keysOf(timeline)[index]
  const shape = curveOf(key.ease) ??
    curveOf(timeline.other.ease) ?? { name: 'linear' as const, curve: kCurves.linear }
  const travel = key.interpolation ?? timeline.other.interpolation
  const stepped = travel === 'stepped' || key.ease === 'stepped'
  return stepped ? { name: 'stepped', curve: shape.curve } : shape
}

export function setEase(timeline: Timeline, index: number, ease: EaseName | Curve): Timeline {
  let key = keysOf(timeline)[index]
  if (key.ease === 'stepped') key = withoutField(key, 'ease')
  if (ease === 'stepped') return withKey(timeline, index, { ...key, interpolation: 'stepped' })
  if (key.interpolation === 'stepped') key = withoutField(key, 'interpolation')
  if (timeline.other.interpolation === 'stepped') key = { ...key, interpolation: 'smooth' }
  if (ease === 'custom') ease = [...easeOf(timeline, index).curve]
  if (ease === 'linear' && timeline.other.ease === undefined) key = withoutField(key, 'ease')
  else key = { ...key, ease: typeof ease === 'string' ? ease : limited(ease) }
  return withKey(timeline, index, key)
}

/** A curve as the file may have it: time runs forward. */
function limited([x1, y1, x2, y2]: Curve): Curve {
  const x = (value: number) => round(clamp(value, 0, 1), 2)
  const y = (value: number) => round(clamp(value, kLowestY, kHighestY), 2)
  return [x(x1), y(y1), x(x2), y(y2)]
}

/** Frames that each picture of a span stands. */
export function stepOf(timeline: Timeline, index: number): number {
  return keysOf(timeline)[index].step ?? timeline.step
}

/** null: as the whole timeline. */
export function setStep(timeline: Timeline, index: number, step: number | null): Timeline {
  const key = keysOf(timeline)[index]
  return withKey(timeline, index, step === null ? withoutField(key, 'step') : { ...key, step })
}

const bezier = (a: number, b: number, t: number) =>
  3 * (1 - t) * (1 - t) * t * a + 3 * (1 - t) * t * t * b + t * t * t

/** Share of the way at a share of the time. x rises with t, so halving finds it. */
export function easeAt([x1, y1, x2, y2]: Curve, time: number): number {
  if (time <= 0) return 0
  if (time >= 1) return 1
  let low = 0
  let high = 1
  for (let i = 0; i < 30; ++i) {
    const middle = (low + high) / 2
    if (bezier(x1, x2, middle) < time) low = middle
    else high = middle
  }
  return bezier(y1, y2, (low + high) / 2)
}

/** The way of each frame of a span, from leaving the hold to the next key. */
export function waysOf(timeline: Timeline, index: number): number[] {
  if (index + 1 >= timeline.keys.length) return []
  const frames = framesOf(timeline)
  const count = frames[index + 1] - frames[index] - holdOf(timeline, index)
  const { name, curve } = easeOf(timeline, index)
  const step = Math.max(1, stepOf(timeline, index))
  return Array.from({ length: count }, (_, j) =>
    name === 'stepped' ? 0 : easeAt(curve, (Math.floor(j / step) * step) / count),
  )
}

/** Which made frame belongs to a frame of the ruler; they differ after a change of the rate. */
export function madeFrame(frames: Frames, fps: number, frame: number): number {
  return clamp(Math.round((frame * frames.fps) / fps), 0, frames.count - 1)
}

/** The poses whose textures show at a frame, and the share of the second, as in the film. */
export function texturesAt(frames: Frames, frame: number): [string, string, number] {
  const last = frames.poses.length - 1
  if (last < 0 || frames.times.length === 0) return ['', '', 0]
  const key = clamp(Math.floor(frames.times[frame]), 0, last)
  const next = Math.min(key + 1, last)
  return [frames.poses[key], frames.poses[next], clamp(frames.times[frame] - key, 0, 1)]
}

/** True if the made frames have the timeline's keys at their places. */
export function framesFit(timeline: Timeline, frames: Frames): boolean {
  if (frames.fps !== timeline.fps || frames.count !== lengthOf(timeline)) return false
  return framesOf(timeline).every((frame, i) => frames.keys[frame] === timeline.keys[i].pose)
}

/** An order of poses with the times at which the made frames have them. */
export function spreadOrder(timeline: Timeline, frames: Frames): Timeline {
  const starts: number[] = []
  frames.keys.forEach((pose, i) => {
    const wanted = timeline.keys[starts.length]?.pose
    if (pose !== '' && pose === wanted && frames.keys[i - 1] !== pose) starts.push(i)
  })
  if (starts.length !== timeline.keys.length) return timeline
  const keys = timeline.keys.map((key, i) => ({ ...key, at: round(starts[i] / frames.fps) }))
  return { ...timeline, keys }
}

/** "12 frames, 0.50 s" */
export function lengthText(frames: number, fps: number): string {
  return `${frames} frame${frames === 1 ? '' : 's'} · ${(frames / fps).toFixed(2)} s`
}
