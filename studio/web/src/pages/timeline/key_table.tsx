// The keys as a table: the same edits as on the ruler, in numbers.
import { swatchOf } from './desk'
import type { Desk } from './desk'
import { Icon } from './icons'
import { kEases, PoseSelect } from './inspector'
import { NumberField } from './number_field'
import {
  deleteKey,
  easeOf,
  frameOfSeconds,
  framesOf,
  holdOf,
  moveKey,
  secondsOf,
  setEase,
  setHold,
  setPose,
} from './timeline_model'
import type { EaseName } from './timeline_model'

function EaseCell({ desk, index }: { desk: Desk; index: number }) {
  if (index + 1 === desk.timeline.keys.length) return <span class="soft">ends</span>
  const { name } = easeOf(desk.timeline, index)
  return (
    <select
      aria-label={`Ease of key ${index + 1}`}
      value={name}
      onChange={(event) => {
        const ease = event.currentTarget.value as EaseName
        desk.edit((now) => setEase(now, index, ease))
      }}
    >
      {kEases.map((ease) => (
        <option key={ease.name} value={ease.name}>
          {ease.label}
        </option>
      ))}
      {name === 'ease' && <option value="ease">Ease</option>}
      <option value="custom">Custom</option>
    </select>
  )
}

function Row({ desk, index }: { desk: Desk; index: number }) {
  const { timeline, selected } = desk
  const frame = framesOf(timeline)[index]
  const name = `key ${index + 1}`
  const { pose } = timeline.keys[index]
  const go = (to: number) => desk.edit((now) => moveKey(now, index, to))
  return (
    <tr
      class={index === selected ? 'chosen' : ''}
      onFocusIn={() => desk.select(index)}
      onPointerDown={() => desk.select(index)}
    >
      <td>
        <span class="tl-swatch" style={{ background: swatchOf(desk.poses, pose) }} />
      </td>
      <td>
        <PoseSelect
          label={`Pose of ${name}`}
          poses={desk.poses}
          pose={pose}
          change={(next) => desk.edit((now) => setPose(now, index, next))}
        />
      </td>
      <td>
        <NumberField
          label={`Frame of ${name}`}
          value={frame}
          disabled={index === 0}
          change={go}
        />
      </td>
      <td>
        <NumberField
          label={`Seconds of ${name}`}
          value={secondsOf(timeline, frame)}
          digits={2}
          step={0.01}
          disabled={index === 0}
          change={(seconds) => go(frameOfSeconds(timeline, seconds))}
        />
      </td>
      <td>
        <NumberField
          label={`Hold of ${name} in frames`}
          value={holdOf(timeline, index)}
          min={0}
          change={(hold) => desk.edit((now) => setHold(now, index, hold))}
        />
      </td>
      <td>
        <EaseCell desk={desk} index={index} />
      </td>
      <td>
        <button
          class="quiet"
          aria-label={`Delete ${name}`}
          disabled={timeline.keys.length <= 2}
          onClick={() => desk.edit((now) => deleteKey(now, index))}
        >
          <Icon name="bin" />
        </button>
      </td>
    </tr>
  )
}

export function KeyTable({ desk }: { desk: Desk }) {
  return (
    <table class="tl-table tl-key-table">
      <thead>
        <tr>
          <th>
            <span class="hidden">Colour</span>
          </th>
          <th scope="col">Pose</th>
          <th scope="col">Frame</th>
          <th scope="col">Time</th>
          <th scope="col">Hold</th>
          <th scope="col">Ease</th>
          <th>
            <span class="hidden">Delete</span>
          </th>
        </tr>
      </thead>
      <tbody>
        {desk.timeline.keys.map((_, index) => (
          <Row key={index} desk={desk} index={index} />
        ))}
      </tbody>
    </table>
  )
}
