// The lanes' window: its width, zoom by wheel and buttons, and following the playhead.
import { useCallback, useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { kGutter } from './desk'
import type { Player } from './player'
import { windowFor } from './view_window'
import type { ViewWindow } from './view_window'

const kMostZoom = 200

export interface Zooming {
  view: ViewWindow
  zoom: number
  /** Keeps the frame in place that is at `x` of the lanes; without it, the playhead. */
  setZoom: (zoom: number, x?: number) => void
  setStart: (frame: number) => void
  /** for the box that has gutter and lanes */
  box: { current: HTMLDivElement | null }
}

export function useViewWindow(total: number, player: Player): Zooming {
  const box = useRef<HTMLDivElement>(null)
  const [width, setWidth] = useState(0)
  const [{ zoom, start }, setPlace] = useState({ zoom: 1, start: 0 })
  const view = useMemo(() => windowFor(width, total, zoom, start), [width, total, zoom, start])
  const latest = useRef({ view, zoom })
  latest.current = { view, zoom }

  const setStart = useCallback((frame: number) => {
    const { view: now } = latest.current
    const next = windowFor(now.width, now.total, latest.current.zoom, frame).start
    setPlace((old) => (old.start === next ? old : { ...old, start: next }))
  }, [])
  const setZoom = useCallback(
    (wanted: number, x?: number) => {
      const { view: now } = latest.current
      const next = Math.min(kMostZoom, Math.max(1, wanted))
      const at = x ?? (player.frame + 0.5 - now.start) * now.scale
      const scale = windowFor(now.width, now.total, next, 0).scale
      const moved = now.start + at / now.scale - at / scale
      setPlace({ zoom: next, start: windowFor(now.width, now.total, next, moved).start })
    },
    [player],
  )
  useEffect(() => {
    const element = box.current
    if (!element) return
    const measure = () => setWidth(Math.max(0, element.clientWidth - kGutter))
    const watch = new ResizeObserver(measure)
    watch.observe(element)
    measure()
    const wheel = (event: WheelEvent) => {
      const { view: now, zoom: old } = latest.current
      const x = event.clientX - element.getBoundingClientRect().left - kGutter
      event.preventDefault()
      if (event.ctrlKey) return setZoom(old * Math.exp(-event.deltaY / 300), Math.max(0, x))
      const by = Math.abs(event.deltaX) > Math.abs(event.deltaY) ? event.deltaX : event.deltaY
      setStart(now.start + by / now.scale)
    }
    element.addEventListener('wheel', wheel, { passive: false })
    return () => {
      watch.disconnect()
      element.removeEventListener('wheel', wheel)
    }
  }, [setStart, setZoom])
  // A playhead that leaves the window turns the page.
  useEffect(
    () =>
      player.watch((frame) => {
        const { view: now } = latest.current
        const shown = now.width / now.scale
        if (frame < now.start || frame > now.start + shown - 1) setStart(frame - 0.05 * shown)
      }),
    [player, setStart],
  )
  return { view, zoom, setZoom, setStart, box }
}
