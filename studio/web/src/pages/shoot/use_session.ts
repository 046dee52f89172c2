// The session as the server tells it: what was before this page, then event by event.
import { useCallback, useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../../api'
import type { ShootStory, StudioEvent } from '../../api'
import { useStudio } from '../../state'
import { afterEnd, afterEvent, fromStory, kNoSession } from './session'
import type { Session } from './session'

type Told = Extract<StudioEvent, { type: 'shoot' | 'shoot_ended' }>

function after(session: Session, told: Told): Session {
  if (told.type === 'shoot') return afterEvent({ ...session, running: true }, told.event)
  return afterEnd(session, told.message)
}

export interface Shooting {
  /** null: not known yet */
  session: Session | null
  story: ShootStory | null
  /** asks the server again; after a start, as the new session's events begin anew */
  load: () => Promise<void>
}

export function useSession(): Shooting {
  const { follow, complain } = useStudio()
  const [session, setSession] = useState<Session | null>(null)
  const [story, setStory] = useState<ShootStory | null>(null)
  // Events may come while the story is on its way; it holds those up to its number.
  const early = useRef<Told[] | null>([])
  const latest = useRef(0)

  const load = useCallback(async () => {
    const mine = ++latest.current
    early.current ??= []
    try {
      const now = await api.shoot()
      if (mine !== latest.current) return
      const missed = (early.current ?? []).filter((told) => told.number > now.number)
      early.current = null
      setStory(now)
      setSession(missed.reduce(after, fromStory(now)))
    } catch (error) {
      complain(error)
    }
  }, [complain])

  useEffect(() => {
    void load()
    return follow((event) => {
      if (event.type === 'connection' && event.open) void load()
      if (event.type !== 'shoot' && event.type !== 'shoot_ended') return
      if (early.current) early.current.push(event)
      else setSession((old) => after(old ?? kNoSession, event))
    })
  }, [follow, load])
  return { session, story, load }
}
