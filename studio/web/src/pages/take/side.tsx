// Beside the puppet: the joint and the frames that are changed, all joints, the changes so far, and
// the baking.
import { useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { count } from '../../words'
import { NumberField } from '../timeline/number_field'
import {
  canDelete,
  canHold,
  canMove,
  hold,
  longer,
  move,
  setValue,
  takeOut,
  valueFrame,
} from './acts'
import { BakePanel } from './bake_panel'
import { colorOf } from './desk'
import type { TakeDesk } from './desk'
import {
  framesOfTake,
  lengthOfSpan,
  limitWords,
  lineWords,
  spanOf,
  unitSign,
  valueWords,
} from './take_model'

const kTabs = ['Joints', 'Changes', 'Bake'] as const
type Tab = (typeof kTabs)[number]

function Value({ desk }: { desk: TakeDesk }) {
  const { joint, span } = desk
  const { tell } = useStudio()
  const frame = valueFrame(desk)
  const many = lengthOfSpan(span) > 1
  return (
    <div class="take-value">
      <h2>{joint.name}</h2>
      <label>
        <NumberField
          label={`Value of ${joint.name} in recorded frame ${frame}`}
          value={joint.values[frame]}
          digits={2}
          step={0.1}
          change={(value) => {
            if (!setValue(desk, value)) tell(`${joint.name} ${limitWords(joint)}.`)
          }}
        />
        {unitSign(joint.unit)}
      </label>
      <p class="small soft">
        in frame {frame}
        {many && ', the others of the selection go along'}
        {limitWords(joint) && ` · ${limitWords(joint)}`}
      </p>
    </div>
  )
}

function Frames({ desk }: { desk: TakeDesk }) {
  const { span, take } = desk
  const last = framesOfTake(take) - 1
  const select = (first: number, to: number) => desk.select(spanOf(first, to, last + 1))
  return (
    <div class="stack take-change">
      <div class="row">
        <span>Frames</span>
        <NumberField
          label="First frame that is changed"
          value={span.first}
          min={0}
          max={last}
          change={(first) => select(first, Math.max(first, span.last))}
        />
        <span>to</span>
        <NumberField
          label="Last frame that is changed"
          value={span.last}
          min={0}
          max={last}
          change={(to) => select(Math.min(span.first, to), to)}
        />
        <div class="choice" role="group" aria-label="Joints that are changed">
          <button aria-pressed={!desk.allJoints} onClick={() => desk.setAllJoints(false)}>
            This joint
          </button>
          <button aria-pressed={desk.allJoints} onClick={() => desk.setAllJoints(true)}>
            All joints
          </button>
        </div>
      </div>
      <div class="row take-acts">
        <button
          disabled={!canHold(desk)}
          title="They stand as the first"
          onClick={() => hold(desk)}
        >
          Hold <kbd>H</kbd>
        </button>
        <button disabled={!canMove(desk, -1)} onClick={() => move(desk, -1)}>
          Earlier <kbd>[</kbd>
        </button>
        <button disabled={!canMove(desk, 1)} onClick={() => move(desk, 1)}>
          Later <kbd>]</kbd>
        </button>
        <button title="All joints: the last one is shown for one more" onClick={() => longer(desk)}>
          Longer <kbd>D</kbd>
        </button>
        <button
          disabled={!canDelete(desk)}
          title="All joints: the frames after them move up"
          onClick={() => takeOut(desk)}
        >
          Take out <kbd>Del</kbd>
        </button>
      </div>
    </div>
  )
}

function Joints({ desk }: { desk: TakeDesk }) {
  const [filter, setFilter] = useState('')
  const wanted = filter.toLowerCase()
  const rows = desk.take.joints
    .map((joint, index) => ({ joint, index }))
    .filter(({ joint }) => joint.name.toLowerCase().includes(wanted))
  return (
    <>
      <input
        type="search"
        class="take-filter"
        aria-label="Find a joint"
        placeholder="Find a joint"
        value={filter}
        onInput={(event) => setFilter(event.currentTarget.value)}
      />
      <ul class="take-joints">
        {rows.map(({ joint, index }) => (
          <li key={joint.name}>
            <input
              type="checkbox"
              aria-label={`Show the curve of ${joint.name}`}
              title="Show the curve beside the chosen one"
              checked={desk.pinned.includes(index)}
              onChange={(event) => desk.pin(index, event.currentTarget.checked)}
            />
            <button
              class="quiet"
              aria-pressed={index === desk.chosen}
              onClick={() => desk.choose(index)}
            >
              <span
                class="tl-swatch"
                style={{ background: colorOf(desk, index) }}
                aria-hidden="true"
              />
              <span class="name">{joint.name}</span>
              <span class="number">
                {valueWords(joint, joint.values[Math.min(desk.frame, joint.values.length - 1)])}
              </span>
            </button>
          </li>
        ))}
      </ul>
      {rows.length === 0 && <p class="small soft">No joint is called so.</p>}
    </>
  )
}

function Changes({ desk }: { desk: TakeDesk }) {
  const { done, undone } = desk.edits
  if (done.length + undone.length === 0)
    return (
      <p class="small soft">
        Nothing is changed yet. Changes stay in this browser until they are saved as a new take; the
        recorded one is never touched.
      </p>
    )
  return (
    <ol class="take-changes" aria-label="Changes">
      {done.map((change, i) => (
        <li key={`${i} ${change.join()}`}>{change.map(lineWords).join('; ')}</li>
      ))}
      {[...undone].reverse().map((change, i) => (
        <li key={`undone ${i}`} class="soft">
          <s>{change.map(lineWords).join('; ')}</s> undone
        </li>
      ))}
    </ol>
  )
}

export function Side({ desk }: { desk: TakeDesk }) {
  const [tab, setTab] = useState<Tab>('Joints')
  const turn = (event: KeyboardEvent) => {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key] ?? 0
    if (by === 0) return
    event.preventDefault()
    const next = kTabs[(kTabs.indexOf(tab) + by + kTabs.length) % kTabs.length]
    setTab(next)
    document.getElementById(`take-tab-${next}`)?.focus()
  }
  const words = (name: Tab) =>
    name === 'Changes' && desk.edits.done.length > 0
      ? count(desk.edits.done.length, 'change')
      : name
  return (
    <aside class="tl-side" aria-label="Details">
      <div class="take-now">
        <Value desk={desk} />
        <Frames desk={desk} />
      </div>
      <div class="tl-tabs" role="tablist" aria-label="Details" onKeyDown={turn}>
        {kTabs.map((name) => (
          <button
            key={name}
            id={`take-tab-${name}`}
            role="tab"
            aria-selected={name === tab}
            aria-controls="take-panel"
            tabIndex={name === tab ? 0 : -1}
            onClick={() => setTab(name)}
          >
            {words(name)}
          </button>
        ))}
      </div>
      <div id="take-panel" class="tl-panel" role="tabpanel" aria-labelledby={`take-tab-${tab}`}>
        {tab === 'Joints' && <Joints desk={desk} />}
        {tab === 'Changes' && <Changes desk={desk} />}
        {tab === 'Bake' && <BakePanel desk={desk} />}
      </div>
    </aside>
  )
}
