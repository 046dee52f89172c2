// The curve of a span with two handles; dots are its frames.
import { useRef } from 'preact/hooks'

import { easeAt, kHighestY, kLowestY, waysOf } from './timeline_model'
import type { Curve } from './timeline_model'
import type { Timeline } from '../../api'
import { NumberField } from './number_field'

const kWidth = 300
const kHeight = 156
const kSide = 14
/** How far beyond 0 and 1 the plot reaches, if no handle is farther. */
const kBeyond = 0.25

interface Plot {
  low: number
  high: number
}

const plotOf = ([, y1, , y2]: Curve): Plot => ({
  low: Math.min(-kBeyond, y1 - 0.1, y2 - 0.1),
  high: Math.max(1 + kBeyond, y1 + 0.1, y2 + 0.1),
})
const xOf = (x: number) => kSide + x * (kWidth - 2 * kSide)
const yOf = (plot: Plot, y: number) => (kHeight * (plot.high - y)) / (plot.high - plot.low)

function curvePath(curve: Curve, plot: Plot): string {
  const points: string[] = []
  for (let i = 0; i <= 60; ++i)
    points.push(`${xOf(i / 60).toFixed(1)} ${yOf(plot, easeAt(curve, i / 60)).toFixed(1)}`)
  return `M${points.join('L')}`
}

/** The span's frames on the curve: close dots are slow, wide ones fast. */
function Frames({ timeline, index, plot }: { timeline: Timeline; index: number; plot: Plot }) {
  const ways = waysOf(timeline, index)
  if (ways.length === 0 || ways.length > 150) return null
  return (
    <>
      {[...ways, 1].map((way, j) => (
        <circle
          key={j}
          class="tl-dot"
          r={2.4}
          cx={xOf(j / ways.length)}
          cy={yOf(plot, way)}
        />
      ))}
    </>
  )
}

function moved(curve: Curve, which: 0 | 1, x: number, y: number): Curve {
  const next: Curve = [...curve]
  next[2 * which] = Math.min(1, Math.max(0, x))
  next[2 * which + 1] = Math.min(kHighestY, Math.max(kLowestY, y))
  return next
}

function Handle(props: {
  curve: Curve
  which: 0 | 1
  plot: Plot
  place: (event: PointerEvent) => [number, number]
  change: (curve: Curve) => void
}) {
  const { curve, which, plot } = props
  const [x, y] = [curve[2 * which], curve[2 * which + 1]]
  const key = (event: KeyboardEvent) => {
    const by = event.shiftKey ? 0.1 : 0.01
    const dx = { ArrowLeft: -by, ArrowRight: by }[event.key] ?? 0
    const dy = { ArrowUp: by, ArrowDown: -by }[event.key] ?? 0
    if (dx === 0 && dy === 0) return
    event.preventDefault()
    event.stopPropagation()
    props.change(moved(curve, which, x + dx, y + dy))
  }
  return (
    <>
      <line
        class="tl-arm"
        x1={xOf(which)}
        y1={yOf(plot, which)}
        x2={xOf(x)}
        y2={yOf(plot, y)}
      />
      <circle
        class="tl-handle"
        cx={xOf(x)}
        cy={yOf(plot, y)}
        r={7}
        tabIndex={0}
        role="slider"
        aria-label={which === 0 ? 'Handle at the start' : 'Handle at the end'}
        aria-valuemin={0}
        aria-valuemax={1}
        aria-valuenow={x}
        aria-valuetext={`time ${x.toFixed(2)}, way ${y.toFixed(2)}`}
        onKeyDown={key}
        onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
        onPointerMove={(event) => {
          if (event.currentTarget.hasPointerCapture(event.pointerId))
            props.change(moved(curve, which, ...props.place(event)))
        }}
      />
    </>
  )
}

const kFieldNames = ['Start: time', 'Start: way', 'End: time', 'End: way']

/** `change` gets every step of a drag; the caller makes one change of them. */
export function EaseEditor(props: {
  timeline: Timeline
  index: number
  curve: Curve
  stepped: boolean
  change: (curve: Curve) => void
}) {
  const { curve, stepped } = props
  const svg = useRef<SVGSVGElement>(null)
  const plot = plotOf(curve)
  const place = (event: PointerEvent): [number, number] => {
    const box = svg.current!.getBoundingClientRect()
    const x = ((event.clientX - box.left) / box.width) * kWidth
    const y = (event.clientY - box.top) / box.height
    return [(x - kSide) / (kWidth - 2 * kSide), plot.high - y * (plot.high - plot.low)]
  }
  const stairs = `M${xOf(0)} ${yOf(plot, 0)}H${xOf(1)}V${yOf(plot, 1)}`
  return (
    <div class="tl-ease">
      <svg ref={svg} viewBox={`0 0 ${kWidth} ${kHeight}`} role="group" aria-label="Ease curve">
        <rect
          class="tl-square"
          x={xOf(0)}
          y={yOf(plot, 1)}
          width={xOf(1) - xOf(0)}
          height={yOf(plot, 0) - yOf(plot, 1)}
        />
        <path class="tl-curve" d={stepped ? stairs : curvePath(curve, plot)} />
        <Frames timeline={props.timeline} index={props.index} plot={plot} />
        {!stepped &&
          ([0, 1] as const).map((which) => (
            <Handle
              key={which}
              which={which}
              curve={curve}
              plot={plot}
              place={place}
              change={props.change}
            />
          ))}
      </svg>
      <div class="tl-four">
        {kFieldNames.map((name, k) => (
          <NumberField
            key={name}
            label={name}
            value={curve[k]}
            digits={2}
            step={0.01}
            disabled={stepped}
            change={(value) => {
              const next: Curve = [...curve]
              next[k] = value
              props.change(next)
            }}
          />
        ))}
      </div>
    </div>
  )
}
