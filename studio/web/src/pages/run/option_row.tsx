// One option of a stage: name, input that fits its type, help, range, and where it is set.
import { useEffect, useRef, useState } from 'preact/hooks'

import { problemOf, rangeOf, number, sameValue, stepped } from './option_check'
import { Icon } from './icons'
import type { KnownOption } from './use_stages'

export interface OptionState {
  option: KnownOption
  /** as the step uses it */
  value: string
  /** where pipeline.yaml sets it; null: it does not */
  set: { text: string; line: number; pose: boolean } | null
}

const kMostButtons = 4
const kMostLetters = 26

/** A few short choices stand side by side; more of them go into a list. */
function asButtons(choices: string[]): boolean {
  return choices.length <= kMostButtons && choices.join('').length <= kMostLetters
}

interface InputProps {
  id: string
  state: OptionState
  disabled: boolean
  /** false: it was refused */
  save: (value: string) => Promise<boolean>
}

function Switch({ id, state, disabled, save }: InputProps) {
  const on = state.value === 'true'
  return (
    <button
      id={id}
      class="run-switch"
      role="switch"
      aria-checked={on}
      aria-label={state.option.name}
      aria-describedby={`${id}-help`}
      disabled={disabled}
      onClick={() => void save(String(!on))}
    >
      <i aria-hidden="true" />
      {on ? 'on' : 'off'}
    </button>
  )
}

function Choices({ id, state, disabled, save }: InputProps) {
  const choices = state.option.choices ?? []
  if (asButtons(choices))
    return (
      <div
        class="choice"
        role="group"
        aria-label={state.option.name}
        aria-describedby={`${id}-help`}
      >
        {choices.map((choice) => (
          <button
            key={choice}
            aria-pressed={choice === state.value}
            disabled={disabled}
            onClick={() => choice !== state.value && void save(choice)}
          >
            {choice}
          </button>
        ))}
      </div>
    )
  return (
    <select
      id={id}
      aria-label={state.option.name}
      aria-describedby={`${id}-help`}
      disabled={disabled}
      value={state.value}
      onChange={(event) => void save(event.currentTarget.value)}
    >
      {choices.map((choice) => (
        <option key={choice}>{choice}</option>
      ))}
    </select>
  )
}

function TextOrNumber({ id, state, disabled, save }: InputProps) {
  const { option, value } = state
  const [draft, setDraft] = useState(value)
  const sent = useRef(value)
  useEffect(() => {
    sent.current = value
    setDraft(value)
  }, [value, option.name])
  const problem = problemOf(option, draft)
  const latest = useRef(value)
  latest.current = value
  const commit = async () => {
    // Enter is followed by leaving the field: the same value is not sent twice.
    if (problem || sameValue(option, draft, sent.current)) return
    sent.current = draft.trim()
    if (await save(draft.trim())) return
    sent.current = latest.current
    setDraft(latest.current)
  }
  const numeric = option.type !== 'string'
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key === 'Enter') void commit()
    if (event.key === 'Escape' && draft !== value) {
      event.stopPropagation() // the first Escape takes the text back, the next leaves the panel
      setDraft(value)
    }
    if (numeric && (event.key === 'ArrowUp' || event.key === 'ArrowDown')) {
      event.preventDefault()
      setDraft(stepped(option, draft, event.key === 'ArrowUp' ? 1 : -1))
    }
  }
  return (
    <>
      <span class={`field ${numeric ? 'numeric' : ''}`}>
        <input
          id={id}
          type="text"
          inputMode={numeric ? 'decimal' : 'text'}
          spellcheck={false}
          autocomplete="off"
          placeholder={numeric ? '' : 'empty'}
          aria-label={option.name}
          aria-describedby={`${id}-help ${id}-problem`}
          aria-invalid={problem !== ''}
          disabled={disabled}
          value={draft}
          onInput={(event) => setDraft(event.currentTarget.value)}
          onBlur={() => void commit()}
          onKeyDown={onKeyDown}
        />
        {option.unit && <small title={option.unit}>{option.unit}</small>}
      </span>
      <p id={`${id}-problem`} class="problem" role="alert">
        {problem}
      </p>
    </>
  )
}

function Where({ state }: { state: OptionState }) {
  const { option, value, set } = state
  const facts: string[] = []
  const range = rangeOf(option)
  if (range) facts.push(range)
  facts.push(`default ${defaultWords(option)}`)
  return (
    <p class="where">
      <span>{facts.join(' · ')}</span>
      {set && (
        <span class="set">
          pipeline.yaml, line {set.line}
          {set.pose ? ', this pose' : ''}
        </span>
      )}
      {!set && !sameValue(option, value, option.default) && (
        <span>set by the default pipeline</span>
      )}
    </p>
  )
}

function defaultWords(option: KnownOption): string {
  if (option.type === 'bool') return option.default === 'true' ? 'on' : 'off'
  if (option.type === 'string') return option.default || 'empty'
  return number(Number(option.default))
}

export function OptionRow(props: {
  state: OptionState
  disabled: boolean
  /** null: back to the default */
  save: (value: string | null) => Promise<boolean>
}) {
  const { option, set } = props.state
  const id = `option-${option.name}`
  const choices = (option.choices ?? []).length > 0
  const Input = option.type === 'bool' ? Switch : choices ? Choices : TextOrNumber
  return (
    <li class={`run-option ${set ? 'is-set' : ''}`}>
      <div class="head">
        <span class="name">{option.name.replaceAll('_', ' ')}</span>
        <Input id={id} state={props.state} disabled={props.disabled} save={props.save} />
      </div>
      <p id={`${id}-help`} class="help">
        {option.help}
      </p>
      <div class="foot">
        <Where state={props.state} />
        {set && (
          <button
            class="link"
            disabled={props.disabled}
            aria-label={`${option.name}: back to the default`}
            onClick={() => void props.save(null)}
          >
            <Icon name="undo" />
            back to the default
          </button>
        )}
      </div>
    </li>
  )
}
