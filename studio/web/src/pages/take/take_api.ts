// Requests of a take's page; docs/studio-api.md lists them.
import { ask, get, send } from '../../api'
import type { ArmatureSetup, ArmatureView } from '../armature/armature_api'
import { kBoneNumbers } from '../armature/skin'
import { framesOfTake, isFilmed } from './take_model'
import type { Between, Take } from './take_model'

export interface OpenedTake {
  view: ArmatureView
  /** whether there is a set, and a texture */
  set: boolean
  texture: boolean
}

/** A take as changes make it. */
export interface Draft {
  take: Take
  /** the bones of each recorded frame */
  poses: Float32Array[]
  /** the bones of each frame of the film as it would be baked; empty: frames are held */
  film: Float32Array[]
  /** the values of all joints in these, frame after frame */
  filmValues: Float32Array
}

/** Bytes as studio/runs/take_desk.h says. @throws Error  they are none */
export function parseDraft(bytes: ArrayBuffer, bones: number): Draft {
  const all = new Uint8Array(bytes)
  const end = all.indexOf(10)
  if (end < 0 || (end + 1) % 4 !== 0) throw new Error('The take was not read whole; try it again.')
  const take = JSON.parse(new TextDecoder().decode(all.subarray(0, end))) as Take
  const one = kBoneNumbers * bones
  const [recorded, film, joints] = [framesOfTake(take), take.film, take.joints.length]
  const numbers = new Float32Array(bytes, end + 1, Math.floor((bytes.byteLength - end - 1) / 4))
  if (numbers.length !== (recorded + film) * one + film * joints)
    throw new Error('The take was not read whole; try it again.')
  const poses = Array.from({ length: recorded + film }, (_, f) =>
    numbers.subarray(f * one, (f + 1) * one),
  )
  return {
    take,
    poses: poses.slice(0, recorded),
    film: poses.slice(recorded),
    filmValues: numbers.subarray((recorded + film) * one),
  }
}

/** What a baked take can be in the project. */
export type Use = 'export' | 'composite'

/** The take's part in pipeline.yaml. */
export interface TakeUse {
  revision: string
  /** its frames are there */
  baked: boolean
  /** … but the take has changed since */
  stale: boolean
  uses: Record<Use, { step: string; out: string; used: boolean; lack: string }>
}

export const takeApi = {
  /** `setup`: other files than those that are known */
  open: (take: string, setup?: ArmatureSetup) =>
    send<OpenedTake>('POST', '/api/armature/take/open', { take, setup }),
  /** The files that it is shown with. */
  setup: (take: string) =>
    get<ArmatureSetup>(`/api/armature/take/setup?${new URLSearchParams({ take })}`),
  /** The take with these lines done; it is not kept. */
  draft: async (take: string, edits: string[], between: Between, bones: number) => {
    const answer = await ask('/api/armature/take/draft', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ take, edits, between: isFilmed(between) ? between : '' }),
    })
    return parseDraft(await answer.arrayBuffer(), bones)
  },
  use: (take: string) =>
    get<TakeUse>(`/api/armature/take/use?${new URLSearchParams({ take })}`),
  setUse: (take: string, use: Use, used: boolean, revision: string) =>
    send<TakeUse>('PUT', '/api/armature/take/use', { take, use, used, revision }),
  save: (take: string, name: string, edits: string[]) =>
    send<{ take: string }>('POST', '/api/armature/take/save', { take, name, edits }),
}
