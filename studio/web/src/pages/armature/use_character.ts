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

/** @param setup  null while there is nothing to load yet */
export function useCharacter(setup: ArmatureSetup | null): Loaded | null {
  const { complain } = useStudio()
  const [loaded, setLoaded] = useState<Loaded | null>(null)
  useEffect(() => {
    if (!setup) return undefined
    let ended = false
    const load = async () => {
      const [view, mesh, weights, set] = await Promise.all([
        armatureApi.view(),
        armatureApi.mesh(),
        armatureApi.weights(),
        setup.set ? armatureApi.set() : null,
      ])
      const body = parseMesh(mesh)
      if (ended) return
      const character = {
        mesh: body,
        weights: parseWeights(weights, body.vertices),
        set: set && parseMesh(set),
        textureUrl: setup.texture && armatureApi.textureUrl,
      }
      setLoaded({ view, character })
    }
    load().catch(complain)
    return () => {
      ended = true
    }
  }, [setup, complain])
  return loaded
}

/** The bones of all recorded frames. @param changes  another number when one was recorded */
export function useFrames(bones: number, frames: number, changes: number): Float32Array[] {
  const { complain } = useStudio()
  const [all, setAll] = useState<Float32Array[]>([])
  useEffect(() => {
    if (bones === 0) return undefined
    let ended = false
    const load = async () => {
      const bytes = await armatureApi.frames(0)
      const numbers = new Float32Array(bytes, 0, Math.floor(bytes.byteLength / 4))
      const one = kBoneNumbers * bones
      const there = Math.min(frames, Math.floor(numbers.length / one))
      const parts = Array.from({ length: there }, (_, f) =>
        numbers.subarray(f * one, (f + 1) * one),
      )
      if (!ended) setAll(parts)
    }
    load().catch(complain)
    return () => {
      ended = true
    }
  }, [bones, frames, changes, complain])
  return all
}
