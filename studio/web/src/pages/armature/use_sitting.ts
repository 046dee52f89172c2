// The session of the Armature page, its poses and its bakes.
import { useEffect, useRef, useState } from 'preact/hooks'

import type { StudioEvent } from '../../api'
import { useStudio } from '../../state'
import { useToldSession } from '../../use_told_session'
import type { ToldBy } from '../../use_told_session'
import { armatureApi, bakedWords } from './armature_api'
import type { ArmatureEvent, ArmaturePose, ArmatureStory } from './armature_api'
import { afterEnd, afterEvent, fromStory, kNoSitting } from './sitting'
import type { Sitting } from './sitting'

type Told = Extract<StudioEvent, { type: 'armature' | 'armature_ended' }>

const kToldBy: ToldBy<Sitting, ArmatureStory, Told> = {
  ask: () => armatureApi.story(),
  isTold: (event): event is Told => event.type === 'armature' || event.type === 'armature_ended',
  start: kNoSitting,
  fromStory,
  after: (sitting, told) =>
    told.type === 'armature'
      ? afterEvent(sitting, told.event as ArmatureEvent)
      : afterEnd(sitting, told.message),
}

export interface AtPuppet {
  /** null: not known yet */
  sitting: Sitting | null
  story: ArmatureStory | null
  baking: boolean
  setBaking: (baking: boolean) => void
  load: () => Promise<void>
}

export function useSitting(): AtPuppet {
  const { follow, complain, tell } = useStudio()
  const { session: sitting, story, load } = useToldSession(kToldBy)
  const [baking, setBaking] = useState(false)

  useEffect(() => setBaking(story?.baking ?? false), [story])
  useEffect(
    () =>
      follow((event) => {
        if (event.type === 'armature_ended') void load()
        if (event.type !== 'armature_baked') return
        setBaking(false)
        if (event.exit_code === 0) tell(bakedWords(event.message))
        else complain(event.message)
      }),
    [follow, load, tell, complain],
  )
  return { sitting, story, baking, setBaking, load }
}

/** Calls `use` with each new pose, as fast as it can be shown, while `on`. */
export function usePoses(on: boolean, use: (pose: ArmaturePose) => void): void {
  const latest = useRef(use)
  latest.current = use
  useEffect(() => {
    if (!on) return undefined
    let ended = false
    const go = async () => {
      let number = 0
      while (!ended) {
        try {
          const next = await armatureApi.pose(number)
          if (ended) return
          if (next) {
            number = next.number
            latest.current(next.pose)
          }
          // The browser draws, then asks again.
          await new Promise((done) => setTimeout(done, 12))
        } catch {
          await new Promise((done) => setTimeout(done, 1000))
        }
      }
    }
    void go()
    return () => {
      ended = true
    }
  }, [on])
}
