// The chosen key, and the motion from it to the next.
import { swatchOf } from './desk'
import type { Desk } from './desk'
import { EaseEditor } from './ease_editor'
import { Icon } from './icons'
import { NumberField } from './number_field'
import {
  copyKey,
  deleteKey,
  easeOf,
  frameOfSeconds,
  framesOf,
  holdOf,
  keysOf,
  lengthText,
  moveKey,
  roomOf,
  secondsOf,
  setEase,
  setHold,
  setPose,
  setStep,
} from './timeline_model'
import type { EaseName } from './timeline_model'

export const kEases: { name: EaseName; label: string }[] = [
  { name: 'linear', label: 'Linear' },
  { name: 'in', label: 'In' },
  { name: 'out', label: 'Out' },
  { name: 'in-out', label: 'In-out' },
  { name: 'stepped', label: 'Stepped' },
]

/** The poses to choose from; a name of the file that is no pose stays visible. */
export function PoseSelect(props: {
  label: string
  poses: string[]
  pose: string
  change: (pose: string) => void
}) {
  const known = props.poses.includes(props.pose)
  return (
    <select
      aria-label={props.label}
      value={props.pose}
      onChange={(event) => props.change(event.currentTarget.value)}
    >
      {!known && <option value={props.pose}>{props.pose}</option>}
      {props.poses.map((pose) => (
        <option key={pose} value={pose}>
          {pose}
        </option>
      ))}
    </select>
  )
}

function Place({ desk, index }: { desk: Desk; index: number }) {
  const { timeline } = desk
  const frame = framesOf(timeline)[index]
  const { min, max } = roomOf(timeline, index)
  const go = (to: number) => desk.edit((now) => moveKey(now, index, to), `move ${index}`)
  const hold = (frames: number) => desk.edit((now) => setHold(now, index, frames), `hold ${index}`)
  return (
    <div class="tl-fields">
      <label>
        Frame
        <NumberField
          label="Frame of the key"
          value={frame}
          min={min}
          max={max}
          disabled={index === 0}
          change={go}
        />
      </label>
      <label>
        Time
        <NumberField
          label="Time of the key in seconds"
          value={secondsOf(timeline, frame)}
          digits={2}
          step={0.01}
          disabled={index === 0}
          change={(seconds) => go(frameOfSeconds(timeline, seconds))}
        />
      </label>
      <label>
        Hold
        <NumberField
          label="Hold in frames"
          value={holdOf(timeline, index)}
          min={0}
          change={hold}
        />
      </label>
    </div>
  )
}

function PictureStep({ desk, index }: { desk: Desk; index: number }) {
  const own = keysOf(desk.timeline)[index].step
  const choices: [string, number | null][] = [
    ['As all', null],
    ['Ones', 1],
    ['Twos', 2],
    ['Threes', 3],
  ]
  return (
    <div class="choice tl-choice" role="group" aria-label="Pictures of this motion">
      {choices.map(([label, step]) => (
        <button
          key={label}
          aria-pressed={(own ?? null) === step}
          onClick={() => desk.edit((now) => setStep(now, index, step))}
        >
          {label}
        </button>
      ))}
    </div>
  )
}

function Motion({ desk, index }: { desk: Desk; index: number }) {
  const { timeline } = desk
  const frames = framesOf(timeline)
  const { name, curve } = easeOf(timeline, index)
  const span = frames[index + 1] - frames[index] - holdOf(timeline, index)
  return (
    <>
      <div class="row spread tl-to">
        <h2 class="tl-head">
          To <span class="tl-plain">{timeline.keys[index + 1].pose}</span>
        </h2>
        <span class="soft small number">{lengthText(span, timeline.fps)}</span>
      </div>
      <div class="choice tl-choice" role="group" aria-label="Ease">
        {kEases.map((ease) => (
          <button
            key={ease.name}
            aria-pressed={name === ease.name}
            onClick={() => desk.edit((now) => setEase(now, index, ease.name))}
          >
            {ease.label}
          </button>
        ))}
      </div>
      <EaseEditor
        timeline={timeline}
        index={index}
        curve={curve}
        stepped={name === 'stepped'}
        change={(next) => desk.edit((now) => setEase(now, index, next), `ease ${index}`)}
      />
      <PictureStep desk={desk} index={index} />
    </>
  )
}

export function Inspector({ desk }: { desk: Desk }) {
  const { timeline, selected: index } = desk
  const key = timeline.keys[index]
  const last = index + 1 === timeline.keys.length
  return (
    <div class="tl-inspector">
      <div class="row tl-title">
        <span class="tl-swatch" style={{ background: swatchOf(desk.poses, key.pose) }} />
        <PoseSelect
          label="Pose of the key"
          poses={desk.poses}
          pose={key.pose}
          change={(pose) => desk.edit((now) => setPose(now, index, pose))}
        />
        <span class="soft small number">
          key {index + 1} of {timeline.keys.length}
        </span>
        <div class="tl-tools">
          <button
            class="quiet"
            aria-label="Copy the key to the playhead"
            title="Copy to the playhead (Ctrl+D)"
            onClick={() => desk.insert((now) => copyKey(now, index, desk.player.frame))}
          >
            <Icon name="copy" />
          </button>
          <button
            class="quiet"
            aria-label="Delete the key"
            title="Delete (Del)"
            disabled={timeline.keys.length <= 2}
            onClick={() => desk.edit((now) => deleteKey(now, index))}
          >
            <Icon name="bin" />
          </button>
        </div>
      </div>
      <Place desk={desk} index={index} />
      {last ? (
        <p class="soft small">The last key: the animation ends with its hold.</p>
      ) : (
        <Motion desk={desk} index={index} />
      )}
    </div>
  )
}
