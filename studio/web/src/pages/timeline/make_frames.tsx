// Says when the shown frames are old, and makes new ones.
import { api } from '../../api'
import { useStudio } from '../../state'
import { percent } from '../../words'
import type { Editing } from './use_timeline'
import { interpolateStep } from './use_frames'

function MakeButton({ editing }: { editing: Editing }) {
  const { steps, running, reload, complain } = useStudio()
  if (running) {
    const step = interpolateStep(steps.steps)
    const at = step && running.steps[step.id]
    return <span class="soft number">{at ? percent(at.fraction) : 'A run is at work…'}</span>
  }
  const make = async () => {
    // What is made must be what is on the ruler.
    if (!(await editing.flush())) return
    await api.run({ until: ['interpolate'] })
    await reload()
  }
  return (
    <button
      class="main"
      disabled={steps.locked_by !== ''}
      title={steps.locked_by}
      onClick={() => make().catch(complain)}
    >
      Make frames
    </button>
  )
}

export function FramesNote(props: { editing: Editing; made: boolean; stale: boolean }) {
  if (props.made && !props.stale) return null
  if (props.made)
    return (
      <div class="tl-note" role="status">
        <span>The frames are of the last run; the timeline has changed since.</span>
        <MakeButton editing={props.editing} />
      </div>
    )
  return (
    <div class="tl-first">
      <h2>No frames yet</h2>
      <p>Set the keys below, then make the frames between them.</p>
      <MakeButton editing={props.editing} />
    </div>
  )
}
