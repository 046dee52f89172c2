// The suggestions and the pairs as lists to go through by keyboard.
import type { ComponentChildren } from 'preact'
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks'

import { cssShare, percent } from '../../words'
import { RowTools } from './bench_pieces'
import type { Item } from './markers'
import type { Picking } from './picking'

type PairItem = Extract<Item, { kind: 'pair' }>
type SuggestionItem = Extract<Item, { kind: 'suggestion' }>

const kSure = 0.8

/** A row's button. The chosen one is scrolled to, and keeps the focus if the list has it. */
export function RowButton(props: {
  id: string
  chosen: boolean
  title?: string
  onClick: () => void
  onDblClick?: () => void
  children: ComponentChildren
}) {
  const button = useRef<HTMLButtonElement>(null)
  useEffect(() => {
    if (!props.chosen) return
    button.current?.scrollIntoView({ block: 'nearest' })
    const now = document.activeElement
    const free = now === document.body || now?.closest('.lm-rows')
    if (free && !(now instanceof HTMLInputElement)) button.current?.focus()
  }, [props.chosen])
  return (
    <button
      ref={button}
      class="lm-row"
      data-row={props.id}
      aria-current={props.chosen ? 'true' : undefined}
      title={props.title}
      onClick={props.onClick}
      onDblClick={props.onDblClick}
    >
      {props.children}
    </button>
  )
}

export function RenameField({
  from,
  picking,
}: {
  from: string
  picking: Pick<Picking, 'setRenaming' | 'rename'>
}) {
  const field = useRef<HTMLInputElement>(null)
  const given_up = useRef(false)
  // Kept here: the list is drawn again at each event, and would put the old name back.
  const [name, setName] = useState(from)
  // Before the next key comes, however long a frame takes.
  useLayoutEffect(() => {
    field.current?.focus()
    field.current?.select()
  }, [])
  return (
    <input
      ref={field}
      class="lm-rename"
      aria-label={`New name of ${from}`}
      value={name}
      maxLength={64}
      onInput={(event) => setName(event.currentTarget.value)}
      onBlur={(event) => !given_up.current && picking.rename(from, event.currentTarget.value)}
      onKeyDown={(event) => {
        if (event.key === 'Escape') given_up.current = true
        if (event.key === 'Escape') picking.setRenaming('')
        if (event.key === 'Enter') event.currentTarget.blur()
        event.stopPropagation()
      }}
    />
  )
}

function missingSide(item: PairItem, picking: Picking): string {
  if (!item.pair.template) return `not on ${picking.template}`
  if (!item.pair.pose) return `not on ${picking.pose}`
  return ''
}

function PairRow({ item, picking }: { item: PairItem; picking: Picking }) {
  const { name } = item.pair
  const missing = missingSide(item, picking)
  const problem = picking.problems.get(name) ?? ''
  const chosen = item.id === picking.chosen
  const state = problem ? 'problem' : missing ? 'open' : 'whole'
  if (picking.renaming === name)
    return (
      <li>
        <RenameField from={name} picking={picking} />
      </li>
    )
  return (
    <li class={chosen ? 'chosen' : ''}>
      <RowButton
        id={item.id}
        chosen={chosen}
        title="Double click or F2 renames"
        onClick={() => picking.choose(item)}
        onDblClick={() => picking.setRenaming(name)}
      >
        <i class={`lm-dot ${state}`} aria-hidden="true" />
        <span class="lm-name">{name}</span>
        {missing && <span class="lm-state">{missing}</span>}
        {problem && <span class="hidden">has a problem</span>}
      </RowButton>
      <RowTools
        name={name}
        rename={() => picking.setRenaming(name)}
        remove={() => picking.remove(item)}
      />
      {problem && <p class="lm-problem">{problem}</p>}
    </li>
  )
}

