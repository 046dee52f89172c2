// The Run page: all steps as a board, and beside it the chosen step.
import { useEffect, useRef, useState } from 'preact/hooks'

import type { Step } from '../api'
import { useStudio } from '../state'
import { inField } from './poses/keys'
import { Board } from './run/board'
import { Detail } from './run/detail'
import { Effect } from './run/effect'
import { OptionSearch, OtherMatches } from './run/option_form'
import type { Change } from './run/option_form'
import { effectOf } from './run/step_words'
import { Findings, RunUnderWay, Summary } from './run/summary'
import { useStages } from './run/use_stages'
import './run/run.css'

const fromAddress = () => decodeURIComponent(location.hash.replace(/^#\/run\/?/, ''))

/** The chosen step is in the address, so that other pages can lead to it: #/run/dense%2Frest */
function useChosen(): [string, (id: string) => void] {
  const [chosen, setChosen] = useState(fromAddress)
  useEffect(() => {
    const changed = () => location.hash.startsWith('#/run') && setChosen(fromAddress())
    addEventListener('hashchange', changed)
    return () => removeEventListener('hashchange', changed)
  }, [])
  const choose = (id: string) => {
    history.replaceState(null, '', `#/run/${encodeURIComponent(id)}`)
    setChosen(id)
  }
  return [chosen, choose]
}

/** The step to look at when none is chosen: what fails, works, or would run. */
function worthALook(steps: Step[], atWork: Set<string>): string {
  const wanted = (test: (step: Step) => boolean) => steps.find(test)?.id
  return (
    wanted((step) => step.state === 'failed') ??
    wanted((step) => atWork.has(step.id)) ??
    wanted((step) => step.state === 'would_run' || step.state === 'never') ??
    ''
  )
}

function Hint() {
  return (
    <div class="empty">
      <h2>Choose a step</h2>
      <p>Its reasons, options and log show here. Arrow keys move over the board, Enter opens.</p>
    </div>
  )
}

export function RunPage() {
  const { steps, running } = useStudio()
  const stages = useStages()
  const [chosen, choose] = useChosen()
  const [query, setQuery] = useState('')
  const [change, setChange] = useState<Change | null>(null)
  const search = useRef<HTMLInputElement>(null)
  const heading = useRef<HTMLHeadingElement>(null)
  const [first] = useState(() => {
    return worthALook(steps.steps, new Set(Object.keys(running?.steps ?? {})))
  })
  const id = chosen || first
  const step = steps.steps.find((one) => one.id === id)
  // Marks what the last change of an option has set off, until a run makes it old.
  const effect = change ? effectOf(change.steps, steps.steps) : { ids: [], text: '' }

  useEffect(() => {
    if (running) setChange(null)
  }, [running !== null])
  useEffect(() => {
    const onKey = (event: KeyboardEvent) => {
      if (event.key !== '/' || event.ctrlKey || event.metaKey || inField(event)) return
      event.preventDefault()
      search.current?.focus()
    }
    addEventListener('keydown', onKey)
    return () => removeEventListener('keydown', onKey)
  }, [])
  const open = (next: string, byKey = false) => {
    choose(next)
    if (byKey) requestAnimationFrame(() => heading.current?.focus())
  }
  const backToBoard = (event: KeyboardEvent) => {
    if (event.key !== 'Escape') return
    document.querySelector<HTMLElement>(`.run-board [data-id="${CSS.escape(id)}"]`)?.focus()
  }
  const summaries = new Map(
    steps.steps.map((one) => [
      one.step,
      stages?.find((stage) => stage.stage === one.stage)?.summary ?? '',
    ]),
  )
  return (
    <main class="page run-page">
      <h1 class="hidden">Run</h1>
      <div class="work">
        <Summary />
        <RunUnderWay />
        <Board selected={id} fresh={effect.ids} open={open} summaries={summaries} />
        <Findings open={open} />
      </div>
      <aside class="run-side" aria-label="The chosen step" onKeyDown={backToBoard}>
        <OptionSearch query={query} setQuery={setQuery} input={search} />
        <div class="run-scroll">
          {step ? (
            <Detail
              step={step}
              stage={stages && (stages.find((one) => one.stage === step.stage) ?? 'unknown')}
              query={query}
              setChange={setChange}
              open={open}
              heading={heading}
            />
          ) : (
            !query && <Hint />
          )}
          {query && stages && (
            <OtherMatches query={query} stages={stages} except={step?.step ?? ''} open={open} />
          )}
        </div>
        {change && <Effect change={change} text={effect.text} dismiss={() => setChange(null)} />}
      </aside>
    </main>
  )
}
