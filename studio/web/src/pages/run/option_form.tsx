// The options of a step as a form that its stage's --describe dictates, with a search over all.
import { useState } from 'preact/hooks'
import type { RefObject } from 'preact'

import { api, ApiError } from '../../api'
import type { Stage, Step } from '../../api'
import { useStudio } from '../../state'
import { Icon } from './icons'
import { OptionRow } from './option_row'
import type { OptionState } from './option_row'
import type { KnownOption } from './use_stages'

export interface Change {
  step: string
  pose: string
  option: string
  from: string
  to: string
  /** what pipeline.yaml said before; null: nothing */
  before: string | null
  /** the steps before the change, to tell what it has set off */
  steps: Step[]
}

/** Sets an option, loads the project again, and returns what that did to the steps' states. */
export function useSetOption(): (
  change: Omit<Parameters<typeof api.setOption>[0], 'revision'>,
) => Promise<boolean> {
  const { project, reload, tell, complain } = useStudio()
  return async (change) => {
    try {
      await api.setOption({ ...change, revision: project.revision })
      await reload()
      return true
    } catch (error) {
      if (error instanceof ApiError && error.status === 409) {
        await reload()
        tell(`${error.message} The page shows it as it is now; change it again.`)
      } else complain(error)
      return false
    }
  }
}

export function statesOf(step: Step, stage: Stage): OptionState[] {
  return stage.options.map((option) => ({
    option,
    value: step.options[option.name] ?? option.default,
    set: step.set[option.name] ?? null,
  }))
}

function matches(option: KnownOption, stage: string, query: string): boolean {
  const name = `${option.name} ${option.name.replaceAll('_', ' ')}`
  const text = `${name} ${option.help} ${stage} ${(option.choices ?? []).join(' ')}`.toLowerCase()
  return query.toLowerCase().split(/\s+/).every((word) => text.includes(word))
}

/** Options that people change, and those that the project sets, come first. */
function firstOf(states: OptionState[]): Set<string> {
  const some = states.some((one) => one.option.common)
  const first = states.filter((one) => !some || one.option.common || one.set !== null)
  return new Set(first.map((one) => one.option.name))
}

export function OptionSearch(props: {
  query: string
  setQuery: (query: string) => void
  input: RefObject<HTMLInputElement>
}) {
  return (
    <div class="run-search">
      <Icon name="search" />
      <input
        ref={props.input}
        type="search"
        placeholder="Search all options"
        aria-label="Search all options"
        aria-keyshortcuts="/"
        value={props.query}
        onInput={(event) => props.setQuery(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key !== 'Escape' || props.query === '') return
          event.stopPropagation()
          props.setQuery('')
        }}
      />
      <kbd aria-hidden="true">/</kbd>
    </div>
  )
}

/** Options of the other steps that fit the search, to jump to. */
export function OtherMatches(props: {
  query: string
  stages: Stage[]
  /** the step whose own options are shown already, or '' */
  except: string
  open: (id: string) => void
}) {
  const { steps } = useStudio()
  const seen = new Set([props.except])
  const found: { step: Step; option: KnownOption }[] = []
  for (const step of steps.steps) {
    if (seen.has(step.step)) continue
    seen.add(step.step)
    const stage = props.stages.find((one) => one.stage === step.stage)
    for (const option of stage?.options ?? [])
      if (matches(option, step.step, props.query)) found.push({ step, option })
  }
  if (found.length === 0) return null
  return (
    <section class="run-others">
      <h2>{props.except ? 'In other steps' : 'Options'}</h2>
      <ul class="list">
        {found.slice(0, 40).map(({ step, option }) => (
          <li key={`${step.step}.${option.name}`}>
            <button onClick={() => props.open(step.id)} title={option.help}>
              <span>
                {option.name.replaceAll('_', ' ')} <small>{option.help}</small>
              </span>
              <small>{step.title}</small>
            </button>
          </li>
        ))}
      </ul>
    </section>
  )
}

function Scope(props: { pose: string; onlyThis: boolean; set: (onlyThis: boolean) => void }) {
  return (
    <div class="row run-scope">
      <span class="small soft">A change is for</span>
      <div class="choice" role="group" aria-label="A change is for">
        <button aria-pressed={!props.onlyThis} onClick={() => props.set(false)}>
          all poses
        </button>
        <button aria-pressed={props.onlyThis} onClick={() => props.set(true)}>
          {props.pose} only
        </button>
      </div>
    </div>
  )
}

export function OptionForm(props: {
  step: Step
  stage: Stage
  query: string
  setChange: (change: Change | null) => void
}) {
  const { steps } = useStudio()
  const { step, stage, query } = props
  const [onlyThis, setOnlyThis] = useState(false)
  const [busy, setBusy] = useState(false)
  const setOption = useSetOption()
  const siblings = steps.steps.filter((one) => one.step === step.step)
  const canBeForPose = step.pose !== '' && siblings.length > 1
  const states = statesOf(step, stage)
  // Asked once: an option does not jump to another place when it is set.
  const [firstNames] = useState(() => firstOf(states))

  const save = async (state: OptionState, value: string | null) => {
    const { option, set } = state
    // Taking a value back must happen where it stands.
    const forPose = value === null ? set?.pose === true : canBeForPose && onlyThis
    const pose = forPose ? step.pose : ''
    const before = set && set.pose === forPose ? set.text : null
    setBusy(true)
    const done = await setOption({ step: step.step, pose, option: option.name, value })
    setBusy(false)
    const to = value ?? option.default
    const change = { step: step.step, pose, option: option.name, before, steps: steps.steps }
    if (done) props.setChange({ ...change, from: state.value, to })
    return done
  }
  const row = (state: OptionState) => (
    <OptionRow
      key={state.option.name}
      state={state}
      disabled={busy}
      save={(value) => save(state, value)}
    />
  )
  const found = states.filter((one) => matches(one.option, step.step, query))
  const more = query ? [] : states.filter((one) => !firstNames.has(one.option.name))
  const first = query ? found : states.filter((one) => firstNames.has(one.option.name))
  return (
    <div class="run-options">
      {canBeForPose && <Scope pose={step.pose} onlyThis={onlyThis} set={setOnlyThis} />}
      {query && found.length === 0 && (
        <p class="soft">No option of this step has “{query}” in its name or help.</p>
      )}
      <ul>{first.map(row)}</ul>
      {more.length > 0 && (
        <details>
          <summary>{more.length} more options</summary>
          <ul>{more.map(row)}</ul>
        </details>
      )}
    </div>
  )
}

