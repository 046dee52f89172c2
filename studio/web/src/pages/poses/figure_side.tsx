// Beside the photograph in which the figure is shown: what a click says, what was said, what next.
import { useState } from 'preact/hooks'

import { api } from '../../api'
import type { Figure, Step } from '../../api'
import { FailureSheet, Sheet } from '../../sheet'
import { useStudio } from '../../state'
import { sentence, stepName } from '../../words'
import { askingFor, shapeOf } from './figure_model'
import type { FigureTool } from './figure_view'
import type { FigureDesk } from './use_figure'

/** The words of the page: for photographs of a pose, and for films. */
export interface FigureWords {
  figure: string
  /** a picture in which it is shown */
  picture: string
  help: string
}
const kPhotographs: FigureWords = {
  figure: 'the figure',
  picture: 'photograph',
  help:
    'Needed only where the masks took something else for it. A click in one photograph, or a line ' +
    'over it, is enough: the others follow.',
}

export function FigureSide(props: {
  words?: FigureWords
  desk: FigureDesk
  tool: FigureTool
  change: (tool: FigureTool) => void
  /** the photograph that is shown */
  name: string
  choose: (name: string) => void
}) {
  const { desk, tool, change } = props
  const words = props.words ?? kPhotographs
  const { figure } = desk
  const mode = (is: boolean, text: string, key: string) => (
    <button
      class={`figure-mode ${is ? 'is' : 'not'}`}
      aria-pressed={tool.figure === is}
      aria-keyshortcuts={key}
      onClick={() => change({ ...tool, figure: is })}
    >
      <i aria-hidden="true">{is ? '+' : '−'}</i>
      <span>{text}</span>
      <kbd>{key}</kbd>
    </button>
  )
  return (
    <aside class="figure-side" aria-label="What is the figure">
      <section class="stack">
        {figure?.unclear ? (
          <>
            <h2>What is {words.figure}?</h2>
            <p>{askingFor(desk.strokes.clicks, words.picture)}</p>
            <p class="small soft">{sentence(figure.unclear)}</p>
          </>
        ) : (
          <>
            <h2>Show {words.figure}</h2>
            <p class="soft">{words.help}</p>
          </>
        )}
        {figure && <Refused figure={figure} />}
        {figure?.problem && <p class="bad">{sentence(figure.problem)}</p>}
      </section>
      {figure?.step !== '' && (
        <section class="stack" aria-label="What a click says">
          <div class="stack figure-modes" role="group" aria-label="What a click says">
            {mode(true, `This is ${words.figure}`, 'F')}
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
      <SaidList {...props} noun={words.picture} />
      {figure && figure.step !== '' && <Making desk={desk} />}
      {props.words && figure && <Remarks step={figure.step} />}
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
  noun: string
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
              title={stroke.gone ? `This ${props.noun} is not there any more` : stroke.picture}
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

/** What the step that makes the masks told a person to look at. */
function Remarks({ step }: { step: string }) {
  const { steps } = useStudio()
  const made = steps.steps.find((one) => one.id === step)
  const told = steps.warnings.filter(
    (one) => made && one.steps.includes(made.step) && one.poses.includes(made.pose),
  )
  if (told.length === 0) return null
  return (
    <section class="stack" aria-labelledby="figure-remarks">
      <h3 id="figure-remarks">To look at</h3>
      <ul class="figure-remarks small soft">
        {told.map((one) => (
          <li key={one.text}>{sentence(one.text)}</li>
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
    return `${stepName(step.id, [step])} failed. ${sentence(step.error)}`
  const again = step?.state === 'never' ? '' : 'again '
  return `The masks are made ${again}at the next run.`
}

/** What else runs again: of many steps of several poses only how many. */
function Follow({ steps }: { steps: string[] }) {
  const all = useStudio().steps.steps
  if (steps.length === 0) return null
  const kMost = 8
  const words = steps.length > kMost
      ? `the ${steps.length} steps that need them`
      : steps.map((id) => stepName(id, all)).join(', ')
  return <p class="small soft">Where they change, these run again after them: {words}.</p>
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
      {!done && <Follow steps={figure.follow} />}
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
