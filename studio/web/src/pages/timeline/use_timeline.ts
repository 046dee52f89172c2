// The project's timeline while it is edited: undo, redo, and saving a moment after each change.
import { useCallback, useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import type { Frames, Timeline } from '../../api'
import { useStudio } from '../../state'
import { useUnsavedGuard } from '../poses/route'
import { framesFit, spreadOrder } from './timeline_model'

const kSaveAfterMs = 400
/** Changes of one kind within this time are undone together. */
const kOneChangeMs = 900
const kMostUndo = 200
/** A server that is away is asked again after this time. */
const kAskAgainMs = 3000

export type Saving = 'saved' | 'waiting' | 'saving' | 'failed'

export interface Editing {
  timeline: Timeline
  /** true: pipeline.yaml has only an order of poses */
  order: boolean
  saving: Saving
  canUndo: boolean
  canRedo: boolean
  /** `tag`: changes of the same tag in quick succession are one for undo. */
  commit: (next: Timeline, tag?: string) => void
  undo: () => void
  redo: () => void
  /** Saves what waits; false if the server refused. */
  flush: () => Promise<boolean>
}

interface State {
  timeline: Timeline
  order: boolean
  past: Timeline[]
  future: Timeline[]
}

const fresh = (timeline: Timeline): State => ({
  timeline,
  order: timeline.keys.length > 1 && !timeline.timed,
  past: [],
  future: [],
})

const sameKeys = (a: Timeline, b: Timeline) =>
  JSON.stringify({ ...a, revision: '', timed: true }) ===
  JSON.stringify({ ...b, revision: '', timed: true })

/** Saves the newest state; asks again as long as changes come in meanwhile. */
class Saver {
  revision = ''
  wanted: Timeline | null = null
  /** what the server made of the last save */
  answer: Timeline | null = null
  private timer = 0
  private busy: Promise<boolean> | null = null
  onState: (saving: Saving) => void = () => undefined
  onError: (error: unknown) => void = () => undefined

  get dirty(): boolean {
    return this.wanted !== null || this.busy !== null
  }

  later(timeline: Timeline): void {
    this.wanted = timeline
    this.onState('waiting')
    clearTimeout(this.timer)
    this.timer = window.setTimeout(() => void this.flush(), kSaveAfterMs)
  }

  /** Gives up what waits; the file has changed under it. */
  forget(): void {
    clearTimeout(this.timer)
    this.wanted = null
  }

  flush(): Promise<boolean> {
    clearTimeout(this.timer)
    this.busy ??= this.save().finally(() => (this.busy = null))
    return this.busy
  }

  private async save(): Promise<boolean> {
    while (this.wanted) {
      const timeline = this.wanted
      this.onState('saving')
      try {
        const answer = await api.saveTimeline({ ...timeline, revision: this.revision })
        this.revision = answer.revision
        this.answer = answer
      } catch (error) {
        this.onState('failed')
        this.onError(error)
        const away = error instanceof ApiError && error.status === 0
        if (away) this.timer = window.setTimeout(() => void this.flush(), kAskAgainMs)
        return false
      }
      if (this.wanted === timeline) this.wanted = null
    }
    this.onState('saved')
    return true
  }
}

/** null: not read yet, or not readable. */
export function useTimeline(frames: Frames | null): Editing | null {
  const { version, connected, tell, complain } = useStudio()
  const [state, setState] = useState<State | null>(null)
  const [saving, setSaving] = useState<Saving>('saved')
  const saver = useMemo(() => new Saver(), [])
  const lastChange = useRef({ tag: '', time: 0 })

  const adopt = useCallback(
    (read: Timeline) => {
      saver.revision = read.revision
      // Our own save, read back, is no news: what can be undone stays.
      const ours = saver.answer !== null && sameKeys(saver.answer, read)
      setState((old) => (old && (ours || sameKeys(old.timeline, read)) ? old : fresh(read)))
      setSaving('saved')
    },
    [saver],
  )
  const load = useCallback(async () => {
    if (saver.dirty) return
    const before = saver.answer
    try {
      const read = await api.timeline()
      // A save may have overtaken this answer; what it brought is newer.
      if (!saver.dirty && saver.answer === before) adopt(read)
    } catch (error) {
      complain(error)
    }
  }, [saver, adopt, complain])

  saver.onState = setSaving
  saver.onError = (error) => {
    if (!(error instanceof ApiError) || error.status !== 409) return complain(error)
    saver.forget()
    tell('The timeline was changed elsewhere and was read again; your last change is not in it.')
    void api.timeline().then(adopt, complain)
  }
  useEffect(() => void load(), [load, version])
  // A server that comes back gets what it has missed.
  useEffect(() => {
    if (connected && saver.wanted) void saver.flush()
  }, [connected, saver])
  useEffect(() => {
    const leave = () => void saver.flush()
    addEventListener('pagehide', leave)
    return () => {
      removeEventListener('pagehide', leave)
      leave()
    }
  }, [saver])

  useUnsavedGuard(saving === 'failed')

  // An order of poses is shown with the times that its frames have; it becomes times when edited.
  const order = state !== null && state.order && !(frames && framesFit(state.timeline, frames))
  const timeline = useMemo(
    () => (state && order && frames ? spreadOrder(state.timeline, frames) : state?.timeline),
    [state, order, frames],
  )

  const commit = useCallback(
    (next: Timeline, tag = '') => {
      if (!timeline || next === timeline) return
      const time = performance.now()
      const last = lastChange.current
      const together = tag !== '' && tag === last.tag && time - last.time < kOneChangeMs
      lastChange.current = { tag, time }
      setState((old) => {
        if (!old) return old
        const past = together ? old.past : [...old.past, timeline].slice(-kMostUndo)
        return { timeline: next, order: false, past, future: [] }
      })
      saver.later(next)
    },
    [timeline, saver],
  )
  const step = useCallback(
    (from: 'past' | 'future', to: 'past' | 'future') => {
      if (!state || !timeline || state[from].length === 0) return
      lastChange.current.tag = ''
      const next = state[from][state[from].length - 1]
      const changed = { [from]: state[from].slice(0, -1), [to]: [...state[to], timeline] }
      setState({ ...state, ...changed, timeline: next, order: false })
      saver.later(next)
    },
    [state, timeline, saver],
  )
  const undo = useCallback(() => step('past', 'future'), [step])
  const redo = useCallback(() => step('future', 'past'), [step])
  const flush = useCallback(() => saver.flush(), [saver])

  if (!state || !timeline) return null
  return {
    timeline,
    order,
    saving,
    canUndo: state.past.length > 0,
    canRedo: state.future.length > 0,
    commit,
    undo,
    redo,
    flush,
  }
}
