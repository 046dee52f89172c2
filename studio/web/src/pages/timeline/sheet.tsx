// Ruler, keys, sound and curves, one below the other on the same frames.
import { useEffect, useRef, useState } from 'preact/hooks'

import { Curves } from './curves'
import { kGutter, swatchOf, useFrame } from './desk'
import type { Desk } from './desk'
import { KeyLane } from './key_lane'
import type { Player } from './player'
import { Ruler } from './ruler'
import { addKey } from './timeline_model'
import type { SoundState } from './use_sound'
import type { Zooming } from './use_view_window'
import { xOf } from './view_window'
import type { ViewWindow } from './view_window'
import { SoundLane } from './wave'

export interface Asked {
  frame: number
  /** where on the sheet the question appears [px] */
  x: number
}

/** Asks which pose a new key shows. */
function PoseMenu(props: { desk: Desk; asked: Asked; close: () => void }) {
  const { desk, asked, close } = props
  const menu = useRef<HTMLDivElement>(null)
  useEffect(() => {
    const before = document.activeElement
    menu.current?.querySelector('button')?.focus()
    const outside = (event: PointerEvent) => {
      if (!menu.current?.contains(event.target as Node)) close()
    }
    addEventListener('pointerdown', outside, { capture: true })
    return () => {
      removeEventListener('pointerdown', outside, { capture: true })
      if (before instanceof HTMLElement && before.isConnected) before.focus()
    }
  }, [])
  const key = (event: KeyboardEvent) => {
    event.stopPropagation()
    if (event.key === 'Escape') return close()
    const by = { ArrowDown: 1, ArrowUp: -1 }[event.key] ?? 0
    if (by === 0) return
    event.preventDefault()
    const all = [...menu.current!.querySelectorAll('button')]
    const at = all.indexOf(document.activeElement as HTMLButtonElement)
    all[(at + by + all.length) % all.length].focus()
  }
  return (
    <div
      ref={menu}
      class="tl-menu"
      role="menu"
      aria-label={`Pose of the new key at frame ${asked.frame}`}
      style={{ left: `${asked.x}px` }}
      onKeyDown={key}
    >
      <div class="soft small number" role="presentation">
        New key at frame {asked.frame}
      </div>
      {desk.poses.map((pose) => (
        <button
          key={pose}
          class="quiet"
          role="menuitem"
          onClick={() => {
            close()
            desk.insert((now) => addKey(now, asked.frame, pose))
          }}
        >
          <span class="tl-swatch" style={{ background: swatchOf(desk.poses, pose) }} />
          {pose}
        </button>
      ))}
    </div>
  )
}

/** The line through all lanes, and the number at its head. */
export function Playhead({ player, view }: { player: Player; view: ViewWindow }) {
  const line = useRef<HTMLDivElement>(null)
  const head = useRef<HTMLSpanElement>(null)
  useFrame(player, (frame) => {
    if (!line.current || !head.current) return
    line.current.style.transform = `translateX(${xOf(view, frame)}px)`
    head.current.textContent = String(frame)
  })
  return (
    <div class="tl-over" aria-hidden="true">
      <div ref={line} class="tl-playhead" style={{ width: `${view.scale}px` }}>
        <span ref={head} class="number" />
      </div>
    </div>
  )
}

export function ScrollBar({ zooming }: { zooming: Zooming }) {
  const bar = useRef<HTMLDivElement>(null)
  const { view, zoom, setStart } = zooming
  // Scroll events come late: those of our own scrolling would undo the next zoom.
  const ours = useRef(0)
  useEffect(() => {
    if (!bar.current) return
    bar.current.scrollLeft = view.start * view.scale
    ours.current = bar.current.scrollLeft
  }, [view, zoom === 1])
  if (zoom === 1) return null
  return (
    <div
      ref={bar}
      class="tl-scroll"
      role="group"
      tabIndex={0}
      aria-label="Scroll the ruler"
      onScroll={(event) => {
        const left = event.currentTarget.scrollLeft
        if (Math.abs(left - ours.current) > 1) setStart(left / view.scale)
      }}
    >
      <div style={{ width: `${view.total * view.scale}px` }} />
    </div>
  )
}

export function Sheet(props: {
  desk: Desk
  zooming: Zooming
  sound: SoundState
  asked: Asked | null
  ask: (asked: Asked | null) => void
  keyDown: (event: KeyboardEvent, index: number) => void
}) {
  const { desk, zooming, ask } = props
  const { view } = desk
  const fps = desk.timeline.fps
  const add = (frame: number, clientX: number) => {
    const box = zooming.box.current!.getBoundingClientRect()
    ask({ frame, x: Math.min(clientX - box.left, box.width - 190) })
  }
  const [grid] = useState(() => ({ '--gutter': `${kGutter}px` }))
  const second = fps * view.scale
  return (
    <section class="tl-sheet" aria-label="Timeline" style={grid}>
      <div
        ref={zooming.box}
        class="tl-lanes"
        style={{ '--second': `${second}px`, '--from': `${-view.start * view.scale}px` }}
      >
        <div class="tl-row tl-top">
          <div class="tl-gutter">Frames</div>
          <div class="tl-lane">
            <Ruler desk={desk} add={add} />
          </div>
        </div>
        <div class="tl-row tl-keyrow">
          <div class="tl-gutter">Keys</div>
          <div class="tl-lane">
            <KeyLane desk={desk} add={add} keyDown={props.keyDown} />
          </div>
        </div>
        <SoundLane desk={desk} state={props.sound} />
        <Curves desk={desk} />
        <Playhead player={desk.player} view={view} />
        {props.asked && (
          <PoseMenu
            key={props.asked.frame}
            desk={desk}
            asked={props.asked}
            close={() => ask(null)}
          />
        )}
      </div>
      <ScrollBar zooming={zooming} />
    </section>
  )
}
