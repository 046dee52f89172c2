// The photograph under the brush: pointer, wheel and keys become strokes, lassos, zoom and pan.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useSize } from './load'
import { MaskCanvas } from './mask_canvas'
import type { MaskLook } from './mask_canvas'
import { kFigure, kOutside } from './mask_model'
import type { MaskModel, Point } from './mask_model'
import { enclosedRows, joinedRows } from './mask_shapes'

export interface Tool {
  mode: 'add' | 'remove'
  /** paints along a stroke; what a line encloses; what hangs together with a place */
  shape: 'brush' | 'lasso' | 'fill'
  /** diameter in pixels of the photograph */
  size: number
  look: MaskLook
}

interface Drag {
  kind: 'paint' | 'lasso' | 'pan'
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
  /** the corners of the lasso, in pixels of the photograph */
  const lasso = useRef<Point[]>([])
  const loop = useRef<SVGPolygonElement>(null)
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
  useEffect(() => placeRing(), [props.tool.size, props.tool.mode, props.tool.shape])
  useEffect(() => dropLasso(), [props.tool.shape, props.model])
  useEffect(() => followSpace(setSpaceHeld), [])
  useEffect(() => {
    // By hand, as the page must not scroll or zoom with it.
    const wheel = (event: WheelEvent) => {
      event.preventDefault()
      const factor = Math.exp(-event.deltaY * (event.deltaMode === 1 ? 0.05 : 0.0015))
      canvas.current!.zoomTo(canvas.current!.zoom() * factor, at(event))
      placeRing()
      drawLasso()
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
    const { shape, size } = latest.current.tool
    const wide = shape === 'brush' ? Math.max(3, canvas.current.length(size)) : kPointer
    ring.current.style.width = ring.current.style.height = `${wide}px`
    ring.current.style.transform = `translate(${place.x - wide / 2}px, ${place.y - wide / 2}px)`
    ring.current.style.visibility = 'visible'
  }
  const drawLasso = () => {
    if (!loop.current || !canvas.current) return
    const places = lasso.current.map((point) => canvas.current!.toWindow(point))
    loop.current.setAttribute('points', places.map(({ x, y }) => `${x},${y}`).join(' '))
  }
  const dropLasso = () => {
    lasso.current = []
    drawLasso()
  }
  const valueOf = (event: { altKey: boolean }) =>
    (latest.current.tool.mode === 'add') !== event.altKey ? kFigure : kOutside
  const paintTo = (to: Point) => {
    const { model, tool } = latest.current
    canvas.current!.maskChanged(model.paint(drag.current!.last, to, tool.size / 2))
    drag.current!.last = to
  }

  /** Fills what the lasso encloses, or what hangs together with a place. */
  const fillAt = (event: { altKey: boolean }, place: Point) => {
    const { model, tool, stroked } = latest.current
    const { values, width, height } = model
    const rows =
      tool.shape === 'fill'
        ? joinedRows(values, width, height, place)
        : enclosedRows(lasso.current, width, height)
    model.begin(valueOf(event))
    canvas.current!.maskChanged(model.fill(rows))
    model.end()
    dropLasso()
    stroked()
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
    const { shape } = latest.current.tool
    if (shape === 'lasso') {
      drag.current.kind = 'lasso'
      lasso.current = [drag.current.last]
      return
    }
    if (shape === 'fill') {
      const at = drag.current.last
      drag.current = null
      return fillAt(event, at)
    }
    latest.current.model.begin(valueOf(event))
    paintTo(drag.current.last)
  }
  const move = (event: PointerEvent) => {
    const place = at(event)
    if (drag.current?.kind === 'pan') {
      canvas.current!.pan(place.x - drag.current.last.x, place.y - drag.current.last.y)
      drag.current.last = place
      drawLasso()
    } else if (drag.current?.kind === 'lasso') {
      lasso.current.push(canvas.current!.toPhotograph(place))
      drawLasso()
    } else if (drag.current) {
      // The browser gathers the moves between two frames; all of them belong to the stroke.
      const all = event.getCoalescedEvents?.() ?? []
      for (const one of all.length > 0 ? all : [event])
        paintTo(canvas.current!.toPhotograph(at(one)))
    }
    cursor.current = canvas.current!.toPhotograph(place)
    placeRing()
  }
  const up = (event: PointerEvent) => {
    const painted = drag.current?.kind === 'paint'
    const enclosed = drag.current?.kind === 'lasso'
    drag.current = null
    if (enclosed) return fillAt(event, lasso.current[0])
    if (!painted) return
    latest.current.model.end()
    latest.current.stroked()
  }
  /** By keys: Enter sets a corner; once more at the same place closes the line. */
  const corner = (event: KeyboardEvent, place: Point) => {
    const last = lasso.current.at(-1)
    if (last && last.x === place.x && last.y === place.y) return fillAt(event, place)
    lasso.current.push(place)
    drawLasso()
  }
  const key = (event: KeyboardEvent) => {
    const { model, tool } = latest.current
    const direction = kArrows[event.key]
    if (event.key === 'Escape' && lasso.current.length > 0) {
      event.stopPropagation()
      return dropLasso()
    }
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
    if (tool.shape === 'fill') return fillAt(event, cursor.current)
    if (tool.shape === 'lasso') return corner(event, cursor.current)
    model.begin(valueOf(event))
    canvas.current!.maskChanged(model.paint(cursor.current, cursor.current, tool.size / 2))
    model.end()
    latest.current.stroked()
  }

  return (
    <div
      ref={host}
      class={`surface ${props.tool.shape} ${spaceHeld ? 'pans' : ''}`}
      role="application"
      tabIndex={0}
      aria-label={props.label}
      onPointerDown={down}
      onPointerMove={move}
      onPointerUp={up}
      onPointerCancel={() => {
        drag.current = null
        dropLasso()
        latest.current.model.end()
      }}
      onPointerLeave={() => !drag.current && (ring.current!.style.visibility = 'hidden')}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={key}
    >
      <canvas ref={below} />
      <canvas ref={above} />
      <svg class="lasso" aria-hidden="true">
        <polygon ref={loop} class={props.tool.mode} />
      </svg>
      <div ref={ring} class={`ring ${props.tool.mode}`} />
    </div>
  )
}

/** How large the ring is where it is no brush [px] */
const kPointer = 9

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
