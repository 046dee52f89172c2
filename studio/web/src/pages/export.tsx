// The report in the page, the files to take away, and the formats of the animation.
import { useEffect, useRef, useState } from 'preact/hooks'

import { api } from '../api'
import type { Step } from '../api'
import { useStudio } from '../state'
import { Formats } from './export/format_list'
import type { Result } from './export/formats'
import { Results } from './export/results'
import { Upkeep } from './export/upkeep'
import { useStages } from './run/use_stages'
import './run/run.css'
import './export/export.css'

function useResults(): Result[] {
  const { version, complain } = useStudio()
  const [results, setResults] = useState<Result[]>([])
  useEffect(() => {
    let alive = true
    api
      .results()
      .then((all) => alive && setResults(all))
      .catch((error) => alive && complain(error))
    return () => {
      alive = false
    }
  }, [version, complain])
  return results
}

/** Grows with each new report, so that the frame loads it again and not on every change. */
function useReportNumber(report: Step | undefined): number {
  const state = report?.state
  const [number, setNumber] = useState(0)
  const before = useRef(state)
  useEffect(() => {
    if (state === 'done' && before.current !== 'done') setNumber((old) => old + 1)
    before.current = state
  }, [state])
  return number
}

function Report() {
  const { project, steps, running, reload, complain } = useStudio()
  const step = steps.steps.find((one) => one.step === 'report')
  const number = useReportNumber(step)
  const make = () => api.run({ until: [step?.id ?? 'report'] }).then(reload).catch(complain)
  const blocked = running !== null || steps.locked_by !== ''
  if (!project.has_report)
    return (
      <div class="empty">
        <h2>No report yet</h2>
        <p>It shows each pose beside its photographs, with figures and what to mend.</p>
        {step && (
          <button class="main" disabled={blocked} onClick={make}>
            Run until the report
          </button>
        )}
      </div>
    )
  const stale = step && step.state !== 'done'
  return (
    <section class="export-report" aria-label="Report">
      <header>
        <h2>Report</h2>
        {stale && <span class="warn small">The project has changed since this report</span>}
        <div class="row end">
          {stale && (
            <button disabled={blocked} onClick={make}>
              Make it again
            </button>
          )}
          <a class="button" href="/report/index.html" target="_blank" rel="noopener">
            Open in a tab
          </a>
        </div>
      </header>
      <iframe
        key={number}
        title="Report on this project"
        sandbox="allow-scripts"
        src={`/report/index.html?${number}`}
      />
    </section>
  )
}

function NoAnimation({ poses }: { poses: number }) {
  return (
    <section aria-label="Formats">
      <h2>Animation</h2>
      <p class="soft">
        {poses < 1
          ? 'There is no pose yet. Add one on the Poses page.'
          : 'The project’s file, pipeline.yaml, has switched the export step off.'}
      </p>
    </section>
  )
}

export function ExportPage() {
  const { project, steps } = useStudio()
  const stages = useStages()
  const results = useResults()
  const step = steps.steps.find((one) => one.step === 'export')
  const stage = stages?.find((one) => one.stage === step?.stage)
  return (
    <main class="page export-page">
      <h1 class="hidden">Report and export</h1>
      <aside class="side" aria-label="Files">
        {step && !stages && <p class="soft">Asks which formats there are …</p>}
        {step && stage && <Formats step={step} stage={stage} results={results} />}
        {!step && <NoAnimation poses={project.poses.length} />}
        <Results results={results} />
        <Upkeep />
      </aside>
      <Report />
    </main>
  )
}
