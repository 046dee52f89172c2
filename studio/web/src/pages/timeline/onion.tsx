// Onion skin: frames before and after, or any chosen ones, see-through over the shown frame.
import type { Player } from './player'
import { Icon } from './icons'

export interface Onion {
  on: boolean
  before: number
  after: number
  /** frames that are always shown */
  chosen: number[]
}

export const kNoOnion: Onion = { on: false, before: 2, after: 2, chosen: [] }
export const kBeforeTint = '#e0563b'
export const kAfterTint = '#2f8fd8'
const kMost = 8

/** The frames to show around one, with their tint; equal frames once. */
export function skins(onion: Onion, frame: number, range: number): Map<number, string> {
  const found = new Map<number, string>()
  const add = (at: number) => {
    if (at >= 0 && at < range && at !== frame) found.set(at, at < frame ? kBeforeTint : kAfterTint)
  }
  for (let by = 1; by <= onion.before; ++by) add(frame - by)
  for (let by = 1; by <= onion.after; ++by) add(frame + by)
  onion.chosen.forEach(add)
  return found
}

function Stepper(props: {
  label: string
  value: number
  tint: string
  change: (value: number) => void
}) {
  const { value, change } = props
  return (
    <div class="tl-stepper" role="group" aria-label={props.label}>
      <button
        aria-label={`${props.label}: one fewer`}
        disabled={value === 0}
        onClick={() => change(value - 1)}
      >
        −
      </button>
      <span class="number" style={{ borderBottomColor: props.tint }} title={props.label}>
        {value}
      </span>
      <button
        aria-label={`${props.label}: one more`}
        disabled={value === kMost}
        onClick={() => change(value + 1)}
      >
        +
      </button>
    </div>
  )
}

export function OnionControls(props: {
  onion: Onion
  player: Player
  change: (onion: Onion) => void
}) {
  const { onion, change, player } = props
  const choose = () => {
    const others = onion.chosen.filter((frame) => frame !== player.frame)
    change({ ...onion, chosen: [...others, player.frame].sort((a, b) => a - b) })
  }
  return (
    <div class="tl-onion">
      <button
        aria-pressed={onion.on}
        title="Onion skin (O)"
        onClick={() => change({ ...onion, on: !onion.on })}
      >
        <Icon name="onion" /> Onion skin
      </button>
      {onion.on && (
        <>
          <Stepper
            label="Frames before"
            value={onion.before}
            tint={kBeforeTint}
            change={(before) => change({ ...onion, before })}
          />
          <Stepper
            label="Frames after"
            value={onion.after}
            tint={kAfterTint}
            change={(after) => change({ ...onion, after })}
          />
          <button title="Keep this frame as onion skin (Shift+O)" onClick={choose}>
            + This frame
          </button>
          {onion.chosen.map((frame) => (
            <button
              key={frame}
              class="number"
              aria-label={`Frame ${frame} is onion skin: remove it`}
              onClick={() =>
                change({ ...onion, chosen: onion.chosen.filter((one) => one !== frame) })
              }
            >
              {frame} ×
            </button>
          ))}
        </>
      )}
    </div>
  )
}
