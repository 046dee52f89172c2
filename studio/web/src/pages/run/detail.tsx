// One step: why it runs, how to run it, its options and its log.
import { useEffect, useRef, useState } from 'preact/hooks'
import type { RefObject } from 'preact'

import { api, ApiError } from '../../api'
import type { Stage, Step } from '../../api'
import { FailureSheet } from '../../sheet'
import { useStudio } from '../../state'
import { Bar } from '../../bar'
import { percent } from '../../words'
import { kAsksForFigure } from '../poses/pose_side'
import { addressOf } from '../poses/route'
import { Icon } from './icons'
import { Log } from './log'
import { OptionForm } from './option_form'
import type { Change } from './option_form'
import { Explanation } from './reasons'
import { kStateWords, shownState } from './step_words'

function useExplanation(id: string): string {
  const { version, complain } = useStudio()
  const [known, setKnown] = useState({ id: '', text: '' })
  useEffect(() => {
    let alive = true
    api
      .explain(id)
      .then(({ text }) => alive && setKnown({ id, text }))
      .catch((error) => alive && complain(error))
    return () => {
      alive = false
    }
  }, [id, version, complain])
  return known.id === id ? known.text : ''
}

function RunButtons({ step }: { step: Step }) {
  const { steps, running, reload, tell, complain } = useStudio()
  const blocked = steps.locked_by || (running ? 'A run is at work.' : '')
  const start = (selection: Parameters<typeof api.run>[0]) =>
    api
      .run(selection)
      .then(reload)
      .catch(async (error) => {
        complain(error)
        if (error instanceof ApiError && error.status === 409) await reload()
      })
  const done = step.state === 'done'
  const only = { only: [step.id] }
  return (
    <div class="run-buttons">
      <div class="row">
        {running ? (
          <button onClick={() => api.stop().then(() => tell('The run stops.')).catch(complain)}>
            Stop the run
          </button>
        ) : (
          <button
            class={done || blocked ? '' : 'main'}
            disabled={blocked !== '' || done}
            title="This step and all that it needs"
            onClick={() => start({ until: [step.id] })}
          >
            Run until here
          </button>
        )}
        <button
          disabled={blocked !== '' || done}
          title="Just this step, from inputs as last made"
          onClick={() => start(only)}
        >
          Run this only
        </button>
        <button
          disabled={blocked !== '' || (!done && step.state !== 'failed')}
          title="Run it again, even though it is up to date"
          onClick={() => start({ ...only, force: [step.id] })}
        >
          Force
        </button>
      </div>
      {blocked && !running && <p class="warn small">{blocked}</p>}
    </div>
  )
}

type Tab = 'options' | 'log'

function Tabs(props: { tab: Tab; set: (tab: Tab) => void; options: number }) {
  const tabs: [Tab, string][] = [
    ['options', `Options ${props.options || ''}`],
    ['log', 'Log'],
  ]
  const onKeyDown = (event: KeyboardEvent) => {
    if (event.key !== 'ArrowLeft' && event.key !== 'ArrowRight') return
    const other = props.tab === 'log' ? 'options' : 'log'
    props.set(other)
    document.getElementById(`run-tab-${other}`)?.focus()
  }
  return (
    <div class="run-tabs" role="tablist" aria-label="Of this step" onKeyDown={onKeyDown}>
      {tabs.map(([tab, words]) => (
        <button
          key={tab}
          id={`run-tab-${tab}`}
          role="tab"
          aria-selected={props.tab === tab}
          aria-controls="run-tab-panel"
          tabIndex={props.tab === tab ? 0 : -1}
          onClick={() => props.set(tab)}
        >
          {words}
        </button>
      ))}
    </div>
  )
}

function Head({ step, heading }: { step: Step; heading: RefObject<HTMLHeadingElement> }) {
  const { running } = useStudio()
  const state = shownState(step, running)
  const work = running?.steps[step.id]
  return (
    <header>
      <div class="row spread">
        <h2 ref={heading} tabIndex={-1}>
          {step.title}
          {step.pose && <span class="soft"> {step.pose}</span>}
        </h2>
        <span class={`run-state ${state}`}>
          <Icon name={state} />
          {work ? percent(work.fraction) : kStateWords[state]}
        </span>
      </div>
      {work && (
        <div class="now">
          <Bar share={work.fraction} />
          <p class="small soft">{work.what}</p>
        </div>
      )}
    </header>
  )
}

function Failure({ step }: { step: Step }) {
  const { project } = useStudio()
  if (step.state !== 'failed') return null
  const films = project.kind === 'performance'
  const asksForFigure = step.error.includes(kAsksForFigure)
  return (
    <div class="run-failure">
      <b>It failed.</b>
      {step.error && <p>{step.error}</p>}
      {step.pictures.map((one) => (
        <FailureSheet key={one.picture} picture={one} figure={asksForFigure} />
      ))}
      {asksForFigure && step.pose && (
        <p>
          <a href={films ? '#/films' : addressOf({ pose: step.pose, tab: 'figure', item: '' })}>Show what it is ›</a>
        </p>
      )}
    </div>
  )
}

export function Detail(props: {
  step: Step
  /** null: not yet read; 'unknown': a program that does not describe itself */
  stage: Stage | 'unknown' | null
  query: string
  setChange: (change: Change | null) => void
  open: (id: string) => void
  heading: RefObject<HTMLHeadingElement>
}) {
  const { running } = useStudio()
  const { step } = props
  const stage = props.stage === 'unknown' ? null : props.stage
  const isRunning = running?.steps[step.id] !== undefined
  const wantsLog = isRunning || step.state === 'failed'
  const [tab, setTab] = useState<Tab>(wantsLog ? 'log' : 'options')
  const text = useExplanation(step.id)
  const shownFor = useRef(step.id)
  useEffect(() => {
    // Another step: what matters most of it. The same step keeps the tab that its reader chose.
    if (shownFor.current !== step.id) setTab(wantsLog ? 'log' : 'options')
    shownFor.current = step.id
  }, [step.id, wantsLog])
  useEffect(() => {
    if (props.query) setTab('options')
  }, [props.query])
  return (
    <div class={`run-detail ${tab}`}>
      <Head step={step} heading={props.heading} />
      {!props.query && (
        <>
          {stage?.summary && <p class="soft small">{stage.summary}</p>}
          <RunButtons step={step} />
          <Failure step={step} />
          {text && !isRunning && (
            <Explanation
              text={text}
              about={step.id}
              withoutNotes={step.state === 'failed'}
              open={props.open}
            />
          )}
        </>
      )}
      <Tabs tab={tab} set={setTab} options={stage?.options.length ?? 0} />
      <div id="run-tab-panel" role="tabpanel" aria-labelledby={`run-tab-${tab}`}>
        {tab === 'log' && <Log id={step.id} isRunning={isRunning} />}
        {tab === 'options' && stage && (
          <OptionForm
            key={step.id}
            step={step}
            stage={stage}
            query={props.query}
            setChange={props.setChange}
          />
        )}
        {tab === 'options' && !stage && (
          <p class="soft">
            {props.stage === 'unknown'
              ? 'This step is a program of the project’s own; it tells no options.'
              : 'Reads the options …'}
          </p>
        )}
      </div>
    </div>
  )
}
