// 'Register', and how well the template lay on the pose before and after.
import { useEffect, useState } from 'preact/hooks'

import { api, ApiError } from '../../api'
import { useStudio } from '../../state'
import { Bar } from '../../bar'
import { cssShare, percent } from '../../words'
import { figuresOf, pairsApart } from './fit_figures'
import type { FitFigures } from './fit_figures'

interface FitRecord {
  before: FitFigures | null
  after: FitFigures | null
  /** 'asked': the run is not known to have begun */
  state: 'idle' | 'asked' | 'runs'
}

const kNothing: FitRecord = { before: null, after: null, state: 'idle' }

/** By pose; outlives the page, so that a look at another page does not lose the comparison. */
const records = new Map<string, FitRecord>()

/** null: the pose has not been registered. */
async function measure(pose: string): Promise<FitFigures | null> {
  try {
    const figures = figuresOf(await api.fit(pose))
    if (!figures) return null
    return { ...figures, pairs: pairsApart((await api.pairFit(pose)).pairs) }
  } catch (error) {
    if (error instanceof ApiError && error.status === 404) return null
    throw error
  }
}

function useFit(pose: string, save: () => Promise<void>) {
  const { steps, running, version, reload, complain } = useStudio()
  const [, redraw] = useState(0)
  const put = (record: FitRecord) => {
    records.set(pose, record)
    redraw((old) => old + 1)
  }
  const record = records.get(pose) ?? kNothing

  // The present fit, where nobody has pressed the button yet.
  useEffect(() => {
    if (records.get(pose)?.state === 'asked' || records.get(pose)?.state === 'runs') return
    measure(pose).then((after) => {
      const old = records.get(pose) ?? kNothing
      if (old.state === 'idle') put({ ...old, after })
    }, complain)
  }, [pose, version])

  const ended = record.state === 'runs' && running === null && !steps.running
  useEffect(() => {
    if (!ended) return
    measure(pose).then((after) => put({ ...record, after, state: 'idle' }), complain)
  }, [ended])

  const register = async () => {
    try {
      await save()
      const before = await measure(pose)
      put({ before, after: null, state: 'asked' })
      await api.run({ until: [`register/${pose}`] })
      await reload()
      put({ before, after: null, state: 'runs' })
    } catch (error) {
      put({ ...record, state: 'idle' })
      complain(error)
    }
  }
  return { record, register }
}

/** Two bars of one figure, to the same scale. */
function Bars(props: {
  name: string
  before: number | null
  after: number | null
  longest: number
}) {
  const bar = (value: number | null, kind: string) =>
    value === null ? null : (
      <div class={`lm-bar ${kind}`}>
        <div style={{ width: cssShare(value / props.longest) }} />
        <span class="number">{percent(value, 2)}</span>
      </div>
    )
  return (
    <>
      <dt>{props.name}</dt>
      <dd>
        {bar(props.before, 'before')}
        {bar(props.after, 'after')}
      </dd>
    </>
  )
}

function verdict(before: FitFigures | null, after: FitFigures | null) {
  if (!before || !after) return null
  const paired = before.pairs != null && after.pairs != null
  const [was, is] = paired ? [before.pairs!, after.pairs!] : [before.median, after.median]
  if (was === 0) return null
  const change = is / was - 1
  if (Math.abs(change) < 0.01) return <span class="soft">the same as before</span>
  return change < 0 ? (
    <span class="good">
      {paired ? 'pairs ' : ''}
      {percent(-change)} closer
    </span>
  ) : (
    <span class="warn">
      {paired ? 'pairs ' : ''}
      {percent(change)} farther
    </span>
  )
}

export function FitCard(props: { pose: string; pairs: number; save: () => Promise<void> }) {
  const { pose } = props
  const { steps, running } = useStudio()
  const { record, register } = useFit(pose, props.save)
  const { before, after } = record
  const step = steps.steps.find((one) => one.id === `register/${pose}`)
  const atWork = record.state !== 'idle'
  const now = running?.steps[`register/${pose}`]
  const longest = Math.max(before?.most ?? 0, after?.most ?? 0) || 1
  const apart = [before?.pairs ?? null, after?.pairs ?? null]
  return (
    <section class="lm-fit" aria-label="Fit">
      {(before || after) && (
        <>
          <div class="row spread">
            <h2 class="lm-title">Distance to the scan</h2>
            <span class="small">{atWork ? null : verdict(before, after)}</span>
          </div>
          <dl>
            <Bars
              name="Median"
              before={before?.median ?? null}
              after={after?.median ?? null}
              longest={longest}
            />
            <Bars
              name="95 %"
              before={before?.most ?? null}
              after={after?.most ?? null}
              longest={longest}
            />
            {(apart[0] !== null || apart[1] !== null) && (
              <Bars
                name="Pairs"
                before={apart[0]}
                after={apart[1]}
                longest={Math.max(apart[0] ?? 0, apart[1] ?? 0) || 1}
              />
            )}
          </dl>
          <p class="small soft lm-legend">
            {before && (
              <>
                <i class="before" aria-hidden="true" /> before{' '}
              </>
            )}
            <i class="after" aria-hidden="true" /> {before ? 'after' : 'now'}, of the diagonal
          </p>
        </>
      )}
      {atWork && (
        <div class="stack" style="gap:4px" role="status">
          <Bar share={now?.fraction ?? running?.overall ?? 0} />
          <span class="small soft">{now?.what || 'The steps before it run first.'}</span>
        </div>
      )}
      {!atWork && step?.state === 'failed' && <p class="small bad">{step.error}</p>}
      <button
        class="main lm-wide"
        disabled={atWork || running !== null || steps.locked_by !== ''}
        title={steps.locked_by || `Lays the net on ${pose}, and runs what that needs (Ctrl+Enter)`}
        data-action="register"
        onClick={register}
      >
        {atWork ? 'Lays the net …' : `Lay the net on ${pose}`}
      </button>
      {!atWork && !after && (
        <p class="small soft">
          {props.pairs < 4
            ? 'Four pairs that are not in one plane are a good start.'
            : `The net has not been laid on ${pose} yet.`}
        </p>
      )}
    </section>
  )
}
