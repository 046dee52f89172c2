// What the project's steps come to: counts, the run under way, verdicts and warnings.
import type { Verdict, Warning } from '../../api'
import { useStudio } from '../../state'
import { Bar } from '../../bar'
import { percent, stepTitle } from '../../words'
import { Icon } from './icons'
import { kStateWords, shownState } from './step_words'
import type { Shown } from './step_words'

const kOrder: Shown[] = ['running', 'failed', 'would_run', 'waits', 'never', 'missing', 'done']

/** Beside a number. */
const kCountWords: Partial<Record<Shown, string>> = { done: 'up to date', waits: 'wait' }

function nextWords(counts: Map<Shown, number>, lockedBy: string, isRunning: boolean): string {
  if (lockedBy) return `Locked: ${lockedBy}`
  if (isRunning) return ''
  const has = (state: Shown) => (counts.get(state) ?? 0) > 0
  if (has('failed')) return 'A step has failed: choose it to read why.'
  if (!has('done') && has('never')) return 'Nothing has run yet: press Run, at the top right.'
  if (has('would_run') || has('never') || has('waits')) return 'Press Run to bring all up to date.'
  return 'All is up to date.'
}

export function Summary() {
  const { steps, running } = useStudio()
  const counts = new Map<Shown, number>()
  for (const step of steps.steps) {
    const state = shownState(step, running)
    counts.set(state, (counts.get(state) ?? 0) + 1)
  }
  const next = nextWords(counts, steps.locked_by, running !== null)
  return (
    <header class="run-summary">
      <ul aria-label="States of the steps">
        {kOrder
          .filter((state) => counts.has(state))
          .map((state) => (
            <li key={state} class={state}>
              <Icon name={state} />
              <b class="number">{counts.get(state)}</b>{' '}
              {kCountWords[state] ?? kStateWords[state]}
            </li>
          ))}
      </ul>
      <p class={steps.locked_by ? 'warn' : 'soft'}>{next}</p>
    </header>
  )
}

export function RunUnderWay() {
  const { running } = useStudio()
  if (!running) return null
  const last = running.notes[running.notes.length - 1]
  return (
    <section class="run-now" aria-label="The run under way">
      <b class="number">{percent(running.overall)}</b>
      <Bar share={running.overall} />
      <span class="soft number">{running.left === null ? '' : `${running.left} left`}</span>
      {last && (
        <details>
          <summary title={last}>{last}</summary>
          <ul>
            {running.notes.map((note, i) => (
              <li key={i}>{note}</li>
            ))}
          </ul>
        </details>
      )}
    </section>
  )
}

function VerdictLine({ verdict }: { verdict: Verdict }) {
  return (
    <li>
      <span class={`grade ${verdict.grade}`}>
        <Icon name={verdict.grade} />
        {verdict.grade}
      </span>
      <b>{verdict.about}</b>
      <span>{verdict.why}</span>
    </li>
  )
}

function WarningLine({ warning, open }: { warning: Warning; open: (id: string) => void }) {
  const { steps } = useStudio().steps
  return (
    <li>
      <span class="grade look">
        <Icon name="warning" />
        <span class="hidden">warning</span>
      </span>
      <span class="from">
        {warning.steps.map((id) => (
          <button key={id} class="link" onClick={() => open(id)}>
            {stepTitle(id, steps)} <code>{id}</code>
          </button>
        ))}
      </span>
      <span>{warning.text}</span>
    </li>
  )
}

export function Findings({ open }: { open: (id: string) => void }) {
  const { steps } = useStudio()
  return (
    <>
      {steps.verdicts.length > 0 && (
        <section class="run-findings">
          <h2>Verdicts</h2>
          <ul>
            {steps.verdicts.map((one, i) => (
              <VerdictLine key={i} verdict={one} />
            ))}
          </ul>
        </section>
      )}
      {steps.warnings.length > 0 && (
        <section class="run-findings">
          <h2>Warnings</h2>
          <ul>
            {steps.warnings.map((one, i) => (
              <WarningLine key={i} warning={one} open={open} />
            ))}
          </ul>
        </section>
      )}
    </>
  )
}
