// A session at the puppet, as the events of `keypose armature live` tell it.
import type { ArmatureEvent, ArmatureStory } from './armature_api'

/** What is wrong, or was. */
export interface Trouble {
  words: string
  do: string
}

export interface Sitting {
  running: boolean
  /** the session has its puppet; before, its weights may be computed */
  ready: boolean
  /** the frame that is recorded next */
  at: number
  frames: number
  fps: number
  step: number
  plate: number
  /** bigger with each change of a recorded frame */
  changes: number
  /** of the controller; null: it answers */
  box: Trouble | null
  /** of sensors, by the joint's name */
  sensors: Record<string, { kind: string; words: string }>
  /** why the frame that was asked for is not taken yet */
  waiting: string
  /** why the last command was not obeyed */
  refused: string
  /** what may be wrong with the puppet's files */
  warning: string
  /** what the session said when it failed */
  failure: string
}

export const kNoSitting: Sitting = {
  running: false,
  ready: false,
  at: 0,
  frames: 0,
  fps: 24,
  step: 2,
  plate: 0,
  changes: 0,
  box: null,
  sensors: {},
  waiting: '',
  refused: '',
  warning: '',
  failure: '',
}

/** Kinds of sensor faults in a word or two. */
const kSensorKinds: Record<string, string> = {
  'sensor-jumped': 'jumped',
  'sensor-lost-count': 'lost count',
  'sensor-no-signal': 'no signal',
  'still-joint': 'stuck?',
}

const textOf = (value: unknown): string => (typeof value === 'string' ? value : '')
const numberOf = (value: unknown, otherwise: number): number =>
  typeof value === 'number' ? value : otherwise

function without<T>(all: Record<string, T>, name: string): Record<string, T> {
  return Object.fromEntries(Object.entries(all).filter(([key]) => key !== name))
}

function afterSensor(old: Sitting, event: ArmatureEvent): Sitting {
  const joint = textOf(event.joint)
  const kind = kSensorKinds[event.event]
  if (!kind) return { ...old, sensors: without(old.sensors, joint) }
  const words = [textOf(event.words), textOf(event.what_to_do)].filter(Boolean).join('. ')
  return { ...old, sensors: { ...old.sensors, [joint]: { kind, words } } }
}

export function afterEvent(before: Sitting, event: ArmatureEvent): Sitting {
  const old = { ...before, running: true, refused: '' }
  const place = {
    at: numberOf(event.at, old.at),
    frames: numberOf(event.frames, old.frames),
  }
  switch (event.event) {
    case 'session':
      return {
        ...old,
        ...place,
        ready: true,
        fps: numberOf(event.fps, old.fps),
        step: numberOf(event.step, old.step),
        changes: old.changes + 1,
      }
    case 'at':
      return { ...old, ...place, waiting: '', changes: old.changes + 1 }
    case 'recorded': {
      const at = numberOf(event.frame, old.at) + 1
      return { ...old, ...place, at, waiting: '', box: null, changes: old.changes + 1 }
    }
    case 'plate':
      return { ...old, plate: numberOf(event.plate, old.plate) }
    case 'waiting':
      return { ...old, waiting: textOf(event.words) }
    case 'refused':
      return { ...old, refused: textOf(event.words) }
    case 'warning':
      return { ...old, warning: textOf(event.words) }
    case 'cable-back':
      return { ...old, box: null }
    case 'cable-out':
    case 'silent':
    case 'power-lost':
      return { ...old, box: { words: textOf(event.words), do: textOf(event.what_to_do) } }
    case 'sensor-back':
    case 'set':
    case 'sensor-jumped':
    case 'sensor-lost-count':
    case 'sensor-no-signal':
    case 'still-joint':
      return afterSensor(old, event)
    default:
      return old
  }
}

export const afterEnd = (old: Sitting, message: string): Sitting => ({
  ...old,
  running: false,
  ready: false,
  failure: message,
})

export function fromStory(story: ArmatureStory): Sitting {
  const told = story.events.reduce(afterEvent, kNoSitting)
  return { ...told, running: story.running, failure: story.running ? '' : story.message }
}

/** The plate that is behind a recorded frame. */
export const plateOf = (frame: number, step: number, plates: number): number =>
  Math.max(0, Math.min(frame * step, plates - 1))
