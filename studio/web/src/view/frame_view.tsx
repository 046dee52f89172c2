// A picture, large: clicks as numbered marks, the wheel to look closer.
import type { ComponentChildren } from 'preact'
import { useEffect, useRef, useState } from 'preact/hooks'

export interface Mark {
  name: string
  pixel: [number, number]
  chosen: boolean
  /** not complete yet: its place on the mesh is missing */
  pending: boolean
  /** of all marks, where this has none of its own */
  color?: string
}

export interface Zoom {
  scale: number
  /** of the view's middle, in the frame's pixels */
  x: number
  y: number
}
interface Press {
  x: number
  y: number
  /** of the mark under it, or '' */
  name: string
  moved: boolean
  /** false: it only moves the picture */
  clicks: boolean
  /** what it draws; null: it draws nothing */
  line: [number, number][] | null
}
const kMostZoom = 12
const kStill_px = 4

const clamp = (value: number, least: number, most: number) =>
  Math.min(most, Math.max(least, value))

/** The middle stays so that the frame fills the view. */
export function withinFrame(zoom: Zoom, width: number, height: number): Zoom {
  const scale = clamp(zoom.scale, 1, kMostZoom)
  const half = (size: number) => size / 2 / scale
  return {
    scale,
    x: clamp(zoom.x, half(width), width - half(width)),
    y: clamp(zoom.y, half(height), height - half(height)),
  }
}

export interface FrameViewProps {
  src: string
  width: number
  height: number
  label: string
  caption: string
  marks: Mark[]
  onPick: (pixel: [number, number]) => void
  onChoose: (name: string) => void
  onMove: (name: string, pixel: [number, number], done: boolean) => void
  /** what a pressed pointer draws; without it the picture is moved (with it by the middle button) */
  onLine?: (pixels: [number, number][], done: boolean) => void
  /** the pixel under the pointer; null: it has left */
  onHover?: (pixel: [number, number] | null) => void
  /** laid over a corner of the view */
  aside?: ComponentChildren
  /** for people who do not see the picture */
  help: string
  /** another object: looks there */
  look?: Zoom | null
  /** drawn over the picture, in its pixels: the children of an SVG */
  children?: ComponentChildren
}

