// What all pages share: the project, its steps, the run under way, and short notices.
import { createContext } from 'preact'
import type { ComponentChildren } from 'preact'
import { useCallback, useContext, useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api, ApiError, events, wasMoved } from './api'
import type { Project, Steps, StudioEvent } from './api'
import { afterLine, kNoRun } from './run_lines'
import type { Running } from './run_lines'
import { frontOf, shownFront } from './view/front'

interface Notice {
  id: number
  text: string
  bad: boolean
  /** said because the studio did not answer; goes when it does */
  away: boolean
}

export interface Studio {
  project: Project
  steps: Steps
  /** null: no run is at work */
  running: Running | null
  connected: boolean
  /** number of tabs that have this project open */
  tabs: number
  /** increases with every change of the project's files or results; for effects that load again */
  version: number
  reload: () => Promise<void>
  tell: (text: string) => void
  /** Shows an error in words. */
  complain: (error: unknown) => void
  /** Calls `listen` with all that the server tells, until the returned function is called. */
  follow: (listen: (event: StudioEvent) => void) => () => void
}

const Context = createContext<Studio | null>(null)

export function useStudio(): Studio {
  const studio = useContext(Context)
  if (!studio) throw new Error('useStudio outside of StudioState')
  return studio
}

/** As in index.html, which shows before this program runs. */
export function Waiting() {
  return (
    <header class="top">
      <div class="brand">Keypose</div>
    </header>
  )
}

export function StudioState({ children }: { children: ComponentChildren }) {
  const [project, setProject] = useState<Project | null>(null)
  const [steps, setSteps] = useState<Steps | null>(null)
  const [running, setRunning] = useState<Running | null>(null)
  const [connected, setConnected] = useState(true)
  const [tabs, setTabs] = useState(1)
  const [version, setVersion] = useState(0)
  const [notices, setNotices] = useState<Notice[]>([])
  const [fatal, setFatal] = useState('')
  const nextNotice = useRef(1)
  const followers = useRef(new Set<(event: StudioEvent) => void>())
  const follow = useCallback((listen: (event: StudioEvent) => void) => {
    followers.current.add(listen)
    return () => void followers.current.delete(listen)
  }, [])

  const notice = useCallback((text: string, bad: boolean, away = false) => {
    const id = nextNotice.current++
    const added: Notice = { id, text, bad, away }
    // Good news take the place of older ones: they have one line, and none of it is lost work.
    const stays = (one: Notice) => one.text !== text && (bad || one.bad)
    setNotices((old) => [...old.filter(stays), added].slice(-4))
    if (!bad) setTimeout(() => setNotices((old) => old.filter((one) => one.id !== id)), 5000)
  }, [])
  const tell = useCallback((text: string) => notice(text, false), [notice])
  const complain = useCallback(
    (error: unknown) => {
      const away = error instanceof ApiError && error.status === 0
      notice(error instanceof Error ? error.message : String(error), true, away)
    },
    [notice],
  )
  const reload = useCallback(async () => {
    try {
      const [one, two] = await Promise.all([api.project(), api.steps()])
      setProject(one)
      shownFront.degrees = frontOf(two)
      setSteps(two)
      setRunning((old) => (two.running ? (old ?? kNoRun) : null))
      setVersion((old) => old + 1)
      setFatal('')
    } catch (error) {
      if (error instanceof ApiError && error.status === 403) setFatal(error.message)
      else complain(error)
    }
  }, [complain])

  useEffect(() => {
    void reload()
    if (wasMoved())
      complain(new Error('Another tab has opened another project: this tab shows that one now.'))
    return events((event) => {
      for (const listen of followers.current) listen(event)
      if (event.type === 'run') {
        setRunning((old) => afterLine(old ?? kNoRun, event.line))
        if (event.line.event === 'finish') void reload()
      } else if (event.type === 'run_ended') {
        setRunning(null)
        if (event.exit_code === 0) tell('The run is done.')
        else if (event.exit_code !== 130) complain(event.message)
        void reload()
      } else if (event.type === 'project') {
        void reload()
      } else if (event.type === 'writers') {
        setTabs(event.count)
      } else if (event.type === 'connection') {
        setConnected(event.open)
        if (!event.open) return
        setNotices((old) => old.filter((one) => !one.away))
        void reload()
      }
    })
  }, [reload, tell, complain])

  const studio = useMemo(
    () =>
      project && steps
        ? { project, steps, running, connected, tabs, version, reload, tell, complain, follow }
        : null,
    [project, steps, running, connected, tabs, version, reload, tell, complain, follow],
  )
  if (fatal)
    return (
      <main class="empty">
        <h1>This tab is not let in</h1>
        <p>{fatal}</p>
      </main>
    )
  return (
    <Context.Provider value={studio}>
      {studio ? children : <Waiting />}
      <div class="notices" role="status" aria-live="polite">
        {notices.map((one) => (
          <div key={one.id} class={one.bad ? 'bad' : ''}>
            <span title={one.bad ? undefined : one.text}>{one.text}</span>
            <button
              class="quiet"
              aria-label="Dismiss"
              onClick={() => setNotices((old) => old.filter((other) => other.id !== one.id))}
            >
              ×
            </button>
          </div>
        ))}
      </div>
    </Context.Provider>
  )
}
