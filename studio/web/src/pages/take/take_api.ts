// Requests of a take's page; docs/studio-api.md lists them.
import { ask, send } from '../../api'
import type { ArmatureView } from '../armature/armature_api'
import { framesOf } from '../armature/use_character'
import type { Take } from './take_model'

export interface OpenedTake {
  view: ArmatureView
  /** whether there is a set, and a texture */
  set: boolean
  texture: boolean
}

/** A take as changes make it, with the bones of each frame. */
export interface Draft {
  take: Take
  poses: Float32Array[]
}

/** Bytes as studio/runs/take_desk.h says. @throws Error  they are none */
export function parseDraft(bytes: ArrayBuffer, bones: number): Draft {
  const all = new Uint8Array(bytes)
  const end = all.indexOf(10)
  if (end < 0 || (end + 1) % 4 !== 0) throw new Error('The take was not read whole; try it again.')
  const take = JSON.parse(new TextDecoder().decode(all.subarray(0, end))) as Take
  return { take, poses: framesOf(bytes, end + 1, bones) }
}

export const takeApi = {
  open: (take: string) => send<OpenedTake>('POST', '/api/armature/take/open', { take }),
  /** The take with these lines done; it is not kept. */
  draft: async (take: string, edits: string[], bones: number) => {
    const answer = await ask('/api/armature/take/draft', {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ take, edits }),
    })
    return parseDraft(await answer.arrayBuffer(), bones)
  },
  save: (take: string, name: string, edits: string[]) =>
    send<{ take: string }>('POST', '/api/armature/take/save', { take, name, edits }),
}
