// The frame ruler: scrub on it, or double-click for a key.
import { useEffect, useRef } from 'preact/hooks'

import { cssColor } from '../../css_color'
import { clearedCanvas, useFrame, useTheme } from './desk'
import type { Desk } from './desk'
import type { Player } from './player'
import { keysOf, lengthOf, secondsOf } from './timeline_model'
import { frameAt, labelStep, xOf } from './view_window'
import type { ViewWindow } from './view_window'

function drawTick(context: CanvasRenderingContext2D, x: number, from: number, to: number): void {
  context.beginPath()
  context.moveTo(Math.round(x) + 0.5, from)
  context.lineTo(Math.round(x) + 0.5, to)
  context.stroke()
}

function drawRuler(canvas: HTMLCanvasElement, view: ViewWindow, fps: number, end: number): void {
  const context = clearedCanvas(canvas)
  if (!context) return
  const height = canvas.clientHeight
  const step = labelStep(view, fps)
  const fine = view.scale >= 5 ? 1 : Math.max(1, Math.round(step / 5))
  context.fillStyle = cssColor('--sunk')
  context.fillRect(xOf(view, end), 0, view.width, height)
  context.font = `11px ${cssColor('--font')}`
  const last = Math.min(view.total, Math.ceil(view.start + view.width / view.scale))
  const first = Math.floor(view.start / step) * step
  for (let frame = first; frame <= last; frame += fine) {
    const x = xOf(view, frame)
    const labelled = frame % step === 0
    const second = frame % Math.round(fps) === 0
    context.strokeStyle = cssColor(second ? '--soft' : '--line')
    drawTick(context, x, labelled ? height - 12 : height - 5, height)
    if (!labelled) continue
    context.fillStyle = cssColor(second ? '--ink' : '--soft')
    context.fillText(String(frame), x + 4, height - 8)
  }
}

/** `end`: where the ruler is empty from; `words`: what is at a frame, for those who hear it. */
export function FrameRuler(props: {
  player: Player
  view: ViewWindow
  fps: number
  end: number
  title: string
  words: (frame: number) => string
  add?: (frame: number, x: number) => void
}) {
  const { player, view, fps, end } = props
  const canvas = useRef<HTMLCanvasElement>(null)
  const slider = useRef<HTMLDivElement>(null)
  const theme = useTheme()
  useEffect(() => {
    if (canvas.current) drawRuler(canvas.current, view, fps, end)
  }, [view, fps, end, theme])
  useFrame(player, (frame) => {
    slider.current?.setAttribute('aria-valuenow', String(frame))
    const words = `frame ${frame}, ${(frame / fps).toFixed(2)} seconds${props.words(frame)}`
    slider.current?.setAttribute('aria-valuetext', words)
  })

  const at = (event: PointerEvent | MouseEvent) =>
    frameAt(view, event.clientX - slider.current!.getBoundingClientRect().left)
  const press = (event: PointerEvent) => {
    if (event.button !== 0) return
    slider.current!.setPointerCapture(event.pointerId)
    player.seek(at(event), true)
  }
  const move = (event: PointerEvent) => {
    if (slider.current!.hasPointerCapture(event.pointerId)) player.seek(at(event), true)
  }
  return (
    <div
      ref={slider}
      class="tl-ruler"
      role="slider"
      tabIndex={0}
      aria-label="Playhead"
      aria-valuemin={0}
      aria-valuemax={view.total - 1}
      title={props.title}
      onPointerDown={press}
      onPointerMove={move}
      onDblClick={(event) => props.add?.(at(event), event.clientX)}
      onKeyDown={(event) => {
        const by = { ArrowLeft: -1, ArrowRight: 1, PageUp: 10, PageDown: -10 }[event.key] ?? 0
        if (by === 0) return
        event.preventDefault()
        player.seek(player.frame + by * (event.shiftKey ? 10 : 1), true)
      }}
    >
      <canvas ref={canvas} />
    </div>
  )
}

export function Ruler(props: { desk: Desk; add: (frame: number, x: number) => void }) {
  const { player, timeline, view } = props.desk
  const keyWords = (frame: number) => {
    const key = keysOf(timeline).find((one) => one.at === secondsOf(timeline, frame))
    return key ? `, key ${key.pose}` : ''
  }
  return (
    <FrameRuler
      player={player}
      view={view}
      fps={timeline.fps}
      end={lengthOf(timeline)}
      title="Drag to scrub; double-click adds a key"
      words={keyWords}
      add={props.add}
    />
  )
}
