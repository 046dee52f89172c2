// What all pages share: the project, its steps, the run under way, and short notices.
import { createContext } from 'preact'
import type { ComponentChildren } from 'preact'
import { useCallback, useContext, useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api, ApiError, events } from './api'
import type { Project, RunLine, Steps } from './api'

export interface Running {
  /** [0, 1] of the whole run */
  overall: number
  seconds_left: number | null
  /** fraction and words by step that is at work */
  steps: Record<string, { fraction: number; what: string }>
  /** steps that this run has finished, with their status */
  finished: Record<string, string>
  notes: string[]
}

interface Notice {
  id: number
  text: string
  bad: boolean
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
}

const Context = createContext<Studio | null>(null)

export function useStudio(): Studio {
  const studio = useContext(Context)
  if (!studio) throw new Error('useStudio outside of StudioState')
  return studio
}

const kNoRun: Running = { overall: 0, seconds_left: null, steps: {}, finished: {}, notes: [] }

/** The run's state after one more line. */
export function afterLine(run: Running, line: RunLine): Running {
  const next: Running = {
    ...run,
    overall: line.overall ?? run.overall,
    seconds_left: line.seconds_left ?? null,
  }
  const step = line.step
  if (line.event === 'start' && step)
    next.steps = { ...run.steps, [step]: { fraction: 0, what: 'starts' } }
  if (line.event === 'progress' && step)
    next.steps = {
      ...run.steps,
      [step]: { fraction: line.fraction ?? 0, what: line.what ?? '' },
    }
  if (line.event === 'finish' && step) {
    const { [step]: _, ...others } = run.steps
    next.steps = others
    next.finished = { ...run.finished, [step]: line.status ?? '' }
  }
  if (line.event === 'note' && line.text) next.notes = [...run.notes.slice(-50), line.text]
  return next
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

  const notice = useCallback((text: string, bad: boolean) => {
    const id = nextNotice.current++
    setNotices((old) => [...old.filter((one) => one.text !== text), { id, text, bad }].slice(-4))
    if (!bad) setTimeout(() => setNotices((old) => old.filter((one) => one.id !== id)), 5000)
  }, [])
  const tell = useCallback((text: string) => notice(text, false), [notice])
  const complain = useCallback(
    (error: unknown) => notice(error instanceof Error ? error.message : String(error), true),
    [notice],
  )
  const reload = useCallback(async () => {
    try {
      const [one, two] = await Promise.all([api.project(), api.steps()])
      setProject(one)
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
    return events((event) => {
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
      } else {
        setConnected(event.open)
        if (event.open) void reload()
      }
    })
  }, [reload, tell, complain])

  const studio = useMemo(
    () =>
      project && steps
        ? { project, steps, running, connected, tabs, version, reload, tell, complain }
        : null,
    [project, steps, running, connected, tabs, version, reload, tell, complain],
  )
  if (fatal)
    return (
      <main class="empty">
        <h2>This tab is not let in</h2>
        <p>{fatal}</p>
      </main>
    )
  return (
    <Context.Provider value={studio}>
      {studio ? children : null}
      <div class="notices" role="status" aria-live="polite">
        {notices.map((one) => (
          <div key={one.id} class={one.bad ? 'bad' : ''}>
            <span>{one.text}</span>
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
