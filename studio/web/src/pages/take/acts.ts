// What the buttons and keys of a take's page do.
import { goTo } from './desk'
import type { TakeDesk } from './desk'
import {
  addLine,
  deleteLine,
  framesOfTake,
  holdLine,
  kAll,
  lengthOfSpan,
  moveLine,
  repeatLine,
  setLine,
  stepLine,
  within,
  withinBy,
} from './take_model'
import type { Joint, Span } from './take_model'

const jointOf = (desk: TakeDesk) => (desk.allJoints ? kAll : desk.joint.name)

export const canHold = (desk: TakeDesk): boolean => lengthOfSpan(desk.span) > 1
export const canMove = (desk: TakeDesk, by: number): boolean =>
  desk.span.first + by >= 0 && desk.span.last + by < framesOfTake(desk.take)
export const canDelete = (desk: TakeDesk): boolean =>
  lengthOfSpan(desk.span) < framesOfTake(desk.take)

export function hold(desk: TakeDesk): void {
  if (canHold(desk)) desk.edits.change([holdLine(jointOf(desk), desk.span)])
}

/** The selection goes along with its frames. */
export function move(desk: TakeDesk, by: number): void {
  if (!canMove(desk, by)) return
  const { span, selected } = desk
  desk.edits.change([moveLine(jointOf(desk), span, by)])
  goTo(desk, desk.frame + by)
  if (selected) desk.select({ first: span.first + by, last: span.last + by })
}

export function longer(desk: TakeDesk): void {
  desk.edits.change([repeatLine(desk.span.last, 1)])
}

export function takeOut(desk: TakeDesk): void {
  if (!canDelete(desk)) return
  desk.edits.change([deleteLine(desk.span)])
  desk.select(null)
  goTo(desk, Math.max(0, desk.span.first - 1))
}

export function setStep(desk: TakeDesk, step: number): void {
  if (step === desk.take.step) return
  desk.edits.change([stepLine(step)])
  desk.select(null)
}

/** A value for the frames of `span`: of one frame a number, of several an offset. */
export function pulledLine(joint: Joint, span: Span, frame: number, value: number) {
  const start = joint.values[frame]
  if (span.first === span.last) {
    const kept = within(joint, value)
    return { line: setLine(joint.name, span, kept), by: kept - start, stopped: kept !== value }
  }
  const by = withinBy(joint, span, value - start)
  return { line: addLine(joint.name, span, by), by, stopped: by !== value - start }
}

/** Sets the value at the playhead; a selection goes along by the same amount. */
export function setValue(desk: TakeDesk, value: number): boolean {
  const { line, by, stopped } = pulledLine(desk.joint, desk.span, valueFrame(desk), value)
  if (by !== 0) desk.edits.change([line])
  return !stopped
}

/** The frame whose value is shown: that at the playhead, if it is one of those that are changed. */
export function valueFrame(desk: Pick<TakeDesk, 'span' | 'frame'>): number {
  const { first, last } = desk.span
  return desk.frame >= first && desk.frame <= last ? desk.frame : first
}
