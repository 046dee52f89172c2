// Requests of the armature page; docs/studio-api.md lists them.
import { ask, get, send } from '../../api'
import { sentence } from '../../words'

/** `warnings`: what baking has said, a line each. */
export const bakedWords = (warnings: string): string =>
  ['The frames are baked.', ...warnings.split('\n').map(sentence)].filter((one) => one).join(' ')

/** Files are named from the project's folder; '' is not given. */
export interface ArmatureSetup {
  take: string
  /** a device, or 'simulated' */
  port: string
  calibration: string
  description: string
  chains: string
  skeleton: string
  mesh: string
  weights: string
  texture: string
  plate: string
  shot: string
  set: string
  /** 'y' or 'z': which way is up in the description, and in the skeleton's file */
  armature_up: string
  skeleton_up: string
  fps: number
  /** frames of the film for each recorded one */
  step: number
}

/** One event of `keypose armature live`. */
export interface ArmatureEvent {
  event: string
  [field: string]: unknown
}

export interface ArmatureStory {
  running: boolean
  baking: boolean
  /** of the last event */
  number: number
  events: ArmatureEvent[]
  exit_code: number
  /** what the last session said when it failed, or '' */
  message: string
  ports: { path: string; name: string }[]
  /** of the last session in this project */
  setup: ArmatureSetup | null
  /** below the folder 'armature' */
  files: string[]
  takes: string[]
  /** takes that were edited: recording does not go on with them */
  edited: string[]
}

/** A camera as in core/values/camera.h; motions are w x y z of the turn, then the shift. */
export interface PlateCamera {
  width: number
  height: number
  fx: number
  fy: number
  cx: number
  cy: number
  k1: number
  k2: number
  p1: number
  p2: number
  camera_from_world: number[]
  world_from_character: number[]
  scale: number
}

export interface ArmatureView {
  bones: number
  vertices: number
  sensors: { name: string; unit: string }[]
  /** exact: its joints have the puppet's angles, one to one */
  chains: { name: string; exact: boolean }[]
  plate_count: number
  /** empty: there is no plate */
  pictures: string[]
  views: PlateCamera[]
}

export interface ArmaturePose {
  pose: number
  time: number
  fresh: boolean
  repeats: number
  damaged: number
  /** 7 numbers a bone */
  bones: number[]
  /** of the sensors, in their units */
  values: number[]
  /** sensors whose counter jumped */
  held: number[]
  /** how often each sensor's counter has wrapped */
  wraps: number[]
  /** near gap, far gap, mean distance from the curve, over the chain's length */
  chains: [number, number, number][]
}

const bytesOf = async (path: string) => (await ask(`/api/armature/${path}`)).arrayBuffer()

/** Of the session, if no take is named. */
const ofTake = (take: string, more: Record<string, string> = {}) => {
  const query = new URLSearchParams(take ? { ...more, take } : more).toString()
  return query ? `?${query}` : ''
}

export const armatureApi = {
  story: () => get<ArmatureStory>('/api/armature'),
  example: () => send<ArmatureSetup>('POST', '/api/armature/example', {}),
  start: (setup: ArmatureSetup) => send<object>('POST', '/api/armature/start', setup),
  tell: (command: { command: string; frame?: number; joint?: string }) =>
    send<object>('POST', '/api/armature/command', command),
  interrupt: () => send<object>('POST', '/api/armature/interrupt', {}),
  /** Of the last session's take, if none is named. */
  bake: (between: string, take?: string) =>
    send<object>('POST', '/api/armature/bake', { between, take }),
  /** Waits for one that is not number `after`; null after a second without one. */
  pose: (after: number) =>
    get<{ number: number; pose: ArmaturePose } | null>(`/api/armature/pose?after=${after}`),
  view: () => get<ArmatureView>('/api/armature/view'),
  weights: (take = '') => bytesOf(`weights${ofTake(take)}`),
  mesh: (take = '') => bytesOf(`mesh${ofTake(take)}`),
  set: (take = '') => bytesOf(`mesh${ofTake(take, { what: 'set' })}`),
  /** All recorded frames from a byte on. */
  frames: (from: number) => bytesOf(`frames?from=${from}`),
  textureUrl: (take = '') => `/api/armature/texture${ofTake(take)}`,
  /** `session` is another number for each session, as its plates may be other ones. */
  plateUrl: (index: number, session: number, take = '') =>
    `/api/armature/plate${ofTake(take, { index: String(index), session: String(session) })}`,
}
