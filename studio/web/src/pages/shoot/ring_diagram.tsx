// The rings seen from above: which angles are there, which to look at, which are missing.
import { useState } from 'preact/hooks'

import { count } from '../../words'
import { countsOf, degrees, radiusOf, ringWords, slotsOf, spotOf } from './ring_map'
import type { Slot } from './ring_map'
import type { Session } from './session'

const kSize = 220
const kRim = 96
const kLays = ['Upright', 'Lying', 'Lying 2', 'Lying 3', 'Lying 4', 'Lying 5']

/** Told apart by shape too: a disc, a diamond, a circle, a dash. */
function Mark({ slot, size }: { slot: Slot; size: number }) {
  const half = size / 2
  if (slot.state === 'warned')
    return <path class="warned" d={`M0 ${-size}L${size} 0 0 ${size}${-size} 0Z`} />
  if (slot.state === 'skipped') return <path class="skipped" d={`M${-half} 0H${half}`} />
  return <circle class={slot.state} r={slot.state === 'done' ? size * 0.8 : size * 0.6} />
}

const kStateWords = {
  done: 'there',
  warned: 'look at it',
  missing: 'not yet',
  skipped: 'left out',
}

function Spot(props: {
  slot: Slot
  radius: number
  size: number
  chosen: boolean
  choose: () => void
}) {
  const { slot, size } = props
  const { x, y } = spotOf(slot.angle_deg, props.radius)
  const words = `${degrees(slot.angle_deg)}, ${kStateWords[slot.state]}`
  return (
    <g
      transform={`translate(${x.toFixed(2)} ${y.toFixed(2)})`}
      class={slot.photograph ? 'there' : ''}
      data-slot={`${slot.flip} ${slot.ring} ${slot.index}`}
      data-state={slot.state}
      onClick={slot.photograph ? props.choose : undefined}
    >
      <title>{words}</title>
      <circle class="reach" r={size * 1.8} />
      <Mark slot={slot} size={size} />
      {slot.current && <circle class="current" r={size * 1.7} />}
      {props.chosen && <circle class="chosen" r={size * 1.5} />}
    </g>
  )
}

function wordsOf(session: Session, rings: Slot[][]): string {
  const parts = rings.map((slots, r) => {
    const { done, warned, missing } = countsOf(slots)
    const looks = warned > 0 ? `, ${warned} to look at` : ''
    return `${ringWords(session.plan, r + 1)}: ${done + warned} there${looks}, ${missing} missing`
  })
  return parts.join('; ')
}

export function RingDiagram(props: {
  session: Session
  chosen: string
  choose: (name: string) => void
}) {
  const { session } = props
  const [lay, setLay] = useState<number | null>(null)
  const flip = lay ?? session.flip
  const rings = slotsOf(session, flip)
  const size = Math.max(2, Math.min(5.5, (1.1 * kRim) / Math.max(1, session.plan.angles)))
  const half = kSize / 2
  return (
    <figure class="shoot-rings">
      {session.plan.flips > 0 && (
        <div class="choice" role="group" aria-label="How the figure lies">
          {Array.from({ length: session.plan.flips + 1 }, (_, one) => (
            <button key={one} aria-pressed={one === flip} onClick={() => setLay(one)}>
              {kLays[one] ?? `Lying ${one}`}
            </button>
          ))}
        </div>
      )}
      <svg
        viewBox={`${-half} ${-half} ${kSize} ${kSize}`}
        role="img"
        aria-label={`The rings from above. ${wordsOf(session, rings)}`}
      >
        {rings.map((slots, r) => {
          const radius = radiusOf(r + 1, session.plan, kRim)
          return (
            <g key={r}>
              <circle class="way" r={radius} />
              {slots.map((slot) => (
                <Spot
                  key={slot.index}
                  slot={slot}
                  radius={radius}
                  size={size}
                  chosen={slot.photograph !== null && slot.photograph.name === props.chosen}
                  choose={() => slot.photograph && props.choose(slot.photograph.name)}
                />
              ))}
            </g>
          )
        })}
        {session.doing !== 'ended' && <Middle session={session} />}
      </svg>
      <Legend slots={rings.flat()} />
    </figure>
  )
}

/** Where the table and the camera are to stand now. */
function Middle({ session }: { session: Session }) {
  return (
    <>
      <text y={2} text-anchor="middle" class="middle">
        {degrees(session.angle_deg)}
      </text>
      <text y={18} text-anchor="middle" class="height">
        camera at {degrees(session.tilt_deg)}
      </text>
    </>
  )
}

function Legend({ slots }: { slots: Slot[] }) {
  const counts = countsOf(slots)
  const all: [Slot['state'], string][] = [
    ['done', 'there'],
    ['warned', 'to look at'],
    ['missing', 'missing'],
    ['skipped', 'left out'],
  ]
  return (
    <figcaption class="small soft number">
      {all
        .filter(([state]) => counts[state] > 0)
        .map(([state, words]) => (
          <span key={state} title={count(counts[state], 'angle')}>
            <svg width="12" height="12" viewBox="-6 -6 12 12" aria-hidden="true">
              <Mark slot={{ state } as Slot} size={5} />
            </svg>
            {counts[state]} {words}
          </span>
        ))}
    </figcaption>
  )
}
