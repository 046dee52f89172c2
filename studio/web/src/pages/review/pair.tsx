// Two things in one place: beside each other, with an edge between them, or their difference.
import type { ComponentChildren } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

import { Edge } from '../poses/wipe'

export type Mode = 'side' | 'slider' | 'difference' | 'distance'

/** How many times brighter a difference is shown. */
export const kGains = [1, 4, 16]

export function Pair(props: {
  mode: Mode
  gain: number
  before: ComponentChildren
  after: ComponentChildren
  /** over the picture */
  over?: ComponentChildren
}) {
  const { mode } = props
  const [edge, setEdge] = useState(50)
  const beside = mode === 'side' || mode === 'distance'
  return (
    <div class={`rv-pair ${beside ? 'beside' : mode}`}>
      <div
        class="rv-both"
        style={mode === 'difference' ? { filter: `brightness(${props.gain})` } : undefined}
      >
        <div class="rv-layer">
          {props.before}
          {mode !== 'difference' && <span class="tag rv-name">Before</span>}
        </div>
        <div
          class="rv-layer rv-after"
          style={mode === 'slider' ? { clipPath: `inset(0 0 0 ${edge}%)` } : undefined}
        >
          {props.after}
          {mode !== 'difference' && <span class="tag rv-name">After</span>}
        </div>
      </div>
      {mode === 'slider' && <Edge edge={edge} move={setEdge} label="Share of the result before" />}
      {props.over && <div class="rv-over">{props.over}</div>}
    </div>
  )
}

interface Zoom {
  scale: number
  x: number
  y: number
}
const kMost = 16

/** The wheel looks closer, a drag moves: both pictures alike, by the style of each. */
export function useZoom(key: string) {
  const [zoom, setZoom] = useState<Zoom>({ scale: 1, x: 0, y: 0 })
  const element = useRef<HTMLDivElement>(null)
  useEffect(() => setZoom({ scale: 1, x: 0, y: 0 }), [key])
  useEffect(() => {
    const wheel = (event: WheelEvent) => {
      const layer = (event.target as Element).closest('.rv-layer')
      if (!layer) return
      event.preventDefault()
      const box = layer.getBoundingClientRect()
      const x = event.clientX - box.left - box.width / 2
      const y = event.clientY - box.top - box.height / 2
      setZoom((old) => {
        const scale = Math.min(kMost, Math.max(1, old.scale * Math.exp(-0.0015 * event.deltaY)))
        if (scale === 1) return { scale, x: 0, y: 0 }
        const by = scale / old.scale
        return { scale, x: x - (x - old.x) * by, y: y - (y - old.y) * by }
      })
    }
    const own = element.current
    own?.addEventListener('wheel', wheel, { passive: false })
    return () => own?.removeEventListener('wheel', wheel)
  }, [])
  const move = (event: PointerEvent) => {
    const held = event.buttons === 1 && (event.target as Element).closest('.rv-layer')
    if (held && zoom.scale > 1)
      setZoom((old) => ({ ...old, x: old.x + event.movementX, y: old.y + event.movementY }))
  }
  const style = { transform: `translate(${zoom.x}px, ${zoom.y}px) scale(${zoom.scale})` }
  return { element, style, move }
}
