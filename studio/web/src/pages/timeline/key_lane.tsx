// The keys as blocks: drag to move, drag the right edge to hold, Alt copies, Shift takes the rest.
import { useEffect, useRef, useState } from 'preact/hooks'

import type { Timeline } from '../../api'
import { swatchOf } from './desk'
import type { Desk } from './desk'
import {
  blockEnd,
  copyKey,
  easeOf,
  framesOf,
  freeFrame,
  holdOf,
  holdUntil,
  keyAt,
  lengthText,
  moveKey,
  moveKeysFrom,
  setHold,
  stepOf,
  waysOf,
} from './timeline_model'
import { frameAt, xOf } from './view_window'
import type { ViewWindow } from './view_window'

const kSpanHeight = 30
const kLeastBlock = 9

type Mode = 'move' | 'hold'
interface Drag {
  mode: Mode
  index: number
  base: Timeline
  /** frames between the pointer and the key, so that the block does not jump */
  grip: number
  moved: boolean
  result: { timeline: Timeline; index: number }
}
interface Tip {
  x: number
  text: string
}

/** How a drag would end at a place of the ruler, and what to say of it. */
function dragged(drag: Drag, place: number, event: PointerEvent): [Drag['result'], string] {
  const { base, index } = drag
  const target = Math.round(place - drag.grip)
  if (drag.mode === 'hold') {
    const timeline = setHold(base, index, holdUntil(base, index, target))
    return [{ timeline, index }, `holds ${lengthText(holdOf(timeline, index), base.fps)}`]
  }
  if (event.altKey || event.ctrlKey) {
    const result = copyKey(base, index, freeFrame(base, target))
    return [result, `copy at ${placeText(result.timeline, result.index)}`]
  }
  if (index === 0) return [{ timeline: base, index }, 'the first key is frame 0']
  const timeline = event.shiftKey
    ? moveKeysFrom(base, index, target)
    : moveKey(base, index, target)
  const more = event.shiftKey ? ', with all after it' : ''
  return [{ timeline, index }, placeText(timeline, index) + more]
}

function placeText(timeline: Timeline, index: number): string {
  const frame = framesOf(timeline)[index]
  return `frame ${frame} · ${(frame / timeline.fps).toFixed(2)} s`
}

/** Follows the pointer until it is let go; Escape takes the drag back. */
function useDrag(desk: Desk, lane: { current: HTMLDivElement | null }) {
  const [tip, setTip] = useState<Tip | null>(null)
  const latest = useRef(desk)
  latest.current = desk
  const drag = useRef<Drag | null>(null)

  const placeOf = (event: PointerEvent) => {
    const { start, scale } = latest.current.view
    return start + (event.clientX - lane.current!.getBoundingClientRect().left) / scale
  }
  const end = (keep: boolean) => {
    const over = drag.current
    drag.current = null
    setTip(null)
    if (!over) return
    latest.current.preview(null)
    if (keep && over.moved) latest.current.insert(() => over.result)
  }
  useEffect(() => {
    const move = (event: PointerEvent) => {
      const now = drag.current
      if (!now) return
      const [result, text] = dragged(now, placeOf(event), event)
      now.moved = now.moved || result.timeline !== now.base
      now.result = result
      latest.current.preview(result.timeline)
      setTip({ x: event.clientX - lane.current!.getBoundingClientRect().left, text })
    }
    const up = () => end(true)
    const cancel = () => end(false)
    const key = (event: KeyboardEvent) => event.key === 'Escape' && end(false)
    addEventListener('pointermove', move)
    addEventListener('pointerup', up)
    addEventListener('pointercancel', cancel)
    addEventListener('keydown', key)
    return () => {
      removeEventListener('pointermove', move)
      removeEventListener('pointerup', up)
      removeEventListener('pointercancel', cancel)
      removeEventListener('keydown', key)
    }
  }, [])
  const begin = (event: PointerEvent, index: number, mode: Mode) => {
    if (event.button !== 0) return
    event.stopPropagation()
    const base = latest.current.timeline
    const held = mode === 'hold' ? blockEnd(base, index) : framesOf(base)[index]
    const grip = placeOf(event) - held
    drag.current = { mode, index, base, grip, moved: false, result: { timeline: base, index } }
    latest.current.select(index)
  }
  return { tip, begin }
}

