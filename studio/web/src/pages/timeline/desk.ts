// What the parts of the timeline page share, and small helpers of theirs.
import { useEffect, useRef, useState } from 'preact/hooks'

import type { Timeline } from '../../api'
import type { Player } from './player'
import type { Made } from './use_frames'
import type { ViewWindow } from './view_window'

export interface Desk {
  /** as shown: with a drag that is not over yet */
  timeline: Timeline
  poses: string[]
  selected: number
  select: (index: number) => void
  /** Does an edit; a Refusal is told in words. */
  edit: (change: (timeline: Timeline) => Timeline, tag?: string) => void
  /** Shows an edit without making it; null: ends that. */
  preview: (timeline: Timeline | null) => void
  /** Adds or copies a key and selects it. */
  insert: (change: (timeline: Timeline) => { timeline: Timeline; index: number }) => void
  player: Player
  made: Made | null
  view: ViewWindow
}

/** The lanes' left column [px]; timeline.css has the same. */
export const kGutter = 168

/** Muted, and told apart on both themes; names say the same, so colour is never alone. */
const kSwatches =
  '#c8643c #3f7fa6 #6d8f3d #a1589a #b98a1f #4b8f83 #8267b5 #a6616a'.split(' ')

export const swatchOf = (poses: string[], pose: string): string =>
  kSwatches[Math.max(0, poses.indexOf(pose)) % kSwatches.length]

/** Calls back at each new frame without drawing the component again. */
export function useFrame(player: Player, show: (frame: number) => void): void {
  const latest = useRef(show)
  latest.current = show
  useEffect(() => {
    latest.current(player.frame)
    return player.watch((frame) => latest.current(frame))
  }, [player])
  // What it draws on may have changed too.
  useEffect(() => latest.current(player.frame))
}

/** The playing state; draws the component again when it changes. */
export function usePlaying(player: Player): boolean {
  const [playing, setPlaying] = useState(player.playing)
  useEffect(() => player.watchState(() => setPlaying(player.playing)), [player])
  return playing
}

/** Increases when light turns to dark or back: canvases do not follow CSS by themselves. */
export function useTheme(): number {
  const [theme, setTheme] = useState(0)
  useEffect(() => {
    const changed = () => setTheme((old) => old + 1)
    const watch = new MutationObserver(changed)
    watch.observe(document.documentElement, { attributeFilter: ['data-theme'] })
    const system = matchMedia('(prefers-color-scheme: dark)')
    system.addEventListener('change', changed)
    return () => {
      watch.disconnect()
      system.removeEventListener('change', changed)
    }
  }, [])
  return theme
}

/** A canvas of its box's size in the screen's own pixels, cleared; null while it has none. */
export function clearedCanvas(canvas: HTMLCanvasElement): CanvasRenderingContext2D | null {
  const { clientWidth: width, clientHeight: height } = canvas
  if (width === 0 || height === 0) return null
  const ratio = window.devicePixelRatio
  canvas.width = Math.round(width * ratio)
  canvas.height = Math.round(height * ratio)
  const context = canvas.getContext('2d')
  context?.scale(ratio, ratio)
  return context
}
