// The session as the server tells it: what was before this page, then event by event; and poses.
import { useCallback, useEffect, useRef, useState } from 'preact/hooks'

import type { StudioEvent } from '../../api'
import { useStudio } from '../../state'
import { armatureApi } from './armature_api'
import type { ArmatureEvent, ArmaturePose, ArmatureStory } from './armature_api'
import { afterEnd, afterEvent, fromStory, kNoSitting } from './sitting'
import type { Sitting } from './sitting'

type Told = Extract<StudioEvent, { type: 'armature' | 'armature_ended' }>

const after = (sitting: Sitting, told: Told): Sitting =>
  told.type === 'armature'
    ? afterEvent(sitting, told.event as ArmatureEvent)
    : afterEnd(sitting, told.message)

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
  const [sitting, setSitting] = useState<Sitting | null>(null)
  const [story, setStory] = useState<ArmatureStory | null>(null)
  const [baking, setBaking] = useState(false)
  // Events may come while the story is on its way; it holds those up to its number.
  const early = useRef<Told[] | null>([])
  const latest = useRef(0)

  const load = useCallback(async () => {
    const mine = ++latest.current
    early.current ??= []
    try {
      const now = await armatureApi.story()
      if (mine !== latest.current) return
      const missed = (early.current ?? []).filter((told) => told.number > now.number)
      early.current = null
      setStory(now)
      setBaking(now.baking)
      setSitting(missed.reduce(after, fromStory(now)))
    } catch (error) {
      complain(error)
    }
  }, [complain])

  useEffect(() => {
    void load()
    return follow((event) => {
      if (event.type === 'connection' && event.open) void load()
      if (event.type === 'armature_ended') void load()
      if (event.type === 'armature_baked') {
        setBaking(false)
        if (event.exit_code === 0) tell('The frames are baked.')
        else complain(event.message)
      }
      if (event.type !== 'armature' && event.type !== 'armature_ended') return
      if (early.current) early.current.push(event)
      else setSitting((old) => after(old ?? kNoSitting, event))
    })
  }, [follow, load, tell, complain])
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
