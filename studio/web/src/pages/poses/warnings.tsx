// What the steps of a pose said, each with the buttons that do what it says.
import type { Steps, Warning } from '../../api'
import { useStudio } from '../../state'
import { count, stepTitle } from '../../words'
import { namedIn, saysLeaveOut } from './named'
import type { PhotoActs } from './photo_acts'
import type { Judged } from './quality'

interface Said {
  steps: string[]
  text: string
  failed: boolean
  /** the step will run again: its words are of before */
  earlier: boolean
}

/**
 * Warnings, and the words of steps that failed. Of steps that will run again those warnings too that
 * name a photograph which is not left out yet.
 * @param used  names of the photographs that are not left out
 */
export function saidOf(steps: Steps, pose: string, used: string[]): Said[] {
  const failed = steps.steps
    .filter((step) => step.pose === pose && step.state === 'failed' && step.error)
    .map((step) => ({ steps: [step.id], text: step.error, failed: true, earlier: false }))
  const warnings = (list: Warning[], earlier: boolean) =>
    list
      .filter((one) => one.poses.includes(pose))
      .map(({ steps: of, text }) => ({ steps: of, text, failed: false, earlier }))
  const earlier = warnings(steps.earlier_warnings, true).filter(
    ({ text }) => saysLeaveOut(text) && namedIn(text, used).length > 0,
  )
  return [...failed, ...warnings(steps.warnings, false), ...earlier]
}

/** So many have a button each; more are left out together. */
const kEach = 3

function LeaveOutButtons({ names, acts }: { names: string[]; acts: PhotoActs }) {
  const button = (words: string, which: string[]) => (
    <button key={words} title={acts.note} onClick={() => acts.leaveOut(which, true)}>
      {words}
    </button>
  )
  if (names.length > kEach) return button(`Leave these ${names.length} out`, names)
  return <>{names.map((name) => button(`Leave out ${name}`, [name]))}</>
}

export function Warnings(props: {
  said: Said[]
  judged: Judged[]
  acts: PhotoActs
  show: (name: string) => void
}) {
  const { said, judged, acts } = props
  const { steps } = useStudio().steps
  if (said.length === 0) return null
  const names = judged.map((one) => one.photograph.name)
  const out = new Set(
    judged.filter((one) => one.photograph.left_out).map((one) => one.photograph.name),
  )
  return (
    <details class="warnings" open>
      <summary>
        {count(said.length, 'warning')} <span class="soft">from the steps of this pose</span>
      </summary>
      <ul>
        {said.map((one, i) => {
          const named = namedIn(one.text, names)
          const left = named.filter((name) => !out.has(name))
          return (
            <li key={i}>
              <span class="soft" title={one.steps.join(', ')}>
                {one.steps.map((id) => stepTitle(id, steps)).join(', ')}
              </span>
              <span>
                {one.earlier && <span class="soft">Before your change: </span>}
                <span class={one.failed ? 'bad' : ''}>{one.text}</span>
                {named.length > 0 && (
                  <span class="row acts">
                    {left.length > 0 && saysLeaveOut(one.text) && (
                      <LeaveOutButtons names={left} acts={acts} />
                    )}
                    {left.length === 0 && <span class="soft">left out by now</span>}
                    <button class="quiet" onClick={() => props.show(named[0])}>
                      Show {named.length > 1 ? 'the first' : 'it'}
                    </button>
                  </span>
                )}
              </span>
            </li>
          )
        })}
      </ul>
    </details>
  )
}