/** The way of each frame of a span as a line: steps where pictures stand. */
function spanPath(timeline: Timeline, index: number, view: ViewWindow): string {
  const ways = waysOf(timeline, index)
  const left = framesOf(timeline)[index] + holdOf(timeline, index)
  const y = (way: number) => kSpanHeight * (1 - Math.min(1.2, Math.max(-0.2, way)))
  const stands = stepOf(timeline, index) > 1 || easeOf(timeline, index).name === 'stepped'
  const points: string[] = []
  ways.forEach((way, j) => {
    const x = xOf(view, left + j + 0.5)
    points.push(`${x.toFixed(1)} ${y(way).toFixed(1)}`)
    if (stands) points.push(`${(x + view.scale).toFixed(1)} ${y(way).toFixed(1)}`)
  })
  const arrival = `${xOf(view, left + ways.length + 0.5).toFixed(1)} ${y(1).toFixed(1)}`
  return ways.length === 0 ? '' : `M${[...points, arrival].join('L')}`
}

function Spans({ desk }: { desk: Desk }) {
  const { timeline, view, selected } = desk
  return (
    <svg class="tl-spans" aria-hidden="true" width={view.width} height={kSpanHeight}>
      {timeline.keys.slice(1).map((_, index) => (
        <path
          key={index}
          d={spanPath(timeline, index, view)}
          class={index === selected ? 'chosen' : ''}
        />
      ))}
    </svg>
  )
}

function keyWords(timeline: Timeline, index: number): string {
  const hold = holdOf(timeline, index)
  const ease = index + 1 < timeline.keys.length ? `, then ${easeOf(timeline, index).name}` : ''
  const held = hold > 0 ? `, holds ${hold} frames` : ''
  return `${timeline.keys[index].pose}, ${placeText(timeline, index)}${held}${ease}`
}

function KeyBlock(props: {
  desk: Desk
  index: number
  begin: (event: PointerEvent, index: number, mode: Mode) => void
  keyDown: (event: KeyboardEvent, index: number) => void
}) {
  const { desk, index } = props
  const { timeline, view, selected } = desk
  const frames = framesOf(timeline)
  const left = xOf(view, frames[index])
  const width = Math.max(kLeastBlock, xOf(view, blockEnd(timeline, index)) - left)
  const next = index + 1 < frames.length ? xOf(view, frames[index + 1]) : left + width + 160
  const inside = width >= 64
  const pose = timeline.keys[index].pose
  const chosen = index === selected
  return (
    <div
      class={`tl-key${chosen ? ' chosen' : ''}${inside ? ' wide' : ''}`}
      style={{
        transform: `translateX(${left}px)`,
        width: `${width}px`,
        '--swatch': swatchOf(desk.poses, pose),
        '--room': `${Math.max(0, inside ? width - 18 : next - left - width - 8)}px`,
      }}
    >
      <button
        type="button"
        class="tl-block"
        data-key={index}
        tabIndex={chosen ? 0 : -1}
        aria-pressed={chosen}
        aria-label={keyWords(timeline, index)}
        aria-describedby="tl-key-help"
        onPointerDown={(event) => props.begin(event, index, 'move')}
        onFocus={() => desk.select(index)}
        onKeyDown={(event) => props.keyDown(event, index)}
      />
      <span class="tl-name" aria-hidden="true">
        {pose}
      </span>
      <span class="tl-edge" onPointerDown={(event) => props.begin(event, index, 'hold')} />
    </div>
  )
}

export function KeyLane(props: {
  desk: Desk
  add: (frame: number, x: number) => void
  keyDown: (event: KeyboardEvent, index: number) => void
}) {
  const { desk } = props
  const lane = useRef<HTMLDivElement>(null)
  const { tip, begin } = useDrag(desk, lane)
  const at = (event: MouseEvent) =>
    frameAt(desk.view, event.clientX - lane.current!.getBoundingClientRect().left)
  const select = (event: PointerEvent) => desk.select(keyAt(desk.timeline, at(event)))
  return (
    <div
      ref={lane}
      class="tl-keys"
      role="group"
      aria-label="Keys"
      onPointerDown={select}
      onDblClick={(event) => {
        if (event.target === lane.current) props.add(at(event), event.clientX)
      }}
    >
      <Spans desk={desk} />
      {desk.timeline.keys.map((_, index) => (
        <KeyBlock
          key={index}
          desk={desk}
          index={index}
          begin={begin}
          keyDown={props.keyDown}
        />
      ))}
      {tip && (
        <div class="tl-tip number" style={{ transform: `translateX(${tip.x}px)` }}>
          {tip.text}
        </div>
      )}
      <span id="tl-key-help" class="hidden">
        Left and right move the key by a frame, with Shift by ten; Alt and left or right change its
        hold; up and down go to other keys; Delete removes it; Control D copies it.
      </span>
    </div>
  )
}
