// The recorded frames under the ruler, as blocks: a held pose is one. Drag over them to select.
import { useEffect, useRef } from 'preact/hooks'

import { cssColor } from '../../css_color'
import { clearedCanvas, useTheme } from '../timeline/desk'
import { frameAt, xOf } from '../timeline/view_window'
import { goTo } from './desk'
import type { TakeDesk } from './desk'
import { framesOfTake, heldFrames, recordedAt, spanOf } from './take_model'

function draw(canvas: HTMLCanvasElement, desk: TakeDesk, held: boolean[]): void {
  const context = clearedCanvas(canvas)
  if (!context) return
  const height = canvas.clientHeight
  const { view, take, span } = desk
  const wide = view.scale * take.step
  for (let f = 0; f < held.length; ++f) {
    const x = xOf(view, f * take.step)
    if (x + wide < 0 || x > view.width) continue
    const chosen = f >= span.first && f <= span.last
    context.fillStyle = cssColor(chosen ? '--accent-wash' : '--sunk')
    context.fillRect(x, 5, wide, height - 10)
    context.fillStyle = cssColor(chosen ? '--accent' : '--soft')
    // A pose that goes on has no edge between its frames, but a line through them.
    if (!held[f]) context.fillRect(x, 5, Math.min(2, wide / 3), height - 10)
    else context.fillRect(x, height / 2 - 0.5, wide, 1)
  }
}

export function FrameLane({ desk }: { desk: TakeDesk }) {
  const { view, take, span } = desk
  const canvas = useRef<HTMLCanvasElement>(null)
  const anchor = useRef(0)
  const theme = useTheme()
  useEffect(() => {
    if (canvas.current) draw(canvas.current, desk, heldFrames(take))
  }, [view, take, span.first, span.last, theme])
  const at = (event: PointerEvent) => {
    const x = event.clientX - canvas.current!.getBoundingClientRect().left
    return recordedAt(take, frameAt(view, x))
  }
  const select = (frame: number) => {
    goTo(desk, frame)
    desk.select(spanOf(anchor.current, frame, framesOfTake(take)))
  }
  return (
    <div class="tl-row take-frames">
      <div class="tl-gutter">Recorded</div>
      <div class="tl-lane">
        <canvas
          ref={canvas}
          aria-hidden="true"
          title="Drag to select frames"
          onPointerDown={(event) => {
            if (event.button !== 0) return
            event.currentTarget.setPointerCapture(event.pointerId)
            const frame = at(event)
            if (!event.shiftKey) anchor.current = frame
            else anchor.current = frame > span.first ? span.first : span.last
            select(frame)
          }}
          onPointerMove={(event) => {
            if (event.currentTarget.hasPointerCapture(event.pointerId)) select(at(event))
          }}
        />
      </div>
    </div>
  )
}
