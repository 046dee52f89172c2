// What is asked of the person, what has failed, and the buttons of a session.
import { useEffect, useRef, useState } from 'preact/hooks'
import type { ComponentChildren } from 'preact'

import { sentence } from '../../words'
import { kScan } from '../new_project/rows'
import { degrees } from './ring_map'
import type { Session } from './session'
import { kFullRing, kSix } from './setup'
import { ringIsBetter } from './setup_form'

const kDoing: Record<Session['doing'], string> = {
  begins: 'Begins …',
  turning: 'The table turns …',
  settling: 'The figure comes to rest …',
  shooting: 'Shoots …',
  checking: 'Looks at the photograph …',
  asking: 'Waits for you',
  paused: 'Paused',
  idle: 'All angles are there',
  ended: 'Ended',
}

export function doingWords(session: Session): string {
  const { doing } = session
  if (doing === 'turning') return `The table turns to ${degrees(session.angle_deg)} …`
  if (doing === 'shooting') return `Shoots ${degrees(session.angle_deg)} …`
  if (doing === 'begins' && session.total > 0) return 'Ready'
  return kDoing[doing]
}

/** True while the program works by itself and needs nobody. */
export const isAtWork = (session: Session): boolean =>
  ['turning', 'settling', 'shooting', 'checking'].includes(session.doing)

/** What the space bar does now, and the words on its button; null: nothing. */
export function mainAct(session: Session): { command: string; words: string } | null {
  if (!session.running || !session.pose || isAtWork(session)) return null
  if (session.ask || session.fault?.needs_hand) return { command: 'done', words: 'Done' }
  if (session.doing === 'paused' && session.done > 0) return { command: 'go-on', words: 'Go on' }
  if (session.doing === 'idle') return null
  return { command: 'shoot', words: 'Shoot' }
}

/** Tells a mouse's click to leave the keyboard where it was: the space bar shoots. */
function withoutFocus(act: () => void) {
  return (event: MouseEvent) => {
    if (event.detail > 0) (event.currentTarget as HTMLElement).blur()
    act()
  }
}

export function Act(props: {
  keys?: string
  main?: boolean
  disabled?: boolean
  act: () => void
  children: ComponentChildren
}) {
  return (
    <button
      class={props.main ? 'main' : ''}
      disabled={props.disabled}
      onClick={withoutFocus(props.act)}
    >
      {props.children} {props.keys && <kbd>{props.keys}</kbd>}
    </button>
  )
}

/** A sentence on what is wrong or wanted, and one on what to do. */
export function Say({ session }: { session: Session }) {
  const { fault, ask } = session
  if (fault)
    return (
      <div class="shoot-say fault" role="alert">
        <p>
          <b>{sentence(fault.words)}</b>
        </p>
        <p>{sentence(fault.do)}</p>
        <p class="small soft">
          {fault.needs_hand
            ? 'Press Done when it is mended. Nothing that was shot is lost.'
            : 'It tries again by itself. Nothing that was shot is lost.'}
        </p>
      </div>
    )
  if (ask)
    return (
      <div class="shoot-say ask" role="status">
        <p>
          <b>{sentence(ask.words)}</b>
        </p>
        {ask.do && <p>{sentence(ask.do)}</p>}
      </div>
    )
  if (session.recovered || session.refused)
    return (
      <div class="shoot-say" role="status">
        <p>{sentence(session.refused || session.recovered)}</p>
      </div>
    )
  return null
}

export function NextPose(props: {
  session: Session
  /** the pose that is bent into few photographs; '': none yet */
  template: string
  /** angles: of the first ring alone; null: the same plan */
  go: (pose: string, angles: number | null) => void
  close: () => void
}) {
  const { plan } = props.session
  const all = plan.rings_deg.length * plan.angles * (plan.flips + 1)
  const [name, setName] = useState('')
  const field = useRef<HTMLInputElement>(null)
  useEffect(() => field.current?.focus(), [])
  const good = /^[\p{L}\p{M}\p{N}_][\p{L}\p{M}\p{N}_-]*$/u.test(name) && name !== props.session.pose
  return (
    <form
      class="shoot-next"
      onSubmit={(event) => {
        event.preventDefault()
        if (good) props.go(name, kSix)
      }}
    >
      <label for="shoot-next">Next pose</label>
      <div class="row">
        <input
          id="shoot-next"
          ref={field}
          value={name}
          autocomplete="off"
          spellcheck={false}
          placeholder="bent"
          onInput={(event) => setName(event.currentTarget.value.normalize('NFC'))}
          onKeyDown={(event) => event.key === 'Escape' && props.close()}
        />
        <button class="main" disabled={!good}>
          Six photographs
        </button>
        <button
          type="button"
          disabled={!good}
          onClick={() => props.go(name, all >= kScan ? null : kFullRing)}
        >
          {all >= kScan ? `All ${all}, as now` : 'A full ring'}
        </button>
        <button type="button" class="quiet" onClick={props.close}>
          Cancel
        </button>
      </div>
      <p class="small soft">
        Same camera and table; {props.session.pose} lies over the live picture as onion skin.{' '}
        {ringIsBetter(props.template || props.session.pose)}
      </p>
    </form>
  )
}
