// What a session's page loads once: the mesh with its weights, the set, the cameras; and the
// recorded frames, whenever one has changed.
import { useEffect, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { parseMesh } from '../../view/mesh_data'
import { armatureApi } from './armature_api'
import type { ArmatureSetup, ArmatureView } from './armature_api'
import type { Character } from './puppet_view'
import { kBoneNumbers, parseWeights } from './skin'

export interface Loaded {
  view: ArmatureView
  character: Character
}

/** @param has  what there is besides the mesh @param take  none: the session's */
export async function loadCharacter(
  has: { set: boolean; texture: boolean },
  take = '',
): Promise<Character> {
  const [mesh, weights, set] = await Promise.all([
    armatureApi.mesh(take),
    armatureApi.weights(take),
    has.set ? armatureApi.set(take) : null,
  ])
  const body = parseMesh(mesh)
  return {
    mesh: body,
    weights: parseWeights(weights, body.vertices),
    set: set && parseMesh(set),
    textureUrl: has.texture ? armatureApi.textureUrl(take) : '',
  }
}

/** @param setup  null while there is nothing to load yet */
export function useCharacter(setup: ArmatureSetup | null): Loaded | null {
  const { complain } = useStudio()
  const [loaded, setLoaded] = useState<Loaded | null>(null)
  useEffect(() => {
    if (!setup) return undefined
    let ended = false
    const load = async () => {
      const has = { set: setup.set !== '', texture: setup.texture !== '' }
      const [view, character] = await Promise.all([armatureApi.view(), loadCharacter(has)])
      if (!ended) setLoaded({ view, character })
    }
    load().catch(complain)
    return () => {
      ended = true
    }
  }, [setup, complain])
  return loaded
}

/** The bones of each frame, of bytes as `frames.bin` has them. */
export function framesOf(bytes: ArrayBuffer, from: number, bones: number): Float32Array[] {
  const numbers = new Float32Array(bytes, from, Math.floor((bytes.byteLength - from) / 4))
  const one = kBoneNumbers * bones
  return Array.from({ length: Math.floor(numbers.length / one) }, (_, f) =>
    numbers.subarray(f * one, (f + 1) * one),
  )
}

/** The bones of all recorded frames. @param changes  another number when one was recorded */
export function useFrames(bones: number, frames: number, changes: number): Float32Array[] {
  const { complain } = useStudio()
  const [all, setAll] = useState<Float32Array[]>([])
  useEffect(() => {
    if (bones === 0) return undefined
    let ended = false
    const load = async () => {
      const parts = framesOf(await armatureApi.frames(0), 0, bones)
      if (!ended) setAll(parts.slice(0, frames))
    }
    load().catch(complain)
    return () => {
      ended = true
    }
  }, [bones, frames, changes, complain])
  return all
}
