// Below the figure: which colours it is shown in, the switch between them, and how to get more.
import { api } from '../../api'
import { useStudio } from '../../state'
import { sentence } from '../../words'
import type { FrameColours } from '../../api'
import { kColours, kNames, problemOf } from './colours'
import type { Colours } from './colours'

const kTitles: Record<Colours, string> = {
  video: 'The films, painted on each frame by the step video3d',
  own: 'The texture or the colours that came with the scan',
  grey: 'The shape alone, shaded',
}

/** The step that paints, if the project has it switched on. */
function usePainter(shot: string) {
  const { steps } = useStudio()
  return steps.steps.find((one) => one.step === 'video3d' && one.pose === shot)
}

/** The colours of the video are not there, or not those of these frames: what to do. */
function Paint({ shot, colours }: { shot: string; colours: FrameColours }) {
  const { steps, running, reload, complain } = useStudio()
  const painter = usePainter(shot)
  const blocked = running !== null || steps.locked_by !== ''
  const old = colours.video !== null && painter?.state !== 'done' && running === null
  if (colours.video && !old) return null
  const words = old
    ? 'These were painted before something changed.'
    : `No colours of the video: ${colours.video_problem}`
  return (
    <div class="small motion-paint">
      <p>{sentence(words)}</p>
      {painter && (
        <button
          disabled={blocked}
          onClick={() => api.run({ until: [painter.id] }).then(reload).catch(complain)}
        >
          Paint from the films
        </button>
      )}
    </div>
  )
}

export function ColoursBar(props: {
  shot: string
  colours: FrameColours
  shown: Colours
  choose: (kind: Colours) => void
  /** receives the line that says what is shown; it changes with each frame */
  line: { current: HTMLParagraphElement | null }
}) {
  const { shot, colours, shown } = props
  return (
    <div class="motion-colours">
      <div class="choice" role="group" aria-label="Colours of the figure">
        {kColours.map((kind) => (
          <button
            key={kind}
            aria-pressed={kind === shown}
            disabled={problemOf(colours, kind) !== ''}
            title={problemOf(colours, kind) || `${kTitles[kind]} (C)`}
            onClick={() => props.choose(kind)}
          >
            {kNames[kind]}
          </button>
        ))}
      </div>
      <p ref={props.line} class="small number motion-shown" />
      <Paint shot={shot} colours={colours} />
    </div>
  )
}
