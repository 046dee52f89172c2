// The photograph under the brush: pointer, wheel and keys become strokes, zoom and pan.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useSize } from './load'
import { MaskCanvas } from './mask_canvas'
import type { MaskLook } from './mask_canvas'
import { kFigure, kOutside } from './mask_model'
import type { MaskModel, Point } from './mask_model'

export interface Tool {
  mode: 'add' | 'remove'
  /** diameter in pixels of the photograph */
  size: number
  look: MaskLook
}

interface Drag {
  kind: 'paint' | 'pan'
  last: Point
}

export function BrushSurface(props: {
  model: MaskModel
  picture: ImageBitmap
  tool: Tool
  label: string
  ready: (canvas: MaskCanvas | null) => void
  stroked: () => void
}) {
  const { element: host, size } = useSize<HTMLDivElement>()
  const below = useRef<HTMLCanvasElement>(null)
  const above = useRef<HTMLCanvasElement>(null)
  const ring = useRef<HTMLDivElement>(null)
  const canvas = useRef<MaskCanvas | null>(null)
  const latest = useRef(props)
  latest.current = props
  const drag = useRef<Drag | null>(null)
  const cursor = useRef<Point | null>(null)
  const [spaceHeld, setSpaceHeld] = useState(false)

  useEffect(() => {
    const made = new MaskCanvas(below.current!, above.current!, props.model, props.picture)
    canvas.current = made
    latest.current.ready(made)
    host.current!.focus({ preventScroll: true })
    return () => {
      canvas.current = null
      latest.current.ready(null)
      made.dispose()
    }
  }, [props.model])
  useEffect(() => {
    if (size.width > 0) canvas.current?.resize(size.width, size.height)
  }, [size.width, size.height, props.model])
  useEffect(() => {
    canvas.current!.look = props.tool.look
    canvas.current!.redraw()
  }, [props.tool.look])
  useEffect(() => placeRing(), [props.tool.size, props.tool.mode])
  useEffect(() => followSpace(setSpaceHeld), [])
  useEffect(() => {
    // By hand, as the page must not scroll or zoom with it.
    const wheel = (event: WheelEvent) => {
      event.preventDefault()
      const factor = Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015))
      canvas.current!.zoomTo(canvas.current!.zoom() * factor, at(event))
      placeRing()
    }
    host.current!.addEventListener('wheel', wheel, { passive: false })
    return () => host.current?.removeEventListener('wheel', wheel)
  }, [])

  const at = (event: MouseEvent): Point => {
    const box = host.current!.getBoundingClientRect()
    return { x: event.clientX - box.left, y: event.clientY - box.top }
  }
  /** The brush's size round the cursor; moved by the compositor, nothing is drawn. */
  const placeRing = () => {
    if (!ring.current || !canvas.current || !cursor.current) return
    const place = canvas.current.toWindow(cursor.current)
    const wide = Math.max(3, canvas.current.length(latest.current.tool.size))
    ring.current.style.width = ring.current.style.height = `${wide}px`
    ring.current.style.transform = `translate(${place.x - wide / 2}px, ${place.y - wide / 2}px)`
    ring.current.style.visibility = 'visible'
  }
  const valueOf = (event: { altKey: boolean }) =>
    (latest.current.tool.mode === 'add') !== event.altKey ? kFigure : kOutside
  const paintTo = (to: Point) => {
    const { model, tool } = latest.current
    canvas.current!.maskChanged(model.paint(drag.current!.last, to, tool.size / 2))
    drag.current!.last = to
  }

  const down = (event: PointerEvent) => {
    const pans = event.button === 1 || (event.button === 0 && spaceHeld)
    if (!pans && event.button !== 0) return
    event.preventDefault()
    host.current!.focus({ preventScroll: true })
    host.current!.setPointerCapture(event.pointerId)
    const place = at(event)
    drag.current = { kind: pans ? 'pan' : 'paint', last: place }
    if (pans) return
    drag.current.last = canvas.current!.toPhotograph(place)
    latest.current.model.begin(valueOf(event))
    paintTo(drag.current.last)
  }
  const move = (event: PointerEvent) => {
    const place = at(event)
    if (drag.current?.kind === 'pan') {
      canvas.current!.pan(place.x - drag.current.last.x, place.y - drag.current.last.y)
      drag.current.last = place
    } else if (drag.current) {
      // The browser gathers the moves between two frames; all of them belong to the stroke.
      const all = event.getCoalescedEvents?.() ?? []
      for (const one of all.length > 0 ? all : [event])
        paintTo(canvas.current!.toPhotograph(at(one)))
    }
    cursor.current = canvas.current!.toPhotograph(place)
    placeRing()
  }
  const up = () => {
    const painted = drag.current?.kind === 'paint'
    drag.current = null
    if (!painted) return
    latest.current.model.end()
    latest.current.stroked()
  }
  const key = (event: KeyboardEvent) => {
    const { model, tool } = latest.current
    const direction = kArrows[event.key]
    if (!direction && event.key !== 'Enter') return
    if (event.ctrlKey || event.metaKey || event.altKey) return
    event.preventDefault()
    const place = cursor.current ?? { x: model.width / 2, y: model.height / 2 }
    const step = event.shiftKey ? 1 : Math.max(1, Math.round(tool.size / 4))
    const [dx, dy] = direction ?? [0, 0]
    cursor.current = {
      x: Math.min(model.width, Math.max(0, place.x + dx * step)),
      y: Math.min(model.height, Math.max(0, place.y + dy * step)),
    }
    placeRing()
    if (event.key !== 'Enter') return
    model.begin(valueOf(event))
    canvas.current!.maskChanged(model.paint(cursor.current, cursor.current, tool.size / 2))
    model.end()
    latest.current.stroked()
  }

  return (
    <div
      ref={host}
      class={`surface ${spaceHeld ? 'pans' : ''}`}
      role="application"
      tabIndex={0}
      aria-label={props.label}
      onPointerDown={down}
      onPointerMove={move}
      onPointerUp={up}
      onPointerCancel={up}
      onPointerLeave={() => !drag.current && (ring.current!.style.visibility = 'hidden')}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={key}
    >
      <canvas ref={below} />
      <canvas ref={above} />
      <div ref={ring} class={`ring ${props.tool.mode}`} />
    </div>
  )
}

const kArrows: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
}

/** Tells while the space bar is held, except on a button, which it presses. */
function followSpace(tell: (held: boolean) => void): () => void {
  const down = (event: KeyboardEvent) => {
    if (event.key !== ' ' || (event.target as HTMLElement).closest('button, input, select')) return
    event.preventDefault()
    tell(true)
  }
  const up = (event: KeyboardEvent) => event.key === ' ' && tell(false)
  const lost = () => tell(false)
  addEventListener('keydown', down)
  addEventListener('keyup', up)
  addEventListener('blur', lost)
  return () => {
    removeEventListener('keydown', down)
    removeEventListener('keyup', up)
    removeEventListener('blur', lost)
  }
}
