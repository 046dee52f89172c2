// The joints' curves under the ruler: each recorded frame a level of its own, as it was posed. The
// chosen joint's levels can be pulled.
import { useEffect, useRef, useState } from 'preact/hooks'

import { cssColor } from '../../css_color'
import { useStudio } from '../../state'
import { clearedCanvas, useTheme } from '../timeline/desk'
import { frameAt, xOf } from '../timeline/view_window'
import { pulledLine, valueFrame } from './acts'
import { colorOf, goTo } from './desk'
import type { TakeDesk } from './desk'
import {
  gridOf,
  limitWords,
  plotRange,
  recordedAt,
  roundedTo,
  unitSign,
  valueWords,
} from './take_model'
import type { Joint } from './take_model'

/** How near to a level the pointer takes hold of it [px]. */
const kReach = 12
const kPadding = 10

/** A pull that is under way, or was let go and is not drawn by its draft yet. */
interface Pull {
  joint: Joint
  frame: number
  first: number
  last: number
  /** [px] */
  from: number
  by: number
  stopped: boolean
  letGo: boolean
  /** The scale stands while something is pulled along it. */
  scale: { low: number; high: number }
}

interface Plot {
  low: number
  high: number
  height: number
}

const yOf = (plot: Plot, value: number): number =>
  kPadding + ((plot.high - value) / (plot.high - plot.low)) * (plot.height - 2 * kPadding)

/** What a pixel is worth. */
const perPixel = (plot: Plot): number => (plot.high - plot.low) / (plot.height - 2 * kPadding)

/** Joints that are drawn: those of the chosen joint's unit, it last and so on top. */
const drawnJoints = ({ pinned, chosen, take, joint }: TakeDesk): number[] => [
  ...pinned.filter((one) => one !== chosen && take.joints[one].unit === joint.unit),
  chosen,
]

/** A joint's values with a pull that its draft does not have yet. */
function valuesOf(joint: Joint, pull: Pull | null): number[] {
  if (!pull || pull.joint.name !== joint.name) return joint.values
  return joint.values.map((value, f) =>
    f >= pull.first && f <= pull.last ? pull.joint.values[f] + pull.by : value,
  )
}

class Drawing {
  constructor(
    private readonly context: CanvasRenderingContext2D,
    private readonly desk: TakeDesk,
    private readonly plot: Plot,
  ) {}

  private xOf(frame: number): number {
    return xOf(this.desk.view, frame * this.desk.take.step)
  }

  private line(y: number): void {
    this.context.beginPath()
    this.context.moveTo(0, Math.round(y) + 0.5)
    this.context.lineTo(this.desk.view.width, Math.round(y) + 0.5)
    this.context.stroke()
  }

  selection(): void {
    const { span } = this.desk
    this.context.fillStyle = cssColor('--accent-wash')
    const x = this.xOf(span.first)
    this.context.fillRect(x, 0, this.xOf(span.last + 1) - x, this.plot.height)
  }

  grid(): void {
    const { low, high, height } = this.plot
    this.context.strokeStyle = cssColor('--line')
    for (const value of gridOf(low, high, height / 34)) this.line(yOf(this.plot, value))
  }

  /** Where the chosen joint stops. */
  limits(): void {
    this.context.strokeStyle = cssColor('--bad')
    this.context.setLineDash([5, 4])
    for (const limit of [this.desk.joint.low, this.desk.joint.high])
      if (limit !== null) this.line(yOf(this.plot, limit))
    this.context.setLineDash([])
  }

  /** Levels, and faint lines from one to the next; all faint where the film goes its own way. */
  curve(values: number[], color: string, chosen: boolean): void {
    const { context, plot } = this
    const held = this.desk.take.film === 0
    context.strokeStyle = color
    context.lineWidth = chosen && held ? 2.5 : 1.5
    context.globalAlpha = held ? 1 : 0.5
    const levels = new Path2D()
    const jumps = new Path2D()
    values.forEach((value, f) => {
      const y = yOf(plot, value)
      levels.moveTo(this.xOf(f), y)
      levels.lineTo(this.xOf(f + 1), y)
      if (f + 1 === values.length) return
      jumps.moveTo(this.xOf(f + 1), y)
      jumps.lineTo(this.xOf(f + 1), yOf(plot, values[f + 1]))
    })
    context.stroke(levels)
    context.lineWidth = 1
    context.globalAlpha = held ? 0.55 : 0
    context.stroke(jumps)
    context.globalAlpha = 1
  }