export function FrameView(props: FrameViewProps) {
  const { width, height } = props
  const box = useRef<HTMLDivElement>(null)
  const [zoom, setZoom] = useState<Zoom>({ scale: 1, x: width / 2, y: height / 2 })
  const pressed = useRef<Press | null>(null)
  const whole = { scale: 1, x: width / 2, y: height / 2 }
  useEffect(() => setZoom(whole), [width, height, props.src])
  useEffect(() => {
    if (props.look) setZoom(withinFrame(props.look, width, height))
  }, [props.look])

  const pixelAt = (x: number, y: number): [number, number] => {
    const place = box.current!.getBoundingClientRect()
    const across = ((x - place.left) / place.width - 0.5) * (width / zoom.scale) + zoom.x
    const down = ((y - place.top) / place.height - 0.5) * (height / zoom.scale) + zoom.y
    const round = (value: number) => Math.round(100 * value) / 100
    return [round(clamp(across, 0, width)), round(clamp(down, 0, height))]
  }
  const wheel = (event: WheelEvent) => {
    event.preventDefault()
    const at = pixelAt(event.clientX, event.clientY)
    setZoom((old) => {
      const scale = clamp(old.scale * Math.exp(-0.0015 * event.deltaY), 1, kMostZoom)
      const keep = old.scale / scale
      const x = at[0] + (old.x - at[0]) * keep
      const y = at[1] + (old.y - at[1]) * keep
      return withinFrame({ scale, x, y }, width, height)
    })
  }
  // Not as an attribute: such listeners may not keep the page from scrolling.
  const latest = useRef(wheel)
  latest.current = wheel
  useEffect(() => {
    const element = box.current!
    const listen = (event: WheelEvent) => latest.current(event)
    element.addEventListener('wheel', listen, { passive: false })
    return () => element.removeEventListener('wheel', listen)
  }, [])

  const down = (event: PointerEvent) => {
    const draws = props.onLine !== undefined && event.button === 0 && !event.shiftKey
    if (event.button !== 0 && !(props.onLine && event.button === 1)) return
    if (event.button === 1) event.preventDefault() // which would begin to scroll
    const mark = (event.target as Element).closest<HTMLElement>('[data-mark]')
    box.current!.setPointerCapture(event.pointerId)
    pressed.current = {
      x: event.clientX,
      y: event.clientY,
      name: mark?.dataset.mark ?? '',
      moved: false,
      clicks: event.button === 0,
      line: draws && !mark ? [pixelAt(event.clientX, event.clientY)] : null,
    }
  }
  const move = (event: PointerEvent) => {
    const press = pressed.current
    props.onHover?.(pixelAt(event.clientX, event.clientY))
    if (!press) return
    const [dx, dy] = [event.clientX - press.x, event.clientY - press.y]
    if (!press.moved && Math.hypot(dx, dy) < kStill_px) return
    press.moved = true
    if (press.name) return props.onMove(press.name, pixelAt(event.clientX, event.clientY), false)
    if (press.line) {
      // The browser gathers the moves between two frames; all of them belong to the line.
      const all = event.getCoalescedEvents?.() ?? []
      for (const one of all.length > 0 ? all : [event])
        press.line.push(pixelAt(one.clientX, one.clientY))
      return props.onLine!(press.line, false)
    }
    const place = box.current!.getBoundingClientRect()
    press.x = event.clientX
    press.y = event.clientY
    setZoom((old) => {
      const x = old.x - (dx / place.width) * (width / old.scale)
      const y = old.y - (dy / place.height) * (height / old.scale)
      return withinFrame({ ...old, x, y }, width, height)
    })
  }
  const up = (event: PointerEvent) => {
    const press = pressed.current
    pressed.current = null
    if (!press) return
    const pixel = pixelAt(event.clientX, event.clientY)
    if (press.name && press.moved) props.onMove(press.name, pixel, true)
    else if (press.name) props.onChoose(press.name)
    else if (press.line && press.moved) props.onLine!(press.line, true)
    else if (!press.moved && press.clicks) props.onPick(pixel)
  }
  const key = (event: KeyboardEvent) => {
    if (event.key === ' ') {
      event.preventDefault()
      return props.onPick([zoom.x, zoom.y])
    }
    const chosen = props.marks.find((mark) => mark.chosen)
    const x = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0
    const y = { ArrowUp: -1, ArrowDown: 1 }[event.key] ?? 0
    if (!chosen || (x === 0 && y === 0)) return
    event.preventDefault()
    event.stopPropagation()
    const by = event.shiftKey ? 10 : 1
    const next: [number, number] = [
      clamp(chosen.pixel[0] + by * x, 0, width),
      clamp(chosen.pixel[1] + by * y, 0, height),
    ]
    props.onMove(chosen.name, next, true)
  }
  const left = (x: number) => `${50 + (100 * (x - zoom.x) * zoom.scale) / width}%`
  const top = (y: number) => `${50 + (100 * (y - zoom.y) * zoom.scale) / height}%`
  return (
    <section class="view frame-view" aria-label={props.label}>
      <div
        ref={box}
        class="frame-sheet"
        style={{ '--ratio': String(width / height) }}
        role="application"
        tabIndex={0}
        aria-label={props.help}
        onPointerDown={down}
        onPointerMove={move}
        onPointerUp={up}
        onPointerLeave={() => props.onHover?.(null)}
        onPointerCancel={() => {
          if (pressed.current?.line) props.onLine?.([], true)
          pressed.current = null
        }}
        onKeyDown={key}
      >
        <img
          src={props.src}
          alt=""
          draggable={false}
          style={{
            left: left(0),
            top: top(0),
            width: `${100 * zoom.scale}%`,
            height: `${100 * zoom.scale}%`,
          }}
        />
        {props.children && (
          <svg
            class="frame-over"
            aria-hidden="true"
            viewBox={`0 0 ${width} ${height}`}
            style={{
              left: left(0),
              top: top(0),
              width: `${100 * zoom.scale}%`,
              height: `${100 * zoom.scale}%`,
            }}
          >
            {props.children}
          </svg>
        )}
        {props.marks.map((mark) => (
          <span
            key={mark.name}
            data-mark={mark.name}
            class={`frame-mark ${mark.chosen ? 'chosen' : ''} ${mark.pending ? 'pending' : ''}`}
            style={{
              left: left(mark.pixel[0]),
              top: top(mark.pixel[1]),
              ...(mark.color && { '--mark': mark.color }),
            }}
          >
            <b>{mark.name}</b>
          </span>
        ))}
      </div>
      {props.aside}
      <span class="tag frame-caption">{props.caption}</span>
      {zoom.scale > 1 && (
        <button
          class="frame-zoom small"
          title="The whole picture again"
          onClick={() => setZoom(whole)}
        >
          {zoom.scale.toFixed(1)} ×
        </button>
      )}
    </section>
  )
}
