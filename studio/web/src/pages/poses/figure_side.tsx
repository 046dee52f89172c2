// Beside the photograph in which the figure is shown: what a click says, what was said, what next.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import type { Figure, Pose, Step } from '../../api'
import { FailureSheet, Sheet } from '../../sheet'
import { useStudio } from '../../state'
import { sentence } from '../../words'
import { askingFor, shapeOf } from './figure_model'
import type { FigureTool } from './figure_view'
import type { FigureDesk } from './use_figure'

export function FigureSide(props: {
  pose: Pose
  desk: FigureDesk
  tool: FigureTool
  change: (tool: FigureTool) => void
  /** the photograph that is shown */
  name: string
  choose: (name: string) => void
}) {
  const { desk, tool, change } = props
  const { figure } = desk
  const mode = (is: boolean, words: string, key: string) => (
    <button
      class={`figure-mode ${is ? 'is' : 'not'}`}
      aria-pressed={tool.figure === is}
      aria-keyshortcuts={key}
      onClick={() => change({ ...tool, figure: is })}
    >
      <i aria-hidden="true">{is ? '+' : '−'}</i>
      <span>{words}</span>
      <kbd>{key}</kbd>
    </button>
  )
  return (
    <aside class="figure-side" aria-label="What is the figure">
      <section class="stack">
        {figure?.unclear ? (
          <>
            <h2>What is the figure?</h2>
            <p>{askingFor(desk.strokes.clicks)}</p>
            <p class="small soft">{sentence(figure.unclear)}</p>
          </>
        ) : (
          <>
            <h2>Show the figure</h2>
            <p class="soft">
              Needed only where the masks took something else for it. A click in one photograph, or
              a line over it, is enough: the others follow.
            </p>
          </>
        )}
        {figure && <Refused figure={figure} />}
        {figure?.problem && <p class="bad">{sentence(figure.problem)}</p>}
      </section>
      {figure?.step !== '' && (
        <section class="stack" aria-label="What a click says">
          <div class="stack figure-modes" role="group" aria-label="What a click says">
            {mode(true, 'This is the figure', 'F')}
            {mode(false, 'This is not', 'N')}
          </div>
          <label class="figure-look small">
            <input
              type="checkbox"
              checked={tool.masks}
              aria-keyshortcuts="M"
              onChange={() => change({ ...tool, masks: !tool.masks })}
            />
            <span>Darken what was not taken for it</span>
            <kbd>M</kbd>
          </label>
        </section>
      )}
      <SaidList {...props} />
      {figure && figure.step !== '' && <Making desk={desk} />}
    </aside>
  )
}

/** What was taken for the figure when a step last refused it. */
export function Refused({ figure }: { figure: Figure }) {
  return (
    <>
      {figure.refused.map((one) => (
        <FailureSheet key={one.step + one.picture} picture={one} figure={true} />
      ))}
    </>
  )
}

function SaidList(props: {
  desk: FigureDesk
  name: string
  choose: (name: string) => void
}) {
  const { strokes } = props.desk
  const remove = (index: number) =>
    strokes.change(
      'removed',
      strokes.clicks.filter((_, i) => i !== index),
    )
  return (
    <section class="stack" aria-labelledby="figure-said-title">
      <div class="row spread">
        <h3 id="figure-said-title">Said so far</h3>
        <button
          class="quiet small"
          disabled={!strokes.canUndo}
          aria-keyshortcuts="Control+Z"
          onClick={() => void strokes.undo()}
        >
          Undo
        </button>
      </div>
      {strokes.clicks.length === 0 && <p class="small soft">Nothing yet.</p>}
      <ul class="figure-list">
        {strokes.clicks.map((stroke, i) => (
          <li key={i} class={stroke.figure ? 'is' : 'not'}>
            <button
              class="quiet where"
              disabled={stroke.gone}
              aria-current={stroke.picture === props.name ? 'true' : undefined}
              title={stroke.gone ? 'This photograph is not there any more' : stroke.picture}
              onClick={() => props.choose(stroke.picture)}
            >
              <i aria-label={stroke.figure ? 'the figure:' : 'not the figure:'}>
                {stroke.figure ? '+' : '−'}
              </i>
              <span class="name">{stroke.picture}</span>
              <span class="small soft">{stroke.gone ? 'is gone' : shapeOf(stroke)}</span>
            </button>
            <button
              class="quiet"
              aria-label={`Take back ${shapeOf(stroke)} in ${stroke.picture}`}
              onClick={() => remove(i)}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
    </section>
  )
}

/** In one line: how far the masks are. */
function stateOf({ figure, strokes }: FigureDesk, step: Step | undefined): string {
  const nothing = strokes.clicks.length === 0
  if (strokes.failed) return `Not saved: ${strokes.failed}`
  if (figure!.unclear && nothing) return 'Show the figure first.'
  if (step?.state === 'done')
    return nothing ? 'The masks are made.' : 'The masks are made with what you said.'
  if (step?.state === 'failed' && !figure!.unclear)
    return `${step.id} failed. ${sentence(step.error)}`
  return 'The masks are made again at the next run.'
}

/** What happens with it: saved, the masks made again, looked at before the long steps. */
function Making({ desk }: { desk: FigureDesk }) {
  const { steps, running, tell, complain, reload } = useStudio()
  const [asked, setAsked] = useState(false)
  const { strokes } = desk
  const figure = desk.figure!
  const step = steps.steps.find((one) => one.id === figure.step)
  const held = running ? 'A run is at work.' : steps.locked_by
  const make = async () => {
    setAsked(true)
    try {
      await strokes.save()
      await api.run({ until: [figure.step] })
      tell('The masks are being made. Look at them here before all the rest is made.')
      await reload()
    } catch (error) {
      complain(error)
    } finally {
      setAsked(false)
    }
  }
  const done = step?.state === 'done'
  const first = figure.unclear !== '' && strokes.clicks.length === 0
  return (
    <section class="stack figure-making" aria-label="The masks">
      <p class="small" role="status">
        {stateOf(desk, step)}
      </p>
      <button
        class={done ? '' : 'main'}
        disabled={done || first || asked || held !== '' || strokes.failed !== ''}
        title={held || 'Makes the masks, and what they need, and stops there'}
        onClick={() => void make()}
      >
        {running ? 'A run is at work …' : 'Make the masks'}
      </button>
      {figure.sheet && (
        <Sheet
          src={api.resultUrl(figure.sheet, String(step?.seconds ?? ''))}
          title="What was taken for the figure"
          alt="Every photograph; bright is what was taken for the figure"
        >
          All masks in one picture
        </Sheet>
      )}
    </section>
  )
}