  /** The joint's values in the film as it would be baked, each in the middle of its frame. */
  film(joint: number, color: string, chosen: boolean): void {
    const { context, desk, plot } = this
    const { film, joints } = desk.take
    const values = desk.edits.draft!.filmValues
    context.strokeStyle = color
    context.lineWidth = chosen ? 2.5 : 1.5
    context.beginPath()
    for (let f = 0; f < film; ++f)
      context.lineTo(xOf(desk.view, f + 0.5), yOf(plot, values[f * joints.length + joint]))
    context.stroke()
  }

  /** Handles of the chosen joint, where there is room for them. */
  handles(values: number[], color: string): void {
    const { context, desk } = this
    if (desk.view.scale * desk.take.step < 9) return
    context.fillStyle = color
    values.forEach((value, f) => {
      const held = f >= desk.span.first && f <= desk.span.last
      context.beginPath()
      const x = (this.xOf(f) + this.xOf(f + 1)) / 2
      context.arc(x, yOf(this.plot, value), held ? 4.5 : 3, 0, 2 * Math.PI)
      context.fill()
    })
  }
}

function draw(canvas: HTMLCanvasElement, desk: TakeDesk, plot: Plot, pull: Pull | null): void {
  const context = clearedCanvas(canvas)
  if (!context) return
  const drawing = new Drawing(context, desk, plot)
  drawing.selection()
  drawing.grid()
  drawing.limits()
  for (const j of drawnJoints(desk)) {
    const color = colorOf(desk, j)
    const ink = color.startsWith('var(') ? cssColor(color.slice(4, -1)) : color
    const values = valuesOf(desk.take.joints[j], pull)
    drawing.curve(values, ink, j === desk.chosen)
    drawing.film(j, ink, j === desk.chosen)
    if (j === desk.chosen) drawing.handles(values, ink)
  }
}

/** The numbers of the grid, in the gutter. */
function Scale({ plot, unit }: { plot: Plot; unit: string }) {
  if (plot.height === 0) return null
  return (
    <div class="take-scale number" aria-hidden="true">
      {gridOf(plot.low, plot.high, plot.height / 34).map((value) => (
        <span key={value} style={{ top: `${yOf(plot, value)}px` }}>
          {value}
          {unitSign(unit)}
        </span>
      ))}
    </div>
  )
}

/** Pulling by the pointer: what is held, and how far. */
function pulling(props: {
  desk: TakeDesk
  plot: Plot
  host: { current: HTMLDivElement | null }
  pull: Pull | null
  setPull: (pull: Pull | null) => void
}) {
  const { desk, plot, host, pull, setPull } = props
  const { take, view, edits } = desk
  const place = (event: PointerEvent) => {
    const box = host.current!.getBoundingClientRect()
    return { x: event.clientX - box.left, y: event.clientY - box.top }
  }
  /** The joint whose level is near, and the recorded frame. */
  const near = (event: PointerEvent) => {
    const { x, y } = place(event)
    const film = frameAt(view, x)
    const frame = recordedAt(take, film)
    const inside = film >= 0 && film < take.step * desk.joint.values.length
    const away = (j: number) => Math.abs(yOf(plot, take.joints[j].values[frame]) - y)
    const close = drawnJoints(desk).filter((j) => inside && away(j) < kReach)
    if (close.length === 0) return { frame, joint: -1 }
    const nearest = close.reduce((best, j) => (away(j) < away(best) ? j : best))
    return { frame, joint: close.includes(desk.chosen) ? desk.chosen : nearest }
  }
  const press = (event: PointerEvent) => {
    if (event.button !== 0) return
    host.current!.setPointerCapture(event.pointerId)
    const { frame, joint } = near(event)
    desk.player.pause()
    goTo(desk, frame)
    if (joint < 0) return setPull(null)
    desk.choose(joint)
    const held = desk.selected && frame >= desk.span.first && frame <= desk.span.last
    if (!held) desk.select(null)
    const { first, last } = held ? desk.span : { first: frame, last: frame }
    const from = place(event).y
    const start = { joint: take.joints[joint], frame, first, last, from, by: 0 }
    const scale = { low: plot.low, high: plot.high }
    setPull({ ...start, stopped: false, letGo: false, scale })
  }
  const move = (event: PointerEvent) => {
    if (!host.current!.hasPointerCapture(event.pointerId)) {
      host.current!.style.cursor = near(event).joint < 0 ? '' : 'ns-resize'
      return
    }
    if (!pull) return goTo(desk, near(event).frame)
    if (pull.letGo) return
    const each = perPixel(plot)
    const start = pull.joint.values[pull.frame]
    const value = roundedTo(start + (pull.from - place(event).y) * each, each)
    const { line, by, stopped } = pulledLine(pull.joint, pull, pull.frame, value)
    if (by === pull.by) return
    setPull({ ...pull, by, stopped })
    edits.show(by === 0 ? [] : [line])
  }
  const letGo = () => {
    if (!pull || pull.letGo) return
    const value = pull.joint.values[pull.frame] + pull.by
    if (pull.by === 0) return setPull(null)
    edits.change([pulledLine(pull.joint, pull, pull.frame, value).line])
    setPull({ ...pull, letGo: true })
  }
  const cancel = () => {
    if (pull && !pull.letGo) edits.show([])
    setPull(null)
  }
  return { press, move, letGo, cancel }
}

