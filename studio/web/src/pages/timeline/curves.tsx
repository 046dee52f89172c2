// Area and volume of each frame under the ruler; what straight lines would do is dashed.
import { useEffect, useMemo, useRef } from 'preact/hooks'
import uPlot from 'uplot'
import 'uplot/dist/uPlot.min.css'

import { cssColor } from '../../css_color'
import { kGutter, useFrame, useTheme } from './desk'
import type { Desk } from './desk'
import type { Made } from './use_frames'
import { madeFrame } from './timeline_model'
import { frameAt } from './view_window'
import type { ViewWindow } from './view_window'

const kCold = '--tl-cold'

function dataOf(made: Made, fps: number): uPlot.AlignedData {
  const { frames } = made
  const percent = (values: number[]) => values.map((value) => 100 * value)
  return [
    frames.area.map((_, i) => (i * fps) / frames.fps),
    percent(frames.linear_area),
    percent(frames.linear_volume),
    percent(frames.area),
    percent(frames.volume),
  ]
}

/** Frames are cells: a value is drawn in the middle of its own. */
const xRange = (view: ViewWindow) => ({
  min: view.start - 0.5,
  max: view.start + view.width / view.scale - 0.5,
})

function optionsOf(view: ViewWindow, height: number): uPlot.Options {
  const area = cssColor('--accent')
  const volume = cssColor(kCold)
  const line = { width: 1, stroke: cssColor('--line') }
  const ghost = (stroke: string) => ({ stroke, width: 1, dash: [4, 4], points: { show: false } })
  const solid = (stroke: string) => ({ stroke, width: 1.75, points: { show: false } })
  return {
    width: view.width + kGutter,
    height,
    padding: [10, 0, 8, 0],
    legend: { show: false },
    cursor: { show: false, drag: { x: false, y: false, setScale: false } },
    scales: {
      x: { time: false, auto: false },
      // The hundred is always in sight, and half a percent does not look like a cliff.
      y: { range: (_, low, high) => [Math.min(low, 99.5) - 0.3, Math.max(high, 100.5) + 0.3] },
    },
    axes: [
      { show: false },
      {
        size: kGutter,
        gap: 6,
        font: `11px ${cssColor('--font')}`,
        stroke: cssColor('--soft'),
        grid: line,
        ticks: { show: false },
        space: 26,
        values: (_, ticks) => ticks.map((tick) => `${Number(tick.toFixed(1))} %`),
      },
    ],
    series: [{}, ghost(area), ghost(volume), solid(area), solid(volume)],
  }
}

export function Curves({ desk }: { desk: Desk }) {
  const { made, view, player, timeline } = desk
  const host = useRef<HTMLDivElement>(null)
  const plot = useRef<uPlot | null>(null)
  const area = useRef<HTMLElement>(null)
  const volume = useRef<HTMLElement>(null)
  const theme = useTheme()
  const data = useMemo(() => made && dataOf(made, timeline.fps), [made, timeline.fps])
  useEffect(() => {
    if (!data || !host.current || view.width <= 0) return
    const made = new uPlot(optionsOf(view, host.current.clientHeight), data, host.current)
    plot.current = made
    return () => {
      plot.current = null
      made.destroy()
    }
  }, [data, theme, view.width])
  useEffect(() => plot.current?.setScale('x', xRange(view)), [view, data, theme])
  useFrame(player, (frame) => {
    if (!made) return
    const at = madeFrame(made.frames, timeline.fps, frame)
    const words = (value: number) => `${(100 * value).toFixed(1)} %`
    if (area.current) area.current.textContent = words(made.frames.area[at])
    if (volume.current) volume.current.textContent = words(made.frames.volume[at])
  })

  const scrub = (event: PointerEvent) => {
    const x = event.clientX - host.current!.getBoundingClientRect().left - kGutter
    if (x >= 0) player.seek(frameAt(view, x), true)
  }
  if (!made)
    return (
      <div class="tl-curves tl-none soft">
        Area and volume of each frame are drawn here once the frames are made.
      </div>
    )
  return (
    <div
      class="tl-curves"
      onPointerDown={(event) => {
        event.currentTarget.setPointerCapture(event.pointerId)
        scrub(event)
      }}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) scrub(event)
      }}
    >
      <div ref={host} class="tl-plot" aria-hidden="true" />
      <dl class="tl-legend number">
        <div>
          <dt class="tl-area">Area</dt>
          <dd ref={area} />
        </div>
        <div>
          <dt class="tl-volume">Volume</dt>
          <dd ref={volume} />
        </div>
      </dl>
      <div class="tl-linear soft">straight lines</div>
    </div>
  )
}