function SuggestionRow({ item, picking }: { item: SuggestionItem; picking: Picking }) {
  const { number, suggestion } = item
  const sure = percent(suggestion.confidence)
  const chosen = item.id === picking.chosen
  return (
    <li class={chosen ? 'chosen' : ''}>
      <RowButton
        id={item.id}
        chosen={chosen}
        title="Enter accepts, Backspace refuses"
        onClick={() => picking.choose(item)}
      >
        <i class="lm-dot suggested" aria-hidden="true" />
        <span class="lm-name number">
          <span class="hidden">Suggestion </span>
          {number}
        </span>
        <span class="lm-sure" aria-hidden="true">
          <span style={{ width: cssShare(suggestion.confidence) }} />
        </span>
        <span class="lm-state number">{sure}</span>
      </RowButton>
      <span class="lm-tools always">
        <button
          class="quiet good"
          aria-label={`Accept suggestion ${number}`}
          title="Accept (Enter)"
          onClick={() => picking.decide(true, item)}
        >
          ✓
        </button>
        <button
          class="quiet"
          aria-label={`Refuse suggestion ${number}`}
          title="Refuse (Backspace)"
          onClick={() => picking.decide(false, item)}
        >
          ×
        </button>
      </span>
    </li>
  )
}

export function SuggestionList({ picking }: { picking: Picking }) {
  const rows = picking.items.filter((item) => item.kind === 'suggestion')
  if (rows.length === 0) return null
  const sure = rows.filter((item) => item.suggestion.confidence > kSure).length
  return (
    <section class="lm-suggested" aria-label="Suggestions">
      <div class="row spread">
        <h2 class="lm-title">Suggested · {rows.length}</h2>
        <button class="quiet small" onClick={picking.refuseAll}>
          Refuse all
        </button>
      </div>
      <ul class="lm-rows">
        {rows.map((item) => (
          <SuggestionRow key={item.id} item={item} picking={picking} />
        ))}
      </ul>
      {sure > 0 && (
        <button
          class="lm-wide"
          data-action="accept-sure"
          onClick={() => picking.acceptAbove(kSure)}
        >
          Accept all above {percent(kSure)}
          <span class="soft number">{sure}</span>
        </button>
      )}
    </section>
  )
}

export function PairList({ picking }: { picking: Picking }) {
  const rows = picking.items.filter((item) => item.kind === 'pair')
  const open = rows.filter((item) => !item.pair.template || !item.pair.pose).length
  const whole = rows.length - open
  return (
    <section class="lm-pairs" aria-label="Landmarks">
      <div class="row spread">
        <h2 class="lm-title">
          Pairs · <span class="number">{whole}</span>
          {open > 0 && <span class="lm-open"> · {open} open</span>}
        </h2>
        <UndoButtons
          undo={picking.undo}
          redo={picking.redo}
          canUndo={picking.pending !== null || picking.files.history.past.length > 0}
          canRedo={picking.files.history.future.length > 0}
        />
      </div>
      {rows.length === 0 && picking.files.loaded && (
        <p class="small soft">
          None yet: click a place on {picking.template}, then the same one on {picking.pose}, or
          press Suggest.
        </p>
      )}
      <ul class="lm-rows">
        {rows.map((item) => (
          <PairRow key={item.id} item={item} picking={picking} />
        ))}
      </ul>
    </section>
  )
}

export function UndoButtons(props: {
  undo: () => void
  redo: () => void
  canUndo: boolean
  canRedo: boolean
}) {
  return (
    <span class="lm-undo">
      <button
        class="quiet"
        aria-label="Undo"
        title="Undo (Ctrl+Z)"
        disabled={!props.canUndo}
        onClick={props.undo}
      >
        ↶
      </button>
      <button
        class="quiet"
        aria-label="Redo"
        title="Redo (Ctrl+Shift+Z)"
        disabled={!props.canRedo}
        onClick={props.redo}
      >
        ↷
      </button>
    </span>
  )
}
