// What is known of the camera, and the button that looks for it.
import { api } from '../../api'
import { useStudio } from '../../state'
import { percent } from '../../words'
import type { Film, Located } from './shot_api'
import { cameraWords, focalWords, gradeOf, methodWords, seenWords } from './words'

const kSteps = ['locate', 'composite'] as const
const kWords = { good: 'fits', look: 'look at it', wrong: 'does not fit' }

/** The state of a step in words; '' when it is done. */
function useStepWords(name: string): string {
  const { steps, running } = useStudio()
  const step = steps.steps.find((one) => one.step === name)
  if (!step || step.state === 'done') return ''
  const at = running?.steps[step.id]
  if (at) return `${percent(at.fraction)} ${at.what}`
  if (running && running.finished[step.id] === undefined) return 'waits for its turn'
  if (step.state === 'failed') return step.error
  return ''
}

/** Runs one step and what it needs. */
export function RunStep(props: {
  step: (typeof kSteps)[number]
  name: string
  again: string
  /** a result is shown, which may be an earlier one */
  there: boolean
}) {
  const { steps, running, complain, reload } = useStudio()
  const step = steps.steps.find((one) => one.step === props.step)
  const words = useStepWords(props.step)
  const failed = step?.state === 'failed' && !running
  const done = step?.state === 'done'
  const start = async () => {
    await api.run(done ? { only: [props.step], force: [props.step] } : { until: [props.step] })
    await reload()
  }
  return (
    <div class="stack">
      <button
        class={done ? '' : 'main'}
        data-action={props.step}
        disabled={!step || running !== null || steps.locked_by !== ''}
        onClick={() => void start().catch(complain)}
      >
        {done ? props.again : props.name}
      </button>
      {props.there && step && !done && !running && (
        <p class="small warn">This is an earlier result: something has changed since.</p>
      )}
      {words && <p class={failed ? 'small bad shot-error' : 'small soft'}>{words}</p>}
    </div>
  )
}

export function Warnings({ step }: { step: string }) {
  const { steps } = useStudio()
  const own = steps.warnings.filter((warning) => warning.steps.includes(step))
  return (
    <>
      {own.map((warning) => (
        <p key={warning.text} class="small warn">
          {warning.text}
        </p>
      ))}
    </>
  )
}

export function CameraCard(props: {
  located: Located | null
  film: Film
  frame: number
  choose: (frame: number) => void
}) {
  const { located } = props
  return (
    <section class="stack" aria-label="Camera">
      <h2 class="shot-title">Camera</h2>
      {located ? (
        <>
          <p class="small">
            <b class={`tag shot-camera ${located.still ? '' : 'warn'}`}>
              {located.still ? 'still' : 'moving'}
            </b>{' '}
            {cameraWords(located)}
          </p>
          <p class="small">
            Focal length {focalWords(located)}. {seenWords(located)}
          </p>
          <table class="small number">
            <thead>
              <tr>
                <th>Frame</th>
                <th title="Mean distance of the outlines of mesh and film">Outline</th>
                <th title="Overlap of mesh and figure">Overlap</th>
              </tr>
            </thead>
            <tbody>
              {located.frames.map((frame) => {
                const grade = gradeOf(frame)
                return (
                  <tr key={frame.frame}>
                    <td>
                      <button
                        class="quiet shot-goto"
                        aria-current={frame.frame === props.frame ? 'true' : undefined}
                        title={`Found ${methodWords(frame)}`}
                        onClick={() => props.choose(frame.frame)}
                      >
                        {frame.frame} {frame.pose}
                      </button>
                    </td>
                    <td class={grade === 'good' ? 'good' : grade === 'look' ? 'warn' : 'bad'}>
                      {frame.contour_px === null ? '–' : `${frame.contour_px.toFixed(2)} px`}
                      <span class="hidden">, {kWords[grade]}</span>
                    </td>
                    <td>{frame.iou === null ? '–' : percent(frame.iou, 1)}</td>
                  </tr>
                )
              })}
            </tbody>
          </table>
        </>
      ) : (
        <p class="small soft">
          Not found yet. It {props.film.camera === 'moving' ? 'moves' : 'stands still'}, says the
          set-up.
        </p>
      )}
      {located && located.still !== (props.film.camera === 'still') && (
        <p class="small warn">
          The set-up now says that it {props.film.camera === 'moving' ? 'moves' : 'stands still'}:
          find it again.
        </p>
      )}
      <Warnings step="locate" />
      <RunStep
        step="locate"
        name="Find the camera"
        again="Find the camera again"
        there={located !== null}
      />
    </section>
  )
}