/** The value at the playhead by keyboard; presses in quick succession are undone together. */
function useNudge(desk: TakeDesk) {
  const base = useRef<{ joint: Joint; frame: number; total: number } | null>(null)
  const { tell } = useStudio()
  return (by: number) => {
    const { edits, joint, span } = desk
    const tag = `nudge ${joint.name} ${span.first} ${span.last}`
    const again = edits.continues(tag) ? base.current : null
    const { joint: from, frame, total } = again ?? { joint, frame: valueFrame(desk), total: 0 }
    const pulled = pulledLine(from, span, frame, from.values[frame] + total + by)
    base.current = { joint: from, frame, total: pulled.by }
    if (pulled.stopped) tell(`${joint.name} ${limitWords(joint)}.`)
    if (pulled.by !== 0 || again) edits.change([pulled.line], tag)
  }
}

export function CurveLane({ desk }: { desk: TakeDesk }) {
  const { view, take, joint, frame } = desk
  const host = useRef<HTMLDivElement>(null)
  const canvas = useRef<HTMLCanvasElement>(null)
  const [height, setHeight] = useState(0)
  const theme = useTheme()
  const [pull, setPull] = useState<Pull | null>(null)
  const scale = pull?.scale ?? plotRange(drawnJoints(desk).map((j) => take.joints[j]))
  const plot: Plot = { ...scale, height }
  const { press, move, letGo, cancel } = pulling({ desk, plot, host, pull, setPull })
  const nudge = useNudge(desk)
  // What was let go is drawn by its draft, once that is there.
  useEffect(() => {
    if (pull?.letGo && !desk.edits.busy) setPull(null)
  }, [pull, desk.edits.busy, take])
  useEffect(() => {
    const watch = new ResizeObserver(() => setHeight(host.current?.clientHeight ?? 0))
    watch.observe(host.current!)
    return () => watch.disconnect()
  }, [])
  useEffect(() => {
    if (canvas.current && height > 0) draw(canvas.current, desk, plot, pull)
  }, [view, take, desk.chosen, desk.pinned, desk.span, plot.low, plot.high, height, pull, theme])
  const value = joint.values[Math.min(frame, joint.values.length - 1)]
  const pulledValue = pull ? pull.joint.values[pull.frame] + pull.by : value
  return (
    <div class="tl-row take-curves">
      <div class="tl-gutter take-gutter">
        <Scale plot={plot} unit={joint.unit} />
      </div>
      <div
        ref={host}
        class="tl-lane take-plot"
        role="slider"
        tabIndex={0}
        aria-orientation="vertical"
        aria-label={`${joint.name} in recorded frame ${frame}`}
        aria-valuenow={value}
        aria-valuemin={joint.low ?? Math.min(plot.low, value)}
        aria-valuemax={joint.high ?? Math.max(plot.high, value)}
        aria-valuetext={valueWords(joint, value)}
        title="Pull a level up or down; elsewhere, drag to scrub"
        onPointerDown={press}
        onPointerMove={move}
        onPointerUp={letGo}
        onPointerCancel={cancel}
        onKeyDown={(event) => {
          if (event.key === 'Escape' && pull) {
            event.preventDefault()
            return cancel()
          }
          const by = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key]
          if (by === undefined) return
          event.preventDefault()
          nudge(by * (event.shiftKey ? 10 : event.altKey ? 0.1 : 1))
        }}
      >
        <canvas ref={canvas} aria-hidden="true" />
        {pull && (
          <div class="take-tip number">
            {valueWords(joint, pulledValue)}
            {pull.stopped && `, ${limitWords(pull.joint)}`}
          </div>
        )}
      </div>
    </div>
  )
}
