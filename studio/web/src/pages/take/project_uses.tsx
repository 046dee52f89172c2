// The baked frames as a part of the project: a step of pipeline.yaml for each use, put in and taken
// out by a button. `keypose run` does it then, or a button here.
import { useCallback, useEffect, useState } from 'preact/hooks'

import { api } from '../../api'
import { useStudio } from '../../state'
import { LightForm } from './light_form'
import { takeApi } from './take_api'
import type { TakeUse, Use } from './take_api'

const kUses: { use: Use; put: string; what: string }[] = [
  { use: 'export', put: 'Export with the project', what: 'film, GLB and the other formats' },
  { use: 'composite', put: 'Put over its plate', what: 'pictures and a film of it' },
]

interface RowProps {
  state: TakeUse
  row: (typeof kUses)[number]
  busy: boolean
  set: (use: Use, used: boolean) => void
}

function UseRow({ state, row, busy, set }: RowProps) {
  const { running, steps, complain, reload } = useStudio()
  const { use, put, what } = row
  const { step, out, used, lack } = state.uses[use]
  const run = () => api.run({ until: [step] }).then(reload).catch(complain)
  if (!used)
    return (
      <div class="stack take-use">
        <button disabled={busy || !state.baked || lack !== ''} onClick={() => set(use, true)}>
          {put}
        </button>
        <p class="small soft">{lack ? `For that, its files lack ${lack}.` : `Makes ${what}.`}</p>
      </div>
    )
  const inSteps = steps.steps.find((one) => one.step === step)
  const made = inSteps?.state === 'done'
  return (
    <div class="stack take-use">
      <p>
        <b>{step}</b> is a step of the project: {what}.
      </p>
      <p class="small soft">
        {made ? (
          <>
            Made: <span class="mono">{out}</span> · <a href="#/export">look</a>
          </>
        ) : (
          <>
            <span class="mono">keypose run</span> makes <span class="mono">{out}</span>
          </>
        )}
      </p>
      {use === 'composite' && inSteps && <LightForm step={inSteps} />}
      <div class="row">
        <button class="main" disabled={busy || running !== null || made} onClick={() => void run()}>
          Run {step}
        </button>
        <button class="quiet" disabled={busy} onClick={() => set(use, false)}>
          Take {step} out
        </button>
      </div>
    </div>
  )
}

/** @param bakes  another number when something was baked */
export function ProjectUses({ take, bakes }: { take: string; bakes: number }) {
  const { version, tell, complain, reload } = useStudio()
  const [state, setState] = useState<TakeUse | null>(null)
  const [busy, setBusy] = useState(false)
  const load = useCallback(
    () => takeApi.use(take).then(setState).catch(complain),
    [take, complain],
  )
  useEffect(() => void load(), [load, bakes, version])
  if (!state) return null
  const set = async (use: Use, used: boolean) => {
    setBusy(true)
    try {
      const next = await takeApi.setUse(take, use, used, state.revision)
      setState(next)
      tell(`${next.uses[use].step} is ${used ? 'in' : 'out of'} the project.`)
      await reload()
    } catch (error) {
      complain(error)
      await load()
    }
    setBusy(false)
  }
  return (
    <section class="stack take-uses" aria-label="In the project">
      <h3>In the project</h3>
      {!state.baked && <p class="small soft">Bake it first, but not as keys only.</p>}
      {state.stale && <p class="small warn">The take has changed since: bake it again.</p>}
      {kUses.map((row) => (
        <UseRow key={row.use} {...{ row, state, busy }} set={(use, used) => void set(use, used)} />
      ))}
    </section>
  )
}
