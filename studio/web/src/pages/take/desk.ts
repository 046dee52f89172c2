// What the parts of a take's page share.
import { useEffect, useState } from 'preact/hooks'

import type { Player } from '../timeline/player'
import type { ViewWindow } from '../timeline/view_window'
import type { Edits } from './edits'
import { framesOfTake, recordedAt, spanOf } from './take_model'
import type { Joint, Span, Take } from './take_model'

export interface TakeDesk {
  name: string
  take: Take
  edits: Edits
  player: Player
  view: ViewWindow
  /** recorded frame at the playhead, once it rests */
  frame: number
  /** what is changed: the frames that are selected, or the one at the playhead */
  span: Span
  selected: boolean
  select: (span: Span | null) => void
  /** of the joint that is changed */
  chosen: number
  choose: (joint: number) => void
  joint: Joint
  /** other joints whose curves are shown */
  pinned: number[]
  pin: (joint: number, on: boolean) => void
  /** a change is of all joints, not of the chosen one */
  allJoints: boolean
  setAllJoints: (all: boolean) => void
}

/** Muted, and told apart on both themes; the list has the names. */
const kSwatches = '#3f7fa6 #6d8f3d #a1589a #b98a1f #4b8f83 #8267b5 #a6616a'.split(' ')

/** The colour of a curve: that of the chosen joint is the accent. */
export function colorOf(desk: Pick<TakeDesk, 'chosen' | 'pinned'>, joint: number): string {
  if (joint === desk.chosen) return 'var(--accent)'
  const at = desk.pinned.indexOf(joint)
  return at < 0 ? 'var(--line)' : kSwatches[at % kSwatches.length]
}

/** Puts the playhead on a recorded frame. */
export function goTo(desk: Pick<TakeDesk, 'player' | 'take'>, frame: number): void {
  const last = framesOfTake(desk.take) - 1
  desk.player.seek(Math.max(0, Math.min(last, frame)) * desk.take.step)
}

/** The frames that are selected; null: only that at the playhead. */
export function useSelection(take: Take, frame: number) {
  const [kept, select] = useState<Span | null>(null)
  const frames = framesOfTake(take)
  // Frames that are not there any more are not selected any more.
  useEffect(() => select((old) => (old && old.last >= frames ? null : old)), [frames])
  const span = spanOf(kept?.first ?? frame, kept?.last ?? frame, frames)
  return { span, selected: span.first !== span.last, select }
}

/** Takes the frame before or after into the selection; the playhead goes there. */
export function extend(desk: TakeDesk, by: number): void {
  const { span, frame, take, player } = desk
  const now = recordedAt(take, player.frame)
  const anchor = !desk.selected ? now : frame === span.first ? span.last : span.first
  const next = Math.max(0, Math.min(framesOfTake(take) - 1, now + by))
  goTo(desk, next)
  desk.select(spanOf(anchor, next, framesOfTake(take)))
}
