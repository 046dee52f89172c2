// A session as the server tells it: what was before this page, then event by event.
import { useCallback, useEffect, useRef, useState } from 'preact/hooks'

import type { StudioEvent } from './api'
import { useStudio } from './state'

type Numbered = Extract<StudioEvent, { number: number }>

/** How a kind of session is asked for and followed. One that stays the same object. */
export interface ToldBy<Session, Story extends { number: number }, Told extends Numbered> {
  ask: () => Promise<Story>
  isTold: (event: StudioEvent) => event is Told
  start: Session
  fromStory: (story: Story) => Session
  after: (session: Session, told: Told) => Session
}

export interface ToldSession<Session, Story> {
  /** null: not known yet */
  session: Session | null
  story: Story | null
  /** asks the server again; after a start, as the new session's events begin anew */
  load: () => Promise<void>
}

export function useToldSession<Session, Story extends { number: number }, Told extends Numbered>(
  by: ToldBy<Session, Story, Told>,
): ToldSession<Session, Story> {
  const { follow, complain } = useStudio()
  const [session, setSession] = useState<Session | null>(null)
  const [story, setStory] = useState<Story | null>(null)
  // Events may come while the story is on its way; it holds those up to its number.
  const early = useRef<Told[] | null>([])
  const latest = useRef(0)

  const load = useCallback(async () => {
    const mine = ++latest.current
    early.current ??= []
    try {
      const now = await by.ask()
      if (mine !== latest.current) return
      const missed = (early.current ?? []).filter((told) => told.number > now.number)
      early.current = null
      setStory(now)
      setSession(missed.reduce(by.after, by.fromStory(now)))
    } catch (error) {
      complain(error)
    }
  }, [by, complain])

  useEffect(() => {
    void load()
    return follow((event) => {
      if (event.type === 'connection' && event.open) void load()
      if (!by.isTold(event)) return
      if (early.current) early.current.push(event)
      else setSession((old) => by.after(old ?? by.start, event))
    })
  }, [by, follow, load])
  return { session, story, load }
}
