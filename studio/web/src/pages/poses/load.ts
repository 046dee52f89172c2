// Loading for components, and when a pose's results have changed.
import { useEffect, useRef, useState } from 'preact/hooks'

import { ApiError } from '../../api'
import type { Steps } from '../../api'

export interface Loaded<T> {
  value: T | null
  /** the server's words, or '' */
  error: string
  /** true: the server has no such thing yet */
  missing: boolean
  loading: boolean
}

/** Loads when `keys` change. The old value stays until the new one is there. */
export function useLoaded<T>(load: () => Promise<T>, keys: unknown[]): Loaded<T> {
  const [state, setState] = useState<Loaded<T>>({
    value: null,
    error: '',
    missing: false,
    loading: true,
  })
  const latest = useRef(0)
  useEffect(() => {
    const mine = ++latest.current
    const set = (change: Partial<Loaded<T>>) => {
      if (mine === latest.current) setState((old) => ({ ...old, loading: false, ...change }))
    }
    setState((old) => ({ ...old, loading: true }))
    load().then(
      (value) => set({ value, error: '', missing: false }),
      (error: unknown) =>
        set({
          value: null,
          error: error instanceof Error ? error.message : String(error),
          missing: error instanceof ApiError && error.status === 404,
        }),
    )
    return () => void ++latest.current
  }, keys)
  return state
}

/** Changes when a step of the pose was made anew; meshes are too large to load at each event. */
export function resultsOf(steps: Steps, pose: string): string {
  return steps.steps
    .filter((step) => step.pose === pose)
    .map((step) => `${step.id}:${step.state === 'done' ? step.seconds : step.state}`)
    .join(' ')
}

/** The size of an element, as it changes. */
export function useSize<E extends HTMLElement>() {
  const element = useRef<E>(null)
  const [size, setSize] = useState({ width: 0, height: 0 })
  useEffect(() => {
    const read = () =>
      setSize({ width: element.current!.clientWidth, height: element.current!.clientHeight })
    const observer = new ResizeObserver(read)
    observer.observe(element.current!)
    read()
    return () => observer.disconnect()
  }, [])
  return { element, size }
}
